// The task "switch": the robot leads on an option, in real time, until the participant presses or it arrives.
import { make, plugin, practice, show } from "./page.js";

const SVG = "http://www.w3.org/2000/svg";
// A picture that comes later than this after the one before is a stall, ms.
const STALL_MS = 100;

// The team over the map at a time (ms) of a walk.
function place(group, world, walk, ms) {
  const at = Math.min(ms / walk.frame_ms, walk.frames.length - 1);
  const before = Math.floor(at), part = at - before;
  const [a, b] = [walk.frames[before], walk.frames[Math.min(before + 1, walk.frames.length - 1)]];
  // the shorter way round
  const turn = ((((b[2] - a[2]) % 360) + 540) % 360) - 180;
  const [x, y, angle] = [a[0] + (b[0] - a[0]) * part, a[1] + (b[1] - a[1]) * part, a[2] + turn * part];
  group.setAttribute("transform", `translate(${x} ${y}) rotate(${angle}) translate(${-world.anchor[0]} ${-world.anchor[1]})`);
}

export const Switch = plugin("switch", async (display, trial) => {
  const { world, option, repetition, note } = trial;
  const walk = world.walks[option], duration = walk.steps * walk.step_ms;
  const [width, height] = world.size;
  const map = make("img", { class: "map", src: world.file, alt: "Map of walls and obstacles from above, with A, B and the ways", width, height });
  const picture = document.createElementNS(SVG, "svg");
  picture.setAttribute("viewBox", `0 0 ${width} ${height}`);
  picture.setAttribute("aria-hidden", "true");
  const group = document.createElementNS(SVG, "g");
  // made by the program from numbers alone
  group.innerHTML = world.team;
  picture.append(group);
  place(group, world, walk, 0);
  const says = make("p", { role: "status" }, "Press the space bar, or the button, to start.");
  const button = make("button", { type: "button", disabled: true }, "Start");
  show(display, "When would you stop following the robot?", ...practice(trial), make("div", { class: "stage" }, map, picture), says, make("p", {}, button));
  await map.decode().catch(() => {});
  button.disabled = false;
  button.focus({ preventScroll: true });

  return new Promise((done) => {
    let phase = "ready", began = 0, last = 0, frames = 0, plays = 0, stalls = 0, longest = 0, answer = null;
    const stop = () => {
      for (const event of ["keydown", "keyup"]) document.removeEventListener(event, keyed);
      document.removeEventListener("visibilitychange", hidden);
    };
    const result = () => ({
      world: world.name, option: world.options[option], repetition, practice: trial.practice, ...answer, plays, stalls, longest_frame_ms: Math.round(longest),
    });
    const start = () => {
      [phase, frames, stalls, longest] = ["playing", 0, 0, 0];
      plays += 1;
      note("play");
      button.textContent = "I would stop following now";
      says.textContent = "Press the space bar, or the button, at the moment at which you would stop following the robot.";
      requestAnimationFrame(first);
    };
    const first = (now) => {
      if (phase !== "playing") return;
      began = last = now;
      frames = 1;
      requestAnimationFrame(next);
    };
    const next = (now) => {
      if (phase !== "playing") return;
      longest = Math.max(longest, now - last);
      if (now - last > STALL_MS) stalls += 1;
      last = now;
      frames += 1;
      const ms = now - began;
      place(group, world, walk, Math.min(ms, duration));
      if (ms < duration) return requestAnimationFrame(next);
      phase = "arrived";
      note("arrived");
      answer = { step: null, ms: null, frame: null };
      says.textContent = "The robot has arrived, and you followed it to the end.";
      button.textContent = "Continue";
    };
    // `time` is that of the event, by the clock of the pictures
    const press = (time) => {
      if (phase === "ready") return start();
      if (phase === "playing" && frames > 0) {
        phase = "done";
        const ms = Math.max(0, time - began);
        answer = { step: Math.min(Math.floor(ms / walk.step_ms), walk.steps - 1), ms: Math.round(ms), frame: frames };
        note("press", { data: answer });
        stop();
        done(result());
      } else if (phase === "arrived") {
        phase = "done";
        stop();
        done(result());
      }
    };
    const keyed = (event) => {
      if (event.code !== "Space") return;
      // the button would be pressed once more when the key comes up
      event.preventDefault();
      // only a press that is meant: after the end the button, or Enter on it, goes on
      if (event.type === "keydown" && !event.repeat && phase !== "arrived") press(event.timeStamp);
    };
    // a walk that was not seen whole is shown anew
    const hidden = () => {
      if (!document.hidden || phase !== "playing") return;
      phase = "ready";
      note("hidden-while-playing");
      place(group, world, walk, 0);
      button.textContent = "Start";
      says.textContent = "The page was hidden, so the walk begins anew. Press the space bar, or the button, to start.";
    };
    for (const event of ["keydown", "keyup"]) document.addEventListener(event, keyed);
    document.addEventListener("visibilitychange", hidden);
    let isPointer = false;
    button.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      isPointer = true;
      press(event.timeStamp);
    });
    button.addEventListener("click", (event) => {
      // the press was counted when the pointer went down
      if (isPointer) isPointer = false;
      else press(event.timeStamp);
    });
  });
});
