// The page that runs the simulator, in Chromium: node test/page.mjs PROGRAM. It loads, plays, changes a world, carries,
// and gives the same episode again, in the page and in the program.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { loadavg, tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { clock, download, launch, open, over, serve, text } from "./serving.mjs";

const program = process.argv[2];
const repository = fileURLToPath(new URL("../..", import.meta.url));
const folder = mkdtempSync(join(tmpdir(), "page-"));
const cocarry = (...words) => execFileSync(program, words, { cwd: folder, encoding: "utf8", maxBuffer: 1 << 28 });
const MAX_BYTES = 3.5e6;

const server = await serve();
const browser = await launch();

async function loads() {
  const times = [];
  for (let i = 0; i < 3; i++) {
    const { tab, close } = await open(browser, server.address);
    times.push(Number(await tab.evaluate(() => document.body.dataset.drawn)));
    if (i === 0) {
      await tab.waitForFunction(() => Number.parseFloat(document.getElementById("clock").textContent) > 1.2, null, { timeout: 60e3 });
      await tab.waitForFunction(() => document.getElementById("rates").textContent, null, { timeout: 60e3 });
      console.log(`plays: ${await text(tab, "#rates")}`);
      await tab.locator("#play").click();
      // not the clock's, which is rounded: 1.37 s stands there as 1.4, and the next step ends at 1.4 s
      const time = () => tab.locator("#time").evaluate(({ value }) => Number(value));
      const stopped = await time();
      await tab.waitForTimeout(300);
      assert.equal(await time(), stopped, "paused");
      for (const from of [stopped, 0.37, 0.4]) {
        if (from !== stopped) await tab.locator("#time").fill(String(from));
        await tab.locator("#step").click();
        const next = 0.2 * (Math.floor(from / 0.2 + 1e-6) + 1);
        assert.ok(Math.abs((await time()) - next) < 1e-9, `from ${from} s one planning step further: ${await time()} s`);
      }
    }
    await close();
  }
  const bytes = [...server.sent].filter(([name]) => name !== "favicon.ico").reduce((sum, [, length]) => sum + length, 0);
  assert.ok(bytes <= MAX_BYTES, `${bytes} bytes`);
  // told, not asserted: a machine with other work is slower
  console.log(`loads: ${(bytes / 1e6).toFixed(2)} MB in all (compressed), first picture after ${times.join(", ")} ms at a load of ${loadavg()[0].toFixed(1)}`);
}

// The options on the page are those of the program for the same file.
async function sameOptions(tab, name) {
  const file = `${name}.toml`;
  writeFileSync(join(folder, file), await download(tab, "world"));
  const shown = await tab.locator("#options tbody tr").evaluateAll((rows) => rows.map((row) => [...row.cells].map((cell) => cell.textContent.trim())));
  const { options } = JSON.parse(cocarry("world", file, "--json"));
  assert.equal(shown.length, options.length, file);
  options.forEach((option, o) => {
    const [, , length, risk, cost, share] = shown[o];
    const words = [shown[o][0], length, risk, cost, share.replace(/\s/g, "")];
    const { name, length_m: d, risk: s, objective_cost_m: j, probability: p } = flat(option);
    assert.deepEqual(words, [name, d.toFixed(2), s.toFixed(3), j.toFixed(2), `${(100 * p).toFixed(1)}%`], `${file}, option ${name}`);
  });
  return shown.map((row) => row.join(" ")).join("; ");
}

const flat = (option) => Object.fromEntries(Object.entries(option).flatMap(([key, value]) => (value && typeof value === "object" && !Array.isArray(value) ? Object.entries(value) : [[key, value]])));

