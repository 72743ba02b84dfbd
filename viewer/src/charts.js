// The charts beside the scene: stubbornness with its threshold, P_o, forces; each with a cursor at the present time.
import { escaped } from "./episode.js";

const LEFT = 34, RIGHT = 8, TOP = 8, BOTTOM = 20;
const line = "http://www.w3.org/2000/svg";

export function element(name, attributes, parent) {
  const made = document.createElementNS(line, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  parent?.append(made);
  return made;
}

// The charts of an episode: title, unit, height and curves of each.
function charts(episode) {
  const { figures, decided_s: times } = episode.steps;
  const curve = (key, name, colour, dash) => ({ key, name, colour, dash, values: figures[key].values, about: figures[key].description });
  const made = [
    {
      title: "Stubbornness φ", unit: "no unit", height: 120, least: 1.15, digits: 3, times,
      threshold: figures.stubbornness_threshold.values[0],
      about: "φ grows while the robot leads against the human's preference. Above the threshold the human takes the lead.",
      curves: [curve("stubbornness", "φ", "var(--ink)")],
    },
    {
      title: "Preferred option", unit: "probability P<sub>o</sub>", height: 120, least: 1, digits: 3, times,
      about: "The probability that a human prefers the option, as the robot computes it.",
      curves: episode.options.map(({ name, colour, dash, probability }) => ({
        key: `probability[${name}]`, name: `option ${escaped(name)}`, colour, dash: dash.map((d) => d / 2).join(" "), values: probability,
      })),
    },
  ];
  const forces = {
    title: "Force on the object", unit: figures.grip_force_n ? `${figures.grip_force_n.unit}, mean of a step` : "N",
    height: 110, least: 1, digits: 1, times, curves: [],
    about: "The size of the mean force of each grip over a step, weight included.",
    none: "This plant has no forces.",
  };
  if (figures.grip_force_n) {
    forces.curves = [curve("grip_force_n", "robot's gripper", "var(--robot)"), curve("hand_force_n", "human's hand", "var(--human)", "5 3")];
  }
  return [...made, forces];
}

export class Charts {
  constructor(folder, episode, seek) {
    this.episode = episode;
    this.charts = charts(episode).map((chart) => {
      const card = document.createElement("section");
      card.className = "chart";
      card.innerHTML = `<h2>${chart.title} <span style="font-weight:400;color:var(--dim)">(${chart.unit})</span></h2><div class="entries"></div>`;
      card.title = chart.about ?? "";
      const entries = card.querySelector(".entries");
      for (const curve of chart.curves) {
        const entry = document.createElement("span");
        entry.className = "entry";
        entry.innerHTML = `<svg viewBox="0 0 26 8" aria-hidden="true"><path class="halo" d="M0 4H26" stroke-dasharray="${curve.dash ?? ""}"/><path d="M0 4H26" fill="none" stroke="${curve.colour}" stroke-width="3" stroke-dasharray="${curve.dash ?? ""}"/></svg>${curve.name} <output></output>`;
        curve.output = entry.querySelector("output");
        curve.output.dataset.figure = curve.key;
        if (curve.about) entry.title = curve.about;
        entries.append(entry);
      }
      if (chart.threshold !== undefined) {
        entries.insertAdjacentHTML("beforeend", `<span class="entry"><svg viewBox="0 0 26 8" aria-hidden="true"><path class="threshold" style="stroke:var(--human);stroke-width:2;stroke-dasharray:6 4" d="M0 4H26"/></svg>threshold <output data-figure="stubbornness_threshold">${chart.threshold}</output></span>`);
      }
      folder.append(card);
      if (!chart.curves.length) {
        card.insertAdjacentHTML("beforeend", `<p class="none">${chart.none}</p>`);
        return null;
      }
      const svg = element("svg", { role: "img", height: chart.height, "aria-label": `${card.querySelector("h2").textContent} over time` }, card);
      const at = (event) => {
        const box = svg.getBoundingClientRect();
        seek(((event.clientX - box.left - LEFT) / (box.width - LEFT - RIGHT)) * episode.duration);
      };
      svg.addEventListener("pointerdown", (event) => {
        svg.setPointerCapture(event.pointerId);
        at(event);
      });
      svg.addEventListener("pointermove", (event) => event.buttons && at(event));
      return { ...chart, card, svg };
    }).filter(Boolean);
    this.layout();
  }

  // Draws the curves for the present width.
  layout() {
    for (const chart of this.charts) {
      const { svg, height, curves, times, threshold } = chart;
      const width = Math.max(160, svg.clientWidth || svg.parentElement.clientWidth - 24);
      svg.replaceChildren();
      svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
      const room = chart.unit.startsWith("probability") ? 1 : 1.06;
      // not as arguments of `max`: a long episode has too many
      const most = curves.flatMap(({ values }) => values).reduce((most, value) => Math.max(most, room * (value ?? 0)), chart.least);
      const x = (time) => LEFT + (time / this.episode.duration) * (width - LEFT - RIGHT);
      const y = (value) => height - BOTTOM - (value / most) * (height - TOP - BOTTOM);
      for (const [from, to] of led(this.episode)) {
        element("rect", { class: "led", x: x(from), width: x(to) - x(from), y: TOP, height: height - TOP - BOTTOM }, svg);
      }
      for (const tick of ticks(most, 3)) {
        element("path", { class: "grid", d: `M${LEFT} ${y(tick)}H${width - RIGHT}` }, svg);
        element("text", { x: LEFT - 6, y: y(tick) + 4, "text-anchor": "end" }, svg).textContent = tick;
      }
      for (const tick of ticks(this.episode.duration, Math.max(2, Math.floor(width / 70)))) {
        element("path", { class: "axis", d: `M${x(tick)} ${height - BOTTOM}v4` }, svg);
        const text = element("text", { x: x(tick), y: height - 4, "text-anchor": "middle" }, svg);
        text.textContent = tick === 0 ? "0 s" : tick;
      }
      element("path", { class: "axis", d: `M${LEFT} ${height - BOTTOM}H${width - RIGHT}` }, svg);
      if (threshold !== undefined) element("path", { class: "threshold", d: `M${LEFT} ${y(threshold)}H${width - RIGHT}` }, svg);
      for (const { values, colour, dash } of curves) {
        let path = "", isOn = false;
        values.forEach((value, i) => {
          if (value !== null) path += `${isOn ? "L" : "M"}${x(times[i]).toFixed(1)} ${y(value).toFixed(1)}`;
          isOn = value !== null;
        });
        element("path", { class: "halo", d: path, "stroke-dasharray": dash ?? "" }, svg);
        element("path", { class: "line", d: path, stroke: colour, "stroke-dasharray": dash ?? "" }, svg);
      }
      chart.cursor = element("path", { class: "cursor", d: `M0 ${TOP}V${height - BOTTOM}` }, svg);
      chart.x = x;
    }
  }

  // Shows the figures of a step, with the cursor at a time.
  update(time, step) {
    for (const chart of this.charts) {
      chart.cursor.setAttribute("transform", `translate(${chart.x(time).toFixed(2)} 0)`);
      for (const { output, values } of chart.curves) {
        const value = values[step] ?? null;
        output.textContent = value === null ? "–" : value.toFixed(chart.digits);
      }
    }
  }
}

// The spans of time in which the human leads.
export function led(episode) {
  const { decided_s: times } = episode.steps;
  const spans = [];
  for (let i = 0; i < times.length; i++) {
    if (!episode.isHumanLed(i)) continue;
    const end = times[i + 1] ?? episode.duration;
    if (spans.length && spans[spans.length - 1][1] === times[i]) spans[spans.length - 1][1] = end;
    else spans.push([times[i], end]);
  }
  return spans;
}

// Round values from 0 to `most`.
function ticks(most, about) {
  const rough = most / about;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough) ?? 10 * power;
  const values = [];
  for (let i = 0; i * step <= most * 1.0001; i++) values.push(Number((i * step).toPrecision(6)));
  return values;
}
