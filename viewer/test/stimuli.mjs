// Opens the pages of `cocarry stimuli` in Chromium: node test/stimuli.mjs PROGRAM. Participants see the scene and its time,
// and nothing of what the robot believes or the human prefers, neither on the page nor in its source.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { launch } from "./serving.mjs";

const program = process.argv[2];
const screenshots = fileURLToPath(new URL("screenshots", import.meta.url));
const folder = mkdtempSync(join(tmpdir(), "stimuli-"));
mkdirSync(screenshots, { recursive: true });
const browser = await launch();
const world = fileURLToPath(new URL("../../worlds/environment-1.toml", import.meta.url));
const write = (...words) => execFileSync(program, ["stimuli", world, "--episodes", "--plant", "kinematic", "--width", "320", "-o", folder, ...words]);

async function look(option, { width, height, scheme }) {
  const page = join(folder, `environment-1-option-${option}.html`);
  const tab = await browser.newPage({ viewport: { width, height }, colorScheme: scheme });
  const faults = [];
  tab.on("pageerror", (error) => faults.push(error.stack));
  await tab.goto(`${pathToFileURL(page)}#t=12&play=0`);
  await tab.waitForFunction(() => document.body.dataset.drawn);
  await tab.waitForTimeout(300);
  await tab.screenshot({ path: join(screenshots, `stimulus-${option}-${width}-${scheme}.png`) });
  const seen = await tab.evaluate(() => document.body.innerText);
  // what is played ends where the walk does
  await tab.keyboard.press("End");
  const [at, end] = (await tab.locator("#clock").textContent()).split(" / ").map(Number.parseFloat);
  assert.equal(at, end);
  await tab.close();
  assert.deepEqual(faults, []);
  return { seen, source: readFileSync(page, "utf8") };
}

write();
const secrets = ["preferred", "leads on", "risk", "α", "φ", "stubborn", "ξ"];
for (const look_at of [{ width: 1024, height: 700, scheme: "light" }, { width: 390, height: 800, scheme: "dark" }]) {
  const { seen, source } = await look(2, look_at);
  assert.match(seen, /Environment 1/);
  for (const secret of secrets) assert.ok(!seen.includes(secret), `${secret}: ${seen}`);
  const { steps, events, options, ahead, facts, take_over: scenario, world: drawn } = JSON.parse(/id="episode">(.*?)<\/script>/s.exec(source)[1]);
  assert.deepEqual([steps.figures, events, options, ahead, facts, scenario, drawn.openings], [{}, [], [], [], { about: "" }, null, []]);
}
write("--show", "openings,options", "--overwrite");
const { seen, source } = await look(3, { width: 1024, height: 700, scheme: "light" });
for (const name of ["ξ1", "option 1", "option 4"]) assert.ok(seen.replace(/\s*\n\s*/g, "").includes(name), `${name}: ${seen}`);
assert.ok(!/"risk"|"width_m"/.test(source) && !seen.includes("risk"));
await browser.close();
rmSync(folder, { recursive: true });
console.log("stimuli: scene and time alone; names where they are asked for");