async function changes() {
  const { tab, close } = await open(browser, server.address, "play=0&camera=map");
  await tab.waitForSelector('#map [data-item="obstacle:2"]');
  const before = await sameOptions(tab, "as-it-is");
  // wall-3 goes north: the opening south of it widens
  const [x, y] = await middle(tab, '#map [data-item="obstacle:2"] .wall');
  await tab.mouse.move(x, y);
  await tab.mouse.down();
  const during = new Set();
  for (let i = 1; i <= 8; i++) {
    await tab.mouse.move(x, y - 3 * i);
    during.add(await text(tab, "#options tbody"));
  }
  await tab.mouse.up();
  assert.ok(during.size > 3, "options change while the wall is dragged");
  const dragged = await sameOptions(tab, "dragged");
  assert.notEqual(dragged, before);
  const link = await addressOf(tab);
  // keys move it as well; A too; and back
  await tab.locator('[data-item="start_m"]').focus();
  for (const key of ["ArrowUp", "ArrowUp", "Shift+ArrowLeft"]) await tab.keyboard.press(key);
  const keyed = await sameOptions(tab, "keyed");
  assert.notEqual(keyed, dragged);
  for (let i = 0; i < 3; i++) await tab.locator("#undo").click();
  assert.equal(await sameOptions(tab, "undone"), dragged);
  // a wall that is drawn
  await tab.locator("#tool-wall").click();
  const [ax, ay] = await middle(tab, '[data-item="start_m"] .end'), [bx, by] = await middle(tab, '[data-item="target_m"] .end');
  const at = (part, aside) => [ax + part * (bx - ax) - aside * 0.2 * (by - ay), ay + part * (by - ay) + aside * 0.2 * (bx - ax)];
  await tab.mouse.move(...at(0.25, -1));
  await tab.mouse.down();
  await tab.mouse.move(...at(0.25, 0), { steps: 4 });
  await tab.mouse.up();
  const walled = await sameOptions(tab, "walled");
  assert.match(await download(tab, "world"), /drawn-1/);
  await tab.keyboard.press("Escape");
  // a world that cannot be: a sentence, and the last good one stays
  await tab.locator("#tool-move").click();
  await tab.locator("#paste").click();
  await tab.locator("#text").fill("name = \"x\"\nrobot_width_m = -1\nstart_m = [0, 0]\ntarget_m = [1, 1]");
  await tab.locator("#use").click();
  assert.match(await text(tab, "#world-fault"), /world\.toml.*robot_width_m|robot_width_m/s);
  assert.equal((await tab.locator("#options tbody tr").evaluateAll((rows) => rows.map((row) => [...row.cells].map((cell) => cell.textContent.trim()).join(" ")).join("; "))), walled, "the last good world stays");
  await tab.locator("#cancel").click();
  await tab.locator("#file").setInputFiles({ name: "picture.toml", mimeType: "text/plain", buffer: Buffer.from([0xff, 0xfe, 0, 1]) });
  await tab.waitForFunction(() => /picture\.toml is not a text/.test(document.getElementById("world-fault").textContent));
  await close();
  const again = await open(browser, link.split("#")[0], `${link.split("#")[1]}&play=0&camera=map`);
  assert.equal(await sameOptions(again.tab, "linked"), dragged, "the link has the world");
  await again.close();
  console.log(`changes: a dragged, a keyed and a drawn wall have the program's options (${dragged.split("; ").length})`);
}

async function middle(tab, selector) {
  const { x, y, width, height } = await tab.locator(selector).first().boundingBox();
  const view = await tab.locator("#map").boundingBox();
  const [left, right] = [Math.max(x, view.x), Math.min(x + width, view.x + view.width)];
  const [top, bottom] = [Math.max(y, view.y + 60), Math.min(y + height, view.y + view.height - 60)];
  return [(left + right) / 2, (top + bottom) / 2];
}

async function addressOf(tab) {
  await tab.locator("#share").click();
  await tab.waitForFunction(() => document.getElementById("share").textContent !== "Copy link");
  return tab.evaluate(() => location.href);
}

