// The task "carry": the simulator runs in the page, and the participant is the human who carries along.
import { OVER, STEP_DONE, load } from "../../../crates/web/cocarry.js";
import { Carry } from "../../page/carry.js";
import { make, plugin, practice, show } from "./page.js";

const SVG = "http://www.w3.org/2000/svg";
// What is caught up at most after a pause, s; a picture later than this after the one before is a stall, ms.
const MAX_CAUGHT_UP_S = 0.1, STALL_MS = 100;
// The person from above, as in the pictures of the book, m.
const SHOULDERS_M = 0.19, TORSO_M = [0.14, 0.25], HEAD_M = 0.1;
const WORDS = { arrived: "You have arrived.", other: "The walk has ended here." };

let module = null;

const element = (name, attributes) => {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
};

// The team from above; `update` moves it to the state of an episode.
function team({ scale_px: scale, anchor, start_m: start, object_m: [length, breadth] }, { colours, base_m: base }) {
  const px = ([x, y]) => [anchor[0] + (x - start[0]) * scale, anchor[1] - (y - start[1]) * scale];
  const outline = { stroke: "#1d2733", "stroke-width": 1 };
  const robot = element("polygon", { points: base.map(([x, y]) => `${x * scale},${-y * scale}`).join(" "), fill: colours.robot, ...outline });
  const object = element("rect", { x: (-length / 2) * scale, y: (-breadth / 2) * scale, width: length * scale, height: breadth * scale, fill: colours.object, ...outline });
  const torso = element("ellipse", { rx: TORSO_M[0] * scale, ry: TORSO_M[1] * scale, fill: colours.human, ...outline });
  const head = element("circle", { cx: 0.03 * scale, r: HEAD_M * scale, fill: colours.hair });
  const line = (colour, width) => element("line", { stroke: colour, "stroke-width": width * scale, "stroke-linecap": "round" });
  const arm = line(colours.robot, 0.09), arms = [line(colours.human, 0.07), line(colours.human, 0.07)];
  const human = element("g", {});
  human.append(torso, head);
  const group = element("g", {});
  group.append(robot, arm, ...arms, object, human);
  const turn = (yaw, [x, y]) => `translate(${x} ${y}) rotate(${(-yaw * 180) / Math.PI})`;
  const between = (line, from, to) => {
    const [[x1, y1], [x2, y2]] = [px(from), px(to)];
    for (const [key, value] of Object.entries({ x1, y1, x2, y2 })) line.setAttribute(key, value);
  };
  const yawOf = (pose) => Math.atan2(2 * (pose[6] * pose[5] + pose[3] * pose[4]), 1 - 2 * (pose[4] ** 2 + pose[5] ** 2));
  const update = (core) => {
    const [bx, by, heading] = core.part("base"), carried = [...core.part("object")], walker = [...core.part("torso")];
    const yaw = yawOf(carried), facing = yawOf(walker), along = [Math.cos(yaw), Math.sin(yaw)];
    const end = (side) => [carried[0] + (side * length * along[0]) / 2, carried[1] + (side * length * along[1]) / 2];
    robot.setAttribute("transform", turn(heading, px([bx, by])));
    object.setAttribute("transform", turn(yaw, px(carried)));
    human.setAttribute("transform", turn(facing, px(walker)));
    between(arm, [bx, by], end(-1));
    arms.forEach((line, i) => {
      const side = i ? -1 : 1, [x, y] = end(1);
      const shoulder = [walker[0] - Math.sin(facing) * SHOULDERS_M * side, walker[1] + Math.cos(facing) * SHOULDERS_M * side];
      between(line, shoulder, [x - (along[1] * breadth * side) / 2, y + (along[0] * breadth * side) / 2]);
    });
  };
  const back = ([x, y]) => [start[0] + (x - anchor[0]) / scale, start[1] - (y - anchor[1]) / scale];
  return { group, update, back };
}

// Calls `change` while a button is held, by pointer or key.
function held(button, change) {
  let isHeld = false;
  const turn = (next) => next !== isHeld && change((isHeld = next));
  button.addEventListener("pointerdown", (event) => {
    if (event.button === 0) turn(true);
  });
  for (const end of ["pointerup", "pointercancel", "pointerleave", "blur"]) button.addEventListener(end, () => turn(false));
  button.addEventListener("keydown", ({ code }) => code === "Space" && turn(true));
  button.addEventListener("keyup", ({ code }) => code === "Space" && turn(false));
  // what is held down on a touch screen is not a menu
  button.addEventListener("contextmenu", (event) => event.preventDefault());
}

// Notes where a pointer that is down on the picture is, m in whole millimetres, and of what kind it is.
function pointerNotes(stage, floor, note) {
  let isOn = false;
  const down = new Set();
  const tell = (event) => {
    const at = floor(event.clientX, event.clientY).map((value) => Math.round(value * 1e3) / 1e3);
    note(event.type, { data: { at, by: event.pointerType } });
  };
  stage.addEventListener("pointerdown", (event) => {
    if (!isOn || event.button !== 0) return;
    down.add(event.pointerId);
    tell(event);
  });
  stage.addEventListener("pointermove", (event) => down.has(event.pointerId) && tell(event));
  for (const end of ["pointerup", "pointercancel"]) stage.addEventListener(end, (event) => down.delete(event.pointerId) && tell(event));
  return { turnOn: (next) => void (isOn = next) };
}

