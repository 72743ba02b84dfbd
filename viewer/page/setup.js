// The panel of choices: world, human, robot. It shows what is chosen, and changes it.
import { escaped, symbol } from "../src/episode.js";
import { OWN_PERIOD_S, SLIDERS } from "./choices.js";

const $ = (id) => document.getElementById(id);
// Words for names of the program, where the program's own words are long.
const PLANTS = { rapier: "forces and contacts", kinematic: "without forces", point: "planning only: a point" };
const TITLES = { "free-form": "Free-form workshop" };

export class Setup {
  constructor(choices, catalogue) {
    Object.assign(this, { choices, catalogue });
    const title = (name) => TITLES[name] ?? name.replace(/-/g, " ").replace(/^./, (c) => c.toUpperCase());
    fill($("world"), catalogue.worlds.map(({ name }) => [name, title(name)]));
    fill($("robot"), catalogue.robots.map(({ name }) => [name, title(name)]));
    fill($("plant"), ["rapier", "kinematic", "point"].map((name) => [name, PLANTS[name]]));
    fill($("method"), catalogue.methods.map(({ name }) => [name, title(name)]));
    $("world").addEventListener("change", () => $("world").value !== "yours" && choices.change({ world: $("world").value, toml: null }));
    for (const key of ["robot", "plant", "method"]) $(key).addEventListener("change", () => choices.change({ [key]: $(key).value }));
    $("learn").addEventListener("change", () => choices.change({ belief: $("learn").checked ? "learn" : "prior" }));
    $("seed").addEventListener("change", () => {
      const value = Number($("seed").value);
      if (Number.isSafeInteger(value) && value >= 0 && $("seed").value !== "") choices.change({ seed: value });
      this.show();
    });
    document.querySelectorAll('[name="human"]').forEach((input) => input.addEventListener("change", () => {
      const isOwn = input.value === "me";
      choices.change({ carry: isOwn, period: isOwn ? OWN_PERIOD_S : null, ...(!isOwn && { human: input.value }) });
    }));
    for (const [key, { least, most, step }] of Object.entries(SLIDERS)) {
      Object.assign($(key), { min: least, max: most, step });
      $(key).addEventListener("input", () => choices.change({ [key]: Number($(key).value) }));
    }
    choices.onChange(() => this.show());
    this.show();
  }

  // Shows what is chosen.
  show() {
    const { now } = this.choices;
    const yours = $("world").querySelector('[value="yours"]');
    if (now.toml !== null && !yours) $("world").add(new Option("Your world", "yours"));
    if (now.toml === null && yours) yours.remove();
    $("world").value = now.toml === null ? now.world : "yours";
    for (const key of ["robot", "plant", "method", "seed"]) if ($(key).value !== String(now[key])) $(key).value = now[key];
    $("robot").disabled = now.plant === "point";
    $("learn").checked = now.belief === "learn";
    document.querySelectorAll('[name="human"]').forEach((input) => (input.checked = input.value === (now.carry ? "me" : now.human)));
    for (const [key, { digits }] of Object.entries(SLIDERS)) {
      const box = document.querySelector(`[data-slider="${key}"]`);
      box.hidden = key === "rationality" && now.human !== "boltzmann";
      if (Number($(key).value) !== now[key]) $(key).value = now[key];
      box.querySelector("output").textContent = now[key].toFixed(digits).replace(/(\.\d+?)0+$/, "$1").replace(/\.0$/, "");
    }
    $("method-note").textContent = this.catalogue.methods.find(({ name }) => name === now.method)?.about ?? "";
  }

  // Shows a world's options at the start.
  options({ options, note, world, openings }) {
    $("options").querySelector("tbody").innerHTML = options.map(({ name, openings: through, colour, length_m: length, risk, objective_cost_m: cost, probability }) =>
      `<tr><th scope="row"><span class="chip" style="background:${colour}"></span>${escaped(name)}</th><td>${through.map(symbol).join(" ") || "no opening"}</td><td>${number(length, 2)}</td><td>${number(risk, 3)}</td><td>${number(cost, 2)}</td><td>${probability === null ? "–" : `${(100 * probability).toFixed(1)}&#8239;%`}</td></tr>`).join("");
    $("world-note").textContent = note ?? "";
  }
}

const number = (value, digits) => (value === null || value === undefined ? "–" : value.toFixed(digits));

function fill(select, entries) {
  select.replaceChildren(...entries.map(([value, text]) => new Option(text, value)));
}