// An episode of a model, at the highest speed: its digest is the program's, and that of its link. Each of its choices
// changes the digest.
async function repeats() {
  const { tab, close } = await open(browser, server.address, "plant=kinematic&play=0&belief=learn&eta=8&alpha=0.7&gamma=0.9&stubbornness=0.2");
  await tab.locator("#speed").selectOption("8");
  await tab.locator("#play").click();
  const digest = await over(tab);
  assert.match(await text(tab, "#report"), /Arrived at B after/);
  const command = (await text(tab, "#command")).trim();
  const report = await tab.locator("#report pre").textContent();
  const words = command.split(/\s+/);
  assert.equal(words.shift(), "cocarry");
  const lines = (text) => text.split("\n").map((line) => line.trim()).filter(Boolean);
  const printed = lines(cocarry(...words));
  for (const line of lines(report)) assert.ok(printed.includes(line), `the program prints: ${line}\n${printed.join("\n")}`);
  const log = await download(tab, "log");
  writeFileSync(join(folder, "model.json"), log);
  assert.match(cocarry("replay", "model.json"), /identical/);
  const link = await addressOf(tab);
  await close();
  const [address, hash] = link.split("#");
  const again = await open(browser, address, hash);
  await again.tab.locator("#speed").selectOption("8");
  assert.equal(await over(again.tab), digest, "the link gives the same episode");
  await again.close();
  console.log(`repeats: report of ${command.slice(0, 60)}… and digest ${digest} as in the program and from the link`);
}

// A person carries for 30 s of simulated time, by a scripted pointer and keys.
async function carries() {
  const { tab, close } = await open(browser, server.address, "play=0&camera=map&carry=1&period=0.05", { width: 760, height: 640 });
  await tab.locator("#speed").selectOption("8");
  const until = (time) => tab.waitForFunction((time) => Number.parseFloat(document.getElementById("clock").textContent) >= time || document.body.dataset.digest, time, { timeout: 120e3 });
  const box = async (selector) => tab.locator(selector).boundingBox();
  const from = await box("#map .ends g:first-child .end"), to = await box("#map .openings path:nth-child(2)");
  // toward the opening that the robot leads to
  const at = [from, to].map(({ x, y, width, height }) => [x + width / 2, y + height / 2]).reduce(([x0, y0], [x1, y1]) => [x0 + 0.6 * (x1 - x0), y0 + 0.6 * (y1 - y0)]);
  await tab.locator("#play").click();
  await tab.mouse.move(...at);
  await tab.mouse.down();
  for (const [time, aside] of [[1, 6], [2, -6], [3, 0], [4, 4]]) {
    await until(time);
    await tab.mouse.move(at[0] + aside, at[1]);
  }
  await tab.mouse.up();
  await until(7);
  await tab.keyboard.down("r");
  await until(8.5);
  await tab.keyboard.up("r");
  await tab.keyboard.down("d");
  await until(9.5);
  await tab.keyboard.up("d");
  await tab.keyboard.press("t");
  await until(30);
  if (!(await tab.evaluate(() => document.body.dataset.digest))) await tab.locator("#play").click();
  const log = JSON.parse(await download(tab, "log"));
  assert.ok(log.steps * 0.2 >= 30 || log.outcome === "arrived", `${log.steps} steps, ${log.outcome}`);
  const [, digest] = log.digests[log.digests.length - 1];
  writeFileSync(join(folder, "carried.json"), JSON.stringify(log));
  const replayed = cocarry("replay", "carried.json", "--record", "carried.mcap");
  assert.match(replayed, /identical: \d+ digests/);
  assert.match(cocarry("replay", "carried.mcap"), /identical/);
  const link = await addressOf(tab);
  await close();
  const [address, hash] = link.split("#");
  const again = await open(browser, address, `${hash}&play=0`);
  await again.tab.locator("#speed").selectOption("8");
  await again.tab.locator("#play").click();
  await again.tab.waitForFunction((steps) => Number.parseFloat(document.getElementById("clock").textContent) >= steps * 0.2 - 0.1 || document.body.dataset.digest, log.steps, { timeout: 120e3 });
  const repeated = JSON.parse(await download(again.tab, "log"));
  assert.equal(new Map(repeated.digests).get(log.digests[log.digests.length - 1][0]), digest, "the link repeats the person's decisions");
  await again.close();
  console.log(`carries: ${(log.steps * 0.2).toFixed(0)} s, ${log.outcome ?? "not over"}, a link of ${hash.length} characters, the program: ${replayed.trim().replaceAll("\n", "; ")}`);
}

