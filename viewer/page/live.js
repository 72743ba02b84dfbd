// An episode that the module runs, in the form that the player draws: poses by time, figures by step. It grows while it
// runs, so that everything until now can be looked at again.
import { OVER, STEP_DONE } from "../../crates/web/cocarry.js";
import { Episode } from "../src/episode.js";

const POSES = ["object", "hand", "torso"];
// How high the object is held, and how far ahead of the hand the human walks, m, on the planning level.
const HELD_M = 0.7, REACH_M = 0.3;
const MODES = ["robot-led", "human-led"];

export class LiveEpisode extends Episode {
  // `core` is the module's episode, `drawing` the robot's links with their shapes.
  constructor(core, drawing, { measures, colours }, outcomes) {
    const { scenario, world, options, robot } = core.about;
    const shapes = new Map(drawing?.links.map(({ name, shapes }) => [name, shapes]));
    const links = (robot?.links ?? []).map((name, index) => ({ name, index, shapes: shapes.get(name) ?? [] }));
    const drawn = links.filter((link) => link.shapes.length);
    const figure = (unit, description) => ({ unit, description, values: [] });
    const isFelt = scenario.plant === "rapier";
    super({
      title: world.name, facts: scenario, world, colours, measures,
      options: options.map((option) => ({ ...option, probability: [] })),
      robot: drawn, meshes: drawing?.meshes ?? [],
      frames: { time_s: [], links: drawn.map(() => []), object: [], hand: [], torso: [], base: [] },
      steps: {
        decided_s: [], mode: [], executed: [], preferred: [],
        figures: {
          stubbornness: figure("", "phi(k), eq. (5): above 1 the human takes the lead"),
          stubbornness_threshold: { unit: "", values: [1] },
          ...(isFelt && {
            grip_force_n: figure("N", "Size of the mean force of the robot's gripper on the object, weight included"),
            hand_force_n: figure("N", "Size of the mean force of the human's hand on the object, weight included"),
          }),
        },
      },
      events: [], ahead: [],
    });
    this.core = core;
    this.outcomes = outcomes;
    this.isFelt = isFelt;
    this.isRunning = true;
    // when it will probably end, s: before the first step, as on the shortest option
    const shortest = Math.min(...core.part("option_length"));
    this.expected = shortest > 0 ? Math.ceil(shortest / scenario.speed_m_per_s) : 10;
    this.note();
    this.pathNow();
    this.listen();
  }

  // The time until which the episode is known.
  get end() {
    return this.frames.time_s[this.frames.time_s.length - 1] ?? 0;
  }

  // The time that axes show.
  get duration() {
    return this.isRunning ? Math.max(this.expected, this.end) : this.end;
  }

  set duration(_) {}

  get count() {
    return this.steps.decided_s.length;
  }

  set count(_) {}

  // Runs one control period. Returns whether the episode goes on.
  advance() {
    if (!this.isRunning) return false;
    const progress = this.core.period();
    this.isRunning = progress !== OVER;
    this.note();
    if (progress === STEP_DONE || progress === OVER) {
      this.pathNow();
      this.listen();
    }
    return this.isRunning;
  }

  // Notes where everything is, and the figures of the present step.
  note() {
    const { core, frames, steps } = this;
    const time = core.value("time");
    if (!(time <= this.end) || !frames.time_s.length) {
      frames.time_s.push(time);
      for (const [body, pose] of Object.entries(this.#poses())) frames[body].push(...pose);
      const [x, y, yaw] = core.part("base");
      frames.base.push(x, y, 0, 0, 0, Math.sin(yaw / 2), Math.cos(yaw / 2));
      if (this.robot.length) {
        const poses = core.part("links");
        this.robot.forEach(({ index }, i) => {
          for (let k = 0; k < 7; k++) frames.links[i].push(poses[7 * index + k]);
        });
      }
    }
    const left = (core.value("path_length") - core.value("along")) / this.facts.speed_m_per_s;
    if (left > 0 && Number.isFinite(left)) this.expected = Math.max(this.expected, Math.ceil(1.05 * (time + left)));
    const state = {
      step: core.value("step"), mode: core.value("mode"), executed: core.value("executed"), preferred: core.value("preferred"),
      phi: core.value("stubbornness"), probabilities: [...core.part("option_probability")],
    };
    const k = Math.max(0, state.step - 1);
    if (steps.decided_s.length <= k) steps.decided_s.push(k * this.facts.planning_step_s);
    const name = (index) => this.options[index]?.name ?? "";
    steps.mode[k] = MODES[state.mode] ?? MODES[0];
    [steps.executed[k], steps.preferred[k]] = [name(state.executed), name(state.preferred)];
    steps.figures.stubbornness.values[k] = known(state.phi);
    this.options.forEach((option, o) => (option.probability[k] = known(state.probabilities[o])));
    if (this.isFelt) {
      for (const [key, field] of [["grip_force_n", "grip_wrench"], ["hand_force_n", "hand_wrench"]]) {
        steps.figures[key].values[k] = known(Math.hypot(...core.part(field).subarray(0, 3)));
      }
    }
  }

  // Where object, hand and torso are. On the planning level the team is a point: they are drawn for orientation.
  #poses() {
    const { core } = this, [length] = this.world.object_m;
    if (Number.isFinite(core.part("object")[0])) return Object.fromEntries(POSES.map((body) => [body, [...core.part(body)]]));
    const [x, y] = core.part("position"), heading = core.value("heading");
    const yaw = Number.isFinite(heading) ? heading : Math.atan2(this.world.target[1] - y, this.world.target[0] - x);
    const at = (ahead) => [x + ahead * Math.cos(yaw), y + ahead * Math.sin(yaw), HELD_M, 0, 0, Math.sin(yaw / 2), Math.cos(yaw / 2)];
    return { object: at(0), hand: at(length / 2), torso: at(length / 2 + REACH_M) };
  }

  pathNow() {
    const line = this.isRunning ? this.core.path().flat() : [];
    this.ahead.push([this.end, line]);
  }

  // Takes the events since the last call.
  listen() {
    this.events.push(...this.core.events());
  }

  get outcome() {
    return this.outcomes[this.core.value("outcome")] ?? null;
  }

  // The horizontal force of a grip now, N, world axes.
  pull(field) {
    const [x, y] = this.core.part(field);
    return Number.isFinite(x) ? [x, y] : [0, 0];
  }
}

// A person's decisions in a log may have any number: what is beyond is no figure of an episode.
const MAX_FIGURE = 1e9;
const known = (value) => (Math.abs(value) <= MAX_FIGURE ? value : null);
