// For tests with participants of `cocarry study` in Chromium: a study with short walks, its server, what its database has, and
// somebody who goes through all pages with the keyboard.
import assert from "node:assert/strict";
import { execFileSync, spawn, spawnSync } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";

const AXE = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const screenshots = fileURLToPath(new URL("screenshots", import.meta.url));
mkdirSync(screenshots, { recursive: true });
// people carry where the simulator is built
const page = fileURLToPath(new URL("../dist/page", import.meta.url));
export const carries = existsSync(join(page, "cocarry.wasm"));
export const simulator = carries ? ["--page", page] : [];
if (!carries) console.log("skipped: people who carry; build the module of the page with: crates/web/build");

// Ends with a sentence where the program has no studies with people.
export function needPeople(program) {
  if (!spawnSync(program, ["study", "check", "none"]).stderr.toString().includes("feature `people`")) return;
  console.log("skipped: studies with people; build the program with --features people");
  process.exit(0);
}

// Short walks past a pillar, on two ways; the gaps beside it are so wide (m).
const box = (name, x, y, width, depth) => `[[obstacle]]\nname = "${name}"\nshape = "box"\ncenter_m = [${x}, ${y}]\nsize_m = [${width}, ${depth}]\nheight_m = 1.0\n`;
const wall = (name, from, to) => box(name, "2.0", ((from + to) / 2).toFixed(3), "0.2", (to - from).toFixed(3));
export const world = (name, [above, below] = [0.8, 1.0], [low, high] = [-0.5, 0.5]) => [
  `name = "${name}"\nrobot_width_m = 0.5\nstart_m = [0.0, 0.0]\ntarget_m = [4.0, 0.0]\n`,
  wall("upper", high + above, 2.6), wall("middle", low, high), wall("lower", -2.8, low - below),
  box("north", "2.0", "2.65", "8.0", "0.1"), box("south", "2.0", "-2.85", "8.0", "0.1"), box("west", "-2.0", "-0.1", "0.1", "5.6"), box("east", "6.0", "-0.1", "0.1", "5.6"),
].join("\n");

// A folder with a study in these worlds (names and texts), and what is done with it. `edit` changes the text of its file.
export function newStudy(program, worlds, edit = (text) => text) {
  const folder = mkdtempSync(join(tmpdir(), "people-"));
  const cocarry = (...words) => execFileSync(program, words, { cwd: folder, encoding: "utf8", maxBuffer: 1 << 28 });
  cocarry("study", "new", ".");
  for (const [name, text] of Object.entries(worlds)) writeFileSync(join(folder, name), text);
  const names = Object.keys(worlds), file = join(folder, "study.toml");
  writeFileSync(file, edit(readFileSync(file, "utf8")
    .replace('worlds = ["environment-1", "environment-4"]', `worlds = ${JSON.stringify(names)}`)
    .replace('world = "free-form"', `world = "${names[0]}"`)
    .replace('tasks = ["percentages", "switch"]', `tasks = ["percentages", "switch"${carries ? ', "carry"' : ""}]`)
    .replace("\n[end]", `\n${carries ? '[carry]\nmethods = ["mutual"]\ntext = "Carry along."\n\n' : ""}[end]`)));
  const table = (name) => {
    const [header, ...rows] = readFileSync(join(folder, name), "utf8").trim().split("\n").map((line) => line.split(","));
    return rows.map((row) => Object.fromEntries(header.map((column, i) => [column, row[i]])));
  };
  return { program, folder, cocarry, table };
}

// The server of a study; `port` is that of an earlier one, or 0.
export async function serve({ program, folder }, port = 0) {
  const server = spawn(program, ["study", "serve", "study.toml", "--port", String(port), ...simulator], { cwd: folder, stdio: ["ignore", "pipe", "inherit"] });
  for await (const line of createInterface({ input: server.stdout })) {
    const address = /^the study is at (http:\/\/127\.0\.0\.1:(\d+)\/)$/.exec(line);
    if (address) return { server, address: address[1], port: Number(address[2]) };
  }
  throw new Error("the server did not start");
}
export const killed = (server) => new Promise((done) => {
  server.once("exit", done);
  server.kill("SIGKILL");
});

// What the database has, read by a program of others.
export const stored = ({ folder }, database = "study.sqlite") => JSON.parse(execFileSync("python3", ["-c", `
import json, sqlite3, sys
base = sqlite3.connect(sys.argv[1])
print(json.dumps({
    "integrity": base.execute("PRAGMA integrity_check").fetchall(),
    "sessions": base.execute("SELECT participant, finished IS NOT NULL FROM sessions ORDER BY place").fetchall(),
    "chunks": base.execute("SELECT trial, number, sha256 FROM chunks ORDER BY participant, trial, number").fetchall(),
}))`, database], { cwd: folder, encoding: "utf8", maxBuffer: 1 << 28 }));

// The chunks that a server acknowledged to browsers. Whatever was acknowledged is in a sound database, once.
export class Acknowledged {
  #chunks = new Set();

  // Takes an answer of the server to a request.
  note(url, headers, isGood) {
    const chunk = /\/api\/chunks\/(\d+)\/(\d+)$/.exec(url);
    if (chunk && isGood) this.#chunks.add([chunk[1], chunk[2], headers["x-sha256"]].join(" "));
  }

