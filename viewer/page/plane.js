// The plane of alpha and gamma: for every human, the option of least subjective cost, eq. (3); the shares of its area are
// P_o, eq. (4). The cross is this human, and can be dragged. Over it lies what a robot that learns believes.
import { element } from "../src/charts.js";
import { escaped } from "../src/episode.js";
import { luminance } from "../src/labels.js";

const LEFT = 40, RIGHT = 8, TOP = 8, BOTTOM = 36, HEIGHT = 220;

export class Plane {
  constructor(svg, choose) {
    this.svg = svg;
    svg.setAttribute("height", HEIGHT);
    const at = (event) => {
      const { left, top } = svg.getBoundingClientRect();
      const value = ([low, high], part, digits = 3) => Number((low + Math.min(1, Math.max(0, part)) * (high - low)).toFixed(digits));
      choose({
        alpha: value(this.ranges[0], (event.clientX - left - LEFT) / (this.width - LEFT - RIGHT)),
        gamma: value(this.ranges[1], (HEIGHT - BOTTOM - (event.clientY - top)) / (HEIGHT - TOP - BOTTOM)),
      });
    };
    svg.addEventListener("pointerdown", (event) => {
      if (!this.human || event.button !== 0) return;
      svg.setPointerCapture(event.pointerId);
      at(event);
    });
    svg.addEventListener("pointermove", (event) => this.human && event.buttons & 1 && svg.hasPointerCapture(event.pointerId) && at(event));
  }

  // Shows the regions of a world's options. `human` is where the cross is; null for one who has no alpha and gamma.
  show(regions, options, human) {
    Object.assign(this, { regions, options, human });
    this.layout();
  }

  layout() {
    const { svg, regions, options } = this;
    if (!regions) return;
    const width = (this.width = Math.max(160, svg.clientWidth || svg.parentElement.clientWidth - 24));
    this.ranges = [regions.alpha, regions.gamma];
    svg.replaceChildren();
    svg.setAttribute("viewBox", `0 0 ${width} ${HEIGHT}`);
    const scale = ([low, high], from, to) => (value) => from + ((value - low) / (high - low)) * (to - from);
    this.x = scale(this.ranges[0], LEFT, width - RIGHT);
    this.y = scale(this.ranges[1], HEIGHT - BOTTOM, TOP);
    const line = (points) => points.map(([alpha, gamma]) => `${this.x(alpha).toFixed(1)} ${this.y(gamma).toFixed(1)}`).join("L");
    for (const { option, outline } of regions.parts) {
      element("path", { d: `M${line(outline)}Z`, fill: options[option].colour, class: "region", stroke: options[option].colour }, svg);
    }
    for (const border of regions.borders) element("path", { d: `M${line(border)}`, class: "border" }, svg);
    this.belief = element("g", { class: "belief" }, svg);
    this.#names(line);
    element("rect", { class: "frame", x: LEFT, y: TOP, width: width - LEFT - RIGHT, height: HEIGHT - TOP - BOTTOM }, svg);
    const text = (x, y, words, anchor = "middle") => (element("text", { x, y, "text-anchor": anchor }, svg).textContent = words);
    for (const value of marks(regions.alpha)) text(this.x(value), HEIGHT - BOTTOM + 14, value);
    for (const value of marks(regions.gamma)) text(LEFT - 6, this.y(value) + 4, value, "end");
    text((LEFT + width - RIGHT) / 2, HEIGHT - 5, "α: perception of distance");
    const across = `rotate(-90) translate(${-(TOP + HEIGHT - BOTTOM) / 2} 11)`;
    element("text", { transform: across, "text-anchor": "middle" }, svg).textContent = "γ: perception of risk";
    this.cross = ["under", "over"].map((kind) => element("path", { class: `cross ${kind}`, d: "M-7-7L7 7M-7 7L7-7" }, svg));
    this.#place();
    const shares = options.map(({ name, probability }) => `option ${name} ${(100 * (probability ?? 0)).toFixed(0)} %`).join(", ");
    svg.setAttribute("aria-label", `The option that each human prefers, by alpha and gamma: ${shares}`);
  }

