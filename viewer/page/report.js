// The report at the end of an episode: what the robot believed, what the human did, and the program's own report.
import { escaped, symbol } from "../src/episode.js";

// What a person did, in planning steps: counted while the episode runs.
export class Deeds {
  constructor() {
    Object.assign(this, { steps: 0, stances: [0, 0, 0], led: 0, most: 0, last: -1 });
  }

  note(core) {
    const step = core.value("step");
    const peak = core.value("peak_force");
    if (Number.isFinite(peak)) this.most = Math.max(this.most, peak);
    if (step === this.last) return;
    this.last = step;
    this.steps += 1;
    this.stances[core.value("stance")] += 1;
    this.led += core.value("mode") === 1 ? 1 : 0;
  }
}

const ENDS = { arrived: "Arrived at B" };

export function title(episode) {
  const { outcome } = episode;
  return `${ENDS[outcome] ?? `It ended: ${outcome}`} after ${episode.end.toFixed(1)} s`;
}

// The report as HTML. `summary` is the module's; `isOwn` says whether a person carried, and `from` since when, s, where
// it was not the whole time.
export function report(episode, summary, deeds, isOwn, from) {
  const { steps, options, facts } = episode, last = episode.count - 1;
  const option = (name) => options.find((o) => o.name === name);
  const taken = option(steps.executed[last]), first = option(steps.executed[0]);
  const who = isOwn ? "you" : "this human", seconds = (count) => `${(count * facts.planning_step_s).toFixed(1)} s`;
  const percent = (p) => (p === null || p === undefined ? "unknown" : `${(100 * p).toFixed(1)} %`);
  const rows = (pairs) => `<dl>${pairs.filter(Boolean).map(([key, value]) => `<div><dt>${key}</dt><dd>${value}</dd></div>`).join("")}</dl>`;
  const symbolic = (o) => (o ? `option ${symbol(o.name)}` : "none");
  const phi = episode.figure("stubbornness", last);
  const believed = [
    [`that ${who} would choose ${symbolic(taken)}, at the start`, percent(taken?.probability.find((p) => p !== null))],
    [`stubbornness φ at the end`, phi === null ? "unknown" : phi.toFixed(3)],
  ];
  const learned = summary.learned?.human ?? summary.learned;
  if (learned) {
    const range = ([low, high], digits) => `${low.toFixed(digits)} to ${high.toFixed(digits)}`;
    const figure = (key, symbol, digits) => learned[`${key}_mean`] !== undefined && learned[`${key}_mean`] !== null && [
      `${symbol}, mean and 95 % interval`, `${learned[`${key}_mean`].toFixed(digits)} (${range(learned[`${key}_interval`], digits)})`];
    believed.push(figure("alpha", "α", 3), figure("gamma", "γ", 3), figure("eta", "η", 1));
  }
  const did = [
    ["walked along", seconds(deeds.stances[0])],
    deeds.stances[1] ? ["held back", seconds(deeds.stances[1])] : null,
    ["led the team", seconds(deeds.led)],
    ["first and last option", `${symbolic(first)}, ${symbolic(taken)}`],
    episode.isFelt ? ["largest force in a grip", `${deeds.most.toFixed(0)} N`] : null,
  ];
  return `<h2>${escaped(title(episode))}</h2>
    <h3>The robot believed about ${who}</h3>${rows(believed)}
    <h3>${isOwn ? (from ? `You, from ${from.toFixed(1)} s` : "You") : "The human"}</h3>${rows(did)}
    <h3>The program’s report</h3><pre tabindex="0" aria-label="The program’s report">${escaped(summary.text)}</pre>`;
}