  check(study) {
    const { integrity, chunks } = stored(study);
    assert.deepEqual(integrity, [["ok"]]);
    const known = new Set(chunks.map((chunk) => chunk.join(" ")));
    assert.deepEqual([...this.#chunks].filter((chunk) => !known.has(chunk)), []);
    return { acknowledged: this.#chunks.size, stored: chunks.length };
  }
}

const faultsOf = new WeakMap();
export const faults = (tab) => faultsOf.get(tab);
// Opens the study at an address; what goes wrong in the tab, or asks others, is noted.
export async function opened(context, address, query = "") {
  const tab = await context.newPage();
  const found = [];
  faultsOf.set(tab, found);
  tab.on("pageerror", (error) => found.push(error.stack));
  tab.on("request", (request) => {
    if (!request.url().startsWith(address) && !/^(data|blob):/.test(request.url())) found.push(`asked ${request.url()}`);
  });
  await tab.goto(address + query);
  await tab.waitForSelector("h1");
  return tab;
}
export const heading = (tab) => tab.locator("h1").textContent();
export const progress = (tab) => tab.locator("#progress").textContent();
export const pageNumber = async (tab) => Number(/^Page (\d+) /.exec(await progress(tab))?.[1]);
export const onPage = (tab, number) => tab.waitForFunction((number) => document.getElementById("progress").textContent.startsWith(`Page ${number} `), number, { timeout: 60e3 });
export const offPage = (tab, number) => tab.waitForFunction((number) => !document.getElementById("progress").textContent.startsWith(`Page ${number} `), number, { timeout: 60e3 });
export const isShown = (tab) => tab.waitForFunction(() => document.querySelector("h1") && document.querySelector("h1").textContent !== "One moment", null, { timeout: 60e3 });
export const isReady = (tab, text = "Start") => tab.waitForFunction((text) => document.activeElement?.textContent === text, text, { timeout: 240e3 });

// Somebody goes to another tab, perhaps with the code, and comes back: longer than the page takes to send what it noted.
export const leftAndBack = (tab) => tab.evaluate(async () => {
  for (const hidden of [true, false]) {
    Object.defineProperty(document, "hidden", { value: hidden, configurable: true });
    document.dispatchEvent(new Event("visibilitychange", { bubbles: true }));
    await new Promise((done) => setTimeout(done, 1500));
  }
});

export async function looked(tab, name) {
  await tab.evaluate(AXE);
  const { violations } = await tab.evaluate(() => globalThis.axe.run(document, { resultTypes: ["violations"] }));
  assert.deepEqual(violations.map(({ id, nodes }) => `${id}: ${nodes[0].html}`), [], `${name}: axe-core`);
  // nothing is wider than the page
  assert.ok(await tab.evaluate(() => document.documentElement.scrollWidth <= innerWidth), `${name}: too wide`);
  await tab.screenshot({ path: join(screenshots, `people-${name}.png`), fullPage: true });
}

// The pages in their order, each done with the keyboard.
export const PAGES = {
  async "Before you begin"(tab) {
    await tab.locator("input[type=checkbox]").focus();
    await tab.keyboard.press("Space");
    await tab.keyboard.press("Enter");
  },
  async "Which way would you go?"(tab) {
    await tab.keyboard.press("Enter");
  },
  async "The robot leads"(tab) {
    await tab.keyboard.press("Enter");
  },
  async "How likely would you go each way?"(tab, { shares = ["30", "70"] }) {
    const count = await tab.locator(".shares input").count();
    await tab.locator(".shares input").first().focus();
    assert.equal(count, shares.length);
    for (const share of shares) {
      await tab.keyboard.press("Control+A");
      await tab.keyboard.type(share);
      await tab.keyboard.press("Enter");
    }
  },
  async "A question"(tab) {
    const asked = await tab.locator("legend").textContent();
    await tab.locator("input[type=radio]").first().focus();
    for (let i = 0; i < (asked.includes("add up") ? 1 : 2); i++) await tab.keyboard.press("ArrowDown");
    await tab.keyboard.press("Enter");
  },
  // the first walk that counts is stopped, the other one goes to its end
  async "When would you stop following the robot?"(tab, { walks }) {
    await isReady(tab);
    await tab.keyboard.press("Space");
    walks.count += 1;
    if (walks.count < 3) {
      await tab.waitForTimeout(3100);
      await tab.keyboard.press("Space");
    } else {
      await tab.waitForSelector("text=has arrived", { timeout: 30e3 });
      await tab.keyboard.press("Enter");
    }
  },
  async "You carry along"(tab) {
    await tab.keyboard.press("Enter");
  },
  async "Carry along"(tab) {
    await isReady(tab);
    await tab.keyboard.press("Enter");
    await tab.waitForTimeout(1500);
    // takes the lead, goes to the right for a while, and gives it back
    await tab.keyboard.press("t");
    await tab.keyboard.down("ArrowRight");
    await tab.waitForTimeout(1500);
    await tab.keyboard.up("ArrowRight");
    await tab.keyboard.press("t");
    await isReady(tab, "Continue");
    await tab.keyboard.press("Enter");
  },
  async "How was it?"(tab) {
    for (const slider of await tab.locator("input[type=range]").all()) {
      await slider.focus();
      await tab.keyboard.press("ArrowRight");
    }
    await tab.locator("button").focus();
    await tab.keyboard.press("Enter");
  },
  async "How much do you agree?"(tab) {
    for (const scale of await tab.locator("fieldset").all()) {
      await scale.locator("input").nth(4).focus();
      await tab.keyboard.press("Space");
    }
    await tab.keyboard.press("Enter");
  },
};

// Goes from where the tab is to the end. `before(number)` is called on every page, and may return another tab.
export async function goThrough(tab, before = async () => tab, pages = PAGES) {
  const walks = { count: 0 };
  for (;;) {
    await isShown(tab);
    const title = await heading(tab);
    if (title === "The end") return tab;
    const number = await pageNumber(tab);
    tab = await before(number, title);
    // done already
    if ((await progress(tab)) !== "" && (await pageNumber(tab)) !== number) continue;
    assert.ok(pages[title], title);
    await pages[title](tab, { walks });
    await offPage(tab, number);
  }
}
