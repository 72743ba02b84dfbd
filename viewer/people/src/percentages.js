// The task "percentages": a map, and a number for each option. They must sum to 100; nothing is filled in before.
import { fault, hiddenTime, make, plugin, practice, show, submitted } from "./page.js";

export const Percentages = plugin("percentages", async (display, trial) => {
  const { world, note } = trial;
  const began = performance.now(), hidden = hiddenTime();
  const fields = world.options.map((option, index) =>
    make("input", { type: "text", inputmode: "numeric", autocomplete: "off", id: `option-${index}`, name: option, maxlength: "3" }));
  const sum = make("output", { id: "sum" });
  const number = (field) => (/^\d{1,3}$/.test(field.value.trim()) ? Number(field.value) : NaN);
  const add = () => {
    const total = fields.map(number).filter((value) => !Number.isNaN(value)).reduce((a, b) => a + b, 0);
    const left = 100 - total;
    sum.textContent = `${total} %${left > 0 ? `, ${left} left` : left < 0 ? `, ${-left} too many` : ""}`;
    return total;
  };
  const row = (option, index) =>
    make("tr", {}, make("th", { scope: "row" }, make("label", { for: `option-${index}` }, `Way ${option}`)), make("td", {}, fields[index], " %"));
  const table = make("table", { class: "shares" }, make("tbody", {}, ...world.options.map(row),
    make("tr", {}, make("th", { scope: "row" }, "Together"), make("td", {}, sum))));
  const message = fault();
  const form = make("form", { noValidate: true }, table, message, make("button", {}, "Continue"));
  const names = world.options.join(", ");
  const map = make("img", { class: "map", src: world.file, alt: `Map of walls and obstacles from above, with A, B and the ways ${names}`, width: world.size[0], height: world.size[1] });
  show(display, "How likely would you go each way?", ...practice(trial), make("div", { class: "two" }, map, form));
  fields.forEach((field, index) => {
    field.addEventListener("input", () => {
      add();
      message.textContent = "";
      note("input", { data: { option: world.options[index], text: field.value.slice(0, 10) } });
    });
    // Enter goes on to the next field, and from the last one to the next page
    field.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" || index === fields.length - 1) return;
      event.preventDefault();
      fields[index + 1].focus();
    });
  });
  add();
  fields[0].focus({ preventScroll: true });
  return submitted(form, message, () => {
    const open = fields.find((field) => Number.isNaN(number(field)) || number(field) > 100);
    if (open) {
      open.focus();
      throw "Give a whole number from 0 to 100 for every way.";
    }
    if (add() !== 100) throw `The numbers must add up to 100; they add up to ${add()}.`;
    return {
      world: world.name, practice: trial.practice, percent: fields.map((field, index) => [world.options[index], number(field)]),
      ms: Math.round(performance.now() - began), hidden_ms: hidden(),
    };
  });
});
