// What the page shows of its episode at a time: words, figures, picture or map.
import { symbol } from "../src/episode.js";

const $ = (id) => document.getElementById(id);
// How often charts, the plane and the timeline grow, ms.
const GROW_MS = 450;
// How near the team is to B when the plane stays as it was, m.
const LAST_CHOICE_M = 1;
// By how much the share of an option changes until the plane, which takes longer than a picture, is drawn anew.
const SMALLEST_SHARE = 0.01;

export class Shown {
  constructor(app) {
    this.app = app;
  }

  // Shows the present time.
  update() {
    const { app } = this, { episode, runner: { time } } = app, step = episode.step(time), isHuman = episode.isHumanLed(step);
    app.meters.update(episode, step);
    app.timeline.update(time, isHuman ? "human" : "robot");
    this.#leader(step, isHuman);
    if (performance.now() - (this.grown ?? 0) > GROW_MS) this.grow();
    app.charts.update(time, step);
    const goal = app.carry.isOn && episode.isRunning ? app.goal : null;
    if (app.showsMap || !app.view) app.map.team(app.controls.bodies(episode, time), episode.walked(episode.between(time)), goal);
    else {
      // forces are known now alone
      const isNow = episode.isRunning && time >= episode.end - episode.facts.control_period_s - 1e-9;
      app.view.update(time);
      app.view.arrows(isNow);
      app.view.mark(goal);
    }
  }

  #leader(step, isHuman) {
    const { episode, choices } = this.app, executed = episode.steps.executed[step], preferred = episode.steps.preferred[step];
    const leader = `${isHuman ? (choices.isOwn ? "You lead" : "Human leads") : "Robot leads"}${executed ? ` on option ${symbol(executed)}` : ""}`;
    const prefers = !choices.isOwn && preferred && preferred !== executed ? `; human prefers ${symbol(preferred)}` : "";
    if ($("leader-text").innerHTML !== leader + prefers) $("leader-text").innerHTML = leader + prefers;
    $("player").classList.toggle("human", isHuman);
  }

  // Brings charts, timeline and plane up to what is known.
  grow() {
    const { app } = this, { episode, core } = app;
    this.grown = performance.now();
    app.charts.layout();
    app.timeline.grow();
    if (app.map.isHeld || !episode.count) return;
    // the plane goes with the team: what people would choose from here. At B there is nothing left to choose
    const isThere = core.value("path_length") - core.value("along") < LAST_CHOICE_M;
    const step = episode.count - 1, options = episode.options.map((option) => ({ ...option, probability: option.probability[step] }));
    const shares = options.map(({ probability }) => probability ?? 0);
    const isSeen = this.seen?.episode === episode && shares.every((share, o) => Math.abs(share - this.seen.shares[o]) < SMALLEST_SHARE);
    if (!isThere && !isSeen && episode.isRunning) {
      this.seen = { episode, shares };
      app.plane.show(core.regions(), options, app.person());
    }
    if (app.choices.now.belief === "learn") app.plane.believe(core.summary().learned);
  }

  // Says when the first picture was there.
  first() {
    if (document.body.dataset.drawn) return;
    if (!this.app.showsMap) this.app.view.settle();
    document.body.dataset.drawn = performance.now().toFixed(0);
  }
}

// The parts of the picture in which no label may be.
export function covered() {
  const { left, top } = $("stage").getBoundingClientRect();
  return ["cameras", "leader", "caption", "tools", "carry"].map((id) => {
    const box = $(id).getBoundingClientRect();
    return [box.left - left, box.top - top, box.right - left, box.bottom - top];
  });
}
