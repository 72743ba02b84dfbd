// Plays recordings in Chromium: node test/player.mjs PROGRAM. Checks that a page draws at once, plays, seeks, shows the
// recording's figures and asks the network for nothing; writes screenshots of every camera, scheme and size.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { loadavg, tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { chromium } from "playwright-core";
import { unpacked } from "../src/packed.js";

const program = process.argv[2];
const repository = fileURLToPath(new URL("../..", import.meta.url));
const screenshots = fileURLToPath(new URL("screenshots", import.meta.url));
const folder = mkdtempSync(join(tmpdir(), "player-"));
const cocarry = (...words) => execFileSync(program, words, { cwd: repository, encoding: "utf8", maxBuffer: 1 << 28 });
mkdirSync(screenshots, { recursive: true });

// A table of a recording: a record for every row.
function table(recording, channel) {
  const cells = (row) => [...row.matchAll(/("((?:[^"]|"")*)"|[^,]*)(,|$)/g)].map(([, cell, quoted]) => quoted?.replaceAll('""', '"') ?? cell);
  const [head, ...rows] = cocarry("inspect", recording, "--csv", channel).trim().split("\n").map(cells);
  return rows.map((row) => Object.fromEntries(head.map((key, i) => [key, row[i]])));
}

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});

async function open(page, hash, { width = 1280, height = 800, scheme = "light" } = {}) {
  const tab = await browser.newPage({ viewport: { width, height }, colorScheme: scheme });
  const faults = [], asked = [];
  tab.on("pageerror", (error) => faults.push(error.stack));
  tab.on("console", (message) => ["error"].includes(message.type()) && faults.push(message.text()));
  tab.on("request", (request) => asked.push(request.url()));
  await tab.goto(`${pathToFileURL(page)}#${hash}`);
  await tab.waitForFunction(() => document.body.dataset.drawn);
  assert.deepEqual(asked.filter((url) => !url.startsWith("file:") && !url.startsWith("data:")), [], "network requests");
  return { tab, faults, drawn: Number(await tab.evaluate(() => document.body.dataset.drawn)) };
}

const shown = (tab, key) => tab.locator(`output[data-figure="${key}"]`).textContent();
const clock = async (tab) => Number.parseFloat(await tab.locator("#clock").textContent());

// The figures on the page at a time are those of the step in the recording.
async function figures(tab, recording, time) {
  await tab.locator("#time").evaluate((input, value) => {
    input.value = value;
    input.dispatchEvent(new Event("input"));
  }, time);
  const tables = ["/coordination", "/options"].map((channel) => table(recording, channel));
  const step = Math.max(...tables[0].map((row, i) => (Number(row.time_s) <= time + 1e-9 ? i : 0)));
  assert.equal(await shown(tab, "stubbornness"), Number(tables[0][step].stubbornness).toFixed(3));
  for (const key of Object.keys(tables[1][step]).filter((key) => key.endsWith(".probability"))) {
    const name = /\[(.*)\]/.exec(key)[1], recorded = tables[1][step][key];
    const expected = recorded === "" ? "–" : Number(recorded).toFixed(3);
    assert.equal(await shown(tab, `probability[${name}]`), expected, key);
  }
  if (await tab.locator('output[data-figure="hand_force_n"]').count()) {
    const forces = table(recording, "/interaction")[step];
    for (const key of ["grip_force_n", "hand_force_n"]) assert.equal(await shown(tab, key), Number(forces[key]).toFixed(1), key);
  }
  const leader = tables[0][step].mode === "human-led" ? "Human leads" : "Robot leads";
  assert.match(await tab.locator("#leader").textContent(), new RegExp(leader));
}

// Labels that are shown lie apart.
async function labels(tab, name) {
  const shown = await tab.evaluate(() => [...document.querySelectorAll("#labels > div")]
    .filter((e) => e.style.visibility !== "hidden").map((e) => {
      const { left, top, right, bottom } = e.getBoundingClientRect();
      return { words: e.textContent, left, top, right, bottom };
    }));
  const cover = (a, b) => a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 1 && b.top < a.bottom - 1;
  shown.forEach((a, i) => shown.slice(0, i).forEach((b) => assert.ok(!cover(a, b), `${name}: ${a.words} covers ${b.words}`)));
  return shown.length;
}