// Notes stick and buttons of gamepads where they change; called for every picture.
function gamepadNotes(note) {
  const known = new Map();
  return () => {
    for (const pad of navigator.getGamepads?.() ?? []) {
      if (!pad?.connected) continue;
      const stick = [0, 1].map((axis) => Math.round((pad.axes[axis] ?? 0) * 100) / 100);
      const data = { pad: pad.index, stick, pressed: pad.buttons.flatMap(({ pressed }, index) => (pressed ? [index] : [])) };
      const text = JSON.stringify(data);
      if (known.get(pad.index) === text) continue;
      known.set(pad.index, text);
      note("gamepad", { data });
    }
  };
}

export const CarryAlong = plugin("carry", async (display, trial) => {
  const { world, carry, method, note } = trial;
  show(display, "Carry along", make("p", {}, "One moment: the simulator is loaded."));
  module ??= await load(fetch("cocarry.wasm"));
  const scenario = await (await fetch(`carries/${world.number}-${method}.toml`)).text();
  const core = module.open(scenario);
  const [width, height] = world.size;
  const map = make("img", { class: "map", src: world.file, alt: "Map of walls and obstacles from above, with A, B and the ways", width, height });
  const picture = element("svg", { viewBox: `0 0 ${width} ${height}`, "aria-hidden": "true" });
  const bodies = team(world, carry);
  picture.append(bodies.group);
  bodies.update(core);
  // the one in which pointers count
  const stage = make("div", { class: "stage carried", id: "map" }, map, picture);
  const says = make("p", { role: "status" }, "You are the person in blue. Move your hand with a finger or the mouse held down on the picture, the arrow keys, or a gamepad's stick. T or the button takes the lead, and gives it back; R or the button, held, resists.");
  const button = make("button", { type: "button", disabled: true }, "Start");
  const lead = make("button", { type: "button", class: "quiet", hidden: true, "aria-pressed": "false" }, "Take the lead (T)");
  const resist = make("button", { type: "button", class: "quiet", hidden: true, "aria-pressed": "false" }, "Resist (hold R)");
  show(display, "Carry along", ...practice(trial), stage, says, make("p", { class: "hands" }, button, lead, resist));
  await map.decode().catch(() => {});
  button.disabled = false;
  button.focus({ preventScroll: true });

  // the place on the floor at a point of the window
  const floor = (x, y) => {
    const at = picture.getScreenCTM().inverse();
    return bodies.back([at.a * x + at.c * y + at.e, at.b * x + at.d * y + at.f]);
  };
  const hands = new Carry(stage, { floor, bearing: () => Math.PI / 2, onChange: () => tell() });
  const tell = () => {
    lead.setAttribute("aria-pressed", String(hands.isLeading));
    lead.textContent = hands.isLeading ? "Give the lead back (T)" : "Take the lead (T)";
    resist.setAttribute("aria-pressed", String(hands.isResisting));
  };
  const keyed = (event) => {
    if (!hands.key(event, event.type === "keydown")) return;
    event.preventDefault();
    if (!event.repeat) note(event.type, { data: { key: event.key } });
  };
  lead.addEventListener("click", () => {
    hands.lead(!hands.isLeading);
    note("lead", { data: { on: hands.isLeading } });
  });
  held(resist, (isHeld) => {
    hands.resist(isHeld);
    note("resist", { data: { on: isHeld } });
  });
  const pointed = pointerNotes(stage, floor, note), padded = gamepadNotes(note);
  await new Promise((begin) => button.addEventListener("click", begin, { once: true }));
  button.hidden = true;
  lead.hidden = resist.hidden = false;
  hands.turnOn(true);
  pointed.turnOn(true);
  for (const event of ["keydown", "keyup"]) document.addEventListener(event, keyed);

  const options = core.about.options, time = () => core.value("time");
  let frames = 0, stalls = 0, longest = 0, lost = 0;
  await new Promise((done) => {
    let before = null, wanted = 0, second = 0;
    const picture = (now) => {
      const since = before === null ? 0 : now - before;
      before = now;
      frames += 1;
      longest = Math.max(longest, since);
      if (since > STALL_MS) stalls += 1;
      lost += Math.max(0, since / 1000 - MAX_CAUGHT_UP_S);
      wanted += Math.min(since / 1000, MAX_CAUGHT_UP_S);
      padded();
      let progress = null;
      while (time() < wanted && progress !== OVER) {
        hands.decide(core, options);
        progress = core.period();
        if (progress === STEP_DONE && Math.floor(time() + 1e-9) > second) {
          second = Math.floor(time() + 1e-9);
          note("digest", { data: { s: second, digest: core.digest() } });
        }
      }
      bodies.update(core);
      if (progress === OVER) return done();
      requestAnimationFrame(picture);
    };
    requestAnimationFrame(picture);
  });
  for (const event of ["keydown", "keyup"]) document.removeEventListener(event, keyed);
  hands.turnOn(false);
  pointed.turnOn(false);
  const log = core.log();
  core.close();
  says.textContent = log.outcome === "arrived" ? WORDS.arrived : WORDS.other;
  lead.hidden = resist.hidden = true;
  button.hidden = false;
  button.textContent = "Continue";
  button.focus({ preventScroll: true });
  await new Promise((go) => button.addEventListener("click", go, { once: true }));
  return {
    world: world.name, method, practice: trial.practice, log: JSON.stringify(log), frames, stalls,
    longest_frame_ms: Math.round(longest), lost_s: Math.round(1000 * lost) / 1000,
  };
});
