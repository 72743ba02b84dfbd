// The administrator's page of `cocarry study serve` and the page for the ethics board, in Chromium: node test/admin.mjs PROGRAM.
// Both have no script, keep the rules of axe-core, fit a phone, and show hostile answers as text.
import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { execFileSync, spawn, spawnSync } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { fileURLToPath, pathToFileURL } from "node:url";
import { launch } from "./serving.mjs";

const program = process.argv[2];
if (spawnSync(program, ["study", "check", "none"]).stderr.toString().includes("feature `people`")) {
  console.log("skipped: the administrator's page; build the program with --features people");
  process.exit(0);
}
const AXE = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const screenshots = fileURLToPath(new URL("screenshots", import.meta.url));
const folder = mkdtempSync(join(tmpdir(), "admin-"));
mkdirSync(screenshots, { recursive: true });
const cocarry = (...words) => execFileSync(program, words, { cwd: folder, encoding: "utf8" });
const sha256 = (text) => createHash("sha256").update(text).digest("hex");
const HOSTILE = '<img src=x onerror="document.title=1"><script>document.title=2</script>';

cocarry("study", "new", ".");
const server = spawn(program, ["study", "serve", "study.toml", "--port", "0"], { cwd: folder, stdio: ["ignore", "pipe", "inherit"] });
const said = {};
for await (const line of createInterface({ input: server.stdout })) {
  const [, name, address] = /^(the study is at|for you alone:) (http:\S+)$/.exec(line) ?? [];
  if (name) said[name] = address;
  if (Object.keys(said).length === 2) break;
}
const { "the study is at": study, "for you alone:": admin } = said;
const { digest } = await (await fetch(`${study}study.json`)).json();

// A person who answers so many pages, and with script.
async function answers(person, pages, finishes) {
  const key = sha256(person), session = { "x-session-key": key };
  const ask = async (method, path, headers, value) => {
    const answer = await fetch(study + path, { method, headers, body: typeof value === "string" ? value : JSON.stringify(value) });
    assert.ok(answer.ok, await answer.text());
  };
  await ask("POST", "api/session", {}, { key, platform_ids: [["PROLIFIC_PID", `platform-${person}`]], study: digest });
  let whole = "";
  for (let page = 0; page < pages; page++) {
    const data = page ? { task: "scale", name: HOSTILE, answers: [[HOSTILE, 3]] } : { task: "consent", version: HOSTILE, order: 1 };
    const body = JSON.stringify([{ kind: "done", data: page === 2 ? { task: HOSTILE } : data }]);
    await ask("PUT", `api/chunks/${page}/0`, { ...session, "x-sha256": sha256(body) }, body);
    whole += `${page} 0 ${sha256(body)}\n`;
  }
  if (finishes) await ask("POST", "api/finish", session, { digest: sha256(whole) });
}
for (const [at, person] of ["anna", "ben", "clara", "dora", "emil"].entries()) await answers(person, 3 + 2 * at, at > 2);

const browser = await launch();
async function looked(address, name, width, scheme) {
  const context = await browser.newContext({ viewport: { width, height: 800 }, colorScheme: scheme, acceptDownloads: true });
  const tab = await context.newPage();
  const faults = [];
  tab.on("console", (message) => message.type() === "error" && faults.push(message.text()));
  await tab.goto(address);
  await tab.waitForSelector("h1");
  await tab.evaluate(AXE);
  const { violations } = await tab.evaluate(() => globalThis.axe.run(document, { resultTypes: ["violations"] }));
  assert.deepEqual(violations.map(({ id, nodes }) => `${id}: ${nodes[0].html}`), [], `${name}: axe-core`);
  assert.ok(await tab.evaluate(() => document.documentElement.scrollWidth <= innerWidth), `${name}: too wide`);
  assert.equal(await tab.locator("script, [onerror]").count(), 0);
  await tab.screenshot({ path: join(screenshots, `${name}-${width}-${scheme}.png`), fullPage: true });
  return { tab, context, faults };
}

try {
  for (const width of [390, 1024]) {
    for (const scheme of ["light", "dark"]) {
      const { tab, context, faults } = await looked(admin, "study-admin", width, scheme);
      assert.match(await tab.locator("dl").textContent(), /Begun5 of 20\s+Finished2\s+Answering3/);
      assert.equal(await tab.title(), "Carrying together");
      assert.ok((await tab.locator("body").textContent()).includes(HOSTILE), "the answer is shown as text");
      assert.ok(!(await tab.content()).includes("platform-anna"));
      const [file] = await Promise.all([tab.waitForEvent("download"), tab.locator("text=participants.csv").first().click()]);
      cocarry("study", "collect", "study.toml", "-o", "answers", "--overwrite");
      assert.equal(readFileSync(await file.path(), "utf8"), readFileSync(join(folder, "answers/participants.csv"), "utf8"));
      assert.deepEqual(faults, []);
      await context.close();
    }
  }
  cocarry("study", "ethics", "study.toml");
  for (const width of [390, 1024]) {
    const { context, faults } = await looked(pathToFileURL(join(folder, "study.ethics.html")).href, "study-ethics", width, width === 390 ? "dark" : "light");
    assert.deepEqual(faults, []);
    await context.close();
  }
  console.log("administrator's page and page for the ethics board: no script, no fault of axe-core, from 390 px, light and dark; the tables of collect");
} finally {
  await browser.close();
  server.kill("SIGKILL");
  rmSync(folder, { recursive: true });
}
