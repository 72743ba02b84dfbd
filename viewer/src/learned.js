// What the robot has learned of the human: the belief on the plane of alpha and gamma, with the information and eta.
import { element } from "./charts.js";
import { last } from "./episode.js";

const LEFT = 46, RIGHT = 10, TOP = 8, BOTTOM = 40, HEIGHT = 250;
// The opacity of the densest cell of the episode.
const DARKEST = 0.6;

const NOTE = {
  alpha: ["mean of α", "α: how a person perceives distance, with the central 95 % interval."],
  gamma: ["mean of γ", "γ: how a person perceives risk, with the central 95 % interval."],
  eta: ["mean of η, tolerance", "η: how long a person bears the robot's lead on another option, with the central 95 % interval."],
  region_share: ["95 % region", "The smallest part of the prior that holds 95 % of the belief."],
  information_nats: ["information", "About α and γ, against the prior: 0 nats where nothing was learned."],
};

export class Learned {
  constructor(folder, { learned }) {
    Object.assign(this, learned);
    this.times = this.beliefs.map(({ time_s }) => time_s);
    this.size = Math.sqrt(this.planes[0].density.length);
    this.densest = this.planes.flatMap(({ density }) => density).reduce((most, value) => Math.max(most, value), 0);
    const card = document.createElement("section");
    card.className = "chart";
    card.id = "learned";
    card.innerHTML = '<h2>What the robot has learned</h2><div class="entries"></div><p class="none"></p>';
    card.title = "The belief over this human. It begins as the prior; every look at where a leading human goes may narrow it.";
    this.outputs = Object.fromEntries(Object.entries(NOTE).map(([key, [words, about]]) => {
      const entry = document.createElement("span");
      entry.className = "entry";
      entry.title = about;
      entry.append(words, " ", document.createElement("output"));
      entry.lastChild.dataset.figure = `learned.${key}`;
      card.querySelector(".entries").append(entry);
      return [key, entry.lastChild];
    }));
    this.svg = element("svg", { role: "img", height: HEIGHT }, card);
    this.svg.style.cursor = "default";
    const key = card.querySelector(".none");
    key.textContent = `Stronger shade: more probable. Outlined: the 95\u00a0% region. Dot: mean.${this.humans.length ? " Cross: this human." : ""} In brackets: 95\u00a0% intervals.`;
    card.append(key);
    folder.append(card);
    this.layout();
  }

  // Draws axes and an empty plane for the present width.
  layout() {
    const { svg, ranges } = this;
    const width = Math.max(160, svg.clientWidth || svg.parentElement.clientWidth - 24);
    svg.replaceChildren();
    svg.setAttribute("viewBox", `0 0 ${width} ${HEIGHT}`);
    const place = ([low, high], from, to) => (value) => from + ((value - low) / (high - low)) * (to - from);
    this.x = place(ranges[0], LEFT, width - RIGHT);
    this.y = place(ranges[1], HEIGHT - BOTTOM, TOP);
    this.plane = element("g", { class: "density" }, svg);
    element("rect", { class: "frame", x: LEFT, y: TOP, width: width - LEFT - RIGHT, height: HEIGHT - TOP - BOTTOM }, svg);
    for (const value of round(ranges[0])) {
      element("path", { class: "axis", d: `M${this.x(value)} ${HEIGHT - BOTTOM}v4` }, svg);
      element("text", { x: this.x(value), y: HEIGHT - BOTTOM + 17, "text-anchor": "middle" }, svg).textContent = value;
    }
    for (const value of round(ranges[1])) {
      element("path", { class: "axis", d: `M${LEFT} ${this.y(value)}h-4` }, svg);
      element("text", { x: LEFT - 7, y: this.y(value) + 4, "text-anchor": "end" }, svg).textContent = value;
    }
    element("text", { x: (LEFT + width - RIGHT) / 2, y: HEIGHT - 5, "text-anchor": "middle" }, svg).textContent = "α, perception of distance";
    const across = `rotate(-90) translate(${-(TOP + HEIGHT - BOTTOM) / 2} 11)`;
    element("text", { transform: across, "text-anchor": "middle" }, svg).textContent = "γ, perception of risk";
    this.border = element("path", { class: "border" }, svg);
    const mark = (name, d) => [`${name} under`, name].map((kind) => element("path", { class: kind, d }, svg));
    this.cross = this.humans.length ? mark("human", "M-6-6L6 6M-6 6L6-6") : [];
    this.dot = mark("mean", "M-4.5 0a4.5 4.5 0 1 0 9 0a4.5 4.5 0 1 0-9 0z");
    this.drawn = null;
  }

