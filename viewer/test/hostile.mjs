// Opens every kind of page and picture that the program writes, made of hostile names, in Chromium, and gives such files to
// the page that runs the simulator: node test/hostile.mjs PROGRAM. No script of a name runs, no name opens an element,
// nothing is asked of a network, the page has no error and shows neither NaN nor undefined.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { cpSync, existsSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { deflateRawSync } from "node:zlib";
import { launch, open, over, serve } from "./serving.mjs";

const program = process.argv[2];
const repository = fileURLToPath(new URL("../..", import.meta.url));
const folder = mkdtempSync(join(tmpdir(), "hostile-"));
const cocarry = (...words) => {
  try {
    return execFileSync(program, words, { cwd: folder, encoding: "utf8", maxBuffer: 1 << 28, stdio: ["ignore", "pipe", "pipe"] });
  } catch (error) {
    // a team that does not arrive is none
    if (error.status !== 3) throw new Error(`cocarry ${words.join(" ")}: ${error.status}\n${error.stderr}`);
    return error.stdout;
  }
};

// Each would set `ran` where it is taken for more than a name, or make an element `x-ran`.
const NAMES = [
  "<!--<script></script>",
  "</script><script>ran=1</script>",
  "</style><script>ran=1</script><style>",
  "</title><script>ran=1</script>",
  "<img src=x onerror=ran=1>",
  "<x-ran>",
  "\"'><svg onload=ran=1>",
  "\" onmouseover=ran=1 x=\"",
  "javascript:ran=1//",
  "\u202e\u2066\u2028\u0085\ufeff",
  "&lt;x-ran&gt;&#x3c;x-ran&#x3e;",
  "__EPISODE__",
  "${ran=1}",
  "{{ran=1}}",
  "]]><script>ran=1</script><![CDATA[",
  "*/ran=1/*",
  "`;ran=1;`",
  "![a](javascript:ran=1) [a](javascript:ran=1) <script>ran=1</script>",
  "__proto__",
  "constructor",
];
// those that a file can have
const OF_FILES = NAMES.filter((name) => !name.includes("/"));

const inToml = (text) => JSON.stringify(text).slice(1, -1).replace(/\u007f/g, "\\u007f");
const inXml = (text) => text.replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;").replace(/"/g, "&quot;");

