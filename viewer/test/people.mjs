// Participants of `cocarry study` in Chromium: node test/people.mjs PROGRAM. One goes through everything with the keyboard
// alone, while requests are doubled, lose their answers and fail, the page is reloaded and closed, and the server is killed.
// Nothing that the server acknowledged is lost, nothing is counted twice, and every page keeps the rules of axe-core.
import assert from "node:assert/strict";
import { execFileSync, spawn, spawnSync } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";
import { launch, serve as serveFolder } from "./serving.mjs";

const program = process.argv[2];
if (spawnSync(program, ["study", "check", "none"]).stderr.toString().includes("feature `people`")) {
  console.log("skipped: studies with people; build the program with --features people");
  process.exit(0);
}
const AXE = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const screenshots = fileURLToPath(new URL("screenshots", import.meta.url));
const folder = mkdtempSync(join(tmpdir(), "people-"));
mkdirSync(screenshots, { recursive: true });
const cocarry = (...words) => execFileSync(program, words, { cwd: folder, encoding: "utf8" });

// A short walk past a pillar, on two ways of about 5 m.
const box = (name, x, y, width, depth) => `[[obstacle]]\nname = "${name}"\nshape = "box"\ncenter_m = [${x}, ${y}]\nsize_m = [${width}, ${depth}]\nheight_m = 1.0\n`;
writeFileSync(join(folder, "short.toml"), [
  'name = "Short"\nrobot_width_m = 0.5\nstart_m = [0.0, 0.0]\ntarget_m = [4.0, 0.0]\n',
  box("upper", "2.0", "1.95", "0.2", "1.3"), box("middle", "2.0", "0.0", "0.2", "1.0"), box("lower", "2.0", "-2.15", "0.2", "1.3"),
  box("north", "2.0", "2.65", "8.0", "0.1"), box("south", "2.0", "-2.85", "8.0", "0.1"), box("west", "-2.0", "-0.1", "0.1", "5.6"), box("east", "6.0", "-0.1", "0.1", "5.6"),
].join("\n"));
cocarry("study", "new", ".");
// people carry where the simulator is built
const page = fileURLToPath(new URL("../dist/page", import.meta.url));
const carries = existsSync(join(page, "cocarry.wasm"));
if (!carries) console.log("skipped: people who carry; build the module of the page with: crates/web/build");
const simulator = carries ? ["--page", page] : [];
const template = readFileSync(join(folder, "study.toml"), "utf8");
writeFileSync(join(folder, "study.toml"), template
  .replace('worlds = ["environment-1", "environment-4"]', 'worlds = ["short.toml"]')
  .replace('world = "free-form"', 'world = "short.toml"')
  .replace('tasks = ["percentages", "switch"]', `tasks = ["percentages", "switch"${carries ? ', "carry"' : ""}]`)
  .replace("[end]", `${carries ? '[carry]\nmethods = ["mutual"]\ntext = "Carry along."\n\n' : ""}[end]`));

// The server; `port` is that of an earlier one, or 0.
async function serve(port = 0) {
  const server = spawn(program, ["study", "serve", "study.toml", "--port", String(port), ...simulator], { cwd: folder, stdio: ["ignore", "pipe", "inherit"] });
  for await (const line of createInterface({ input: server.stdout })) {
    const address = /^the study is at (http:\/\/127\.0\.0\.1:(\d+)\/)$/.exec(line);
    if (address) return { server, address: address[1], port: Number(address[2]) };
  }
  throw new Error("the server did not start");
}
const killed = (server) => new Promise((done) => {
  server.once("exit", done);
  server.kill("SIGKILL");
});

// What the database has, read by a program of others.
const stored = () => JSON.parse(execFileSync("python3", ["-c", `
import json, sqlite3
base = sqlite3.connect("study.sqlite")
print(json.dumps({
    "integrity": base.execute("PRAGMA integrity_check").fetchall(),
    "sessions": base.execute("SELECT participant, finished IS NOT NULL FROM sessions ORDER BY place").fetchall(),
    "chunks": base.execute("SELECT trial, number, sha256 FROM chunks ORDER BY participant, trial, number").fetchall(),
}))`], { cwd: folder, encoding: "utf8" }));

const browser = await launch();
let { server, address, port } = await serve();
// chunks that the server acknowledged, by session
const acknowledged = new Map();
const counts = { doubled: 0, unanswered: 0, failed: 0 };

