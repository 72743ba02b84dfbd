// Pages of text, questions with a right answer, and scales.
import { fault, make, paragraphs, plugin, show, submitted } from "./page.js";

export const Consent = plugin("consent", async (display, { consent, order }) => {
  const box = make("input", { type: "checkbox", required: true, name: "consent" });
  const message = fault();
  const form = make("form", { noValidate: true },
    make("p", {}, make("label", { class: "choice" }, box, make("span", {}, "I have read this and take part of my own will."))),
    message, make("button", {}, "Begin"));
  show(display, "Before you begin", ...paragraphs(consent.text), form);
  return submitted(form, message, () => {
    if (!box.checked) throw "Tick the box if you want to take part. Otherwise close the page.";
    return { version: consent.version, order };
  });
});

const HEADINGS = { percentages: "Which way would you go?", switch: "The robot leads", carry: "You carry along" };

export const Instructions = plugin("instructions", async (display, { of, text }) => {
  const form = make("form", {}, make("button", {}, "Continue"));
  show(display, HEADINGS[of], ...paragraphs(text), form);
  form.querySelector("button").focus();
  return submitted(form, null, () => ({}));
});

export const Question = plugin("question", async (display, { question, note }) => {
  const answers = [];
  for (;;) {
    const choices = question.answers.map((answer, index) =>
      make("label", { class: "choice" }, make("input", { type: "radio", name: "answer", value: String(index) }), make("span", {}, answer)));
    const message = fault();
    const form = make("form", {}, make("fieldset", {}, make("legend", {}, question.text), ...choices), message, make("button", {}, "Continue"));
    const again = answers.length ? [make("p", {}, "That is not right. Please think again.")] : [];
    show(display, "A question", ...again, form);
    const chosen = await submitted(form, message, () => {
      const checked = form.querySelector("input:checked");
      if (!checked) throw "Choose an answer.";
      return Number(checked.value);
    });
    answers.push(question.answers[chosen]);
    note("answer", { data: { answer: question.answers[chosen] } });
    const right = chosen === question.right;
    if (right || answers.length >= question.attempts) return { text: question.text, answers, right };
  }
});

const NASA_TLX = [
  ["mental demand", "How mentally demanding was the task?", "very low", "very high"],
  ["physical demand", "How physically demanding was the task?", "very low", "very high"],
  ["temporal demand", "How hurried or rushed was the pace of the task?", "very low", "very high"],
  ["performance", "How successful were you in what you were asked to do?", "perfect", "failure"],
  ["effort", "How hard did you have to work for it?", "very low", "very high"],
  ["frustration", "How insecure, discouraged, irritated, stressed or annoyed were you?", "very low", "very high"],
];

// A slider from 0 to 100 in steps of 5, without an answer until it is moved.
function slider([item, question, low, high]) {
  const input = make("input", { type: "range", min: "0", max: "100", step: "5", value: "50", "aria-label": question });
  const value = make("output", {}, "no answer yet");
  let answer = null;
  const take = () => {
    answer = Number(input.value);
    value.textContent = input.value;
  };
  for (const event of ["input", "click"]) input.addEventListener(event, take);
  const field = make("fieldset", {}, make("legend", {}, question), make("div", { class: "range" }, make("span", {}, low), input, make("span", {}, high), value));
  return { item, field, answer: () => answer };
}

function statement(text, { points, ends: [low, high] }, index) {
  const choices = Array.from({ length: points }, (_, point) =>
    make("label", {}, make("input", { type: "radio", name: `item-${index}`, value: String(point + 1) }), make("span", {}, String(point + 1))));
  const end = (word) => make("span", { class: "end" }, word);
  const field = make("fieldset", {}, make("legend", {}, text), make("div", { class: "points" }, end(low), ...choices, end(high)));
  const answer = () => {
    const checked = field.querySelector("input:checked");
    return checked && Number(checked.value);
  };
  return { item: text, field, answer };
}

export const Scale = plugin("scale", async (display, { scale }) => {
  const items = scale.kind === "nasa-tlx" ? NASA_TLX.map(slider) : scale.statements.map((text, index) => statement(text, scale, index));
  const message = fault();
  const form = make("form", {}, ...items.map(({ field }) => field), message, make("button", {}, "Continue"));
  show(display, scale.kind === "nasa-tlx" ? "How was it?" : "How much do you agree?", form);
  return submitted(form, message, () => {
    const missing = items.find(({ answer }) => answer() === null);
    if (missing) {
      missing.field.querySelector("input").focus();
      throw scale.kind === "nasa-tlx" ? "Move every slider to your answer." : "Choose a number for every statement.";
    }
    return { name: scale.name, answers: items.map(({ item, answer }) => [item, answer()]) };
  });
});