  // Shows the belief at a time.
  update(time) {
    const belief = this.beliefs[Math.max(0, last(this.times, time))];
    const between = ([low, high], digits) => `(${low.toFixed(digits)} to ${high.toFixed(digits)})`;
    const figures = {
      alpha: `${belief.alpha_mean.toFixed(3)} ${between(belief.alpha_interval, 2)}`,
      gamma: `${belief.gamma_mean.toFixed(3)} ${between(belief.gamma_interval, 2)}`,
      eta: `${belief.eta_mean.toFixed(1)} ${between(belief.eta_interval, 1)}`,
      region_share: `${(100 * belief.region_share).toFixed(1)} % of the prior`,
      information_nats: `${belief.information_nats.toFixed(2)} nats`,
    };
    for (const [key, text] of Object.entries(figures)) this.outputs[key].textContent = text;
    this.svg.setAttribute("aria-label", `The belief over α and γ: mean α ${figures.alpha}, mean γ ${figures.gamma}; the 95 % region is ${figures.region_share}`);
    const put = (marks, [alpha, gamma]) => marks.forEach((m) => m.setAttribute("transform", `translate(${this.x(alpha)} ${this.y(gamma)})`));
    put(this.dot, [belief.alpha_mean, belief.gamma_mean]);
    if (this.humans.length) put(this.cross, this.humans[Math.max(0, last(this.humans.map(([from]) => from), time))].slice(1));
    if (this.drawn !== belief.plane) this.paint(this.planes[(this.drawn = belief.plane)]);
  }

  // Shades the cells, and draws the border of the region along their edges.
  paint({ density, region }) {
    const { size, ranges } = this;
    const edge = ([low, high], to, i) => to(low + ((high - low) * i) / size);
    const x = (i) => edge(ranges[0], this.x, i).toFixed(2), y = (j) => edge(ranges[1], this.y, j).toFixed(2);
    this.plane.replaceChildren();
    let inside = "";
    for (let i = 0; i < size; i++) {
      // cells of one density in a row are one shape
      for (let j = 0, end; j < size; j = end) {
        for (end = j + 1; end < size && density[i * size + end] === density[i * size + j]; ) end++;
        const opacity = (DARKEST * density[i * size + j]) / this.densest;
        element("path", { d: `M${x(i)} ${y(j)}V${y(end)}H${x(i + 1)}V${y(j)}z`, "fill-opacity": opacity.toFixed(3) }, this.plane);
      }
    }
    const isIn = (i, j) => i >= 0 && j >= 0 && i < size && j < size && region[i * size + j] === "1";
    for (let i = 0; i <= size; i++) {
      for (let j = 0; j <= size; j++) {
        if (isIn(i, j) !== isIn(i - 1, j)) inside += `M${x(i)} ${y(j)}V${y(j + 1)}`;
        if (isIn(i, j) !== isIn(i, j - 1)) inside += `M${x(i)} ${y(j)}H${x(i + 1)}`;
      }
    }
    this.border.setAttribute("d", inside);
  }
}

// Round values in a range, three to seven.
function round([low, high]) {
  const power = 10 ** Math.floor(Math.log10(high - low));
  const step = [1, 0.5, 0.2, 0.1].map((m) => m * power).find((s) => (high - low) / s >= 3) ?? (high - low) / 4;
  const values = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9; i++) values.push(Number((i * step).toPrecision(6)));
  return values;
}
