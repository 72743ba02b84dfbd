// The built site in Chromium: every page opens without an error and asks no other host, live examples play, axe-core finds
// nothing: node test/site.mjs FOLDER. Links are lychee's (site/check).
import assert from "node:assert/strict";
import { mkdirSync, readFileSync, readdirSync } from "node:fs";
import { createRequire } from "node:module";
import { join, resolve } from "node:path";
import { inflateRawSync } from "node:zlib";
import { fileURLToPath } from "node:url";
import { launch, serve } from "./serving.mjs";

const folder = `${resolve(process.argv[2])}/`;
const AXE = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const screenshots = fileURLToPath(new URL("../../site/screenshots", import.meta.url));
mkdirSync(screenshots, { recursive: true });
// How many pages are open at a time.
const TABS = 3;
// The chapters with live examples, and how many.
const LIVE = { "quick-start.html": 2, "learning.html": 1, "page.html": 1, "gallery/porter.html": 1, "gallery/shuttle.html": 1 };
const PHONE = { width: 390, height: 844 }, DESKTOP = { width: 1280, height: 800 };

const server = await serve(folder);
const browser = await launch();

// A browser of its own settings, whose tabs note every fault.
async function context(options = {}) {
  const made = await browser.newContext({ viewport: DESKTOP, ...options });
  // asked by the browser itself, where a page names no icon
  await made.route("**/favicon.ico", (route) => route.fulfill({ status: 204 }));
  const open = async (name) => {
    const tab = await made.newPage(), faults = [];
    tab.on("pageerror", (error) => faults.push(error.stack));
    tab.on("console", (message) => message.type() === "error" && faults.push(message.text()));
    tab.on("response", (response) => response.status() >= 400 && faults.push(`${response.status()} ${response.url()}`));
    tab.on("request", (request) => {
      const url = request.url();
      if (!url.startsWith(server.address) && !/^(data|blob|about):/.test(url)) faults.push(`asked ${url}`);
    });
    await tab.goto(server.address + name);
    const close = async () => {
      assert.deepEqual(faults, [], name);
      await tab.close();
    };
    return { tab, close };
  };
  return { open, close: () => made.close() };
}

async function everyPage() {
  // of the Rust reference, the pages of modules: rustdoc writes all others by the same template, and they are thousands
  const isPage = (name) => name.endsWith(".html") && (!name.startsWith("rust/") || name.endsWith("/index.html")) && !/http-equiv="refresh"/i.test(readFileSync(folder + name, "utf8"));
  const names = readdirSync(folder, { recursive: true }).filter(isPage);
  const { open, close } = await context();
  const left = [...names];
  const next = async () => {
    for (let name = left.pop(); name; name = left.pop()) {
      const { tab, close } = await open(name);
      assert.ok((await tab.locator("body").innerText()).trim(), `${name}: nothing is shown`);
      await close();
    }
  };
  await Promise.all(Array.from({ length: TABS }, next));
  await close();
  console.log(`every page: ${names.length} without an error, none asks another host`);
}