// The page of a recording hands its episode over at 10 s, where it is the recording's; a person carries for ten more.
async function takesOver() {
  const shipped = join(repository, "recordings/environment-4.mcap"), page = join(folder, "taken.html");
  cocarry("render", shipped, "-o", page, "--demo", server.address);
  const context = await browser.newContext({ viewport: { width: 760, height: 640 }, acceptDownloads: true });
  const player = await context.newPage(), faults = [];
  context.on("weberror", (error) => faults.push(error.error().stack));
  await player.goto(`${pathToFileURL(page)}#play=0&t=10`);
  const button = player.locator("#takeover a");
  assert.equal(await button.textContent(), "Take over from 10.0 s");
  const [tab] = await Promise.all([context.waitForEvent("page"), button.click()]);
  await tab.waitForFunction(() => /human’s end is yours/.test(document.getElementById("warning-text").textContent), null, { timeout: 120e3 });
  assert.match(await text(tab, "#warning-text"), /^From 10\.0 s/);
  assert.equal(await clock(tab), 10);
  assert.match(await tab.evaluate(() => location.hash), /&t=10$/, "the link stays until somebody decides");
  // the state is the recording's: the log so far gives the same messages
  const recorded = (log, name) => {
    writeFileSync(join(folder, `${name}.json`), JSON.stringify(log));
    assert.match(cocarry("replay", `${name}.json`, "--overwrite", "--record", `${name}.mcap`), /identical: \d+ digests/);
    return CHANNELS.map((channel) => rows(cocarry("inspect", `${name}.mcap`, "--csv", channel)));
  };
  const theirs = CHANNELS.map((channel) => rows(cocarry("inspect", shipped, "--csv", channel)));
  const before = JSON.parse(await download(tab, "log"));
  assert.deepEqual([before.steps, before.digests.length, before.decisions], [50, 10, undefined]);
  const ours = recorded(before, "before");
  ours.forEach((channel, c) => {
    assert.ok(channel.length >= 50, `${channel.length} rows`);
    assert.deepEqual(theirs[c].slice(0, channel.length), channel);
  });
  // ten more seconds, with the hand elsewhere in the first
  const until = (time) => tab.waitForFunction((time) => Number.parseFloat(document.getElementById("clock").textContent) >= time, time, { timeout: 120e3 });
  await tab.locator("#play").click();
  await tab.keyboard.down("w");
  await until(11);
  await tab.keyboard.up("w");
  await tab.locator("#speed").selectOption("8");
  await until(20);
  await tab.locator("#play").click();
  const log = JSON.parse(await download(tab, "log"));
  assert.ok(log.steps >= 100 && log.decisions, `${log.steps} steps`);
  const after = recorded(log, "after");
  ours.forEach((channel, c) => assert.deepEqual(after[c].slice(0, channel.length), channel, "the same until 10 s"));
  assert.notDeepEqual(after[1].slice(0, 100), theirs[1].slice(0, 100), "then another one");
  assert.match(cocarry("replay", "after.mcap"), /identical/);
  // from where the recording is another one, the page says so
  const href = await button.getAttribute("href");
  await tab.goto("about:blank");
  await tab.goto(href.replace(/object=([\d.]+)/, "object=3$1"));
  await tab.waitForFunction(() => /came out otherwise/.test(document.getElementById("warning-text").textContent), null, { timeout: 120e3 });
  assert.deepEqual(faults, []);
  await context.close();
  console.log(`takes over: at 10 s all ${ours.reduce((sum, channel) => sum + channel.length, 0)} messages of the recording, then ${(log.steps * 0.2 - 10).toFixed(0)} s by hand, a link of ${href.length} characters`);
}

// Tables of the recording that hold the whole state of the team.
const CHANNELS = ["/joints", "/coordination", "/interaction"];
const rows = (table) => table.trim().split("\n").slice(1);

