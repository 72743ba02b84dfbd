// The scene: world, robot, object and human, the options on the floor, and the way walked.
import {
  Box3, BoxGeometry, BufferAttribute, BufferGeometry, CapsuleGeometry, CircleGeometry, Color, CylinderGeometry,
  DirectionalLight, EdgesGeometry, ExtrudeGeometry, Fog, Group, HemisphereLight, InstancedMesh, LineBasicMaterial,
  LineSegments, Matrix4, Mesh, MeshBasicMaterial, MeshLambertMaterial, Object3D, PlaneGeometry, Quaternion, Scene,
  Shape, SphereGeometry, Vector2, Vector3,
} from "three";
import { ConvexGeometry } from "three/examples/jsm/geometries/ConvexGeometry.js";
import { Human } from "./human.js";
import { apart, ribbon, spaced, spacing } from "./lines.js";
import { addMeshes } from "./meshes.js";
import { marks } from "./postures.js";

Object3D.DEFAULT_UP.set(0, 0, 1);

// Cylinders and capsules of three.js lie along y, those of a URDF along z.
const UPRIGHT = new Quaternion().setFromAxisAngle(new Vector3(1, 0, 0), Math.PI / 2);

export class Stage {
  constructor(episode, redraw) {
    this.episode = episode;
    this.scene = new Scene();
    this.bounds = bounds(episode);
    this.walls = [];
    this.labels = [];
    // what takes longest to make: meshes
    this.later = [];
    this.colours = {};
    this.lights();
    this.ground();
    episode.world.obstacles.forEach((obstacle) => this.wall(obstacle));
    episode.world.openings.forEach((opening) => this.opening(opening));
    this.ends = [];
    if (!episode.postures) {
      this.end("A", episode.world.start);
      this.end("B", episode.world.target);
    }
    this.options();
    this.team(redraw);
    this.paint();
  }

  lights() {
    const { center, radius } = this.bounds;
    this.sky = new HemisphereLight("#ffffff", "#a8adb5", 1.55);
    this.sun = new DirectionalLight("#fff8ee", 1.9);
    this.sun.position.set(center.x - 0.35 * radius, center.y - 0.6 * radius, 1.5 * radius);
    this.sun.target.position.copy(center);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(2048, 2048);
    const camera = this.sun.shadow.camera;
    [camera.left, camera.right, camera.bottom, camera.top] = [-radius, radius, -radius, radius].map((r) => 1.05 * r);
    [camera.near, camera.far] = [0.1, 4 * radius];
    this.sun.shadow.normalBias = 0.03;
    this.scene.add(this.sky, this.sun, this.sun.target);
  }

  ground() {
    const { center, radius } = this.bounds;
    this.floor = new Mesh(new PlaneGeometry(12 * radius, 12 * radius), new MeshLambertMaterial());
    this.floor.position.set(center.x, center.y, 0);
    this.floor.receiveShadow = true;
    const lines = [], { low, high } = this.bounds.all;
    const [left, right, front, back] = [Math.floor(low.x) - 2, Math.ceil(high.x) + 2, Math.floor(low.y) - 2, Math.ceil(high.y) + 2];
    const step = spacing(Math.max(right - left, back - front));
    for (let x = left; x <= right; x += step) lines.push(x, front, 0.003, x, back, 0.003);
    for (let y = front; y <= back; y += step) lines.push(left, y, 0.003, right, y, 0.003);
    const grid = new BufferGeometry();
    grid.setAttribute("position", new BufferAttribute(new Float32Array(lines), 3));
    this.grid = new LineSegments(grid, new LineBasicMaterial());
    this.scene.add(this.floor, this.grid);
  }

  wall({ height_m: height, corners, center, radius }) {
    const material = new MeshLambertMaterial();
    let geometry;
    if (corners) {
      const outline = new Shape(corners.map(([x, y]) => new Vector2(x, y)));
      geometry = new ExtrudeGeometry(outline, { depth: height, bevelEnabled: false });
    } else {
      geometry = new CylinderGeometry(radius, radius, height, 48).rotateX(Math.PI / 2);
      geometry.translate(center[0], center[1], height / 2);
    }
    const wall = new Mesh(geometry, material);
    wall.castShadow = wall.receiveShadow = true;
    const edges = new LineSegments(new EdgesGeometry(geometry, 30), new LineBasicMaterial());
    this.walls.push({ wall, edges, opacity: 1 });
    this.scene.add(wall, edges);
  }