async function examples() {
  let count = 0;
  for (const [name, size, scheme] of Object.keys(LIVE).flatMap((name) => [[name, DESKTOP, "light"], [name, PHONE, "dark"]])) {
    const { open, close } = await context({ viewport: size, colorScheme: scheme });
    const { tab, close: done } = await open(name);
    const buttons = tab.locator("button.live"), title = `${name.replace(/\W/g, "-")}-${size.width}`;
    assert.equal(await buttons.count(), LIVE[name], `${name}: live examples`);
    assert.equal(await tab.locator("iframe").count(), 0, "nothing is loaded before a click");
    for (let i = 0; i < LIVE[name]; i++) {
      const still = buttons.nth(i).locator("xpath=ancestor::p/preceding-sibling::p[1]");
      assert.ok(await still.locator("img").first().isVisible());
      await buttons.nth(i).click();
      const page = tab.frameLocator("iframe.live"), clock = page.locator("#clock");
      await tab.waitForFunction(() => Number.parseFloat(document.querySelector("iframe.live").contentDocument?.getElementById("clock")?.textContent) > 0.3, null, { timeout: 120e3 });
      assert.ok(await still.isHidden(), `${name}: the frame takes the picture's place`);
      assert.ok(await page.locator("#warning").isHidden(), `${name}: ${await page.locator("#warning").textContent()}`);
      assert.ok(await page.locator("#setup").isHidden() && await page.locator("#play").isVisible());
      const { scroll, width } = await page.locator("html").evaluate((page) => ({ scroll: page.scrollWidth, width: page.clientWidth }));
      assert.ok(scroll <= width, `${name}: the frame is wider than its place`);
      await page.locator("#play").click();
      const before = await clock.textContent();
      // a step goes to the end of a period, which can be less than what the clock shows
      for (let clicks = 0; clicks < 2; clicks++) await page.locator("#step").click();
      assert.notEqual(await clock.textContent(), before);
      await tab.locator("iframe.live").screenshot({ path: join(screenshots, `${title}-live-${i}.png`) });
      await buttons.nth(i).click();
      assert.ok(await still.isVisible() && (await tab.locator("iframe").count()) === 0, `${name}: stopped`);
      count++;
    }
    assert.ok(await tab.evaluate(() => document.documentElement.scrollWidth <= innerWidth), `${name}: nothing is wider than the screen`);
    await tab.screenshot({ path: join(screenshots, `${title}.png`) });
    await done();
    await close();
  }
  console.log(`live examples: ${count} started by a click, played and stopped, at 1280 and 390 px`);
}

// The kitchen that an example packs is the file of its page.
async function kitchen() {
  const page = readFileSync(new URL("../../book/src/quick-start.md", import.meta.url), "utf8");
  const [, packed] = /&file=([\w-]+)/.exec(page), [, file] = /```toml kitchen\.toml\n([^]*?)```/.exec(page);
  assert.equal(inflateRawSync(Buffer.from(packed, "base64url")).toString(), file);
}

async function withoutScripts() {
  const { open, close } = await context({ javaScriptEnabled: false });
  for (const [name, count] of Object.entries(LIVE)) {
    const { tab, close: done } = await open(name);
    const links = tab.locator('main a[href*="page.html#"]').filter({ hasText: "Run it" });
    assert.equal(await links.count(), count);
    for (let i = 0; i < count; i++) assert.ok(await links.nth(i).isVisible());
    assert.ok(await tab.locator("main img").first().isVisible());
    await done();
  }
  await close();
  console.log("without scripts: pictures and links");
}

async function rules() {
  for (const [size, scheme] of [[DESKTOP, "light"], [DESKTOP, "dark"], [PHONE, "light"], [PHONE, "dark"]]) {
    const { open, close } = await context({ viewport: size, colorScheme: scheme });
    for (const name of ["index.html", "model.html", "page.html", "gallery/porter.html", "commands.html", "demo/index.html#embed=1&play=0"]) {
      const { tab, close: done } = await open(name);
      if (name.startsWith("demo")) await tab.waitForFunction(() => document.body.dataset.drawn);
      await tab.evaluate(`(() => { const module = undefined, exports = undefined; ${AXE} })()`);
      // mdBook's bar and its table of contents are mdBook's
      const { violations } = await tab.evaluate(() => globalThis.axe.run({ exclude: ["#mdbook-menu-bar", "#mdbook-sidebar"] }, { resultTypes: ["violations"] }));
      const words = violations.map(({ id, nodes }) => `${id}: ${nodes.map(({ html, failureSummary }) => `${html} (${failureSummary})`).join("; ")}`);
      assert.deepEqual(words, [], `${name}, ${scheme}: axe-core`);
      await done();
    }
    await close();
  }
  console.log("axe-core: nothing on 6 pages, light and dark, at 1280 and 390 px");
}

try {
  const only = process.argv[3];
  for (const check of [kitchen, examples, withoutScripts, rules, everyPage]) if (!only || check.name === only) await check();
} finally {
  await browser.close();
  server.close();
}
