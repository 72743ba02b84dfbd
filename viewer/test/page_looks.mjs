// How the page looks and behaves for every reader, in Chromium: node test/page_looks.mjs. Rules of accessibility (axe-core),
// controls by keyboard, what happens where something is missing or not as it should be, and screenshots of every width.
import assert from "node:assert/strict";
import { mkdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { clock, launch, open, over, serve, text } from "./serving.mjs";

const AXE = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const screenshots = fileURLToPath(new URL("screenshots", import.meta.url));
mkdirSync(screenshots, { recursive: true });
const server = await serve();
const browser = await launch();
const opened = (hash, options) => open(browser, server.address, hash, options);

// No rule of axe-core is broken.
async function rules(tab, name) {
  // the page's policy lets no script in, but the tester's
  await tab.evaluate(`(() => { const module = undefined, exports = undefined; ${AXE} })()`);
  const { violations } = await tab.evaluate(() => globalThis.axe.run(document, { resultTypes: ["violations"] }));
  const words = violations.map(({ id, nodes }) => `${id}: ${nodes.map(({ html, failureSummary }) => `${html} (${failureSummary})`).join("; ")}`);
  assert.deepEqual(words, [], `${name}: axe-core`);
}

// Every control that is shown and enabled gets the focus by Tab, one after the other, and shows it.
async function keyboard(tab, name) {
  const wanted = await tab.evaluate(() => {
    const all = [...document.querySelectorAll("button, input, select, summary, textarea, canvas[tabindex], pre[tabindex], [role=button][tabindex]")];
    const shown = all.filter((e) => !e.disabled && e.type !== "file" && e.checkVisibility({ visibilityProperty: true }));
    // of radio buttons, the chosen one
    const reached = shown.filter((e) => e.type !== "radio" || e.checked);
    reached.forEach((e, i) => (e.dataset.wanted = i));
    return reached.length;
  });
  const met = new Set();
  await tab.evaluate(() => document.activeElement?.blur());
  for (let i = 0; i < wanted + 40 && met.size < wanted; i++) {
    await tab.keyboard.press("Tab");
    const found = await tab.evaluate(() => document.activeElement?.dataset?.wanted);
    if (found !== undefined) met.add(found);
  }
  const missed = await tab.evaluate((met) => [...document.querySelectorAll("[data-wanted]")].filter((e) => !met.includes(e.dataset.wanted)).map((e) => e.outerHTML.slice(0, 120)), [...met]);
  assert.deepEqual(missed, [], `${name}: controls that Tab does not reach`);
  await tab.evaluate(() => document.querySelectorAll("[data-wanted]").forEach((e) => delete e.dataset.wanted));
  return wanted;
}

// Nothing is wider than the screen, no button lies over another, and what is written fits into its button.
async function fits(tab, name) {
  assert.ok(await tab.evaluate(() => document.documentElement.scrollWidth <= innerWidth), `${name}: nothing is wider than the screen`);
  const covered = await tab.evaluate(() => {
    const shown = [...document.querySelectorAll("#cameras button, #tools button, #carry button, #leader, #caption, #transport button, #transport select, header button, header summary, #warning button")].filter((e) => e.checkVisibility());
    const boxes = shown.map((e) => [e, e.getBoundingClientRect()]);
    const faults = [];
    boxes.forEach(([a, p], i) => boxes.slice(0, i).forEach(([b, q]) => {
      if (p.left < q.right - 1 && q.left < p.right - 1 && p.top < q.bottom - 1 && q.top < p.bottom - 1) faults.push(`${a.id || a.textContent} over ${b.id || b.textContent}`);
    }));
    for (const [e] of boxes) if (e.scrollWidth > e.clientWidth + 1 || e.clientHeight > 60) faults.push(`${e.id || e.textContent} is cut`);
    for (const e of document.querySelectorAll(".meter .name")) if (e.scrollWidth > e.clientWidth) faults.push(`${e.textContent} is cut`);
    return faults;
  });
  assert.deepEqual(covered, [], name);
}

async function readers() {
  let count = 0;
  for (const [name, hash, options] of [
    ["watching", "play=0", {}], ["watching, dark", "play=0", { scheme: "dark" }],
    ["map", "play=0&camera=map", {}], ["map, dark", "play=0&camera=map", { scheme: "dark" }],
    ["carrying", "play=0&carry=1&period=0.05", {}], ["phone", "play=0", { width: 390, height: 844 }], ["tablet, dark", "play=0&belief=learn", { width: 820, height: 1180, scheme: "dark" }],
  ]) {
    const { tab, close } = await opened(hash, options);
    await rules(tab, name);
    count += await keyboard(tab, name);
    await close();
  }
  // the report, at the end of an episode
  const { tab, close } = await opened("plant=point&play=0");
  await tab.locator("#speed").selectOption("8");
  await tab.locator("#play").click();
  await over(tab);
  assert.match(await text(tab, "#said"), /Arrived at B after/, "a screen reader hears the end");
  await rules(tab, "report");
  await tab.locator("#download summary").click();
  await rules(tab, "download");
  await close();
  // who wants less motion gets a still picture
  const still = await opened("", { motion: "reduce" });
  await still.tab.waitForTimeout(500);
  assert.equal(await clock(still.tab), 0, "nothing moves by itself");
  await still.close();
  console.log(`readers: 9 states without a broken rule of axe-core, ${count} controls reached by Tab`);
}

async function missing() {
  // no WebGL: the map
  const flat = await opened("play=0", { waits: false, before: () => {
    const real = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
      return kind.startsWith("webgl") ? null : real.call(this, kind, ...rest);
    };
  } });
  await flat.tab.waitForSelector("#map .wall");
  assert.match(await text(flat.tab, "#warning-text"), /three dimensions.*map/);
  await flat.tab.locator("#step").click();
  assert.equal(await clock(flat.tab), 0.2, "the simulation runs without it");
  await rules(flat.tab, "without WebGL");
  flat.faults.length = 0;
  await flat.close();
  // no WebAssembly: a sentence
  const none = await opened("", { waits: false, before: () => delete globalThis.WebAssembly });
  await none.tab.waitForSelector("#failure:not([hidden])");
  assert.match(await text(none.tab, "#failure"), /no WebAssembly/);
  await none.close();
  // no module: a sentence
  const lacking = await open(browser, server.address, "", { waits: false, before: () => {
    const real = globalThis.fetch;
    globalThis.fetch = (name, ...rest) => real(String(name).endsWith(".wasm") ? "missing.wasm" : name, ...rest);
  } });
  await lacking.tab.waitForSelector("#failure:not([hidden])");
  assert.match(await text(lacking.tab, "#failure"), /could not be loaded.*404/);
  lacking.faults.length = 0;
  await lacking.close();
  // a lost context: the map, and the picture again
  const lost = await opened("play=0");
  await lost.tab.evaluate(() => {
    globalThis.loss = document.getElementById("view").getContext("webgl2").getExtension("WEBGL_lose_context");
    globalThis.loss.loseContext();
  });
  await lost.tab.waitForSelector("#map:not([hidden])");
  assert.match(await text(lost.tab, "#warning-text"), /took the three-dimensional picture away/);
  await lost.tab.locator("#step").click();
  await lost.tab.evaluate(() => globalThis.loss.restoreContext());
  await lost.tab.waitForSelector("#view:not([hidden])");
  lost.faults.length = 0;
  await lost.close();
  // a broken link: a sentence, and the rest of it holds
  const broken = await opened("play=0&alpha=much&eta=15&file=xyz");
  assert.match(await text(broken.tab, "#warning-text"), /not whole: alpha=much: expected a number.*file=xyz/);
  assert.equal(await text(broken.tab, '[data-slider="eta"] output'), "15");
  await broken.tab.locator("#dismiss").click();
  assert.ok(await broken.tab.locator("#warning").isHidden());
  await broken.close();
  console.log("missing: no WebGL, no WebAssembly, no module, a lost context, a broken link: a sentence, and what can go on does");
}