  opening({ name, ends: [a, b], width_m: width, risk, colour }) {
    const bar = ribbon();
    bar.draw([...a, ...b], 0.14, 0.008);
    bar.mesh.material.color.set(colour);
    this.scene.add(bar.mesh);
    const at = new Vector3((a[0] + b[0]) / 2, (a[1] + b[1]) / 2, 0.02);
    this.labels.push({ kind: "opening", name, at, width, risk, colour });
  }

  end(name, [x, y]) {
    const disc = new Mesh(new CircleGeometry(0.16, 40), new MeshBasicMaterial());
    disc.position.set(x, y, 0.006);
    this.scene.add(disc);
    this.ends.push(disc);
    this.labels.push({ kind: "end", name, at: new Vector3(x, y, 0.02) });
  }

  options() {
    this.ribbons = this.episode.options.map((option) => {
      const drawn = ribbon();
      drawn.mesh.material.color.set(option.colour);
      drawn.line = option.path.flat();
      this.scene.add(drawn.mesh);
      return drawn;
    });
    this.episode.options.forEach((option, o) => {
      const at = apart(option.path, this.episode.options.filter((_, other) => other !== o).map((other) => other.path));
      if (at) this.labels.push({ kind: "option", name: option.name, at: new Vector3(...at, 0.05), colour: option.colour });
    });
    this.walked = ribbon();
    this.scene.add(this.walked.mesh);
    this.dots = new InstancedMesh(new CircleGeometry(0.035, 12), new MeshBasicMaterial(), 400);
    this.dots.frustumCulled = false;
    this.scene.add(this.dots);
  }

  team(redraw) {
    const { episode } = this;
    const colour = (rgba) => (rgba ? new Color().setRGB(rgba[0], rgba[1], rgba[2], "srgb") : new Color(episode.colours.robot));
    this.links = episode.robot.map((link) => {
      const group = new Group();
      const drawn = new Group(), colliding = new Group();
      group.add(drawn, colliding);
      colliding.visible = false;
      const all = [...link.shapes.map((shape) => [shape, drawn]), ...(link.collisions ?? []).map((shape) => [shape, colliding])];
      for (const [shape, shapes] of all) {
        const material = new MeshLambertMaterial({ color: colour(shape.colour) });
        const part = new Group();
        part.position.fromArray(shape.pose);
        part.quaternion.fromArray(shape.pose, 3);
        const solid = (geometry, turned) => {
          const mesh = new Mesh(geometry, material);
          if (turned) mesh.quaternion.copy(UPRIGHT);
          mesh.castShadow = mesh.receiveShadow = true;
          part.add(mesh);
        };
        if (shape.box) solid(new BoxGeometry(...shape.box));
        if (shape.cylinder) solid(new CylinderGeometry(shape.cylinder[0], shape.cylinder[0], shape.cylinder[1], 40), true);
        if (shape.capsule) solid(new CapsuleGeometry(shape.capsule[0], shape.capsule[1], 8, 20), true);
        if (shape.sphere) solid(new SphereGeometry(shape.sphere, 28, 20));
        if (shape.mesh !== undefined) {
          const given = shape.colour && material;
          this.later.push(() => addMeshes(part, episode.meshes[shape.mesh], shape.scale, given, episode.colours.robot, redraw));
        }
        if (shape.hull) solid(new ConvexGeometry(shape.hull.map((place) => new Vector3(...place))));
        shapes.add(part);
      }
      this.scene.add(group);
      return group;
    });
    if (episode.postures) {
      const { ring, grasp } = marks(episode.world);
      this.object = grasp;
      this.guides = [ring, grasp];
      this.scene.add(ring, grasp);
      return;
    }
    this.object = new Mesh(new BoxGeometry(...episode.world.object_m), new MeshLambertMaterial({ color: episode.colours.object }));
    this.object.castShadow = this.object.receiveShadow = true;
    this.object.add(new LineSegments(new EdgesGeometry(this.object.geometry), new LineBasicMaterial({ color: "#5e3f17" })));
    this.hand = new Object3D();
    this.torso = new Object3D();
    this.human = new Human(episode);
    this.scene.add(this.object, this.human.group);
    if (!episode.robot.length) this.standIn();
  }

