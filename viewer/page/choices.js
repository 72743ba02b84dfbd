// What is chosen on the page: the parts of a scenario, one plain object. Whoever changes it calls `change`; listeners
// hear what changed.

// The episode that the page begins with: a human who takes the lead after a few seconds.
export const BEGIN = {
  world: "environment-4", toml: null, robot: "carrier", plant: "rapier", human: "preference", rationality: 2,
  alpha: 0.63, gamma: 0.929, eta: 5, stubbornness: 0.1, seed: 0, method: "mutual", belief: "prior",
  // whether a person carries in the model's place, and the control period, s (null: the program's)
  carry: false, period: null,
  // the text of a scenario that was opened: it holds until something else is chosen
  scenario: null,
};

// The control period of an episode in which a person carries from the start, s: their hand is asked for so often.
export const OWN_PERIOD_S = 0.05;

// The range and the step of each slider, and the words around it.
export const SLIDERS = {
  alpha: { least: 0.3, most: 1.2, step: 0.005, digits: 3 },
  gamma: { least: 0.3, most: 1.5, step: 0.005, digits: 3 },
  eta: { least: 1, most: 20, step: 0.5, digits: 1 },
  stubbornness: { least: 0.02, most: 1, step: 0.02, digits: 2 },
  rationality: { least: 0.1, most: 10, step: 0.1, digits: 1 },
};

export class Choices {
  constructor(begin = BEGIN) {
    this.now = { ...BEGIN, ...begin };
    this.listeners = [];
  }

  onChange(listener) {
    this.listeners.push(listener);
  }

  // Changes some of the values; listeners get the names of those that are new.
  change(values) {
    const keys = Object.keys(values).filter((key) => this.now[key] !== values[key]);
    if (!keys.length) return;
    if (keys.some((key) => key !== "carry") && !("scenario" in values) && this.now.scenario !== null) {
      values = { ...values, scenario: null };
      keys.push("scenario");
    }
    Object.assign(this.now, values);
    this.listeners.forEach((listener) => listener(keys));
  }

  get isOwn() {
    return this.now.carry;
  }

  // The parts of a scenario, as the module takes them.
  scenario() {
    const { world, toml, robot, plant, human, rationality, alpha, gamma, eta, stubbornness, seed, method, belief, period } = this.now;
    const settings = { eta, initial_stubbornness: stubbornness, method, belief_update: belief };
    if (human === "boltzmann") settings.human_model = `boltzmann(${rationality})`;
    if (period !== null) settings.control_period_s = period;
    const parts = { world: toml === null ? world : { file: "world.toml", text: toml }, plant, seed, alpha, gamma, settings };
    if (plant !== "point") parts.robot = robot;
    return parts;
  }
}
