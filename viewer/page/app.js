// The episode of the page: made from what is chosen, run, shown, and made again when something is chosen anew.
import { Charts } from "../src/charts.js";
import { Carry } from "./carry.js";
import { BEGIN } from "./choices.js";
import { Editor } from "./editor.js";
import { Controls } from "./controls.js";
import { choicesOf, kindOf } from "./given.js";
import * as link from "./link.js";
import { LiveEpisode } from "./live.js";
import { WorldMap } from "./map.js";
import { Meters } from "./meters.js";
import { Plane } from "./plane.js";
import { Deeds, report, title } from "./report.js";
import { Runner } from "./runner.js";
import { Setup } from "./setup.js";
import { Shown, covered } from "./shown.js";
import { Timeline } from "./timeline.js";
import { View } from "./view.js";

const $ = (id) => document.getElementById(id);
// How long a slider rests before the episode starts again, ms.
const REST_MS = 160;
// Pictures per second below which the picture gets coarser.
const FEW_PICTURES = 24;
// How far the object may be from where a recording has it, m: recordings have millimetres and less.
const SAME_M = 1e-4;
const LONG_LINE = /^(.{400}).+$/gmu;
const isStill = matchMedia("(prefers-reduced-motion: reduce)").matches;

export class App {
  constructor({ module, catalogue, choices, view }) {
    Object.assign(this, { module, catalogue, choices, asked: view, fragment: "", robots: new Map(), showsMap: false, isLost: false });
    this.setup = new Setup(choices, catalogue);
    this.meters = new Meters({ force: $("force-meter"), phi: $("phi-meter"), choice: $("choice") });
    this.plane = new Plane($("plane"), (values) => choices.change(values));
    this.timeline = new Timeline((time) => this.seek(time));
    this.runner = new Runner({ decide: () => this.decide(), done: () => this.deeds.note(this.core) });
    this.runner.onReached = () => this.reached();
    this.runner.onMeasured = () => this.runner.rates.pictures_per_s < FEW_PICTURES && !this.showsMap && this.view?.coarser();
    this.editor = new Editor(module, catalogue.max_bytes.world, {
      draw: (drawn, file) => this.drawWorld(drawn, file),
      fault: (sentence) => this.fault("world-fault", sentence),
      done: (text) => choices.change({ toml: text }),
    });
    this.map = new WorldMap($("map"), $("map-labels"), covered, (...change) => {
      this.editor.change(...change);
      $("undo").disabled = !this.editor.canUndo;
    });
    this.carry = new Carry($("stage"), {
      floor: (x, y) => (this.showsMap ? this.map.floor(x, y) : this.view?.floor(x, y)),
      bearing: () => (this.showsMap || !this.view ? Math.PI / 2 : this.view.bearing()),
      onChange: () => this.controls?.stances(),
    });
    try {
      this.view = new View({ canvas: $("view"), box: $("stage"), labels: $("labels"), covered, onLost: (isLost) => this.lost(isLost) });
    } catch (error) {
      this.showsMap = true;
      this.noView = error;
    }
    this.shown = new Shown(this);
    this.controls = new Controls(this);
    choices.onChange((keys) => this.chosen(keys));
    new ResizeObserver(() => this.resize()).observe($("stage"));
    new ResizeObserver(() => this.plane.layout()).observe($("plane-card"));
  }

  begin(log) {
    const { now } = this.choices, { t: from = null } = this.asked;
    if (this.asked.embed) $("player").dataset.embed = this.asked.embed;
    this.editor.fit(this.robotWidth());
    if (now.scenario !== null) {
      try {
        this.#take(now.scenario, now.carry);
      } catch (error) {
        if (error.name === "Broken") throw error;
        this.warn(`The scenario of this link cannot be: ${error.message}`);
        now.scenario = null;
      }
    }
    if (now.toml !== null && !this.editor.open(now.toml)) {
      this.warn(`The world of this link cannot be: ${$("world-fault").textContent}`);
      this.choices.now.toml = null;
    }
    if (this.choices.now.toml === null) this.editor.open(this.builtIn(this.choices.now.world));
    this.setup.show();
    this.make(log, from);
    if (!this.episode) {
      this.warn(`The episode of this link cannot be: ${$("scenario-fault").textContent}`);
      this.choices.change(BEGIN);
      this.make();
    }
    this.controls.camera(this.view ? (this.asked.camera ?? "follow") : "map");
    if (this.noView) this.warn(`This browser cannot draw in three dimensions (${this.noView.message}). The map shows the same.`);
    // who takes over from somewhere first looks where they are
    this.play(this.asked.play !== "0" && !isStill && !(this.from !== null && now.carry));
    requestAnimationFrame((now) => this.frame(now));
  }

  // The robot as the module draws it, and its width, m; null on the planning level.
  robot() {
    const { robot, plant } = this.choices.now;
    if (plant === "point") return null;
    if (!this.robots.has(robot)) this.robots.set(robot, this.module.robot(robot));
    return this.robots.get(robot);
  }