  // On the planning level there is no robot: a plain cart shows at which end it would be.
  standIn() {
    const material = new MeshLambertMaterial({ color: this.episode.colours.robot });
    const part = (geometry, x, z) => {
      const mesh = new Mesh(geometry, material);
      mesh.position.set(x, 0, z);
      mesh.castShadow = mesh.receiveShadow = true;
      return mesh;
    };
    const cart = new Group();
    const upright = (r, h) => new CylinderGeometry(r, r, h, 36).rotateX(Math.PI / 2);
    const length = this.episode.world.object_m[0];
    const behind = -length / 2 - 0.45;
    cart.add(part(upright(0.25, 0.34), behind, 0.2 - 0.7), part(upright(0.12, 0.5), behind, 0.6 - 0.7));
    cart.add(part(new BoxGeometry(0.5, 0.09, 0.09), behind + 0.22, 0));
    this.object.add(cart);
  }

  // Shows another episode in the same world, with the same bodies.
  take(episode) {
    this.episode = episode;
    this.step = undefined;
    this.human?.take(episode);
  }

  // Makes what the first picture does without.
  finish() {
    this.later.splice(0).forEach((make) => make());
  }

  // Shows the shapes that collide, or those that are drawn.
  collide(isColliding) {
    this.isColliding = isColliding;
    for (const { children: [drawn, colliding] } of this.links) [drawn.visible, colliding.visible] = [!isColliding, isColliding];
  }

  // Shows a time.
  update(time) {
    const { episode } = this, place = episode.between(time), step = episode.step(time);
    this.links.forEach((link, i) => episode.place(link, episode.frames.links[i], place));
    episode.place(this.object, episode.frames.object, place);
    if (episode.postures) return;
    episode.place(this.hand, episode.frames.hand, place);
    episode.place(this.torso, episode.frames.torso, place);
    this.human.update(place, this.torso, this.hand);
    if (step !== this.step) {
      this.step = step;
      this.widths(step);
    }
    this.walked.draw(episode.walked(place), 0.06, 0.05);
    const ahead = spaced(episode.pathAhead(time), 0.2, 400);
    ahead.forEach(([x, y], i) => this.dots.setMatrixAt(i, matrix.makeTranslation(x, y, 0.045)));
    this.dots.count = ahead.length;
    this.dots.instanceMatrix.needsUpdate = true;
  }

  // The box around a robot in all its postures, as far as its links' frames and its base tell.
  robotBox() {
    const { frames, world } = this.episode, box = new Box3();
    const half = world.robot_width_m / 2, margin = 0.02;
    for (const [x, y] of world.footprint_m ?? [[-half, -half], [half, half]]) {
      box.expandByPoint(new Vector3(x - margin, y - margin, 0)).expandByPoint(new Vector3(x + margin, y + margin, 0.3));
    }
    for (const poses of [...frames.links, frames.object]) {
      for (let i = 0; i < poses.length; i += 7) {
        const at = new Vector3().fromArray(poses, i);
        box.expandByPoint(at.clone().addScalar(0.08)).expandByPoint(at.addScalar(-0.08));
      }
    }
    box.min.z = 0;
    return { low: box.min, high: box.max };
  }

  // Places around the team: the human from head to foot, and the robot's end of the object.
  outline() {
    if (this.episode.postures) return [];
    const person = [[-0.25, 0, 1.72], [0.25, 0, 1.72], [-0.25, 0, 0], [0.25, 0, 0]];
    const places = person.map(([x, y, z]) => new Vector3(x, y, 0).applyQuaternion(this.torso.quaternion).add(this.torso.position).setZ(z));
    const length = this.episode.world.object_m[0];
    const end = new Vector3(-length / 2 - 0.4, 0, 0).applyQuaternion(this.object.quaternion).add(this.object.position);
    return [...places, end.clone().setZ(1), end.setZ(0.1)];
  }

  // The options as wide as their P_o, narrow ones above wide ones. While the human leads, P_o may not be known:
  // then they keep their widths.
  widths(step) {
    const known = this.episode.options.map(({ probability }) => {
      for (let k = Math.min(step, probability.length - 1); k >= 0; k--) if (probability[k] !== null) return probability[k];
      return 0;
    });
    const order = known.map((_, o) => o).sort((a, b) => known[b] - known[a] || a - b);
    order.forEach((o, rank) => {
      this.ribbons[o].draw(this.ribbons[o].line, 0.045 + 0.42 * known[o], 0.012 + 0.005 * rank);
    });
  }