// A participant's browser, in which requests suffer: `faults` says how many in ten of each kind do.
async function participant({ width, height, faults = 0 }) {
  const context = await browser.newContext({ viewport: { width, height } });
  let n = 0;
  await context.route("**/api/**", async (route) => {
    const request = route.request(), headers = request.headers();
    const body = request.postData() ?? undefined;
    const send = () => fetch(request.url(), { method: request.method(), headers: { ...headers, origin: address.slice(0, -1) }, body });
    n += 1;
    try {
      if (n % 10 < faults) {
        counts.doubled += 1;
        await send();
      } else if (n % 10 < 2 * faults) {
        counts.unanswered += 1;
        await send();
        return await route.abort("connectionreset");
      } else if (n % 10 < 3 * faults) {
        counts.failed += 1;
        return await route.abort("connectionrefused");
      }
      const answer = await send();
      const chunk = /\/api\/chunks\/(\d+)\/(\d+)$/.exec(request.url());
      if (chunk && answer.ok) {
        const key = headers["x-session-key"];
        acknowledged.set(key, [...(acknowledged.get(key) ?? []), [Number(chunk[1]), Number(chunk[2]), headers["x-sha256"]]]);
      }
      await route.fulfill({ status: answer.status, contentType: "application/json", body: await answer.text() });
    } catch {
      await route.abort("connectionrefused").catch(() => {});
    }
  });
  return context;
}

const faultsOf = new WeakMap();
async function opened(context, query = "", from = address) {
  const tab = await context.newPage();
  const faults = [];
  faultsOf.set(tab, faults);
  tab.on("pageerror", (error) => faults.push(error.stack));
  tab.on("request", (request) => {
    if (!request.url().startsWith(from) && !/^(data|blob):/.test(request.url())) faults.push(`asked ${request.url()}`);
  });
  await tab.goto(from + query);
  await tab.waitForSelector("h1");
  return tab;
}
const heading = (tab) => tab.locator("h1").textContent();
const progress = (tab) => tab.locator("#progress").textContent();
const onPage = (tab, number) => tab.waitForFunction((number) => document.getElementById("progress").textContent.startsWith(`Page ${number} `), number, { timeout: 30e3 });

async function looked(tab, name) {
  await tab.evaluate(AXE);
  const { violations } = await tab.evaluate(() => globalThis.axe.run(document, { resultTypes: ["violations"] }));
  assert.deepEqual(violations.map(({ id, nodes }) => `${id}: ${nodes[0].html}`), [], `${name}: axe-core`);
  // nothing is wider than the page
  assert.ok(await tab.evaluate(() => document.documentElement.scrollWidth <= innerWidth), `${name}: too wide`);
  await tab.screenshot({ path: join(screenshots, `people-${name}.png`) });
}

