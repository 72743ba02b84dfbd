// The page that runs the simulator, in Firefox, by hand: xvfb-run -a node test/firefox.mjs PROGRAM (Node 20: with
// --experimental-websocket; Debian: apt-get install firefox-esr xvfb; without a display Firefox has no WebGL). It opens the
// page of `cocarry demo`, carries by keys, downloads the episode, and replays it in the program. It speaks WebDriver BiDi:
// playwright-core asks a Debian Firefox for commands that it does not know.
import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { setTimeout as sleep } from "node:timers/promises";
import { fileURLToPath } from "node:url";

const program = process.argv[2], here = (name) => fileURLToPath(new URL(name, import.meta.url));
const folder = mkdtempSync(join(tmpdir(), "firefox-"));
const started = [];

// Starts a program; the first line of its output that has these words, and what they found.
async function start(file, words, find, stream = "stdout") {
  const child = spawn(file, words, { cwd: folder, stdio: "pipe" });
  started.push(child);
  for await (const line of createInterface(child[stream])) {
    const found = find.exec(line);
    if (found) return found[0];
  }
  throw new Error(`${file} ended`);
}

// What is asked of Firefox, and `faults`, which the page reported.
async function connect(address) {
  const socket = new WebSocket(address), waiting = new Map(), faults = [];
  socket.onmessage = ({ data }) => {
    const message = JSON.parse(data);
    if (message.type === "event") message.params.level === "error" && faults.push(message.params.text);
    else if (message.type === "success") waiting.get(message.id).resolve(message.result);
    else waiting.get(message.id).reject(new Error(`${message.error}: ${message.message}`));
  };
  await new Promise((resolve, reject) => Object.assign(socket, { onopen: resolve, onerror: reject }));
  let id = 0;
  const ask = (method, params = {}) => new Promise((resolve, reject) => {
    waiting.set(++id, { resolve, reject });
    socket.send(JSON.stringify({ id, method, params }));
  });
  return { ask, faults, close: () => socket.close() };
}

try {
  const page = await start(program, ["demo", "--no-browser", "--port", "0", "--page", here("../dist/page")], /http:\S+/);
  writeFileSync(join(folder, "user.js"), [["browser.download.dir", folder], ["browser.download.folderList", 2]].map(([key, value]) => `user_pref("${key}", ${JSON.stringify(value)});\n`).join(""));
  const firefox = process.env.FIREFOX ?? "firefox-esr";
  const address = await start(firefox, ["--no-remote", "--profile", folder, "--remote-debugging-port", "0"], /ws:\S+/, "stderr");
  const { ask, faults, close } = await connect(`${address}/session`);
  const { capabilities } = await ask("session.new", { capabilities: {} });
  await ask("session.subscribe", { events: ["log.entryAdded"] });
  const { contexts: [{ context }] } = await ask("browsingContext.getTree");
  await ask("browsingContext.setViewport", { context, viewport: { width: 1280, height: 800 } });
  const evaluate = async (expression) => {
    const { result, exceptionDetails } = await ask("script.evaluate", { expression, target: { context }, awaitPromise: true });
    if (exceptionDetails) throw new Error(exceptionDetails.text);
    return result.value;
  };
  const until = async (expression) => {
    for (const end = Date.now() + 180e3; Date.now() < end; await sleep(100)) if (await evaluate(expression)) return;
    throw new Error(`waited for ${expression}`);
  };
  const clock = "Number.parseFloat(document.getElementById('clock').textContent)";
  const click = (selector) => evaluate(`document.querySelector('${selector}').click()`);
  const key = (type, value) => ask("input.performActions", { context, actions: [{ type: "key", id: "keys", actions: [{ type, value }] }] });

  await ask("browsingContext.navigate", { context, url: `${page}#play=0&carry=1&period=0.05`, wait: "complete" });
  await until("Boolean(document.body.dataset.drawn)");
  const first = await evaluate("document.body.dataset.drawn");
  assert.equal(await evaluate("document.getElementById('warning').hidden"), true, await evaluate("document.getElementById('warning-text').textContent"));
  await click("#play");
  await until(`${clock} > 1`);
  await key("keyDown", "d");
  await until(`${clock} > 3`);
  await key("keyUp", "d");
  await until(`${clock} > 8`);
  await click("#play");
  const rates = await evaluate("document.getElementById('rates').textContent");
  const { data } = await ask("browsingContext.captureScreenshot", { context });
  mkdirSync(here("screenshots"), { recursive: true });
  writeFileSync(here("screenshots/firefox.png"), Buffer.from(data, "base64"));
  await click('[data-file="log"]');
  const file = join(folder, "episode.json");
  for (const end = Date.now() + 30e3; !existsSync(file) && Date.now() < end; ) await sleep(100);
  await sleep(500);
  const log = JSON.parse(readFileSync(file, "utf8"));
  assert.ok(log.steps >= 40 && Object.keys(log.decisions.hands).length > 2, `${log.steps} steps`);
  const replayed = execFileSync(program, ["replay", "episode.json"], { cwd: folder, encoding: "utf8" });
  assert.match(replayed, /identical: \d+ digests/);
  assert.deepEqual(faults, []);
  console.log(`Firefox ${capabilities.browserVersion}: first picture after ${first} ms, ${rates}; ${log.steps} steps by hand, the program: ${replayed.trim()}`);
  await ask("browser.close");
  close();
} finally {
  started.forEach((child) => child.kill());
  await sleep(500);
  rmSync(folder, { recursive: true, force: true });
}
