// Runs episodes of the module in Node, and lets the program run their logs again: every digest, one a second, must be
// the same. node node.mjs MODULE.wasm PROGRAM FOLDER; the logs stay in FOLDER.
import assert from "node:assert/strict";
import { execFileSync, spawnSync } from "node:child_process";
import { copyFileSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";

const [, , file, program, folder] = process.argv;
for (const part of ["cocarry.js", "test/episodes.mjs"]) {
  copyFileSync(new URL(`../${part}`, import.meta.url), join(folder, part.split("/").pop()));
}
writeFileSync(join(folder, "package.json"), '{ "type": "module" }');
const { load, Refused } = await import(join(folder, "cocarry.js"));
const { EPISODES, run } = await import(join(folder, "episodes.mjs"));

const compiled = new WebAssembly.Module(readFileSync(file));
assert.deepEqual(WebAssembly.Module.imports(compiled), [], "the module needs a host");
const module = await load(compiled);

// the arithmetic is the program's, but for the principal inertias, for which parry takes the system's functions there
const { stamp, parts: { "principal inertias": inertias, ...parts } } = module.arithmetic();
assert.deepEqual(parts, JSON.parse(readFileSync(new URL("arithmetic.json", import.meta.url))));
console.log(`arithmetic ${stamp}: ${Object.entries(parts).map(([name, digest]) => `${name} ${digest}`).join(", ")} as in the program; principal inertias ${inertias}`);

let steps = 0, milliseconds = 0;
for (const [number, episode] of EPISODES.entries()) {
  const begun = performance.now();
  const { log, summary } = run(module, episode);
  milliseconds += performance.now() - begun;
  steps += log.steps;
  const path = join(folder, `${number}.json`);
  writeFileSync(path, JSON.stringify(log));
  assert.ok(log.digests.length > 1, `${episode[0]}: no digests`);
  assert.equal(Boolean(log.decisions), episode[2] !== undefined, `${episode[0]}: decisions`);
  const said = execFileSync(program, ["replay", path], { encoding: "utf8" });
  assert.match(said, new RegExp(`identical: ${log.digests.length} digest`), said);
  if (!episode[2]) {
    // the command line gives the same figures
    const { command, files } = module.scenario(episode[1]);
    assert.deepEqual(files, []);
    if (!command.includes("export")) {
      const words = [...command.matchAll(/'([^']*)'|(\S+)/g)].map(([, quoted, plain]) => quoted ?? plain);
      const shown = spawnSync(program, [...words.slice(1), "--json"], { encoding: "utf8", maxBuffer: 1 << 28 });
      const figures = JSON.parse(shown.stdout);
      for (const { key, value } of summary.figures) assert.deepEqual(value, figures[key], `${episode[0]}: ${key} of ${command}`);
    }
  }
  // repeated in the module itself
  const again = module.replay(log);
  while (again.value("step") < log.steps && again.step() !== 0);
  assert.deepEqual(again.log().digests, log.digests, `${episode[0]}: another replay`);
  again.close();
  const fallbacks = summary.figures.find(({ key }) => key === "fallback_steps")?.value || 0;
  if (episode[0].endsWith("no solution")) assert.ok(fallbacks > 0, `${episode[0]}: every step has a solution`);
  const without = fallbacks ? `, ${fallbacks} without a solution of eq. (7)` : "";
  console.log(`${episode[0]}: ${log.digests.length} digests equal, ${log.steps} steps${without}, ${log.outcome ?? "goes on"}`);
}
console.log(`${(0.2 * steps / milliseconds * 1e3).toFixed(0)} times real time`);

// bad input is refused with a sentence, and the module goes on
const refuses = (act, words) => assert.throws(act, (error) => error instanceof Refused && words.test(error.message), String(words));
refuses(() => module.open("seed = "), /scenario/);
refuses(() => module.world({ text: "name = 1" }), /world\.toml/);
refuses(() => module.scenario({ world: "environment-9" }), /unknown world `environment-9`/);
refuses(() => module.scenario({ world: "environment-1", settings: { eta: -1 } }), /eta = -1; it must be/);
refuses(() => module.restore(new Uint8Array(100)), /snapshot/);
refuses(() => module.replay("{}"), /log/);
refuses(() => module.call("state", 0, 12345), /12345 is not the handle/);
refuses(() => module.call("input", 0, 2 ** 31), /bytes/);
console.log("bad input is refused");