// The pages in their order, each done with the keyboard.
const PAGES = {
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
  async "How likely would you go each way?"(tab) {
    const count = await tab.locator(".shares input").count();
    await tab.locator(".shares input").first().focus();
    const shares = ["30", "70"];
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
    await tab.waitForFunction(() => document.activeElement?.textContent === "Start");
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
    await tab.waitForFunction(() => document.activeElement?.textContent === "Start");
    await tab.keyboard.press("Enter");
    await tab.waitForTimeout(1500);
    // takes the lead, goes to the right for a while, and gives it back
    await tab.keyboard.press("t");
    await tab.keyboard.down("ArrowRight");
    await tab.waitForTimeout(1500);
    await tab.keyboard.up("ArrowRight");
    await tab.keyboard.press("t");
    await tab.waitForFunction(() => document.activeElement?.textContent === "Continue", null, { timeout: 180e3 });
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
async function goThrough(tab, before = async () => tab) {
  const walks = { count: 0 };
  for (;;) {
    await tab.waitForFunction(() => document.querySelector("h1") && document.querySelector("h1").textContent !== "One moment", null, { timeout: 60e3 });
    const title = await heading(tab);
    if (title === "The end") return tab;
    const number = Number(/^Page (\d+) /.exec(await progress(tab))[1]);
    tab = await before(number, title);
    // done already
    if ((await progress(tab)) !== "" && !(await progress(tab)).startsWith(`Page ${number} `)) continue;
    assert.ok(PAGES[title], title);
    await PAGES[title](tab, { walks });
    await tab.waitForFunction((number) => !document.getElementById("progress").textContent.startsWith(`Page ${number} `), number, { timeout: 30e3 });
  }
}

// Whatever was acknowledged is in a sound database, once.
function nothingIsLost() {
  const { integrity, chunks } = stored();
  assert.deepEqual(integrity, [["ok"]]);
  const known = new Set(chunks.map((chunk) => chunk.join(" ")));
  const all = [...acknowledged.values()].flat().map((chunk) => chunk.join(" "));
  assert.deepEqual(all.filter((chunk) => !known.has(chunk)), []);
  return { acknowledged: new Set(all).size, stored: chunks.length };
}

// One participant, wide screen, every fault.
async function one() {
  const context = await participant({ width: 1024, height: 760, faults: 1 });
  let tab = await opened(context);
  const seen = new Set();
  tab = await goThrough(tab, async (number, title) => {
    if (!seen.has(title)) {
      seen.add(title);
      await looked(tab, `${seen.size}-wide`);
    }
    if (title.startsWith("How likely") && number === 5) {
      // a half answer, and the page is loaded anew
      await tab.locator(".shares input").first().fill("12");
      await tab.waitForTimeout(1300);
      await tab.reload();
      await onPage(tab, number);
      assert.equal(await tab.locator(".shares input").first().inputValue(), "");
      const other = await opened(context);
      assert.match(await other.locator("#stopped").textContent(), /open in another tab/);
      await other.close();
    }
    if (title === "The robot leads") {
      // the tab breaks down, and another one is opened
      await tab.close();
      tab = await opened(context);
      await onPage(tab, number);
    }
    if (title === "How was it?") {
      // the server is killed; the participant goes on, and is told
      await killed(server);
      await PAGES[title](tab, {});
      await tab.waitForFunction(() => document.getElementById("status").textContent.includes("connection is interrupted"), null, { timeout: 30e3 });
      await onPage(tab, number + 1);
      nothingIsLost();
      ({ server } = await serve(port));
    }
    return tab;
  });
  await tab.waitForSelector("#code", { timeout: 60e3 });
  await looked(tab, "end-wide");
  const [code, number] = [await tab.locator("#code").textContent(), await tab.locator("#number").textContent()];
  assert.match(code, /^[0-9A-F]{8}$/);
  await tab.reload();
  assert.equal(await tab.locator("#code").textContent(), code);
  assert.deepEqual(faultsOf.get(tab), []);
  await context.close();
  const { sessions } = stored();
  assert.deepEqual(sessions, [[number, 1]]);
  const { acknowledged, stored: chunks } = nothingIsLost();
  console.log(`one participant by keyboard: ${seen.size} kinds of pages, ${acknowledged} chunks acknowledged of ${chunks} stored; requests: ${JSON.stringify(counts)}`);
  return number;
}

// What was answered is in the tables, and the fits read them.
function collected(number) {
  assert.match(cocarry("study", "check", "study.toml"), /sound; 1 began, 1 finished/);
  cocarry("study", "collect", "study.toml", "-o", "answers");
  const table = (name) => readFileSync(join(folder, "answers", name), "utf8").trim().split("\n").map((line) => line.split(","));
  const answers = table("answers.csv").slice(1).map((row) => row.slice(0, 4).join(","));
  assert.deepEqual(answers, [`${number},worlds/short.toml,1,30`, `${number},worlds/short.toml,2,70`]);
  const switches = table("switches.csv").slice(1);
  assert.equal(switches.length, 2);
  const [stopped, followed] = ["3", ""].map((_, i) => switches[i]);
  const ms = Number(stopped[4]);
  assert.equal(Number(stopped[3]), Math.floor(ms / 200));
  // the key came 3.1 s after the start, by the clock of this program
  assert.ok(ms > 2900 && ms < 4500, `${ms} ms`);
  assert.ok(Number(stopped[5]) > 10, `${stopped[5]} pictures`);
  assert.deepEqual(followed.slice(3, 6), ["", "", ""]);
  if (carries) {
    const [header, row, ...others] = table("carries.csv");
    assert.equal(others.length, 0);
    const carried = Object.fromEntries(header.map((name, i) => [name, row[i]]));
    assert.equal(carried.differs_within_s, "", "run again, it is another episode");
    assert.ok(Number(carried.human_led_from_s) > 0.5, JSON.stringify(carried));
    assert.match(cocarry("replay", `answers/${carried.recording}`), /identical/);
    console.log(`carried: ${carried.outcome} after ${carried.duration_s} s, led from ${carried.human_led_from_s} s; the log gives the same episode, digest by digest`);
  }
  assert.equal(table("responses.csv").length, 1 + 2 + 6 + 2);
  const flags = table("participants.csv")[1].at(-1);
  assert.ok(!flags.includes("left-out"), flags);
  cocarry("fit", "risk-weight", "answers/answers.csv", "--resamples", "40");
  cocarry("fit", "eta", "answers/switches.csv");
  cocarry("infer", "answers/answers.csv", "answers/switches.csv", "--draws", "100");
  console.log(`collected: a switch after ${ms} ms is step ${stopped[3]}; fit and infer read the tables; flags: ${flags || "none"}`);
}

// A narrow screen; killed tabs and servers at any time; then the person is forgotten.
async function killedOften() {
  const context = await participant({ width: 390, height: 800 });
  const query = "?PROLIFIC_PID=abc123def456&STUDY_ID=study1234567";
  let tab = await opened(context, query), kills = 0, closed = 0;
  const seen = new Set();
  tab = await goThrough(tab, async (number, title) => {
    if (!seen.has(title)) {
      seen.add(title);
      await looked(tab, `${seen.size}-narrow`);
    }
    if (title.startsWith("How likely")) {
      for (let round = 0; round < 5; round++) {
        await tab.locator(".shares input").first().fill(String(10 + round));
        // at another part of a second every time
        await tab.waitForTimeout((round * 377) % 1000);
        await killed(server);
        kills += 1;
        ({ server } = await serve(port));
        nothingIsLost();
        await tab.locator(".shares input").nth(1).fill(String(20 + round));
        await tab.waitForTimeout((round * 577) % 1300);
        await tab.close();
        closed += 1;
        tab = await opened(context, query);
        await onPage(tab, number);
      }
    }
    return tab;
  });
  await tab.waitForSelector("#code", { timeout: 60e3 });
  await looked(tab, "end-narrow");
  const number = await tab.locator("#number").textContent();
  await context.close();
  nothingIsLost();
  // the same person in another browser
  const again = await participant({ width: 390, height: 800 });
  const refused = await opened(again, query);
  await refused.waitForSelector("#stopped");
  assert.match(await refused.locator("#stopped").textContent(), /already, in another browser/);
  await again.close();
  const has = (text) => ["study.sqlite", "study.sqlite-wal"].some((name) => {
    try {
      return readFileSync(join(folder, name)).includes(text);
    } catch {
      return false;
    }
  });
  assert.ok(has("abc123def456") && has(number));
  // while the server runs
  assert.match(cocarry("study", "forget", "study.toml", "abc123def456"), new RegExp(`^${number} is removed: \\d+ chunks and 2 parameters`));
  assert.ok(!has("abc123def456") && !has(number));
  assert.deepEqual(stored().integrity, [["ok"]]);
  assert.equal(stored().sessions.length, 1);
  console.log(`${kills} kills of the server and ${closed} of the tab: nothing acknowledged was lost; the person is forgotten`);
}

// Plain files on any host: the participant saves a file.
async function withoutServer() {
  cocarry("study", "build", "study.toml", "-o", "site", ...simulator);
  const host = await serveFolder(join(folder, "site/"));
  const context = await browser.newContext({ viewport: { width: 1024, height: 760 }, acceptDownloads: true });
  const tab = await goThrough(await opened(context, "", host.address));
  await looked(tab, "end-saved");
  assert.equal(await tab.locator("#code").count(), 0);
  const [saved] = await Promise.all([tab.waitForEvent("download"), tab.locator("#save").click()]);
  await saved.saveAs(join(folder, "saved.json"));
  assert.deepEqual(faultsOf.get(tab), []);
  await context.close();
  host.close();
  for (const _ of [1, 2]) cocarry("study", "collect", "study.toml", "--add", "saved.json", "-o", "answers", "--overwrite");
  const people = readFileSync(join(folder, "answers/participants.csv"), "utf8").trim().split("\n");
  assert.equal(people.length, 1 + 2, people.join("\n"));
  console.log("without a server: the file that a participant saves is added once");
}

try {
  collected(await one());
  await killedOften();
  await withoutServer();
} finally {
  await browser.close();
  server.kill("SIGKILL");
  rmSync(folder, { recursive: true });
}
