// Time: fixed steps of the simulation behind a picture that follows the clock. A machine that is too slow loses simulated
// time, and the page says so; it never takes larger steps.

// What is caught up at most after a pause of the page, s, and what stepping may take of a picture, ms.
const MAX_CAUGHT_UP_S = 0.1, BUDGET_MS = 60;
// How long rates are measured, s, and the part of the asked speed below which the machine is slow.
const WINDOW_S = 1, SLOW = 0.93;

export class Runner {
  // `decide` is called before every control period of a running episode, `done` after it.
  constructor({ decide, done }) {
    Object.assign(this, { decide, done, time: 0, speed: 1, isPlaying: false, before: null, goal: null });
    this.rates = { pictures_per_s: null, physics_share: null, speed: null };
    this.measured = fresh();
  }

  begin(episode) {
    Object.assign(this, { episode, time: 0, before: null, goal: null, measured: fresh() });
    this.rates.speed = null;
  }

  play(isPlaying) {
    Object.assign(this, { isPlaying, before: null, measured: fresh() });
    this.rates.speed = null;
  }

  // Runs on to a time as quickly as the machine can, picture by picture; then calls `onReached`.
  goTo(time) {
    this.goal = time;
  }

  #hurry() {
    const start = performance.now();
    const goesOn = () => this.episode.isRunning && this.episode.end < this.goal - 1e-9;
    while (goesOn() && performance.now() - start < BUDGET_MS) this.advance();
    this.time = Math.min(this.goal, this.episode.end);
    if (goesOn()) return;
    Object.assign(this, { goal: null, before: null });
    this.onReached?.();
  }

  // Goes on by the time since the last picture; `now` in ms. Returns whether anything moved.
  frame(now) {
    if (this.goal !== null) {
      this.#hurry();
      return true;
    }
    if (!this.isPlaying || !this.episode) return false;
    const since = this.before === null ? 0 : (now - this.before) / 1000;
    this.before = now;
    const wanted = this.time + Math.min(MAX_CAUGHT_UP_S, since) * this.speed;
    const start = performance.now();
    let isLate = false;
    while (this.episode.isRunning && this.episode.end < wanted && !isLate) {
      this.advance();
      isLate = performance.now() - start > BUDGET_MS;
    }
    const physics = performance.now() - start, from = this.time;
    this.time = Math.min(wanted, this.episode.end);
    this.#measure(since, physics / 1000, this.time - from);
    return true;
  }

  advance() {
    this.decide();
    this.episode.advance();
    this.done();
  }

  get isAtEnd() {
    return !this.episode.isRunning && this.time >= this.episode.end - 1e-9;
  }

  // Goes to the end of the next planning step, running it if it is not known yet.
  step(by = 1) {
    const { planning_step_s: step } = this.episode.facts;
    const next = (Math.floor(this.time / step + 1e-6) + by) * step;
    while (this.episode.isRunning && this.episode.end < next - 1e-9) this.advance();
    this.seek(next);
  }

  seek(time) {
    this.goal = null;
    this.time = Math.min(this.episode.end, Math.max(0, time));
  }

  #measure(since, physics, simulated) {
    const sum = this.measured;
    sum.pictures += 1;
    sum.seconds += since;
    sum.physics += physics;
    sum.simulated += simulated;
    if (sum.seconds < WINDOW_S) return;
    this.rates = { pictures_per_s: sum.pictures / sum.seconds, physics_share: sum.physics / sum.seconds, speed: sum.simulated / sum.seconds };
    this.measured = fresh();
    this.onMeasured?.();
  }

  // The speed that the machine reaches where it is less than the one asked for; else null.
  get slow() {
    const { speed } = this.rates;
    return speed !== null && this.episode?.isRunning && speed < SLOW * this.speed ? speed : null;
  }
}

const fresh = () => ({ pictures: 0, seconds: 0, physics: 0, simulated: 0 });
