// Opens pages of `cocarry robot check --render` in Chromium: node test/robot.mjs PROGRAM. Checks postures, joints, shapes,
// keys and names; writes screenshots of both schemes and of a phone.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const program = process.argv[2];
const repository = fileURLToPath(new URL("../..", import.meta.url));
const screenshots = fileURLToPath(new URL("screenshots", import.meta.url));
const folder = mkdtempSync(join(tmpdir(), "robot-"));
const cocarry = (...words) => execFileSync(program, words, { cwd: repository, encoding: "utf8", maxBuffer: 1 << 28 });
mkdirSync(screenshots, { recursive: true });
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});

async function open(page, hash, { width = 1280, height = 800, scheme = "light" } = {}) {
  const tab = await browser.newPage({ viewport: { width, height }, colorScheme: scheme });
  const faults = [], asked = [];
  tab.on("pageerror", (error) => faults.push(error.stack));
  tab.on("console", (message) => message.type() === "error" && faults.push(message.text()));
  tab.on("request", (request) => asked.push(request.url()));
  await tab.goto(`${pathToFileURL(page)}#${hash}`);
  await tab.waitForFunction(() => document.body.dataset.drawn);
  await tab.waitForTimeout(300);
  assert.deepEqual(asked.filter((url) => !/^(file|data):/.test(url)), [], "network requests");
  return { tab, faults };
}

// The share of a picture's points that differ from the first one.
async function drawn(tab) {
  const bytes = (await tab.locator("#view").screenshot()).toString("base64");
  return tab.evaluate(async (bytes) => {
    const image = new Image();
    image.src = `data:image/png;base64,${bytes}`;
    await image.decode();
    const canvas = Object.assign(document.createElement("canvas"), { width: image.width, height: image.height });
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0);
    return [...context.getImageData(0, 0, image.width, image.height).data].filter((_, i) => i % 4 === 0);
  }, bytes);
}

const differ = (a, b) => a.filter((value, i) => Math.abs(value - b[i]) > 12).length / a.length;

async function check(name) {
  const page = join(folder, `${name}.html`), file = `assets/robots/${name}.toml`;
  const said = cocarry("robot", "check", file, "--render", page);
  assert.match(said, /wrote .*html/);
  const checked = JSON.parse(cocarry("robot", "check", file, "--json"));
  const { tab, faults } = await open(page, "play=0");
  assert.equal(await tab.locator("#title").textContent(), checked.name);
  assert.equal(await tab.title(), checked.name);

  // every posture has its place on the slider, and the joints are there
  const postures = tab.locator("#events button");
  assert.equal(await postures.count(), checked.postures.length);
  for (const [i, posture] of checked.postures.entries()) {
    await postures.nth(i).click();
    assert.equal(await tab.locator("#caption").textContent(), `Posture ${posture.name}`);
    for (const joint of checked.joints) {
      const turns = joint.motion === "revolute", at = posture.joints[joint.name];
      const shown = Number.parseFloat(await tab.locator(`output[data-joint="${joint.name}"]`).textContent());
      assert.ok(Math.abs(shown - (turns ? (at * 180) / Math.PI : at)) < (turns ? 0.051 : 0.00051), `${posture.name}: ${joint.name} ${shown}`);
    }
  }
  // keys: from posture to posture, shapes
  await tab.keyboard.press("Home");
  const first = await drawn(tab);
  assert.ok(new Set(first).size > 50, `${name}: a picture`);
  await tab.keyboard.press("ArrowRight");
  if (checked.postures.length > 1) {
    assert.equal(await tab.locator("#caption").textContent(), `Posture ${checked.postures[1].name}`);
    assert.ok(differ(first, await drawn(tab)) > 0.005, `${name}: postures differ`);
  }
  await tab.keyboard.press("Home");
  await tab.keyboard.press("c");
  assert.equal(await tab.locator('[data-shapes="collisions"]').getAttribute("aria-pressed"), "true");
  await tab.waitForTimeout(300);
  assert.ok(differ(first, await drawn(tab)) > 0.002, `${name}: shapes differ`);
  await tab.locator('[data-shapes="visuals"]').click();
  assert.equal(await tab.locator('[data-shapes="collisions"]').getAttribute("aria-pressed"), "false");
  const nameless = await tab.evaluate(() => [...document.querySelectorAll("button, input, select, canvas")]
    .filter((e) => !e.getAttribute("aria-label") && !e.textContent.trim()).map((e) => e.outerHTML));
  assert.deepEqual(nameless, []);
  assert.deepEqual(faults, []);
  await tab.close();
  return page;
}

try {
  for (const name of ["carrier", "omni-carrier", "porter", "shuttle"]) {
    const page = await check(name);
    for (const [kind, hash, options] of [
      ["", "", {}], ["-dark", "&camera=follow&shapes=collisions", { scheme: "dark" }], ["-phone", "", { width: 390, height: 844 }],
    ]) {
      const { tab, faults } = await open(page, `play=0${hash}`, options);
      assert.ok(await tab.evaluate(() => document.documentElement.scrollWidth <= innerWidth), `${name}${kind}: nothing is wider than the screen`);
      await tab.screenshot({ path: join(screenshots, `robot-${name}${kind}.png`) });
      assert.deepEqual(faults, []);
      await tab.close();
    }
  }
  console.log(`robots: 4 pages with their postures, joints and shapes; screenshots in ${screenshots}`);
} finally {
  await browser.close();
  rmSync(folder, { recursive: true });
}
