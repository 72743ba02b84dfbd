// Simulated participants of known alpha, gamma and eta in Chromium: node test/people.mjs PROGRAM simulated [N [AT_ONCE [SEED]]].
// `cocarry study simulate` draws them and says what each would answer, by eqs. (3) and (5). Here they answer so on the page: shares by
// keyboard, a press in the step at which phi(k) exceeds 1, and a pointer that carries along their way; every fourth has a phone with
// a touch screen. What is collected is compared with what they should have answered, and `infer` with what they are. Everything is in
// real time.
import assert from "node:assert/strict";
import { rmSync } from "node:fs";
import {
  PAGES, carries, faults, heading, isReady, isShown, newStudy, offPage, opened, pageNumber, serve, stored, world,
} from "./participants.mjs";
import { launch } from "./serving.mjs";

const STEP_MS = 200;
// A press is asked for this long before its time: what it takes to reach the page.
const REACH_MS = 10;
// How far ahead of the object a person's pointer is, frames of a walk (25 mm each), and how often it moves, ms.
const AHEAD = 45, MOVE_MS = 150;

// The hands of somebody at a computer, and on a phone.
const mouse = (tab) => ({
  press: () => tab.keyboard.press("Space"),
  goOn: () => tab.keyboard.press("Enter"),
  toggleLead: () => tab.keyboard.press("t"),
  down: async (x, y) => {
    await tab.mouse.move(x, y);
    await tab.mouse.down();
  },
  move: (x, y) => tab.mouse.move(x, y),
  up: () => tab.mouse.up(),
});
async function finger(tab) {
  const protocol = await tab.context().newCDPSession(tab);
  const touch = (type, ...points) => protocol.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y]) => ({ x, y })) });
  const tap = (selector) => async () => {
    const { x, y } = await tab.evaluate((selector) => {
      const button = [...document.querySelectorAll(selector)].find((button) => !button.hidden);
      const { left, top, width, height } = button.getBoundingClientRect();
      return { x: left + width / 2, y: top + height / 2 };
    }, selector);
    await tab.touchscreen.tap(x, y);
  };
  return {
    press: tap("main button"), goOn: tap("main button"), toggleLead: tap("main button[aria-pressed]"),
    down: (x, y) => touch("touchStart", [x, y]), move: (x, y) => touch("touchMove", [x, y]), up: () => touch("touchEnd"),
  };
}

// Where the pointer of somebody who goes along a walk is, in the window; null once it is over.
const ahead = ([frames, far]) => {
  const stage = document.querySelector(".stage svg"), object = stage?.querySelector("g rect");
  if (!object || document.querySelector("main button:not([hidden])")?.textContent === "Continue") return null;
  const [x, y] = /translate\(([-\d.]+) ([-\d.]+)\)/.exec(object.getAttribute("transform")).slice(1).map(Number);
  const gaps = frames.map(([fx, fy]) => Math.hypot(fx - x, fy - y));
  const [fx, fy] = frames[Math.min(gaps.indexOf(Math.min(...gaps)) + far, frames.length - 1)];
  const at = new DOMPoint(fx, fy).matrixTransform(stage.getScreenCTM());
  return [at.x, at.y];
};

