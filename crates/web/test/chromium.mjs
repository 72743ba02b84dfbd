// Runs the same episodes as node.mjs in Chromium, from a server of `cocarry demo`, and compares every digest with the
// logs that node.mjs left in FOLDER. node chromium.mjs MODULE.wasm PROGRAM FOLDER
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { copyFileSync, readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";

const [, , file, program, folder] = process.argv;
const require = createRequire(new URL("../../../viewer/package.json", import.meta.url));
const { chromium } = require("playwright-core");
copyFileSync(file, join(folder, "cocarry.wasm"));
copyFileSync(join(folder, "episodes.mjs"), join(folder, "episodes.js"));
writeFileSync(join(folder, "index.html"), "<!doctype html><title>bits</title>");

const server = spawn(program, ["demo", "--page", folder, "--port", "0", "--no-browser"], { stdio: ["ignore", "pipe", "inherit"] });
const address = await new Promise((resolve, reject) => {
  let said = "";
  server.stdout.on("data", (part) => {
    said += part;
    const found = said.match(/http:\/\/127\.0\.0\.1:\d+\//);
    if (found) resolve(found[0]);
  });
  server.on("exit", (code) => reject(new Error(`cocarry demo ended with ${code}: ${said}`)));
});
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM, args: ["--no-sandbox"] });
try {
  const tab = await browser.newPage();
  const faults = [];
  tab.on("pageerror", (error) => faults.push(error.stack));
  await tab.goto(address);
  const logs = await tab.evaluate(async () => {
    const [{ load }, { EPISODES, run }] = await Promise.all([import("./cocarry.js"), import("./episodes.js")]);
    const module = await load(fetch("cocarry.wasm"));
    return EPISODES.map((episode) => run(module, episode).log);
  });
  assert.deepEqual(faults, []);
  for (const [number, log] of logs.entries()) {
    const there = JSON.parse(readFileSync(join(folder, `${number}.json`)));
    assert.deepEqual(log, there, `episode ${number} differs in the browser`);
  }
  console.log(`${logs.length} episodes in ${browser.version()}: every digest equal`);
} finally {
  await browser.close();
  server.removeAllListeners("exit");
  const ended = new Promise((resolve) => server.once("exit", resolve));
  server.kill("SIGINT");
  await Promise.race([ended, new Promise((resolve) => setTimeout(resolve, 5000))]);
  assert.equal(server.exitCode, 0, "Ctrl-C ends cocarry demo cleanly");
}
