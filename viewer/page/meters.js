// The three bars under the picture: the forces of the grips, stubbornness, and what people would choose.
import { escaped } from "../src/episode.js";
import { luminance } from "../src/labels.js";

// The force at which the bar is full, N, and from which it warns: what a person carries for long.
const FULL_N = 80, HEAVY_N = 50;

export class Meters {
  constructor({ force, phi, choice }) {
    Object.assign(this, { force: parts(force), phi: parts(phi), choice });
  }

  // Begins an episode.
  begin({ options, isFelt }) {
    this.force.box.classList.toggle("none", !isFelt);
    this.choice.innerHTML = options.map(({ name, colour }) =>
      `<span style="background:${colour};color:${luminance(colour) > 0.18 ? "#111" : "#fff"}"><b>${escaped(name)}</b> <i></i></span>`).join("");
    this.segments = [...this.choice.children];
  }

  // Shows the figures of a step.
  update(episode, step) {
    const force = episode.figure("grip_force_n", step), hand = episode.figure("hand_force_n", step);
    if (episode.isFelt && force !== null) {
      this.force.fill(force / FULL_N);
      this.force.box.classList.toggle("over", Math.max(force, hand) > HEAVY_N);
      this.force.say(`${force.toFixed(0)} N`);
    } else this.force.say(episode.isFelt ? "–" : "none");
    const phi = episode.figure("stubbornness", step);
    this.phi.fill((phi ?? 0) / 1.25);
    this.phi.box.classList.toggle("over", phi > 1);
    this.phi.say(phi === null ? "–" : `${phi.toFixed(2)} of 1`);
    const known = episode.options.map(({ probability }) => {
      for (let k = step; k >= 0; k--) if (probability[k] !== null && probability[k] !== undefined) return probability[k];
      return null;
    });
    this.segments.forEach((segment, o) => {
      const p = known[o] ?? 0;
      segment.style.flexGrow = p.toFixed(4);
      segment.classList.toggle("thin", p < 0.1);
      segment.lastChild.textContent = `${(100 * p).toFixed(0)} %`;
    });
    const words = episode.options.map(({ name }, o) => `option ${name} ${known[o] === null ? "unknown" : `${(100 * known[o]).toFixed(0)} %`}`);
    this.choice.setAttribute("aria-label", `What people would choose from here: ${words.join(", ")}`);
  }
}

function parts(box) {
  const [bar, value] = [box.querySelector(".bar > span"), box.querySelector("output")];
  return {
    box,
    fill: (part) => (bar.style.transform = `scaleX(${Math.min(1, Math.max(0, part)).toFixed(4)})`),
    say: (text) => value.textContent !== text && (value.textContent = text),
  };
}
