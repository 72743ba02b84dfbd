// The address of an episode: everything that was chosen, and a person's decisions, in the fragment. A value that cannot
// be is left out with a sentence; the others hold.
import { BEGIN } from "./choices.js";

const NUMBERS = { alpha: [0, 1e3], gamma: [0, 1e3], eta: [0, 1e6], stubbornness: [0, 1], rationality: [0, 1e3], seed: [0, 2 ** 53], period: [0, 60] };
const WORDS = ["world", "robot", "plant", "human", "method", "belief"];
const VIEWS = ["camera", "play", "embed"];
const YES = "1";
// What a link may have, and what it may unpack to, characters: decisions of half an hour have less.
const MAX_LINK = 1 << 18, MAX_TEXT = 4 << 20;

// The fragment of these choices. `log` holds a person's decisions; the world's text and the log are packed.
export async function written(now, log) {
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
  return words.toString();
}

// What a fragment says: choices, a log, what is asked of the view, and a sentence for each value that cannot be.
export async function read(fragment, catalogue) {
  const choices = {}, view = {}, faults = [];
  let log = null;
  const known = names(catalogue);
  if (fragment.length > MAX_LINK) return { choices, log, view, faults: [`it has ${fragment.length} characters; expected at most ${MAX_LINK}`] };
  for (const [key, text] of new URLSearchParams(fragment.replace(/^#/, ""))) {
    const fault = (right) => faults.push(`${key}=${text.length > 40 ? `${text.slice(0, 40)}…` : text}: expected ${right}`);
    if (VIEWS.includes(key)) view[key] = text;
    else if (key in NUMBERS) {
      const [least, most] = NUMBERS[key], value = Number(text);
      const isWhole = key !== "seed" || Number.isInteger(value);
      if (text.trim() !== "" && isWhole && value >= least && value <= most && (value > 0 || key === "seed")) choices[key] = value;
      else fault(key === "seed" ? "a whole number from 0" : `a number above ${least} and at most ${most}`);
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

async function through(bytes, stream, limit = Infinity) {
  const parts = [];
  let length = 0;
  const reader = new Blob([bytes]).stream().pipeThrough(stream).getReader();
  for (let part = await reader.read(); !part.done; part = await reader.read()) {
    length += part.value.length;
    if (length > limit) {
      reader.cancel();
      throw new Error("too long");
    }
    parts.push(part.value);
  }
  return new Uint8Array(await new Blob(parts).arrayBuffer());
}

export async function packed(text) {
  const bytes = await through(new TextEncoder().encode(text), new CompressionStream("deflate-raw"));
  let binary = "";
  for (const byte of bytes) binary += String.fromCharCode(byte);
  return btoa(binary).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
}

export async function unpacked(text) {
  const binary = atob(text.replaceAll("-", "+").replaceAll("_", "/"));
  const bytes = Uint8Array.from(binary, (c) => c.charCodeAt(0));
  const content = await through(bytes, new DecompressionStream("deflate-raw"), MAX_TEXT);
  return new TextDecoder("utf-8", { fatal: true }).decode(content);
}