// A finger on the map, and a gamepad, move the hand.
async function handles() {
  const hands = async (tab) => {
    const { decisions } = JSON.parse(await download(tab, "log"));
    return Object.entries(decisions?.hands ?? {}).flatMap(([step, targets]) => targets.map((target) => [Number(step), target])).filter(([, target]) => target);
  };
  const until = (tab, time) => tab.waitForFunction((time) => Number.parseFloat(document.getElementById("clock").textContent) >= time, time, { timeout: 120e3 });
  const hash = "play=0&camera=map&carry=1&period=0.05";
  const touched = await open(browser, server.address, hash, { width: 390, height: 844, touch: true });
  const { tab } = touched, session = await tab.context().newCDPSession(tab);
  const at = async (selector) => {
    const { x, y, width, height } = await tab.locator(selector).first().boundingBox();
    return [x + width / 2, y + height / 2];
  };
  const [x, y] = await at("#map circle.end");
  const finger = (type, ...points) => session.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y]) => ({ x, y })) });
  await tab.locator("#play").tap();
  await until(tab, 1);
  assert.deepEqual(await hands(tab), [], "no finger, no target");
  await finger("touchStart", [x, y]);
  // ahead of the team: where the robot holds against it, a hand gives way
  await finger("touchMove", [x + 60, y + 80]);
  await until(tab, 4);
  await finger("touchEnd");
  const lifted = await clock(tab);
  await until(tab, lifted + 1);
  await tab.locator("#play").tap();
  const places = await hands(tab);
  assert.ok(places.length > 5, `${places.length} targets by touch`);
  assert.ok(Math.max(...places.map(([step]) => step)) * 0.2 <= lifted + 0.4, "none after the finger is lifted");
  await touched.close();

  const held = await open(browser, server.address, hash, { before: () => {
    globalThis.pad = { connected: true, axes: [0, 0], buttons: [{ pressed: false }, { pressed: false }] };
    navigator.getGamepads = () => [globalThis.pad];
  } });
  const pad = (change) => held.tab.evaluate((change) => {
    if (change.axes) globalThis.pad.axes = change.axes;
    if (change.button !== undefined) globalThis.pad.buttons[change.button].pressed = change.pressed;
  }, change);
  await held.tab.locator("#play").click();
  await until(held.tab, 0.6);
  assert.deepEqual(await hands(held.tab), [], "a stick at rest");
  await pad({ axes: [0, 1] });
  await until(held.tab, 1.6);
  await pad({ axes: [0.1, 0.1], button: 1, pressed: true });
  await held.tab.waitForSelector('#resist[aria-pressed="true"]');
  const rest = await clock(held.tab);
  await until(held.tab, rest + 0.6);
  await pad({ button: 1, pressed: false });
  await held.tab.waitForSelector('#resist[aria-pressed="false"]');
  await pad({ button: 0, pressed: true });
  await held.tab.waitForSelector('#lead[aria-pressed="true"]');
  await until(held.tab, (await clock(held.tab)) + 0.6);
  await held.tab.locator("#play").click();
  const pushed = await hands(held.tab);
  assert.ok(pushed.length > 5, `${pushed.length} targets by stick`);
  assert.ok(Math.max(...pushed.map(([step]) => step)) * 0.2 <= rest + 0.2, "a stick that is nearly at rest is at rest");
  assert.ok(pushed.every(([, [, y]], i) => i === 0 || y < pushed[i - 1][1][1]), "down the map");
  const { decisions: { human } } = JSON.parse(await download(held.tab, "log"));
  for (const [name, what] of [["Resist", "holds back"], ["TakeOver", "leads"]]) assert.ok(human.some(({ stance }) => stance === name), `a button ${what}`);
  await held.close();
  console.log(`handles: ${places.length} targets by touch, ${pushed.length} by a gamepad's stick; its buttons hold back and lead`);
}

try {
  const asked = process.argv[3];
  for (const check of [loads, changes, repeats, carries, takesOver, handles].filter(({ name }) => !asked || name === asked)) {
    const start = Date.now();
    await check();
    console.log(`  (${((Date.now() - start) / 1000).toFixed(0)} s)`);
  }
} finally {
  await browser.close();
  server.close();
  rmSync(folder, { recursive: true });
}
