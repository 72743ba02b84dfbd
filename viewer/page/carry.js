// The human's end of the object in a person's hands: mouse, touch, keys and gamepad become a target for the hand, and
// holding back and taking the lead become a stance.
import { STANCES } from "../../crates/web/cocarry.js";

const KEYS = {
  w: [0, 1], s: [0, -1], a: [-1, 0], d: [1, 0], arrowup: [0, 1], arrowdown: [0, -1], arrowleft: [-1, 0], arrowright: [1, 0],
};
// Where a target that is farther away than this lies makes no difference, s of walking.
const AHEAD_S = 0.8;
// A person feels the force and the page's reader does not: above the first of these, N, horizontally, the hand gives way
// and walks along, until it is below the second.
const GIVES_WAY_N = 30, HOLDS_AGAIN_N = 12;
// A gamepad's stick in this part of its range is at rest.
const DEAD = 0.2;
const GAMEPAD = { resist: 1, lead: 0 };

export class Carry {
  // `floor` gives the place (m) at a point of the window, `bearing` which way is up in the picture, rad.
  constructor(box, { floor, bearing, onChange }) {
    Object.assign(this, { floor, bearing, onChange, keys: new Set(), pointer: null, isResisting: false, isLeading: false, isOn: false });
    box.addEventListener("pointerdown", (event) => {
      if (!this.isOn || event.button !== 0 || !event.target.closest("#view, #map")) return;
      event.preventDefault();
      box.setPointerCapture(event.pointerId);
      this.pointer = { id: event.pointerId, x: event.clientX, y: event.clientY };
      onChange();
    });
    box.addEventListener("pointermove", (event) => {
      if (this.pointer?.id === event.pointerId) Object.assign(this.pointer, { x: event.clientX, y: event.clientY });
    });
    for (const end of ["pointerup", "pointercancel"]) {
      box.addEventListener(end, (event) => this.pointer?.id === event.pointerId && (this.pointer = null));
    }
    addEventListener("blur", () => this.release());
  }

  turnOn(isOn) {
    this.isOn = isOn;
    this.release();
    this.isLeading = false;
  }

  // Lets go of everything that is held.
  release() {
    this.keys.clear();
    this.pointer = null;
    this.isResisting = false;
    this.onChange?.();
  }

  // Takes a key; returns whether it is one of the carrier's.
  key(event, isDown) {
    if (!this.isOn || event.ctrlKey || event.metaKey || event.altKey) return false;
    const name = event.key.toLowerCase();
    if (KEYS[name]) {
      if (isDown) this.keys.add(name);
      else this.keys.delete(name);
      this.isFast = event.shiftKey;
    } else if (name === "r") this.resist(isDown);
    else if (name === "t" && isDown && !event.repeat) this.lead(!this.isLeading);
    else return name === "t";
    this.onChange();
    return true;
  }

  resist(isResisting) {
    this.isResisting = isResisting;
    this.onChange();
  }

  lead(isLeading) {
    this.isLeading = isLeading;
    this.onChange();
  }

  // The direction that keys or a gamepad's stick give, on the floor; null at rest.
  #direction() {
    let [right, up] = [...this.keys].reduce(([x, y], key) => [x + KEYS[key][0], y + KEYS[key][1]], [0, 0]);
    for (const pad of navigator.getGamepads?.() ?? []) {
      if (!pad?.connected) continue;
      const [x, y] = [pad.axes[0] ?? 0, -(pad.axes[1] ?? 0)];
      if (Math.hypot(x, y) > DEAD) [right, up] = [right + x, up + y];
      this.#buttons(pad);
    }
    const size = Math.hypot(right, up);
    if (size < 1e-6) return null;
    const angle = this.bearing() - Math.PI / 2, [c, s] = [Math.cos(angle), Math.sin(angle)];
    const part = Math.min(1, size) / size;
    return [part * (c * right - s * up), part * (s * right + c * up)];
  }

  #buttons(pad) {
    const pressed = (i) => Boolean(pad.buttons[i]?.pressed);
    const now = { resist: pressed(GAMEPAD.resist), lead: pressed(GAMEPAD.lead) };
    const before = this.pad ?? { resist: false, lead: false };
    if (now.resist !== before.resist) this.resist(now.resist);
    if (now.lead && !before.lead) this.lead(!this.isLeading);
    this.pad = now;
  }

  // Tells the module what the person does, before a control period. Returns where the hand shall go, for the picture.
  decide(core, options) {
    const [x, y] = core.part("hand"), [fastest] = core.part("hand_limits");
    const period = core.about.scenario.control_period_s, usual = core.about.scenario.speed_m_per_s;
    let goal = null, speed = 0;
    const direction = this.#direction();
    if (direction) {
      speed = this.isFast ? fastest : Math.min(fastest, 1.2 * usual);
      goal = [x + direction[0] * speed * AHEAD_S, y + direction[1] * speed * AHEAD_S];
    } else if (this.pointer) {
      goal = this.floor(this.pointer.x, this.pointer.y);
      if (goal) speed = Math.min(fastest, 1.2 * usual, Math.hypot(goal[0] - x, goal[1] - y) / AHEAD_S);
    }
    const [fx, fy] = core.part("hand_wrench_now"), force = Math.hypot(fx, fy);
    if (force > GIVES_WAY_N) this.givesWay = true;
    else if (!(force > HOLDS_AGAIN_N)) this.givesWay = false;
    const stance = this.isResisting ? STANCES.resist : this.isLeading ? STANCES.takeOver : STANCES.follow;
    core.human(this.isLeading && goal ? nearest(options, goal) : -1, stance);
    if (!goal || this.givesWay) core.hand();
    else {
      const far = Math.hypot(goal[0] - x, goal[1] - y), part = far > 1e-6 ? Math.min(1, (speed * period) / far) : 0;
      core.hand(mm(x + part * (goal[0] - x)), mm(y + part * (goal[1] - y)));
    }
    return goal;
  }
}

// Decisions are whole millimetres: a link stays short.
const mm = (value) => Math.round(value * 1e3) / 1e3;

// The option whose path from the start passes nearest to a place.
function nearest(options, [x, y]) {
  let best = -1, least = Infinity;
  options.forEach(({ path }, o) => {
    for (let i = 1; i < path.length; i++) {
      const [[ax, ay], [bx, by]] = [path[i - 1], path[i]];
      const length = (bx - ax) ** 2 + (by - ay) ** 2;
      const t = length ? Math.min(1, Math.max(0, ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / length)) : 0;
      const gap = Math.hypot(ax + t * (bx - ax) - x, ay + t * (by - ay) - y);
      if (gap < least - 1e-9) [best, least] = [o, gap];
    }
  });
  return best;
}
