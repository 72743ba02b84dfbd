// Labels in the page over the scene: ends, openings and options. Each takes the first free place around its point; one
// without any is left out.
import { Vector3 } from "three";
import { escaped, symbol } from "./episode.js";

export class Labels {
  constructor(folder, stage) {
    const rank = { end: 0, opening: 1, option: 2 };
    this.labels = stage.labels.map((label) => {
      const element = document.createElement("div");
      element.className = label.kind;
      if (label.kind === "opening") {
        // a stimulus has names alone
        const figures = label.risk === undefined ? "" : ` ${label.width.toFixed(2)} m, risk ${label.risk.toFixed(2)}`;
        element.innerHTML = symbol(label.name) + figures;
        element.style.borderLeftColor = label.colour;
      } else {
        element.innerHTML = label.kind === "option" ? `option ${escaped(label.name)}` : escaped(label.name);
      }
      if (label.kind === "option") {
        element.style.background = label.colour;
        element.style.color = luminance(label.colour) > 0.18 ? "#111" : "#fff";
      }
      folder.append(element);
      return { ...label, element, rank: rank[label.kind] };
    });
    this.measure();
  }

  measure() {
    for (const label of this.labels) {
      [label.width_px, label.height_px] = [label.element.offsetWidth, label.element.offsetHeight];
    }
  }

  update(camera, width, height, obstructions) {
    const shown = [...obstructions];
    const placed = this.labels.map((label) => {
      const seen = new Vector3().copy(label.at).project(camera);
      return { label, seen, distance: label.at.distanceTo(camera.position) };
    });
    placed.sort((a, b) => a.label.rank - b.label.rank || a.distance - b.distance);
    for (const { label, seen } of placed) {
      const [w, h] = [label.width_px, label.height_px];
      const [x, y] = [((seen.x + 1) / 2) * width, ((1 - seen.y) / 2) * height];
      // the middle of the label, from its point
      const places = label.kind === "end" ? [[0, 0]]
        : [[0, -1.1 * h], [0, 1.1 * h], [0.6 * w, -h], [-0.6 * w, -h], [0.6 * w, h], [-0.6 * w, h], [0, -2.2 * h], [0, 2.2 * h]];
      const boxes = places.map(([dx, dy]) => [x + dx - w / 2, y + dy - h / 2, x + dx + w / 2, y + dy + h / 2]);
      const isIn = (b) => seen.z < 1 && b[0] > 0 && b[1] > 0 && b[2] < width && b[3] < height;
      const isFree = (b) => isIn(b) && !shown.some((s) => s[0] < b[2] && b[0] < s[2] && s[1] < b[3] && b[1] < s[3]);
      const box = boxes.find(isFree);
      label.element.style.visibility = box ? "visible" : "hidden";
      if (box) {
        label.element.style.transform = `translate(${box[0].toFixed(1)}px, ${box[1].toFixed(1)}px)`;
        shown.push(box);
      }
    }
  }
}

// The relative luminance of a colour `#rrggbb`; above 0.18, black letters have more contrast on it than white ones.
export function luminance(colour) {
  const light = [1, 3, 5].map((at) => {
    const part = Number.parseInt(colour.slice(at, at + 2), 16) / 255;
    return part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4;
  });
  return 0.2126 * light[0] + 0.7152 * light[1] + 0.0722 * light[2];
}