  // The cross moves without new regions.
  move(human) {
    this.human = human;
    this.#place();
  }

  #place() {
    const { human, cross } = this;
    if (!cross) return;
    const within = (value, [low, high]) => Math.min(high, Math.max(low, value));
    for (const part of cross) {
      part.style.display = human ? "" : "none";
      if (human) part.setAttribute("transform", `translate(${this.x(within(human.alpha, this.ranges[0]))} ${this.y(within(human.gamma, this.ranges[1]))})`);
    }
    this.svg.style.cursor = human ? "crosshair" : "default";
  }

  // The names of the options, in the middle of their largest parts.
  #names() {
    const { svg, regions, options } = this;
    const largest = new Map();
    for (const { option, outline } of regions.parts) {
      const [size, at] = middle(outline.map(([alpha, gamma]) => [this.x(alpha), this.y(gamma)]));
      if (size > (largest.get(option)?.size ?? 500)) largest.set(option, { size, at });
    }
    for (const [option, { at: [x, y] }] of largest) {
      const label = element("text", { x, y: y + 5, "text-anchor": "middle", class: "name" }, svg);
      label.style.fill = luminance(options[option].colour) > 0.18 ? "#111" : "#fff";
      label.textContent = options[option].name;
    }
  }

  // The border of the region that holds 95 % of a learned belief; `learned` as the module's summary has it.
  believe(learned) {
    if (!this.belief) return;
    this.belief.replaceChildren();
    const human = learned?.human ?? learned;
    const { density, region_density: level, alpha_range: alphas, gamma_range: gammas } = human ?? {};
    if (!density?.length || !alphas) return;
    const size = Math.round(Math.sqrt(density.length));
    const isIn = (i, j) => i >= 0 && j >= 0 && i < size && j < size && density[i * size + j] >= level * (1 - 1e-6);
    const x = (i) => this.x(alphas[0] + ((alphas[1] - alphas[0]) * i) / size).toFixed(1);
    const y = (j) => this.y(gammas[0] + ((gammas[1] - gammas[0]) * j) / size).toFixed(1);
    let d = "";
    for (let i = 0; i <= size; i++) {
      for (let j = 0; j <= size; j++) {
        if (isIn(i, j) !== isIn(i - 1, j)) d += `M${x(i)} ${y(j)}V${y(j + 1)}`;
        if (isIn(i, j) !== isIn(i, j - 1)) d += `M${x(i)} ${y(j)}H${x(i + 1)}`;
      }
    }
    element("path", { d, class: "learned under" }, this.belief);
    element("path", { d, class: "learned" }, this.belief);
    const at = `translate(${this.x(human.alpha_mean)} ${this.y(human.gamma_mean)})`;
    element("circle", { r: 5, class: "mean", transform: at }, this.belief);
  }
}

export const legend = (options) => options.map(({ name, colour }) => `<span class="chip" style="background:${colour}"></span>${escaped(name)}`).join(" ");

// The area of a polygon, and its middle.
function middle(points) {
  let area = 0, x = 0, y = 0;
  points.forEach(([x1, y1], i) => {
    const [x2, y2] = points[(i + 1) % points.length], cross = x1 * y2 - x2 * y1;
    area += cross / 2;
    x += ((x1 + x2) * cross) / 6;
    y += ((y1 + y2) * cross) / 6;
  });
  return [Math.abs(area), area ? [x / area, y / area] : points[0]];
}

// Round values in a range, three to seven.
function marks([low, high]) {
  const power = 10 ** Math.floor(Math.log10(high - low));
  const step = [1, 0.5, 0.2, 0.1].map((m) => m * power).find((s) => (high - low) / s >= 3) ?? (high - low) / 4;
  const values = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9; i++) values.push(Number((i * step).toPrecision(6)));
  return values;
}
