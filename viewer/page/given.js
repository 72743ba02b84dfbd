// Files that a reader gives to the page: a world, a scenario, or an episode with its decisions.
import { parse } from "smol-toml";

// What a text is: { world }, { scenario } or { log }. Whether it can be run, the module decides.
export function kindOf(text) {
  if (/^\s*\{/.test(text)) {
    const log = JSON.parse(text);
    if (typeof log?.scenario !== "string") throw new Error("this JSON is not an episode; expected a file that this page or cocarry wrote, with a scenario");
    return { scenario: log.scenario, log };
  }
  let file;
  try {
    file = parse(text);
  } catch {
    // the module says what is wrong with it
    return { world: text };
  }
  return file.world?.text !== undefined && file.settings !== undefined ? { scenario: text } : { world: text };
}

// What the panel of choices shows of a scenario. `about` is the module's description of its episode.
export function choicesOf(scenario, about) {
  const { world, settings } = parse(scenario);
  const boltzmann = /^boltzmann\((.+)\)$/.exec(about.human_model);
  const stubbornness = find(settings, "initial_stubbornness");
  return {
    scenario, toml: world.text, plant: about.plant, method: about.method, seed: about.seed, alpha: about.alpha, gamma: about.gamma, eta: about.eta,
    belief: about.learns ? "learn" : "prior", human: boltzmann ? "boltzmann" : "preference",
    ...(boltzmann && { rationality: Number(boltzmann[1]) }), ...(stubbornness !== undefined && { stubbornness }), carry: false, period: null,
  };
}

// The first value of a key in nested tables.
function find(table, key) {
  for (const [name, value] of Object.entries(table)) {
    if (name === key) return value;
    const within = value && typeof value === "object" && !Array.isArray(value) ? find(value, key) : undefined;
    if (within !== undefined) return within;
  }
  return undefined;
}