// The panel of what the robot has learned has the recording's figures; its region falls over the episode.
async function learned(recording, human) {
  const page = join(folder, "learned.html");
  cocarry("render", recording, "-o", page);
  const { tab, faults } = await open(page, "play=0");
  assert.match(await tab.locator("#learned").textContent(), /α, perception of distance.*γ, perception of risk/);
  const rows = table(recording, "/learned");
  const changes = rows.filter((row, i) => i === 0 || row["human.region_share"] !== rows[i - 1]["human.region_share"]);
  assert.ok(changes.length > 3, "the belief changes");
  const areas = [];
  for (const row of changes) {
    await tab.locator("#time").evaluate((input, value) => {
      input.value = value;
      input.dispatchEvent(new Event("input"));
    }, row.time_s);
    const number = (key) => Number(row[`human.${key}`]);
    const share = number("region_share");
    assert.equal(await shown(tab, "learned.region_share"), `${(100 * share).toFixed(1)} % of the prior`);
    assert.equal(await shown(tab, "learned.information_nats"), `${number("information_nats").toFixed(2)} nats`);
    for (const key of ["alpha", "gamma"]) {
      const ends = [0, 1].map((k) => number(`${key}_interval[${k}]`).toFixed(2)).join(" to ");
      assert.equal(await shown(tab, `learned.${key}`), `${number(`${key}_mean`).toFixed(3)} (${ends})`);
    }
    assert.ok((await shown(tab, "learned.eta")).startsWith(number("eta_mean").toFixed(1)));
    // the middles of cells that the border encloses have an odd number of upright edges on their left
    const { enclosed, marks } = await tab.evaluate(() => {
      const find = (selector) => document.querySelector(`#learned ${selector}`);
      const uprights = [...find(".border").getAttribute("d").matchAll(/M([\d.]+) ([\d.]+)V([\d.]+)/g)]
        .map(([, x, from, to]) => [x, from, to].map(Number));
      const [left, top, width, height] = ["x", "y", "width", "height"].map((name) => Number(find(".frame").getAttribute(name)));
      const enclosed = Array.from({ length: 1024 }, (_, cell) => {
        const x = left + ((Math.floor(cell / 32) + 0.5) * width) / 32, y = top + ((31.5 - (cell % 32)) * height) / 32;
        return uprights.filter(([at, a, b]) => at < x && Math.min(a, b) < y && y < Math.max(a, b)).length % 2 === 1;
      });
      // as parts of the ranges
      const marks = [".mean", ".human"].map((mark) => {
        const [x, y] = find(mark).getAttribute("transform").match(/-?[\d.]+/g).map(Number);
        return [(x - left) / width, (top + height - y) / height];
      });
      return { enclosed, marks };
    });
    const level = number("region_density") * (1 - 1e-9);
    assert.deepEqual(enclosed, enclosed.map((_, cell) => number(`density[${cell}]`) >= level), "the cells within the border");
    const area = enclosed.filter(Boolean).length / 1024;
    // cells lie on a border with their whole area
    assert.ok(Math.abs(area - share) < 0.02, `the border encloses ${area}, recorded ${share}`);
    ["alpha", "gamma"].forEach((key, axis) => {
      const [low, high] = [0, 1].map((k) => number(`${key}_range[${k}]`));
      const near = (part, value) => assert.ok(Math.abs(low + part * (high - low) - value) < 1e-6, `${key}: ${part}, not ${value}`);
      near(marks[0][axis], number(`${key}_mean`));
      near(marks[1][axis], human[key]);
    });
    areas.push(area);
  }
  assert.equal(areas[0], 1, "the prior");
  assert.ok(areas.every((area, i) => i === 0 || area <= areas[i - 1]) && areas[areas.length - 1] < 0.5, `areas ${areas}`);
  assert.deepEqual(faults, []);
  await tab.close();
  for (const [name, options] of [["learned", {}], ["learned-dark", { scheme: "dark" }], ["learned-phone", { width: 390, height: 844 }]]) {
    const { tab } = await open(page, `play=0&t=${changes[changes.length - 1].time_s}`, options);
    assert.ok(await tab.evaluate(() => document.documentElement.scrollWidth <= innerWidth), `${name}: nothing is wider than the screen`);
    await tab.locator("#learned").scrollIntoViewIfNeeded();
    await tab.screenshot({ path: join(screenshots, `${name}.png`) });
    await tab.locator("#learned").screenshot({ path: join(screenshots, `${name}-panel.png`) });
    await tab.close();
  }
  console.log(`learned: the region falls from 1 to ${areas[areas.length - 1].toFixed(3)} of the prior`);
}