  // The drawing of an episode's robot; null for a robot that this page does not know.
  drawing({ about: { robot } }) {
    if (!robot) return null;
    if (this.choices.now.scenario === null) return this.robot();
    const drawings = this.catalogue.robots.map(({ name }) => this.module.robot(name));
    return drawings.find((drawn) => drawn.name.toLowerCase().replaceAll(" ", "-") === robot.name.toLowerCase().replaceAll(" ", "-")) ?? null;
  }

  robotWidth = () => this.robot()?.width_m ?? null;

  builtIn(name) {
    return this.catalogue.worlds.find((world) => world.name === name).text;
  }

  // Something else was chosen.
  chosen(keys) {
    const { now } = this.choices;
    if (keys.includes("robot") || keys.includes("plant")) this.editor.fit(this.robotWidth());
    if (keys.includes("world") || (keys.includes("toml") && this.editor.text !== now.toml)) this.editor.open(now.toml ?? this.builtIn(now.world));
    if (keys.some((key) => ["alpha", "gamma"].includes(key))) this.plane.move(this.person());
    if (keys.includes("carry")) this.takeOver();
    if (keys.join() === "carry") return;
    clearTimeout(this.resting);
    this.resting = setTimeout(() => this.make(), REST_MS);
  }

  // A person takes the human's end, or gives it back to the model.
  takeOver() {
    const { isOwn } = this.choices;
    this.carry.turnOn(isOwn && !this.repeats);
    this.view?.steer(isOwn);
    this.map.isEditable = !isOwn;
    this.map.paint();
    if (!isOwn && this.hasDecided) {
      this.goal = null;
      this.core.human();
      this.core.hand();
    }
    this.controls.made();
  }

  person = () => ({ alpha: this.choices.now.alpha, gamma: this.choices.now.gamma });

  drawWorld(drawn, file) {
    this.drawn = drawn;
    this.setup.options({ ...drawn, note: [drawn.note, ...(drawn.warnings ?? [])].filter(Boolean).join(" ") });
    this.map.show(drawn, file);
    if (drawn.regions) this.plane.show(drawn.regions, drawn.options, this.person());
    $("plane-note").innerHTML = "Each colour is an option; its share of the area is P<sub>o</sub> from where the team is, eq. (4). The cross is this human: drag it.";
  }

  // Opens a file that the reader gives: a world, a scenario, or an episode with its decisions.
  openFile(name, text) {
    try {
      const { world, scenario, log } = kindOf(text);
      if (world !== undefined) return this.editor.open(world) && this.choices.change({ toml: world });
      this.#take(scenario, false);
      this.editor.open(this.choices.now.toml);
      this.setup.show();
      this.make(log);
      this.play(true);
    } catch (error) {
      if (error.name === "Broken") throw error;
      this.fault("world-fault", `${name}: ${error.message}`);
    }
  }

