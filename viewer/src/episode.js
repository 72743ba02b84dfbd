// The episode that the page holds: figures by step, poses by time.
import { Quaternion, Vector3 } from "three";

export class Episode {
  constructor(data) {
    Object.assign(this, data);
    const { time_s: times } = this.frames;
    this.duration = times[times.length - 1];
    this.count = this.steps.decided_s.length;
  }

  // The step that runs at a time: figures of a step hold from its beginning to its end.
  step(time) {
    return Math.max(0, last(this.steps.decided_s, time));
  }

  figure(key, step) {
    return this.steps.figures[key]?.values[step] ?? null;
  }

  isHumanLed(step) {
    return this.steps.mode[step] === "human-led";
  }

  // The newest event at a time; -1 before the first.
  event(time) {
    return last(this.events.map((event) => event.time_s), time);
  }

  // The poses on both sides of a time, and how far it lies between them.
  between(time) {
    const times = this.frames.time_s;
    const before = Math.min(Math.max(0, last(times, time)), times.length - 1);
    const after = Math.min(before + 1, times.length - 1);
    const span = times[after] - times[before];
    return { before, after, part: span > 0 ? Math.min(1, Math.max(0, (time - times[before]) / span)) : 0 };
  }

  // Moves an object in the scene to where a body is.
  place(object, poses, { before, after, part }) {
    read(poses, before, position, rotation);
    read(poses, after, position2, rotation2);
    object.position.lerpVectors(position, position2, part);
    object.quaternion.slerpQuaternions(rotation, rotation2, part);
  }

  pathAhead(time) {
    const found = last(this.ahead.map(([from]) => from), time);
    return found < 0 ? [] : this.ahead[found][1];
  }

  // Where the object was, from the start to a time: [x, y, x, y, ...].
  walked({ before, after, part }) {
    const poses = this.frames.object;
    const line = [];
    for (let i = 0; i <= before; i++) line.push(poses[7 * i], poses[7 * i + 1]);
    const mix = (k) => poses[7 * before + k] + part * (poses[7 * after + k] - poses[7 * before + k]);
    line.push(mix(0), mix(1));
    return line;
  }
}

const position = new Vector3(), position2 = new Vector3();
const rotation = new Quaternion(), rotation2 = new Quaternion();

export function read(poses, i, position, rotation) {
  position.fromArray(poses, 7 * i);
  rotation.fromArray(poses, 7 * i + 3);
}

// The index of the last value that is not above `limit`, to a rounding error; -1 if all are above.
export function last(values, limit) {
  let low = 0, high = values.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle] <= limit + 1e-6) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

// `xi12` as the Greek letter with its index, other names as they are; safe as HTML.
export function symbol(name) {
  const opening = /^xi(\d+)$/.exec(name);
  return opening ? `ξ<sub>${opening[1]}</sub>` : escaped(name);
}

export function escaped(text) {
  return String(text).replace(/[&<>"]/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[c]);
}