async function check(name, recording) {
  const page = join(folder, `${name}.html`);
  cocarry("render", recording, "-o", page);
  const { tab, faults, drawn } = await open(page, "play=0");
  assert.ok(await labels(tab, name) > 2, `${name}: labels`);
  assert.equal(await tab.locator("#learned").count(), 0, `${name}: no panel without /learned`);
  const events = table(recording, "/log");
  const transition = events.find((event) => event.name === "mode");
  assert.ok(transition, `${name}: the human takes the lead`);
  const end = Number(events[events.length - 1].time_s);
  for (const time of [0, Number(transition.time_s), 0.8 * end]) await figures(tab, recording, time);

  // the link to take over holds the scenario, the step that is shown, and where the object is then
  const link = tab.locator("#takeover a"), step = Math.floor(0.8 * end / 0.2 + 1e-6);
  const { href, scenario, object } = await tab.evaluate((step) => {
    const { take_over: { scenario }, frames } = JSON.parse(document.getElementById("episode").textContent);
    return { href: document.querySelector("#takeover a").href, scenario, object: frames.object.slice(7 * step, 7 * step + 3) };
  }, step);
  assert.equal(await link.textContent(), `Take over from ${(0.2 * step).toFixed(1)} s`);
  assert.ok(href.startsWith("http://127.0.0.1:8790/#"), href);
  const asked = new URLSearchParams(href.split("#")[1]);
  assert.equal(await unpacked(asked.get("scenario")), scenario);
  assert.deepEqual([asked.get("carry"), Number(asked.get("t")), asked.get("object").split(",").map(Number)], ["1", Number((0.2 * step).toFixed(6)), object]);
  assert.ok(href.length < 1 << 18, `${href.length} characters`);

  // the transition has its sentence, and the list of events leads to it
  await tab.locator("#events button", { hasText: "arrived" }).first().click();
  assert.match(await tab.locator("#caption").textContent(), /arrived at B/);
  await tab.locator("#events button", { hasText: "takes the lead" }).click();
  assert.equal(await clock(tab), Number(transition.time_s));
  assert.match(await tab.locator("#caption").textContent(), /the human takes the lead/);

  // keys: one step, one event, the ends, speed, cameras, play and pause
  await tab.keyboard.press("Home");
  await tab.keyboard.press("ArrowRight");
  assert.equal(await clock(tab), 0.2);
  await tab.keyboard.press("ArrowLeft");
  assert.equal(await clock(tab), 0);
  await tab.keyboard.press("n");
  assert.equal(await clock(tab), Number(events.find((event) => Number(event.time_s) > 0).time_s));
  await tab.keyboard.press("End");
  assert.ok(Math.abs((await clock(tab)) - end) < 0.051);
  await tab.keyboard.press("ArrowUp");
  assert.equal(await tab.locator("#speed").inputValue(), "2");
  await tab.keyboard.press("2");
  assert.equal(await tab.locator('[data-camera="follow"]').getAttribute("aria-pressed"), "true");
  await tab.keyboard.press("Home");
  await tab.keyboard.press(" ");
  await tab.waitForFunction(() => Number.parseFloat(document.getElementById("clock").textContent) > 0.5);
  await tab.keyboard.press(" ");
  const stopped = await clock(tab);
  await tab.waitForTimeout(300);
  assert.equal(await clock(tab), stopped, "paused");

  // every control has a name
  const nameless = await tab.evaluate(() => [...document.querySelectorAll("button, input, select, canvas, svg[role=img]")]
    .filter((e) => !e.getAttribute("aria-label") && !e.textContent.trim()).map((e) => e.outerHTML));
  assert.deepEqual(nameless, []);
  assert.deepEqual(faults, []);
  await tab.close();
  console.log(`${name}: first picture after ${drawn} ms, figures at 3 times as recorded`);
  return { page, transition: Number(transition.time_s), drawn };
}

try {
  const made = ["point", "kinematic"].map((plant) => {
    const recording = join(folder, `${plant}.mcap`);
    cocarry("run", "environment-4", "--seed", "2", "--plant", plant, "--record", recording);
    return [plant, recording];
  });
  const shipped = [1, 2, 3, 4].map((n) => [`environment-${n}`, join(repository, `recordings/environment-${n}.mcap`)]);
  const checked = {};
  for (const [name, recording] of [...shipped, ...made]) checked[name] = await check(name, recording);

  const learns = join(folder, "learns.mcap");
  cocarry("run", "environment-4", "--alpha", "0.63", "--gamma", "0.929", "--plant", "point", "--method", "human-led", "--belief", "learn", "--record", learns);
  await learned(learns, { alpha: 0.63, gamma: 0.929 });

  const { page, transition } = checked["environment-4"];
  const phone = { width: 390, height: 844 };
  for (const [name, camera, size] of [
    ["overview", "overview", {}], ["follow", "follow", {}], ["shoulder", "shoulder", {}],
    ["overview-dark", "overview", { scheme: "dark" }], ["follow-dark", "follow", { scheme: "dark" }],
    ["phone", "follow", phone], ["phone-overview", "overview", phone], ["phone-dark", "shoulder", { ...phone, scheme: "dark" }],
    ...[768, 800, 844].map((width) => [`tablet-${width}`, "follow", { width, height: 1024 }]),
  ]) {
    const { tab, faults } = await open(page, `play=0&t=${transition + 1.6}&camera=${camera}`, size);
    const wide = await tab.evaluate(() => document.documentElement.scrollWidth <= innerWidth);
    assert.ok(wide, `${name}: nothing is wider than the screen`);
    await tab.waitForTimeout(600);
    await labels(tab, name);
    const covered = await tab.evaluate(() => [...document.querySelectorAll("#cameras button")].filter((button) => {
      const { left, right, top, bottom } = button.getBoundingClientRect();
      return [left + 3, (left + right) / 2, right - 3].some((x) => document.elementFromPoint(x, (top + bottom) / 2) !== button);
    }).map((button) => button.textContent));
    assert.deepEqual(covered, [], `${name}: buttons that something covers`);
    await tab.screenshot({ path: join(screenshots, `${name}.png`) });
    assert.deepEqual(faults, []);
    await tab.close();
  }
  const times = Object.values(checked).map(({ drawn }) => drawn);
  console.log(`first pictures: ${times.join(", ")} ms, at a load of ${loadavg()[0].toFixed(1)}; screenshots in ${screenshots}`);
} finally {
  await browser.close();
  rmSync(folder, { recursive: true });
}