async function pictures() {
  const sizes = { 390: 844, 768: 1024, 1024: 768, 1440: 900 };
  for (const [width, height] of Object.entries(sizes)) {
    for (const scheme of ["light", "dark"]) {
      for (const [name, hash] of [["follow", ""], ["map", "camera=map&"], ["carry", "carry=1&period=0.05&camera=shoulder&"], ["warning", "file=xyz&alpha=much&"]]) {
        if (name !== "follow" && (scheme === "dark" || !["390", "1440"].includes(width))) continue;
        const { tab, close } = await opened(`${hash}play=0`, { width: Number(width), height, scheme });
        for (let i = 0; i < 22; i++) await tab.locator("#step").click();
        await tab.waitForTimeout(700);
        const title = `page-${width}-${scheme}-${name}`;
        await fits(tab, title);
        await tab.screenshot({ path: join(screenshots, `${title}.png`) });
        if (width === "390") await tab.screenshot({ path: join(screenshots, `${title}-all.png`), fullPage: true });
        await close();
      }
    }
  }
  for (const [name, width, height] of [["report", 1440, 900], ["report-phone", 390, 844]]) {
    const { tab, close } = await opened("plant=kinematic&play=0&belief=learn", { width, height });
    await tab.locator("#speed").selectOption("8");
    await tab.locator("#play").click();
    await over(tab);
    await tab.waitForTimeout(500);
    await tab.screenshot({ path: join(screenshots, `page-${name}.png`), fullPage: width < 800 });
    await close();
  }
  console.log(`pictures: in ${screenshots}`);
}

try {
  const only = process.argv[2];
  for (const check of [readers, missing, pictures]) if (!only || check.name === only) await check();
} finally {
  await browser.close();
  server.close();
}
