// For tests of the page in Chromium: its folder on the loopback, the browser, and tabs that note every fault.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { createServer } from "node:http";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import { chromium } from "playwright-core";

const FOLDER = fileURLToPath(new URL("../dist/page/", import.meta.url));
const TYPES = { html: "text/html", js: "text/javascript", css: "text/css", svg: "image/svg+xml", wasm: "application/wasm", txt: "text/plain" };

// Serves the page's folder, or another, compressed as web hosts do; `sent` has the bytes that went for every file.
export async function serve(folder = FOLDER) {
  const sent = new Map(), compressed = new Map();
  const server = createServer(async (request, answer) => {
    const name = new URL(request.url, "http://127.0.0.1").pathname.replace(/^\/$/, "/index.html").slice(1);
    try {
      if (!compressed.has(name)) compressed.set(name, gzipSync(await readFile(folder + name)));
      const bytes = compressed.get(name);
      sent.set(name, bytes.length);
      answer.writeHead(200, { "content-type": TYPES[name.split(".").pop()] ?? "application/octet-stream", "content-encoding": "gzip" }).end(bytes);
    } catch {
      answer.writeHead(404).end();
    }
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  return { address: `http://127.0.0.1:${server.address().port}/`, sent, close: () => server.close() };
}

export const launch = () => chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});

// Opens the page. `before` runs in the page before its scripts do.
export async function open(browser, address, hash = "", { width = 1280, height = 800, scheme = "light", motion = "no-preference", touch = false, before, waits = true } = {}) {
  const context = await browser.newContext({
    viewport: { width, height }, colorScheme: scheme, reducedMotion: motion, hasTouch: touch, acceptDownloads: true,
    permissions: ["clipboard-read", "clipboard-write"],
  });
  const tab = await context.newPage();
  const faults = [];
  tab.on("pageerror", (error) => faults.push(error.stack));
  tab.on("console", (message) => message.type() === "error" && faults.push(message.text()));
  tab.on("request", (request) => {
    const url = request.url();
    if (!url.startsWith(address) && !/^(data|blob):/.test(url)) faults.push(`asked ${url}`);
  });
  if (before) await tab.addInitScript(before);
  await tab.goto(`${address}#${hash}`);
  if (waits) await tab.waitForFunction(() => document.body.dataset.drawn, null, { timeout: 60e3 });
  const close = async () => {
    assert.deepEqual(faults, []);
    await context.close();
  };
  return { tab, faults, close };
}

export const text = (tab, selector) => tab.locator(selector).textContent();
export const clock = async (tab) => Number.parseFloat(await text(tab, "#clock"));

// Waits until the episode is over; its digest.
export async function over(tab, timeout = 240e3) {
  await tab.waitForFunction(() => document.body.dataset.digest, null, { timeout });
  return tab.evaluate(() => document.body.dataset.digest);
}

// Downloads one of the files of the menu, and closes the menu, which lies over the stage; its text.
export async function download(tab, kind) {
  await tab.locator("#download summary").click();
  const [file] = await Promise.all([tab.waitForEvent("download"), tab.locator(`#download [data-file="${kind}"]`).click()]);
  await tab.keyboard.press("Escape");
  await tab.waitForSelector("#download:not([open])");
  return readFile(await file.path(), "utf8");
}
