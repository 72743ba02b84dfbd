// The address of an episode: everything that was chosen, and a person's decisions, in the fragment. A value that cannot
// be is left out with a sentence; the others hold.
import { packed, unpacked } from "../src/packed.js";
import { BEGIN } from "./choices.js";

// Numbers, with the settings in the module's catalogue that have their ranges.
const NUMBERS = {
  alpha: null, gamma: null, eta: "eta", stubbornness: "initial_stubbornness", rationality: "belief_rationality", seed: null, period: "control_period_s",
};
const WORDS = ["world", "robot", "plant", "human", "method", "belief"];
// What is looked at: the camera, whether it plays, a frame in another page, the time that is shown first (s; with `carry`,
// from which the person carries), and where the object is then (m), of an episode from elsewhere.
const VIEWS = ["camera", "play", "embed", "t", "object"];
const YES = "1";
// What a link may have, characters.
const MAX_LINK = 1 << 18;

// The fragment of these choices. `log` holds a person's decisions; the world's text and the log are packed. `time` is the
// one that is shown first; null for the beginning.
export async function written(now, log, time = null) {
  const words = new URLSearchParams();
  for (const key of [...WORDS, ...Object.keys(NUMBERS)]) {
    if (key === "world" && now.toml !== null) continue;
    if (key === "rationality" && now.human !== "boltzmann") continue;
    if (now[key] !== BEGIN[key]) words.set(key, String(now[key]));
  }
  if (now.carry) words.set("carry", YES);
  if (now.scenario !== null) {
    for (const key of [...words.keys()]) if (key !== "carry") words.delete(key);
    words.set("scenario", await packed(now.scenario));
  } else if (now.toml !== null) words.set("file", await packed(now.toml));
  if (log) words.set("log", await packed(JSON.stringify(log)));
  if (time !== null) words.set("t", String(time));
  return words.toString();
}

// What a fragment says: choices, a log, what is asked of the view, and a sentence for each value that cannot be.
export async function read(fragment, catalogue) {
  const choices = {}, view = {}, faults = [];
  let log = null;
  const known = names(catalogue), numbers = ranges(catalogue);
  if (fragment.length > MAX_LINK) return { choices, log, view, faults: [`it has ${fragment.length} characters; expected at most ${MAX_LINK}`] };
  for (const [key, text] of new URLSearchParams(fragment.replace(/^#/, ""))) {
    const fault = (right) => faults.push(`${key}=${text.length > 40 ? `${text.slice(0, 40)}…` : text}: expected ${right}`);
    if (VIEWS.includes(key)) {
      const isNumber = key === "t" || key === "object", values = text.split(",").map(Number);
      if (!isNumber) view[key] = text;
      else if (text.trim() === "" || values.length !== { t: 1, object: 3 }[key] || !values.every(Number.isFinite)) fault({ t: "a time, s", object: "a place, m" }[key]);
      else view[key] = key === "t" ? values[0] : values;
    } else if (key in numbers) {
      const { least, least_is_open: isOpen, most, isWhole } = numbers[key], value = Number(text);
      const isIn = (isOpen ? value > least : value >= least) && value <= most && (!isWhole || Number.isInteger(value));
      if (text.trim() !== "" && isIn) choices[key] = value;
      else fault(`a ${isWhole ? "whole " : ""}number ${isOpen ? "above" : "from"} ${least} ${isOpen ? "and at most" : "to"} ${most}`);
    } else if (key === "carry") {
      if (text === YES) choices.carry = true;
      else fault(YES);
    } else if (key in known) {
      if (known[key].includes(text)) choices[key] = text;
      else fault(`one of ${known[key].join(", ")}`);
    } else if (["file", "log", "scenario"].includes(key)) {
      try {
        const content = await unpacked(text);
        if (key === "log") log = JSON.parse(content);
        else choices[key === "file" ? "toml" : key] = content;
      } catch {
        fault(`${{ file: "a world", log: "decisions", scenario: "a scenario" }[key]} that this page packed`);
      }
    } else fault(`one of ${[...Object.keys(known), ...Object.keys(NUMBERS)].join(", ")} as the key`);
  }
  return { choices, log, view, faults };
}

function names({ worlds, robots, plants, methods }) {
  const of = (list) => list.map(({ name }) => name);
  return {
    world: of(worlds), robot: of(robots), plant: of(plants), method: of(methods),
    human: ["preference", "boltzmann"], belief: ["prior", "learn"],
  };
}

// The range of every number.
function ranges({ settings, perception }) {
  const own = { alpha: perception, gamma: perception, seed: { least: 0, most: Number.MAX_SAFE_INTEGER, isWhole: true } };
  return Object.fromEntries(Object.entries(NUMBERS).map(([key, setting]) => [key, own[key] ?? settings.find((known) => known.key === setting)]));
}
