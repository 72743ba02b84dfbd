// Episodes over all worlds, plants, robots and beliefs, and some with decisions from outside. Runs in Node and in
// browsers.
import { BY_SCENARIO, LEADS, OVER, STANCES, STEP_DONE } from "./cocarry.js";

const learn = { belief_update: "learn" };
const STIFF = { state_weight: 1e6, input_weight: 1e-6 };

/** Name, parts of the scenario, and decisions before a control period, by the planning step begun. */
export const EPISODES = [
  ["point", { world: "environment-1", plant: "point" }],
  ["point, learning", { world: "environment-2", plant: "point", seed: 3, settings: learn }],
  ["point, Boltzmann", { world: "environment-3", plant: "point", seed: 5, settings: { human_model: "boltzmann(2)", belief_rationality: 2 } }],
  ["point, changes", { world: "free-form", plant: "point", changes: [{ step: 20, alpha: 0.6, gamma: 0.9 }] }],
  ["kinematic", { world: "environment-4", plant: "kinematic", seed: 7, settings: { belief_lapse: 0.1 } }],
  ["kinematic, omni", { world: "environment-2", plant: "kinematic", robot: "omni-carrier" }],
  ["kinematic, porter", { world: "free-form", plant: "kinematic", robot: "porter", settings: learn }],
  ["kinematic, shuttle", { world: "environment-1", plant: "kinematic", robot: "shuttle", settings: { control_period_s: 0.1 } }],
  ["kinematic, whole body", { world: "environment-3", plant: "kinematic", settings: { pose: "whole-body", pose_weight: 2, avoid: "robot" } }],
  // weights with which the active-set method of eq. (7) does not converge: clarabel solves 135 programs (tests/suite/web.rs)
  ["kinematic, fallback", { world: "environment-1", plant: "kinematic", settings: { ...STIFF, control_period_s: 0.05 } }],
  // and two without a solution: `fallback_steps` of its summary is 2
  ["kinematic, no solution", { world: "environment-2", plant: "kinematic", settings: { ...STIFF, speed_m_per_s: 0.7 } }],
  ["bodies", { world: "environment-1" }],
  ["bodies, learning", { world: "environment-4", alpha: 0.747, gamma: 0.765, settings: { ...learn, eta: 5 } }],
  ["bodies, omni", { world: "environment-2", robot: "omni-carrier", belief: { alpha: "normal(0.75,0.1,0.55,0.95)" } }],
  ["bodies, porter", { world: "environment-3", robot: "porter", seed: 2 }],
  ["bodies, shuttle", { world: "environment-4", robot: "shuttle", seed: 4, settings: { method: "human-led" } }],
  ["bodies, free form", { world: "free-form", seed: 11, settings: { control_period_s: 0.05, human_model: "boltzmann(4)" } }],
  ["steered option", { world: "environment-4", plant: "point", seed: 1 }, (e, step) => {
    if (step === 10) e.human(0, STANCES.resist);
    if (step === 20) e.human(1, STANCES.takeOver);
    if (step === 40) e.human(BY_SCENARIO, BY_SCENARIO);
  }],
  ["steered lead", { world: "environment-1", plant: "kinematic", seed: 6, settings: learn }, (e, step) => {
    if (step === 1) e.policy(LEADS.robot, 1);
    if (step === 15) e.policy(LEADS.human);
    if (step === 30) e.policy(LEADS.humanKeepingOption);
    if (step === 45) e.policy();
  }],
  ["steered hand", { world: "environment-1", settings: { method: "follow-hand", control_period_s: 0.05 } }, (e, step, period) => {
    const [x, y] = e.part("hand"), angle = 0.02 * (4 * step + period);
    e.hand(x + 0.1, y + 0.03 * Math.round(1e3 * angle % 7) / 7);
  }, 20],
  ["steered hand and stance", { world: "environment-4", seed: 9, settings: { control_period_s: 0.1 } }, (e, step, period) => {
    if (step === 5 && period === 0) e.human(BY_SCENARIO, STANCES.resist);
    if (step === 12 && period === 0) e.human(2, STANCES.takeOver);
    if (step >= 20 && step < 40) { const [x, y] = e.part("hand"); e.hand(x + 0.08, y); }
    if (step === 40) e.hand();
  }, 30],
  ["steered from the start", { world: "environment-2", robot: "porter", seed: 3 }, (e, step) => {
    if (step === 1) { e.human(1, STANCES.takeOver); e.policy(LEADS.human); }
    if (step === 60) { e.human(); e.policy(); }
  }, 40],
];

/** Runs an episode, for at most `seconds`; its log and its summary. */
export function run(module, [, parts, decide, seconds = Infinity]) {
  const { scenario, command, warnings } = module.scenario(parts);
  if (!command.includes("cocarry run ") || !Array.isArray(warnings)) throw new Error(command);
  const episode = module.open(scenario);
  try {
    let progress = STEP_DONE, begun = 0, period = 0;
    while (progress !== OVER && episode.value("time") < seconds - 1e-9) {
      if (progress === STEP_DONE) [begun, period] = [begun + 1, 0];
      decide?.(episode, begun, period);
      progress = decide ? episode.period() : episode.step();
      period += 1;
    }
    while (progress !== OVER && progress !== STEP_DONE) progress = episode.period();
    return { log: episode.log(), summary: episode.summary() };
  } finally {
    episode.close();
  }
}
