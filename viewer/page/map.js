// The map: the world from above as a drawing, in which obstacles, A and B can be moved and walls drawn, with mouse,
// touch or keys. It shows the team as well, and stands in for the three-dimensional view where there is none.
import { element } from "../src/charts.js";
import { escaped, symbol } from "../src/episode.js";
import { apart, spacing } from "../src/lines.js";
import { luminance } from "../src/labels.js";
import { isMovable } from "./edit.js";

// Room around the drawing for the controls, px, and around the paths, m.
const MARGIN = { side: 20, top: 62, bottom: 104 }, MARGIN_M = 0.8;
const NARROW_PX = 620, ROW_PX = 40;
// The size of a key's step, m; with Shift.
const STEP_M = 0.1, LEAP_M = 0.5;
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

export class WorldMap {
  // `edit` is told of every change: (kind, ...arguments); `covered` gives boxes in which no label may be.
  constructor(svg, labels, covered, edit) {
    Object.assign(this, { svg, folder: labels, edit, covered, tool: "move", isEditable: true });
    this.layers = Object.fromEntries(["ground", "paths", "walls", "openings", "walked", "team", "ends", "draft"].map((name) => [name, element("g", { class: name }, svg)]));
    svg.addEventListener("pointerdown", (event) => this.#press(event));
    svg.addEventListener("pointermove", (event) => this.#drag(event));
    for (const end of ["pointerup", "pointercancel"]) svg.addEventListener(end, (event) => this.#release(event, end === "pointerup"));
    svg.addEventListener("keydown", (event) => this.#key(event));
  }

  // Shows a world as the module draws it, with its options; `file` is what was parsed of its text.
  show(drawn, file) {
    Object.assign(this, { drawn, file });
    if (!this.isHeld) this.fit();
    this.paint();
  }

  // Chooses the part of the world that the map shows: where the team may go.
  fit() {
    const { world, options } = this.drawn;
    const places = [world.start, world.target, ...options.flatMap(({ path }) => path)];
    const ends = [0, 1].map((axis) => places.reduce(([low, high], { [axis]: value }) => [Math.min(low, value - MARGIN_M), Math.max(high, value + MARGIN_M)], [Infinity, -Infinity]));
    this.ends = ends;
    const { clientWidth: width, clientHeight: height } = this.svg;
    if (!width || !height) return;
    const [w, h] = ends.map(([low, high]) => high - low);
    // on a narrow stage the controls have two rows
    const rows = width < NARROW_PX ? ROW_PX : 0, side = MARGIN.side, top = MARGIN.top + rows, bottom = MARGIN.bottom + rows;
    // below, there are a caption and buttons
    this.lowest = height - bottom;
    this.scale = Math.min((width - 2 * side) / w, (height - top - bottom) / h);
    this.origin = [width / 2 - (this.scale * (ends[0][0] + ends[0][1])) / 2, (height + top - bottom) / 2 + (this.scale * (ends[1][0] + ends[1][1])) / 2];
    this.svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  }

  layout() {
    if (!this.drawn || !this.svg.clientWidth) return;
    this.fit();
    this.paint();
    if (this.shown) this.team(...this.shown);
  }

  at = ([x, y]) => [this.origin[0] + this.scale * x, this.origin[1] - this.scale * y];
  #line = (points) => points.map((place) => this.at(place).map((v) => v.toFixed(1)).join(" ")).join("L");

  // The place in the world at a point of the window.
  floor(x, y) {
    const { left, top } = this.svg.getBoundingClientRect();
    return [(x - left - this.origin[0]) / this.scale, (this.origin[1] - (y - top)) / this.scale];
  }

  paint() {
    if (!this.scale) return;
    const { layers, drawn: { world, options }, svg } = this;
    const focused = document.activeElement?.closest?.("#map [data-item]")?.dataset.item;
    for (const name of ["ground", "paths", "walls", "openings", "ends"]) layers[name].replaceChildren();
    const { clientWidth: width, clientHeight: height } = svg;
    const [west, north] = this.floor(svg.getBoundingClientRect().left, svg.getBoundingClientRect().top);
    let grid = "";
    const step = spacing(Math.max(width, height) / this.scale);
    for (let x = step * Math.ceil(west / step); this.at([x, 0])[0] < width; x += step) grid += `M${this.at([x, 0])[0].toFixed(1)} 0V${height}`;
    for (let y = step * Math.floor(north / step); this.at([0, y])[1] < height; y -= step) grid += `M0 ${this.at([0, y])[1].toFixed(1)}H${width}`;
    element("path", { d: grid }, layers.ground);
    options.map((_, o) => o).sort((a, b) => (options[b].probability ?? 0) - (options[a].probability ?? 0)).forEach((o) => {
      const { path, colour, dash, probability } = options[o];
      const line = { d: `M${this.#line(path)}`, "stroke-width": (2 + 14 * (probability ?? 0)).toFixed(2) };
      element("path", { ...line, stroke: colour, class: "option", "stroke-dasharray": probability > 0.12 ? "" : dash.map((d) => d / 2).join(" ") }, layers.paths);
    });
    this.#walls(world);
    for (const { ends: [a, b], colour } of world.openings) {
      element("path", { d: `M${this.#line([a, b])}`, stroke: colour, class: "opening" }, layers.openings);
    }
    for (const [name, key, place] of [["A", "start_m", world.start], ["B", "target_m", world.target]]) this.#end(name, key, place);
    this.#labels(world, options);
    if (focused) svg.querySelector(`[data-item="${CSS.escape(focused)}"]`)?.focus({ preventScroll: true });
  }

  #walls(world) {
    // an obstacle with holes is drawn in parts
    const parts = new Map();
    for (const obstacle of world.obstacles) {
      const d = obstacle.corners ? `M${this.#line(obstacle.corners)}Z` : round(this.at(obstacle.center), obstacle.radius * this.scale);
      parts.set(obstacle.index, (parts.get(obstacle.index) ?? "") + d);
    }
    for (const [i, d] of parts) {
      const item = this.file?.obstacle?.[i];
      const isHandle = this.isEditable && item && isMovable(item);
      const group = element("g", isHandle ? handle(`obstacle:${i}`, `Obstacle ${item.name}${place(item)}`) : {}, this.layers.walls);
      if (isHandle) element("path", { d, class: "grasp" }, group);
      element("path", { d, class: "wall" }, group);
    }
  }

  #end(name, key, at) {
    const [x, y] = this.at(at);
    const words = `${name === "A" ? "Start" : "Target"} ${name}, at ${at.map((v) => v.toFixed(2)).join(", ")} m`;
    const group = element("g", { ...(this.isEditable ? handle(key, words) : {}), transform: `translate(${x} ${y})` }, this.layers.ends);
    element("circle", { r: 22, class: "grasp" }, group);
    element("circle", { r: 12, class: "end" }, group);
    element("text", { y: 5, "text-anchor": "middle" }, group).textContent = name;
  }

  #labels(world, options) {
    this.folder.replaceChildren();
    const { clientWidth: width } = this.svg;
    const taken = [...this.covered(), ...[world.start, world.target].map(this.at).map(([x, y]) => [x - 14, y - 14, x + 14, y + 14])];
    const put = (html, kind, at, style) => {
      const label = document.createElement("div");
      label.className = kind;
      label.innerHTML = html;
      Object.assign(label.style, style);
      this.folder.append(label);
      const [w, h] = [label.offsetWidth, label.offsetHeight], [x, y] = this.at(at);
      const places = [[0, -1.1 * h], [0, 1.1 * h], [0.6 * w, -h], [-0.6 * w, -h], [0.6 * w, h], [-0.6 * w, h], [0, 0]];
      const boxes = places.map(([dx, dy]) => [x + dx - w / 2, y + dy - h / 2, x + dx + w / 2, y + dy + h / 2]);
      const box = boxes.find((b) => b[0] > 0 && b[1] > 40 && b[2] < width && b[3] < this.lowest && !taken.some((t) => t[0] < b[2] && b[0] < t[2] && t[1] < b[3] && b[1] < t[3]));
      label.style.visibility = box ? "visible" : "hidden";
      if (!box) return;
      label.style.transform = `translate(${box[0].toFixed(1)}px, ${box[1].toFixed(1)}px)`;
      taken.push(box);
    };
    for (const { name, ends: [a, b], width_m: wide, risk, colour } of world.openings) {
      put(`${symbol(name)} ${wide.toFixed(2)} m, risk ${risk.toFixed(2)}`, "opening", [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2], { borderLeftColor: colour });
    }
    options.forEach((option, o) => {
      const at = apart(option.path, options.filter((_, other) => other !== o).map(({ path }) => path));
      if (at) put(`option ${escaped(option.name)}`, "option", at, { background: option.colour, color: luminance(option.colour) > 0.18 ? "#111" : "#fff" });
    });
  }

  // Shows the team: outlines on the floor, the way walked [x, y, ...], and where the hand shall go.
  team(bodies, walked, target) {
    this.shown = [bodies, walked, target];
    const { team, walked: way } = this.layers;
    if (!this.scale) return;
    team.replaceChildren();
    way.replaceChildren();
    if (!bodies) return;
    const points = [];
    for (let i = 0; i < walked.length; i += 2) points.push([walked[i], walked[i + 1]]);
    if (points.length > 1) element("path", { d: `M${this.#line(points)}` }, way);
    for (const { kind, corners, center, radius } of bodies) {
      const d = corners ? `M${this.#line(corners)}Z` : round(this.at(center), radius * this.scale);
      element("path", { d, class: kind }, team);
    }
    if (target) element("path", { d: round(this.at(target), 9), class: "target" }, team);
  }

  #press(event) {
    if (!this.isEditable || event.button !== 0) return;
    const from = this.floor(event.clientX, event.clientY);
    const item = event.target.closest("[data-item]")?.dataset.item;
    if (this.tool === "move" && !item) return;
    event.preventDefault();
    this.svg.setPointerCapture(event.pointerId);
    this.isHeld = true;
    this.press = { id: event.pointerId, item: this.tool === "wall" ? null : item, from, last: from };
    if (this.press.item) this.svg.querySelector(`[data-item="${CSS.escape(item)}"]`)?.focus({ preventScroll: true });
    this.edit("begin");
  }

