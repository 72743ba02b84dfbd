// A simulated participant in the page of a study. `cocarry study simulate --browser` serves this beside the page, with what each
// participant answers; nothing of it is in the page of people. Pages are read and pressed as somebody would: the page itself knows
// nothing of it. One browser goes through several participants, one after the other.

// How far ahead of the object the pointer of somebody who leads is, frames of a walk (25 mm each), and how often it moves, ms.
const AHEAD = 45, MOVE_MS = 150;
const LOOK_MS = 20;

const sleep = (ms) => new Promise((done) => setTimeout(done, ms));
async function until(find) {
  for (;;) {
    const found = find();
    if (found) return found;
    await sleep(LOOK_MS);
  }
}
const one = (selector) => document.querySelector(`#study ${selector}`);
const all = (selector) => [...document.querySelectorAll(`#study ${selector}`)];
const heading = () => one("h1")?.textContent;
const pageNumber = () => Number(/^Page (\d+) /.exec(document.getElementById("progress").textContent)?.[1] ?? 0);
const button = (text) => all("button").find((button) => button.textContent === text && !button.hidden && !button.disabled);
const submit = () => one("form button").click();

// What the server says of the session: which order of pages it has.
let place = null;
const fetched = globalThis.fetch;
globalThis.fetch = async (...asked) => {
  const answer = await fetched(...asked);
  if (asked[0] === "api/session" && asked[1]?.method === "POST" && answer.ok) ({ place } = await answer.clone().json());
  return answer;
};

const TASKS = {
  async consent() {
    one("input[type=checkbox]").click();
    submit();
  },
  async instructions() {
    submit();
  },
  async percentages({ percent }) {
    for (const [option, share] of percent) {
      const field = all(".shares input").find(({ name }) => name === option);
      field.value = String(share);
      field.dispatchEvent(new Event("input", { bubbles: true }));
    }
    submit();
  },
  async switch({ step }, { world, option }) {
    const start = await until(() => button("Start"));
    start.click();
    // the walk begins with the next picture
    const began = await new Promise((first) => requestAnimationFrame(first));
    if (step !== null) {
      await sleep((step + 0.5) * world.walks[option].step_ms - (performance.now() - began));
      return start.click();
    }
    (await until(() => button("Continue"))).click();
  },
  async carry(_, { world, way, isLeading }) {
    (await until(() => button("Start"))).click();
    const lead = one("button[aria-pressed]"), stage = one(".stage"), map = one(".stage svg");
    const { frames } = world.walks[way];
    const point = () => {
      const [x, y] = /translate\(([-\d.]+) ([-\d.]+)\)/.exec(map.querySelector("g rect").getAttribute("transform")).slice(1).map(Number);
      const gaps = frames.map(([fx, fy]) => Math.hypot(fx - x, fy - y));
      const [fx, fy] = frames[Math.min(gaps.indexOf(Math.min(...gaps)) + AHEAD, frames.length - 1)];
      return new DOMPoint(fx, fy).matrixTransform(map.getScreenCTM());
    };
    // the system knows no such pointer
    stage.setPointerCapture = () => {};
    const points = (type) => {
      const { x, y } = point();
      stage.dispatchEvent(new PointerEvent(type, { bubbles: true, pointerId: 1, pointerType: navigator.maxTouchPoints > 0 ? "touch" : "mouse", isPrimary: true, button: 0, clientX: x, clientY: y }));
    };
    if (isLeading) lead.click();
    for (let type = "pointerdown"; !button("Continue"); type = "pointermove") {
      // who does not lead lets the hand be led
      if (isLeading) points(type);
      await sleep(MOVE_MS);
    }
    button("Continue").click();
  },
  async question({ answers: [text] }) {
    all("label").find((label) => label.textContent === text).querySelector("input").click();
    submit();
  },
  async scale({ answers }) {
    all("fieldset").forEach((field, index) => {
      const answer = String(answers[index][1]), slider = field.querySelector("input[type=range]");
      if (!slider) return field.querySelector(`input[value="${answer}"]`).click();
      slider.value = answer;
      slider.dispatchEvent(new Event("input", { bubbles: true }));
    });
    submit();
  },
};

async function takePart() {
  const [study, { parameter, people }] = await Promise.all(["study.json", "simulated.json"].map(async (name) => (await fetched(name)).json()));
  const { answers, leads, next } = people[new URLSearchParams(location.search).get(parameter)];
  // the answer to a page, whichever order the pages have
  const planned = ({ task, practice, ...page }, world) => answers.find((answer) =>
    answer.task === task && (world === undefined || answer.world === world.name) &&
    (task !== "switch" || (answer.option === world.options[page.option] && answer.repetition === page.repetition)) &&
    (practice === undefined || answer.practice === practice) &&
    (task !== "question" || answer.text === study.questions[page.question].text) && (task !== "scale" || answer.name === study.scales[page.scale].name));
  // where somebody would go: all of the shares are on it
  const way = (world) => Math.max(0, planned({ task: "percentages", practice: false }, world)?.percent.findIndex(([, share]) => share === 100) ?? 0);
  for (let done = 0; ; ) {
    const at = await until(() => (heading() === "The end" ? Infinity : place !== null && pageNumber() > done && heading() !== "One moment" && pageNumber()));
    if (at === Infinity) break;
    const page = study.orders[place % study.orders.length][at - 1], world = study.worlds[page.world];
    await TASKS[page.task](planned(page, world), { world, option: page.option, way: world && way(world), isLeading: page.practice || leads });
    done = at;
  }
  if (next) location.search = next;
}

takePart();
