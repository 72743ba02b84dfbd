// What the pages of all tasks have in common.

// An element, its attributes and its children. Texts are texts: nothing in them is markup.
export function make(name, attributes = {}, ...children) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key in element && typeof value !== "string") element[key] = value;
    else element.setAttribute(key, value);
  }
  element.append(...children);
  return element;
}

// Paragraphs of a text: blank lines divide them.
export const paragraphs = (text) => text.trim().split(/\n\s*\n/).map((part) => make("p", {}, part.replace(/\s+/g, " ")));

// Shows a page, with its heading in focus, so that a screen reader begins there.
export function show(display, heading, ...children) {
  const title = make("h1", { tabIndex: -1 }, heading);
  display.replaceChildren(make("div", {}, title, ...children));
  title.focus();
  scrollTo(0, 0);
}

export const practice = (trial) => (trial.practice ? [make("p", { class: "practice" }, "Practice: this answer does not count.")] : []);

// A form; resolves with what `read` returns at its submission. A text that `read` throws is shown, and the form stays.
export function submitted(form, fault, read) {
  return new Promise((done) => {
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      try {
        const answer = read();
        form.querySelectorAll("button").forEach((button) => (button.disabled = true));
        done(answer);
      } catch (sentence) {
        if (typeof sentence !== "string") throw sentence;
        // emptied first: an equal sentence is said again
        fault.textContent = "";
        fault.textContent = sentence;
      }
    });
  });
}

export const fault = () => make("p", { class: "fault", role: "alert" });

// How long the page was hidden since this was made, ms.
export function hiddenTime() {
  let since = document.hidden ? performance.now() : null, total = 0;
  const change = () => {
    if (document.hidden) since ??= performance.now();
    else if (since !== null) [total, since] = [total + performance.now() - since, null];
  };
  addEventListener("visibilitychange", change);
  return () => {
    removeEventListener("visibilitychange", change);
    return Math.round(total + (since === null ? 0 : performance.now() - since));
  };
}

// A plugin of jsPsych for a task: `run(display, trial)` resolves with what the trial records. `trial.finish` puts that into
// the journal before the next trial begins.
export const plugin = (name, run) =>
  class {
    static info = { name: `cocarry-${name}`, version: "1.0.0", parameters: {}, data: {} };

    async trial(display, trial, onLoad) {
      trial.begin();
      const running = run(display, trial);
      onLoad?.();
      const data = await running;
      await trial.finish({ task: name, ...data });
      return {};
    }
  };