  // Takes the colours of the page, which follow the reader's scheme.
  paint() {
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => style.getPropertyValue(`--${name}`).trim();
    this.scene.background = new Color(colour("sky"));
    this.scene.fog = new Fog(colour("sky"), 3.2 * this.bounds.radius, 7 * this.bounds.radius);
    this.floor.material.color.set(colour("floor"));
    this.grid.material.color.set(colour("grid"));
    for (const { wall, edges } of this.walls) {
      wall.material.color.set(colour("wall"));
      edges.material.color.set(colour("wall-edge"));
    }
    this.walked.mesh.material.color.set(colour("walked"));
    this.dots.material.color.set(colour("walked"));
    this.ends.forEach((disc) => disc.material.color.set(colour("ink")));
  }

  // Leaves the bodies alone: no floor, no sky.
  bare() {
    [this.scene.background, this.scene.fog] = [null, null];
    for (const part of [this.floor, this.grid, ...(this.guides ?? [])]) part.visible = false;
  }

  // Walls that hide the team from the camera become glass. Returns whether any is still changing.
  clear(camera) {
    if (!this.walls.length) return false;
    const eyes = [this.object, this.torso].map(({ position }) => position);
    let isChanging = false;
    for (const part of this.walls) {
      const hides = eyes.some((eye) => crosses(part, camera.position, eye));
      const wanted = hides ? 0.22 : 1;
      const next = Math.abs(wanted - part.opacity) < 0.02 ? wanted : part.opacity + 0.2 * (wanted - part.opacity);
      isChanging ||= next !== part.opacity;
      part.opacity = next;
      // glass needs shaders of its own: only walls that are glass take them
      if (part.wall.material.transparent !== next < 1) {
        for (const { material } of [part.wall, part.edges]) {
          material.transparent = next < 1;
          material.needsUpdate = true;
        }
      }
      part.wall.material.opacity = next;
      part.wall.material.depthWrite = next > 0.95;
      part.edges.material.opacity = 0.35 + 0.65 * next;
    }
    return isChanging;
  }
}

const matrix = new Matrix4();

// Whether the segment between two places passes through a wall's box.
function crosses({ wall }, from, to) {
  wall.geometry.boundingBox ?? wall.geometry.computeBoundingBox();
  const { min, max } = wall.geometry.boundingBox;
  let enter = 0, leave = 1;
  for (const axis of ["x", "y", "z"]) {
    const along = to[axis] - from[axis];
    if (Math.abs(along) < 1e-9) {
      if (from[axis] < min[axis] || from[axis] > max[axis]) return false;
      continue;
    }
    const [t, u] = [(min[axis] - from[axis]) / along, (max[axis] - from[axis]) / along];
    enter = Math.max(enter, Math.min(t, u));
    leave = Math.min(leave, Math.max(t, u));
  }
  return leave > enter;
}

// The box around everything, the box around where the team may go, and the middle and radius of the former.
function bounds({ world: { obstacles, start, target }, frames: { object }, options }) {
  const all = new Box3(), ways = new Box3();
  const add = (box, [x, y], z = 0) => box.expandByPoint(new Vector3(x, y, z));
  for (const { corners, center, radius, height_m: height } of obstacles) {
    corners?.forEach((corner) => add(all, corner, height));
    if (center) [-radius, radius].forEach((r) => add(all, [center[0] + r, center[1] + r], height));
  }
  [start, target].forEach((end) => add(ways, end, 1.7));
  options.forEach(({ path }) => path.forEach((place) => add(ways, place)));
  for (let i = 0; i < object.length; i += 7) add(ways, [object[i], object[i + 1]]);
  ways.expandByVector(new Vector3(1.3, 1.3, 0));
  all.union(ways);
  const center = all.getCenter(new Vector3()).setZ(0), size = all.getSize(new Vector3());
  return {
    all: { low: all.min, high: all.max }, ways: { low: ways.min, high: ways.max },
    center, radius: Math.max(options.length ? 2 : 1.6, 0.5 * Math.hypot(size.x, size.y)),
  };
}