// One participant, from the first page to the code. `plan` has shares and steps by world and option.
async function takePart(browser, address, { plan, index, isPhone, leads }) {
  const context = await browser.newContext(isPhone ? { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true } : { viewport: { width: 1024, height: 760 } });
  let place = null;
  context.on("response", async (response) => {
    if (response.url().endsWith("/api/session") && response.request().method() === "POST") ({ place } = await response.json());
  });
  const tab = await opened(context, address, `?PROLIFIC_PID=simulated${String(index).padStart(5, "0")}`);
  const study = await tab.evaluate(() => fetch("study.json").then((answer) => answer.json()));
  const hands = isPhone ? await finger(tab) : mouse(tab);
  // the time of the first picture of a walk, by the clock of the pictures
  await tab.evaluate(() => {
    const first = (event) => {
      if (event.type === "keydown" && event.code !== "Space") return;
      if (event.target.closest?.("button")?.textContent === "Start") requestAnimationFrame((now) => (globalThis.walkBegan = now));
    };
    for (const kind of ["keydown", "pointerdown"]) document.addEventListener(kind, first, true);
  });
  const pages = {
    ...PAGES,
    async "How likely would you go each way?"(_, { world }) {
      const shares = world.options.map((option) => plan.percent(world.name, option));
      await PAGES["How likely would you go each way?"](tab, { shares });
    },
    async "When would you stop following the robot?"(_, { world, option, practice }) {
      await isReady(tab);
      await tab.evaluate(() => (globalThis.walkBegan = null));
      await hands.press();
      await tab.waitForFunction(() => globalThis.walkBegan !== null);
      const step = practice ? 1 : plan.step(world.name, world.options[option]);
      if (step === null) {
        await tab.waitForSelector("text=has arrived", { timeout: 60e3 });
        return hands.goOn();
      }
      await tab.evaluate((after) => new Promise((done) => {
        const wait = () => (performance.now() >= globalThis.walkBegan + after ? done() : setTimeout(wait, 1));
        wait();
      }), (step + 0.5) * STEP_MS - REACH_MS);
      await hands.press();
    },
    async "Carry along"(_, { world, practice }) {
      await isReady(tab);
      await hands.goOn();
      await tab.waitForTimeout(500);
      const way = world.walks[world.options.indexOf(plan.option(world.name))].frames;
      if (leads || practice) await hands.toggleLead();
      let isDown = false;
      for (;;) {
        const at = await tab.evaluate(ahead, [way, AHEAD]);
        if (!at) break;
        // who does not lead lets the hand be led
        if (leads || practice) {
          await (isDown ? hands.move(...at) : hands.down(...at));
          isDown = true;
        }
        await tab.waitForTimeout(MOVE_MS);
      }
      if (isDown) await hands.up();
      await isReady(tab, "Continue");
      await hands.goOn();
    },
  };
  for (;;) {
    await isShown(tab);
    const title = await heading(tab);
    if (title === "The end") break;
    const number = await pageNumber(tab), page = study.orders[place % study.orders.length][number - 1];
    await pages[title](tab, { ...page, world: study.worlds[page.world] });
    await offPage(tab, number);
  }
  const number = await tab.locator("#number").textContent();
  assert.deepEqual(faults(tab), []);
  await context.close();
  return number;
}

// The smallest number of `n` intervals of 95 % that cover, to be exceeded from below with probability 0.001 at most.
function leastCovering(n) {
  let probability = 0.05 ** n, sum = probability, k = 0;
  while (sum <= 0.001) {
    probability *= ((n - k) / (k + 1)) * (0.95 / 0.05);
    k += 1;
    sum += probability;
  }
  return k;
}

export async function run(program, count = 6, atOnce = 10, seed = 1) {
  const worlds = { "short.toml": world("Short"), "other.toml": world("Other", [0.7, 1.2], [-0.9, 0.3]) };
  const study = newStudy(program, worlds, (text) => text.replace("participants = 20 ", `participants = ${count} `));
  const browser = await launch();
  const { server, address } = await serve(study);
  try {
    study.cocarry("study", "simulate", "study.toml", "--participants", String(count), "--seed", String(seed), "--truth", "truth.csv");
    study.cocarry("study", "collect", "study.toml", "--simulated", "-o", "planned");
    const truths = study.table("truth.csv"), answers = study.table("planned/answers.csv"), switches = study.table("planned/switches.csv");
    const plan = ({ participant }) => {
      const own = (rows, world, option) => rows.find((row) => row.participant === participant && row.world === world && row.option === option);
      return {
        percent: (world, option) => own(answers, world, option).percent,
        option: (world) => (answers.find((row) => row.participant === participant && row.world === world && row.percent === "100") ?? { option: "1" }).option,
        step: (world, option) => ((step) => (step === "" ? null : Number(step)))(own(switches, world, option).step),
      };
    };
    const people = truths.map((truth, index) => ({ truth, plan: plan(truth), index, isPhone: index % 4 === 1, leads: index % 2 === 1 }));
    const began = Date.now(), waiting = [...people];
    await Promise.all(Array.from({ length: Math.min(atOnce, count) }, async () => {
      for (let person = waiting.shift(); person; person = waiting.shift()) {
        person.number = await takePart(browser, address, person);
        console.log(`  participant ${person.index + 1} is done after ${Math.round((Date.now() - began) / 1000)} s`);
      }
    }));
    compare(study, people, { answers, switches });
    console.log(`${count} simulated participants, ${people.filter(({ isPhone }) => isPhone).length} with a touch screen, in ${Math.round((Date.now() - began) / 1000)} s`);
  } finally {
    await browser.close();
    server.kill("SIGKILL");
    rmSync(study.folder, { recursive: true });
  }
}

