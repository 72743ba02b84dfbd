// Changes of a world file: its obstacles, A and B. A world is the object of its TOML text; what the page does not know
// of it stays as it is.
import { parse, stringify } from "smol-toml";

// Walls that are drawn, m.
const THICKNESS = 0.1, HEIGHT = 1.2;
const SHORTEST = 0.2;

export const read = (text) => parse(text);

// The text of a world. With `isDetected`, without the openings and options that it declares: those of a changed world are
// found anew.
export function written(world, isDetected = false) {
  const { opening, option, ...rest } = world;
  return stringify(isDetected ? rest : world);
}

export const hasDeclared = (world) => Boolean(world.opening?.length || world.option?.length);

const cm = (value) => Math.round(value * 100) / 100 + 0;
const moved = ([x, y], [dx, dy]) => [cm(x + dx), cm(y + dy)];

// Whether an obstacle can be moved: the walls of a room cannot.
export const isMovable = (obstacle) => obstacle.shape !== "room";
export const isTurnable = (obstacle) => obstacle.shape === "box";

function changed(world, index, change) {
  const obstacle = world.obstacle.map((item, i) => (i === index ? { ...item, ...change(item) } : item));
  return { ...world, obstacle };
}

export function move(world, index, by) {
  return changed(world, index, (item) => ({
    ...(item.center_m && { center_m: moved(item.center_m, by) }),
    ...(item.vertices_m && { vertices_m: item.vertices_m.map((corner) => moved(corner, by)) }),
    ...(item.holes_m && { holes_m: item.holes_m.map((hole) => hole.map((corner) => moved(corner, by))) }),
  }));
}

// Turns a box about its centre.
export function turn(world, index, degrees) {
  return changed(world, index, (item) => {
    const yaw = (item.yaw_deg ?? 0) + degrees;
    return { yaw_deg: Math.round((((yaw % 360) + 540) % 360) - 180) };
  });
}

// Makes a box longer, or a cylinder wider.
export function stretch(world, index, by) {
  return changed(world, index, (item) => {
    if (item.radius_m !== undefined) return { radius_m: Math.max(0.05, cm(item.radius_m + by / 2)) };
    if (!item.size_m) return {};
    const along = item.size_m[0] >= item.size_m[1] ? 0 : 1;
    return { size_m: item.size_m.map((size, axis) => (axis === along ? Math.max(0.1, cm(size + by)) : size)) };
  });
}

export function remove(world, index) {
  return { ...world, obstacle: world.obstacle.filter((_, i) => i !== index) };
}

// A wall between two places; the same world where they are too close to each other.
export function wall(world, [x0, y0], [x1, y1]) {
  const length = Math.hypot(x1 - x0, y1 - y0);
  if (length < SHORTEST) return world;
  const taken = new Set((world.obstacle ?? []).map(({ name }) => name));
  let number = 1;
  while (taken.has(`drawn-${number}`)) number++;
  const yaw = Math.round((Math.atan2(y1 - y0, x1 - x0) * 180) / Math.PI * 10) / 10;
  const drawn = {
    name: `drawn-${number}`, shape: "box", center_m: [cm((x0 + x1) / 2), cm((y0 + y1) / 2)],
    size_m: [cm(length), THICKNESS], ...(yaw && { yaw_deg: yaw }), height_m: HEIGHT,
  };
  return { ...world, obstacle: [...(world.obstacle ?? []), drawn] };
}

// Moves A (`start_m`) or B (`target_m`).
export function moveEnd(world, key, by) {
  return { ...world, [key]: moved(world[key], by) };
}
