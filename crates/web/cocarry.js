// The WebAssembly module of cocarry, called from JavaScript. README.md has its functions, and what they answer.
// const module = await load(fetch("cocarry.wasm"));
// const episode = module.open(module.scenario({ world: "environment-4", plant: "rapier" }).scenario);
// while (episode.step() !== OVER) console.log(episode.value("time"), episode.part("option_probability"));

/** What `period`, `step` and `run` return. */
export const OVER = 0;
export const WITHIN_STEP = 1;
export const STEP_DONE = 2;

/** What a human does, and who leads, in `human` and `policy`. */
export const BY_SCENARIO = -1;
export const STANCES = { follow: 0, resist: 1, takeOver: 2 };
export const LEADS = { robot: 0, human: 1, humanKeepingOption: 2 };

/** A refused input: `message` is the module's sentence. */
export class Refused extends Error {
  name = "Refused";
}

/** A fault within the module: its instance must not be used any more. */
export class Broken extends Error {
  name = "Broken";
}

/** Loads the module from a Response (or a promise of one), its bytes, or a WebAssembly.Module. */
export async function load(source) {
  const given = await source;
  let instance;
  if (given instanceof WebAssembly.Module) {
    instance = await WebAssembly.instantiate(given, {});
  } else if (typeof Response !== "undefined" && given instanceof Response) {
    if (!given.ok) throw new Error(`${given.url}: the server answered ${given.status}`);
    const streams = given.headers.get("content-type")?.startsWith("application/wasm");
    const loaded = streams
      ? await WebAssembly.instantiateStreaming(given, {})
      : await WebAssembly.instantiate(await given.arrayBuffer(), {});
    instance = loaded.instance;
  } else {
    instance = (await WebAssembly.instantiate(given, {})).instance;
  }
  return new Module(instance.exports);
}

const encoder = new TextEncoder();
const decoder = new TextDecoder();

export class Module {
  #exports;
  #isBroken = false;

  constructor(exports) {
    this.#exports = exports;
  }

  /** Worlds, robots, plants, methods, humans and settings. */
  catalogue = () => this.#json("catalogue");
  /** The stamp of the arithmetic, and digests of its parts. */
  arithmetic = () => this.#json("arithmetic");
  /** A world as it is drawn, with its options and, with `regions: true`, the regions of the (alpha, gamma) plane. */
  world = (parts) => this.#json("world", parts);
  /** The text of a scenario, and the command line that gives the same episode. */
  scenario = (parts) => this.#json("scenario", parts);
  /** Links with shapes, meshes, joints and postures of a robot. */
  robot = (name) => this.#json("robot", { robot: name });
  /** An episode of a scenario's text, before its first step. */
  open = (scenario) => this.#episode("open", encoder.encode(scenario));
  /** An episode in the state of a snapshot (bytes). */
  restore = (snapshot) => this.#episode("restore", snapshot);
  /** An episode that repeats the decisions of a log. */
  replay = (log) => this.#episode("replay", encoder.encode(typeof log === "string" ? log : JSON.stringify(log)));

  #episode(name, input) {
    this.write(input);
    return new Episode(this, this.call(name, 0));
  }

  #json(name, input) {
    if (input !== undefined) this.write(encoder.encode(JSON.stringify(input)));
    this.call(name, 0);
    return JSON.parse(this.text());
  }

  /** Makes bytes the input of the next call. */
  write(bytes) {
    const address = this.call("input", 0, bytes.length) >>> 0;
    new Uint8Array(this.#exports.memory.buffer, address, bytes.length).set(bytes);
  }

  /** Calls a function; `failed` is what it returns where it refuses its input. */
  call(name, failed, ...args) {
    if (this.#isBroken) throw new Broken("the module stopped at an earlier fault");
    let result;
    try {
      result = this.#exports[`cocarry_${name}`](...args);
    } catch (fault) {
      this.#isBroken = true;
      throw new Broken(this.text() || String(fault), { cause: fault });
    }
    if (result === failed) throw new Refused(this.text());
    return result;
  }

  /** The output of the last call, a copy. */
  bytes() {
    const { memory, cocarry_output, cocarry_output_length } = this.#exports;
    const length = cocarry_output_length();
    return new Uint8Array(memory.buffer, cocarry_output() >>> 0, length).slice();
  }

  text() {
    return decoder.decode(this.bytes());
  }

  /** A view of numbers in the module's memory, valid until the next call. */
  numbers(address, length) {
    return new Float64Array(this.#exports.memory.buffer, address >>> 0, length);
  }
}

export class Episode {
  #module;
  #handle;
  #address;
  #length;
  #fields;
  /** What `describe` answered when the episode was opened. */
  about;

  constructor(module, handle) {
    this.#module = module;
    this.#handle = handle;
    this.about = this.#json("describe");
    const { length, fields } = this.about.state;
    this.#length = length;
    this.#fields = new Map(fields.map((field) => [field.name, field]));
    this.#address = module.call("state", 0, handle);
  }

  #json(name) {
    this.#call(name, 0);
    return JSON.parse(this.#module.text());
  }

  #call(name, failed, ...args) {
    return this.#module.call(name, failed, this.#handle, ...args);
  }

  /** The whole state: a view that is valid until the next call of the module. */
  state = () => this.#module.numbers(this.#address, this.#length);

  /** The first number of a field of the state. */
  value = (name) => this.state()[this.#field(name).offset];

  /** The numbers of a field of the state: a view as of `state`. */
  part(name) {
    const { offset, count } = this.#field(name);
    return this.state().subarray(offset, offset + count);
  }

  #field(name) {
    const field = this.#fields.get(name);
    if (!field) throw new Error(`the state has no field ${name}`);
    return field;
  }

  /** The human's decision from the next planning step on; BY_SCENARIO leaves it to the scenario's human. */
  human = (option = BY_SCENARIO, stance = BY_SCENARIO) => this.#call("human", 0, option, stance);
  /** The target of the human's hand (m) from the next control period on; no arguments: none. */
  hand = (x = NaN, y = NaN) => this.#call("hand", 0, x, y);
  /** Who leads from the next planning step on; BY_SCENARIO leaves it to the scenario's method. */
  policy = (lead = BY_SCENARIO, option = BY_SCENARIO) => this.#call("policy", 0, lead, option);
  /** Moves everybody by a control period: OVER, WITHIN_STEP or STEP_DONE. */
  period = () => this.#call("period", -1);
  /** Moves everybody to the end of the planning step. */
  step = () => this.#call("step", -1);
  /** Moves everybody by whole control periods, for at least `seconds` of simulated time. */
  run = (seconds) => this.#call("run", -1, seconds);
  /** The events since the last call. */
  events = () => this.#json("events");
  /** The path ahead. */
  path = () => this.#json("path").points;
  /** The regions of the (alpha, gamma) plane from where the team is. */
  regions = () => this.#json("regions");
  /** The figures of the episode so far. */
  summary = () => this.#json("summary");
  /** Scenario, decisions and digests: what a replay needs. */
  log = () => this.#json("log");

  /** The digest of the state between planning steps. */
  digest() {
    this.#call("digest", 0);
    return this.#module.text();
  }

  /** A snapshot (bytes), between planning steps. */
  snapshot() {
    this.#call("snapshot", 0);
    return this.#module.bytes();
  }

  /** Forgets the episode. */
  close = () => this.#call("close", 0);
}