  // Takes over what a scenario has, so that the panel shows it.
  #take(scenario, carry) {
    const core = this.module.open(scenario), { scenario: about } = core.about;
    core.close();
    Object.assign(this.choices.now, choicesOf(scenario, about), { carry });
  }

  // Makes the episode. `log` repeats decisions of a person; `from` is the time that is shown first, s, until which nobody
  // on this page decides.
  make(log = null, from = null) {
    clearTimeout(this.resting);
    let made, core, repeats = log?.steps;
    try {
      const { scenario } = this.choices.now;
      made = scenario === null ? this.module.scenario(this.choices.scenario()) : { scenario, command: "cocarry replay episode.json" };
      if (from !== null) {
        core = this.module.open(made.scenario);
        const { planning_step_s: step } = core.about.scenario, until = Math.floor(from / step + 1e-6);
        if (this.choices.isOwn) [repeats, from] = [Math.min(repeats ?? until, until), until * step];
      }
      if (log) {
        try {
          const repeated = this.module.replay({ ...log, steps: repeats, scenario: made.scenario });
          core?.close();
          core = repeated;
        } catch (error) {
          if (error.name !== "Refused") throw error;
          this.warn(`The decisions of this link cannot be repeated: ${error.message}`);
          [log, repeats] = [null, from === null ? 0 : repeats];
        }
      }
      core ??= this.module.open(made.scenario);
    } catch (error) {
      if (error.name !== "Refused") throw error;
      this.fault("scenario-fault", error.message);
      return;
    }
    this.fault("scenario-fault", "");
    const warnings = [...(made.warnings ?? [])];
    $("scenario-note").textContent = warnings.join(" ");
    this.made = made;
    this.core?.close();
    this.core = core;
    this.repeats = Number.isSafeInteger(repeats) ? repeats : 0;
    this.hasDecided = Boolean(log);
    Object.assign(this, { given: log, from });
    this.goal = null;
    this.episode = new LiveEpisode(core, this.drawing(core), this.catalogue, this.catalogue.outcomes);
    this.deeds = new Deeds();
    this.isReported = false;
    delete document.body.dataset.digest;
    $("report").replaceChildren();
    this.runner.begin(this.episode);
    if (from !== null) this.runner.goTo(from);
    this.view?.show(this.episode);
    this.takeOver();
    this.timeline.begin(this.episode);
    this.meters.begin(this.episode);
    $("charts").replaceChildren();
    this.charts = new Charts($("charts"), this.episode, (time) => this.seek(time));
    this.address();
    this.show();
  }

  // A person's decisions, before a control period.
  decide() {
    if (this.core.value("step") < this.repeats) return;
    if (this.repeats) this.handOver();
    if (!this.choices.isOwn) return;
    if (!this.hasDecided) {
      this.hasDecided = true;
      this.controls.made();
    }
    this.goal = this.carry.decide(this.core, this.episode.options);
  }

  // The decisions that are repeated are over: a person on this page goes on, if one carries.
  handOver() {
    const known = new Map(this.given?.digests);
    const isOther = this.core.log().digests.some(([steps, digest]) => known.has(steps) && known.get(steps) !== digest);
    const there = this.asked.object, here = this.core.part("object");
    const isElsewhere = there && this.core.value("time") >= this.from - 1e-9 && Math.hypot(...there.map((x, i) => x - here[i])) > SAME_M;
    this.repeats = 0;
    if (this.choices.isOwn) {
      this.hasDecided = true;
      // of an episode of a model, what the person does counts from here
      if (!this.given) this.deeds = new Deeds();
    }
    this.takeOver();
    if (isOther || isElsewhere) this.warn("This episode came out otherwise than where its link was made: another version of the simulator made it.");
    else if (this.from !== null && this.choices.isOwn) this.warn(`From ${this.from.toFixed(1)} s on the human’s end is yours: play, and carry.`);
  }

  // The time that was asked for is reached.
  reached() {
    if (this.repeats && this.core.value("step") >= this.repeats) this.handOver();
    this.show();
    this.view?.follow(1);
    this.address();
  }

  play(isPlaying) {
    if (isPlaying && this.runner.isAtEnd) this.runner.seek(0);
    this.runner.play(isPlaying);
    this.controls.playing(isPlaying);
    if (!isPlaying) this.address();
  }

  step(by) {
    this.play(false);
    this.runner.step(by);
    this.show();
    this.view?.follow(1);
  }

  seek(time) {
    this.runner.seek(time);
    this.show();
    this.view?.follow(1);
  }

  frame(now) {
    const before = this.runner.before;
    if (this.runner.frame(now)) {
      this.show();
      if (before !== null) this.view?.follow(Math.min(0.1, (now - before) / 1000) * this.runner.speed);
      this.controls.rates();
      if (this.runner.isAtEnd) this.play(false);
    }
    if (this.showsMap || (!this.isLost && this.view.draw())) this.shown.first();
    requestAnimationFrame((next) => this.frame(next));
  }

  show() {
    this.shown.update();
    if (!this.episode.isRunning && !this.isReported) this.end();
  }

  // The episode is over: its report, and its digest.
  end() {
    this.isReported = true;
    this.shown.grow();
    $("report").innerHTML = report(this.episode, this.core.summary(), this.deeds, this.hasDecided, this.given ? null : this.from);
    document.body.dataset.digest = this.core.digest();
    $("said").textContent = title(this.episode);
    this.controls.ended();
    this.address();
  }

  // The decisions of a person so far, without what the choices already say; null where nobody decided.
  decisions() {
    if (!this.hasDecided) return null;
    const { scenario, digests, ...log } = this.core.log();
    return { ...log, digests: digests.slice(-1) };
  }

  // Brings the address up to date.
  async address() {
    const asked = (this.addresses = (this.addresses ?? 0) + 1);
    // until a person on this page goes on, the link is the one that was opened
    const isGiven = this.repeats > 0 || (this.from !== null && this.episode.end <= this.from + 1e-9);
    const fragment = await link.written(this.choices.now, isGiven ? this.given : this.decisions(), isGiven ? this.from : null);
    // packing takes a while: the newest holds
    if (asked !== this.addresses) return location.href;
    this.fragment = fragment;
    history.replaceState(null, "", fragment ? `#${fragment}` : location.pathname + location.search);
    return location.href;
  }

  warn(sentence) {
    $("warning").hidden = !sentence;
    this.fault("warning-text", sentence);
  }

  // Says what is wrong in its place; a line of a file that it shows can have any length.
  fault(id, sentence) {
    $(id).textContent = sentence.replace(LONG_LINE, "$1…");
  }

  lost(isLost) {
    this.isLost = isLost;
    if (isLost) {
      this.controls.camera("map");
      this.warn("The browser took the three-dimensional picture away. The map shows the same until it is back.");
    } else {
      this.view.show(this.episode);
      this.controls.camera("follow");
      this.warn("");
    }
  }

  resize() {
    this.view?.resize();
    if (this.showsMap) this.map.layout();
    this.charts?.layout();
    if (this.episode) this.show();
  }
}