  #drag(event) {
    const { press } = this;
    if (!press || press.id !== event.pointerId) return;
    press.last = this.floor(event.clientX, event.clientY);
    const by = [press.last[0] - press.from[0], press.last[1] - press.from[1]];
    if (press.item) this.edit("move", press.item, by);
    else {
      this.layers.draft.replaceChildren();
      element("path", { d: `M${this.#line([press.from, press.last])}` }, this.layers.draft);
    }
  }

  #release(event, isDone) {
    const { press } = this;
    if (!press || press.id !== event.pointerId) return;
    this.press = null;
    this.isHeld = false;
    this.layers.draft.replaceChildren();
    if (!press.item && isDone) this.edit("wall", press.from, press.last);
    this.edit("end");
  }

  #key(event) {
    const item = event.target.closest?.("[data-item]")?.dataset.item;
    if (!item || event.ctrlKey || event.metaKey || event.altKey) return;
    const size = event.shiftKey ? LEAP_M : STEP_M;
    const act = ARROWS[event.key] ? () => this.edit("move", item, ARROWS[event.key].map((part) => part * size))
      : { "[": () => this.edit("turn", item, 5), "]": () => this.edit("turn", item, -5), "+": () => this.edit("stretch", item, size),
        "-": () => this.edit("stretch", item, -size), Delete: () => this.edit("remove", item), Backspace: () => this.edit("remove", item) }[event.key];
    if (!act) return;
    event.preventDefault();
    event.stopPropagation();
    this.edit("begin");
    act();
    this.edit("end");
  }
}

// What makes a shape one that mouse, touch and keys can hold.
const handle = (item, words) => ({ "data-item": item, tabindex: 0, role: "button", "aria-label": words, "aria-keyshortcuts": "ArrowLeft ArrowRight ArrowUp ArrowDown" });

const place = ({ center_m: at }) => (at ? `, at ${at.map((v) => v.toFixed(2)).join(", ")} m` : "");

const round = ([x, y], r) => `M${(x - r).toFixed(1)} ${y.toFixed(1)}a${r.toFixed(1)} ${r.toFixed(1)} 0 1 0 ${(2 * r).toFixed(1)} 0a${r.toFixed(1)} ${r.toFixed(1)} 0 1 0 ${(-2 * r).toFixed(1)} 0z`;
