// Lines on the floor: flat bands, points at equal distances, and where a path is farthest from others.
import { BufferAttribute, BufferGeometry, Mesh, MeshBasicMaterial } from "three";

const MAX_LINES = 1000;

// A flat band on the floor along a line.
export function ribbon() {
  const geometry = new BufferGeometry();
  const mesh = new Mesh(geometry, new MeshBasicMaterial());
  mesh.frustumCulled = false;
  let room = 0;
  const draw = (line, width, z) => {
    const n = line.length / 2;
    if (n > room) {
      room = 2 * n;
      geometry.setAttribute("position", new BufferAttribute(new Float32Array(6 * room), 3));
      const index = [];
      for (let i = 0; i + 1 < room; i++) index.push(2 * i, 2 * i + 2, 2 * i + 1, 2 * i + 1, 2 * i + 2, 2 * i + 3);
      geometry.setIndex(index);
    }
    const { array } = geometry.attributes.position;
    for (let i = 0; i < n; i++) {
      const [x, y] = [line[2 * i], line[2 * i + 1]];
      const to = Math.min(i + 1, n - 1), from = Math.max(i - 1, 0);
      let [dx, dy] = [line[2 * to] - line[2 * from], line[2 * to + 1] - line[2 * from + 1]];
      const length = Math.hypot(dx, dy) || 1;
      [dx, dy] = [((width / 2) * dx) / length, ((width / 2) * dy) / length];
      array.set([x + dy, y - dx, z, x - dy, y + dx, z], 6 * i);
    }
    geometry.attributes.position.needsUpdate = true;
    geometry.setDrawRange(0, Math.max(0, 6 * (n - 1)));
  };
  return { mesh, draw };
}

// Points along a line at equal distances, without its first one.
export function spaced(line, distance, most) {
  const points = [];
  let left = distance;
  for (let i = 2; i < line.length && points.length < most; i += 2) {
    const [x, y] = [line[i - 2], line[i - 1]];
    const [dx, dy] = [line[i] - x, line[i + 1] - y];
    const length = Math.hypot(dx, dy);
    let at = left;
    for (; at <= length && points.length < most; at += distance) points.push([x + (dx * at) / length, y + (dy * at) / length]);
    left = at - length;
  }
  return points;
}

// The point of a path that is farthest from all other paths: there its label is not mistaken.
export function apart(path, others) {
  const points = spaced(path.flat(), 0.25, 400);
  const rest = others.flatMap((other) => spaced(other.flat(), 0.25, 400));
  let best = null, most = -1;
  for (const [x, y] of points) {
    const gap = rest.reduce((least, [u, v]) => Math.min(least, Math.hypot(x - u, y - v)), 4);
    if (gap > most) [best, most] = [[x, y], gap];
  }
  return best;
}

// The distance of a grid's lines over a length, m: 1 m, and more where there would be too many.
export const spacing = (length) => Math.max(1, 10 ** Math.ceil(Math.log10(length / MAX_LINES)));