// What came out, against what they should have answered and what they are.
function compare(study, people, planned) {
  assert.deepEqual(stored(study).integrity, [["ok"]]);
  study.cocarry("study", "collect", "study.toml", "-o", "answers");
  const rows = study.table("answers/participants.csv");
  assert.equal(rows.filter(({ finished_utc, flags }) => finished_utc && !flags.includes("left-out")).length, people.length);
  const numbers = new Map(people.map(({ truth, number }) => [truth.participant, number]));
  const key = ({ participant, world, option }) => `${participant} ${world} ${option}`;
  const got = (name) => new Map(study.table(`answers/${name}`).map((row) => [key(row), row]));
  const answers = got("answers.csv"), switches = got("switches.csv");
  for (const row of planned.answers) assert.equal(answers.get(key({ ...row, participant: numbers.get(row.participant) })).percent, row.percent);
  let exact = 0, far = 0;
  for (const row of planned.switches) {
    const { step } = switches.get(key({ ...row, participant: numbers.get(row.participant) }));
    assert.equal(step === "", row.step === "", `${key(row)}: ${row.step} became ${step}`);
    const off = Math.abs(Number(step) - Number(row.step));
    exact += off === 0;
    far = Math.max(far, off);
  }
  console.log(`answers: ${answers.size} of ${planned.answers.length} as planned; switches: ${exact} of ${switches.size} in the planned step, the others up to ${far} steps off`);
  assert.equal(switches.size, planned.switches.length);
  if (carries) {
    const carried = study.table("answers/carries.csv");
    const equal = carried.filter(({ differs_within_s }) => differs_within_s === "");
    const arrived = carried.filter(({ outcome }) => outcome === "arrived").length;
    const led = people.filter(({ leads }) => leads).flatMap(({ number, plan }) => carried.filter(({ participant }) => participant === number).map((row) => [row, plan.option(row.world)]));
    const along = led.filter(([{ options_walked }, option]) => options_walked === option).length;
    console.log(`carries: ${equal.length} of ${carried.length} replays equal, ${arrived} arrived; ${along} of ${led.length} led went through the openings of their way`);
    assert.equal(equal.length, carried.length);
    assert.equal(carried.length, 2 * people.length);
  }
  covered(study, people);
}

// Whether the intervals of `infer` cover the truths.
export function covered(study, people) {
  const { people: inferred } = JSON.parse(study.cocarry("infer", "answers/answers.csv", "answers/switches.csv", "--json"));
  const counts = { alpha: 0, gamma: 0, eta: 0 };
  for (const { truth, number } of people) {
    const person = inferred.find(({ participant }) => participant === number);
    for (const name of Object.keys(counts)) {
      const [low, high] = person[name].interval;
      // without an upper end it is null
      counts[name] += low <= Number(truth[name]) && Number(truth[name]) <= (high ?? Infinity);
    }
  }
  const least = leastCovering(people.length);
  console.log(`intervals of 95 % cover ${JSON.stringify(counts)} of ${people.length} truths; at least ${least} must`);
  for (const [name, count] of Object.entries(counts)) assert.ok(count >= least, `${name}: ${count}`);
}