// Environment 4 with this before the names of the world and of everything in it; of a wall, an opening and an option it is the whole name.
function world(name) {
  const text = readFileSync(join(repository, "worlds/environment-4.toml"), "utf8");
  const named = inToml(name);
  const prefixed = text.replace(/^name = "/gm, () => `name = "${named}`);
  const all = prefixed.replace(/^(between|openings) = \[(.*)\]/gm, (_, key, list) => `${key} = [${list.replace(/"([^"]*)"/g, (_, old) => `"${named}${old}"`)}]`);
  return ["wall-4", "xi3", "2"].reduce((text, old) => text.replaceAll(`"${named}${old}"`, () => `"${named}"`), all);
}

// The carrier with this before the names of its links, joints and postures.
function robot(name) {
  let urdf = readFileSync(join(repository, "assets/robots/carrier.urdf"), "utf8");
  let toml = readFileSync(join(repository, "assets/robots/carrier.toml"), "utf8");
  urdf = urdf.replace(/(<(?:link|joint) name="|<(?:parent|child) link="|<mimic joint="|<robot name=")/g, (begin) => begin + inXml(name));
  toml = toml.replace(/^(name|base_link|grasp_frame|left_wheel|right_wheel) = "/gm, (begin) => begin + inToml(name));
  toml = toml.replace(/^(\w+_joint) = /gm, (_, joint) => `"${inToml(name)}${joint}" = `);
  return { urdf, toml };
}

const browser = await launch();
const context = await browser.newContext({ viewport: { width: 1000, height: 700 } });
let opened = 0;

// No name is more than a text.
async function untouched(tab, about) {
  // what waits for a pointer or the keyboard
  await tab.mouse.move(300, 300);
  await tab.keyboard.press("Tab");
  const seen = await tab.evaluate(() => ({
    ran: typeof globalThis.ran,
    elements: document.querySelectorAll("x-ran, img[src='x'], [onerror], [onload], [onmouseover]").length,
    links: [...document.querySelectorAll("a, use, image")].filter((e) => /^\s*javascript:/i.test(e.getAttribute("href") ?? e.getAttributeNS("http://www.w3.org/1999/xlink", "href") ?? "")).length,
    words: (document.body ?? document.documentElement).innerText ?? document.documentElement.textContent,
  }));
  assert.equal(seen.ran, "undefined", `${about}: a script ran`);
  assert.equal(seen.elements + seen.links, 0, `${about}: a name is an element or a link`);
  assert.doesNotMatch(seen.words, /\bNaN\b|\bundefined\b|\[object/, about);
  opened += 1;
  return seen.words;
}

async function check(file, name, act = async () => {}) {
  const tab = await context.newPage();
  const faults = [], asked = [];
  tab.on("pageerror", (error) => faults.push(error.stack));
  tab.on("console", (message) => ["error", "warning"].includes(message.type()) && !/GL Driver|WebGL|swiftshader/i.test(message.text()) && faults.push(message.text()));
  tab.on("dialog", (dialog) => faults.push(`dialog ${dialog.message()}`) && dialog.dismiss());
  tab.on("request", (request) => asked.push(request.url()));
  await tab.goto(pathToFileURL(file).href, { waitUntil: "load" });
  const isPage = file.endsWith(".html");
  if (isPage && (await tab.locator("#view").count())) await tab.waitForFunction(() => document.body.dataset.drawn, null, { timeout: 60000 });
  await act(tab);
  const about = `${file}, of ${JSON.stringify(name)}`;
  await untouched(tab, about);
  assert.deepEqual(faults, [], about);
  assert.deepEqual(asked.filter((url) => !/^(file|data|blob):/.test(url)), [], `${about}: network requests`);
  assert.ok(asked.filter((url) => url.startsWith("file:")).length <= 1, `${about}: other files ${asked}`);
  await tab.close();
}

// Every button of a player, its ends and its middle.
async function play(tab) {
  for (const key of ["Home", "n", "n", "End", "c", "c"]) await tab.keyboard.press(key);
  for (const button of (await tab.locator("#events button").all()).slice(0, 4)) await button.click({ timeout: 2000 }).catch(() => {});
}

// The page that runs the simulator: worlds, scenarios and episodes that a reader opens, and links.
async function simulated() {
  const server = await serve();
  const give = (tab, name, text) => tab.locator("#file").setInputFiles({ name, mimeType: "text/plain", buffer: Buffer.from(text) });
  const fault = (tab, words) => tab.waitForFunction((words) => document.getElementById("world-fault").textContent.includes(words), words);
  const refusals = [
    ["", "missing field `name`"], ["{", "JSON"], ["null", "world.toml"], ["{}", "not an episode"], ["[".repeat(500_000), "cannot be empty"], ["{\"a\":".repeat(90_000), "JSON"],
    ["a.".repeat(200_000) + "a = 1", "recursion limit"], ["\0", "world.toml"], ['name = "<img src=x onerror=ran=1>"', "robot_width_m"],
    ['{"scenario": "<img src=x onerror=ran=1>"}', "scenario"],
  ];
  const { tab, close } = await open(browser, server.address, "plant=point&play=0&eta=15");
  const play = (isPlaying) => tab.evaluate((word) => document.querySelector(`#play[aria-label="${word}"]`)?.click(), isPlaying ? "Play" : "Pause");
  for (const [i, name] of NAMES.entries()) {
    // a file that is opened plays
    await play(false);
    await give(tab, `${name.replace(/[/\0]/g, "")}.toml`, world(name));
    const shown = (words) => [...document.querySelectorAll("#options th")].some((cell) => cell.textContent === words);
    await tab.waitForFunction(shown, name, { timeout: 60e3 }).catch(async () => assert.fail(`${name}: ${await tab.locator("#world-fault").textContent()}`));
    for (const camera of i % 4 ? ["map"] : ["map", "overview", "follow"]) await tab.locator(`[data-camera="${camera}"]`).click();
    await tab.locator("#speed").selectOption("8");
    if (i % 6 === 0) {
      await tab.waitForFunction(() => document.getElementById("clock").textContent === "0.0 s");
      await play(true);
      await over(tab);
      const [download] = await Promise.all([tab.waitForEvent("download"), tab.evaluate(() => document.querySelector('[data-file="log"]').click())]);
      const log = JSON.parse(readFileSync(await download.path(), "utf8"));
      assert.equal(log.outcome, "arrived", name);
      // decisions that no person makes
      const [far, human] = [1e6, { stance: "TakeOver", stubbornness: 1e308, discomfort: -1e308, perception: { alpha: 1e308, gamma: -1e308 } }];
      for (const [forged, isRefused] of [
        [{ ...log, decisions: { human: [{ option: 4e9, ...human, hand: [far, -far] }], hands: { 0: [[far, far]], 18446744073709551615: [] } } }],
        [{ ...log, decisions: { human: [] , has_changes: true }, digests: [[0, name]], steps: 1e6 }],
        [{ ...log, decisions: { human: [{ option: 0, ...human, hand: [1e9, 0] }] } }, true],
        [{ ...log, decisions: [] }],
        [{ ...log, steps: 1e7 }, true], [{ ...log, steps: -1 }, true], [{ ...log, decisions: 7 }, true], [{ ...log, version: name }, true],
      ]) {
        await give(tab, "episode.json", JSON.stringify(forged).replaceAll("18446744073709552000", "18446744073709551615"));
        if (isRefused) await tab.waitForFunction(() => /cannot be repeated/.test(document.getElementById("warning-text").textContent));
        await tab.waitForTimeout(500);
        await untouched(tab, `a forged episode of ${name}`);
        await tab.evaluate(() => document.getElementById("dismiss").click());
      }
    }
    await untouched(tab, `the page that runs the simulator, of ${JSON.stringify(name)}`);
  }
  for (const [text, words] of refusals) {
    await give(tab, "a<img src=x onerror=ran=1>.toml", text);
    await fault(tab, words);
    assert.ok((await tab.locator("#world-fault").textContent()).length < 2000, `${text.slice(0, 40)}: a short sentence`);
    await untouched(tab, text.slice(0, 40));
  }
  // a world as wide as one can be, and a wider one, which leaves it as it was
  const far = (m) => give(tab, "far.toml", `name = "far"\nrobot_width_m = 0.5\nstart_m = [-${m}, 0]\ntarget_m = [${m}, 0]\n`);
  await far(10_000);
  await tab.waitForFunction(() => document.getElementById("options").textContent.includes("20000.00"), null, { timeout: 60e3 });
  for (const camera of ["overview", "map"]) await tab.locator(`[data-camera="${camera}"]`).click();
  await untouched(tab, "a world 20 km wide");
  await far(500_000);
  await fault(tab, "start_m[0] = -500000; it must be a coordinate from -10000 to 10000");
  assert.match(await tab.locator("#options").textContent(), /20000\.00/);
  await close();
  const packed = (text) => deflateRawSync(text).toString("base64url");
  for (const [hash, words] of [
    ...NAMES.slice(0, 8).map((name) => [`world=${encodeURIComponent(name)}&${encodeURIComponent(name)}=1`, "expected one of"]),
    ["file=!!!!", "a world that this page packed"], [`file=${packed("x".repeat(5_000_000))}`, "a world that this page packed"],
    [`file=${packed('name = "<x-ran>"')}`, "cannot be"], [`scenario=${packed("<x-ran>")}`, "cannot be"],
    [`log=${packed("null")}`, ""], [`log=${packed("[]")}`, "cannot be repeated"], [`log=${packed('{"steps":"<x-ran>","__proto__":{"ran":1}}')}`, "cannot be repeated"],
    ["seed=1e400&alpha=nan&gamma=-1&period=1e9&camera=<x-ran>&play=<x-ran>", "expected"], [`seed=${"1".repeat(300_000)}`, "expected at most"], ["%", ""], ["=&=&&", ""],
  ]) {
    const { tab, close } = await open(browser, server.address, `${hash}${hash.length > 1e5 ? "" : "&plant=point&play=0"}`);
    assert.ok((await tab.locator("#warning-text").textContent()).includes(words), `${hash.slice(0, 60)}: ${await tab.locator("#warning-text").textContent()}`);
    await untouched(tab, `the link ${hash.slice(0, 60)}`);
    await close();
  }
  server.close();
}

const file = (name) => join(folder, name);

// Episodes and worlds: the point has no robot, the other plants have all panels.
async function episodes() {
  for (const [i, name] of NAMES.entries()) {
    writeFileSync(file("w.toml"), world(name));
    const plant = ["point", "kinematic", "rapier"][i % 3];
    cocarry("run", "w.toml", "--plant", plant, "--max-steps", "6", "--render", "run.html", "--svg", "run.svg", "--record", "run.mcap", "--overwrite");
    cocarry("world", "w.toml", "--svg", "world.svg", "--overwrite");
    await check(file("run.html"), name, play);
    for (const picture of ["run.svg", "world.svg"]) await check(file(picture), name);
    if (i % 3 === 1) {
      cocarry("inspect", "run.mcap", "--svg", "inspect.svg", "--overwrite");
      cocarry("render", "run.mcap", "-o", "strip.svg", "--overwrite");
      for (const picture of ["inspect.svg", "strip.svg"]) await check(file(picture), name);
    }
  }
}

// Pages of robots. A name that xacro would evaluate is refused.
async function robots() {
  for (const name of NAMES.filter((name) => !name.includes("${"))) {
    const { urdf, toml } = robot(name);
    writeFileSync(file("carrier.urdf"), urdf);
    writeFileSync(file("carrier.toml"), toml);
    cocarry("robot", "check", "carrier.toml", "--render", "robot.html", "--overwrite");
    await check(file("robot.html"), name, play);
  }
}

// Names of files: the title of a page is that of its recording.
async function files() {
  cocarry("run", "environment-4", "--plant", "point", "--max-steps", "3", "--record", "plain.mcap", "--overwrite");
  for (const name of OF_FILES) {
    const recording = `${name.replace(/\u2028|\u0085/g, "")}.mcap`;
    cpSync(file("plain.mcap"), file(recording));
    cocarry("render", `./${recording}`, "-o", "named.html", "--overwrite");
    await check(file("named.html"), name, play);
    rmSync(file(recording));
  }
}

// Studies: names of worlds, humans and beliefs in figures and in the report of all claims, which has no others.
async function studies() {
  for (const [i, name] of NAMES.entries()) {
    writeFileSync(file("w.toml"), world(name));
    const humans = ["a", "b"].map((end) => `[[human]]\nname = "${inToml(name)}${end}"\nalpha = "uniform(0.6,0.9)"\ngamma = "uniform(0.5,1.1)"\n`);
    const listed = ["a", "b"].map((end) => `"${inToml(name)}${end}"`).join(", ");
    writeFileSync(file("s.toml"), `name = "${inToml(name)}"\nworlds = ["w.toml", "environment-1"]\nplants = "point"\nmethods = ["mutual", "without-model"]\nhumans = [${listed}]\nseeds = 3\n${humans.join("")}`);
    cocarry("sweep", "s.toml", "-o", "rows.csv", "--overwrite");
    for (const kind of i % 6 === 0 ? ["means", "differences", "map"] : ["means"]) {
      const words = kind === "map" ? ["--cells", "2"] : [];
      cocarry("plot", "rows.csv", "-o", "plot.svg", "--kind", kind, ...words, "--overwrite");
      await check(file("plot.svg"), name);
    }
  }
  cocarry("reproduce", "all", "-o", "report", "--short", "--parts", "h1,h2");
  for (const name of readdirSync(file("report")).filter((name) => name.endsWith(".html"))) await check(file(`report/${name}`), "the report");
}

// A page whose figures are missing, and whose events say anything, as a forged recording may have them.
async function forged() {
  cocarry("run", "environment-4", "--plant", "rapier", "--max-steps", "6", "--render", "forged.html", "--overwrite");
  const page = readFileSync(file("forged.html"), "utf8");
  const [, before, json, after] = /^([\s\S]*<script type="application\/json" id="episode">)([\s\S]*?)(<\/script>[\s\S]*)$/.exec(page);
  const write = (name, episode) => writeFileSync(file(name), before + JSON.stringify(episode).replace(/</g, "\\u003c") + after);
  for (const [i, name] of [...NAMES, ""].entries()) {
    const episode = JSON.parse(json);
    const forget = (values) => values.map((value, at) => (i % 2 || at % 2 ? null : value));
    for (const figure of Object.values(episode.steps.figures)) figure.values = forget(figure.values);
    for (const option of episode.options) option.probability = forget(option.probability);
    for (const key of ["mode", "executed", "preferred"]) episode.steps[key] = forget(episode.steps[key]).map((word) => word && (i % 3 ? word : name));
    for (const event of episode.events) [event.sentence, event.about] = [name, i % 3 ? event.about : name];
    write("forged.html", episode);
    await check(file("forged.html"), name, play);
  }
  // as many steps, as far away, as a recording may have
  const episode = JSON.parse(json), long = 30_000;
  const stretched = (values) => Array.from({ length: long }, (_, k) => values[k % values.length]);
  for (const key of ["mode", "executed", "preferred"]) episode.steps[key] = stretched(episode.steps[key]);
  for (const figure of Object.values(episode.steps.figures)) figure.values = stretched(figure.values);
  episode.options = Array.from({ length: 3 }, (_, k) => episode.options.map((option) => ({ ...option, name: `${option.name}-${k}`, probability: stretched(option.probability) }))).flat();
  episode.steps.decided_s = episode.steps.done_s = Array.from({ length: long }, (_, k) => 0.2 * k);
  episode.frames.object = episode.frames.object.map((value, i) => (i % 7 === 0 ? 1e6 : value));
  write("long.html", episode);
  await check(file("long.html"), "a long episode, far away", play);
}

try {
  const asked = process.argv[3], parts = [episodes, robots, files, studies, forged];
  if (existsSync(fileURLToPath(new URL("../dist/page/cocarry.wasm", import.meta.url)))) parts.push(simulated);
  else console.log("skipped: hostile names on the page that runs the simulator; build its module with: crates/web/build");
  for (const part of parts.filter(({ name }) => !asked || name === asked)) {
    await part();
    console.log(`hostile ${part.name}: ${opened} pages and pictures so far, no script ran`);
  }
} finally {
  await browser.close();
  rmSync(folder, { recursive: true, force: true });
}
