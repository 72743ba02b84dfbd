// `cocarry study simulate --browser`: simulated participants answer on the page, and say what they say without
// it; `infer` finds what they are.
//   node test/rehearsal.mjs PROGRAM [PARTICIPANTS AT_ONCE SEED]
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { existsSync, readFileSync, readdirSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { carries, needPeople, newStudy, simulator, stored, world } from "./participants.mjs";
import { covered } from "./simulated.mjs";

const [program, participants = "4", atOnce = "4", seed = "7"] = process.argv.slice(2);
needPeople(program);
const BROWSER = process.env.CHROMIUM ? `--browser=${process.env.CHROMIUM}` : "--browser";
const worlds = { "short.toml": world("Short") };
const study = () => newStudy(program, worlds);
const rehearsed = study(), planned = study();
const simulate = ["study", "simulate", "study.toml", "--participants", participants, "--seed", seed, "--truth", "truth.csv"];
const collect = ["study", "collect", "study.toml", "--simulated", "-o", "answers"];

// what is no browser, and what is none that goes on, is said
const refused = spawnSync(program, [...simulate, "--browser=/no/such/browser", ...simulator], { cwd: rehearsed.folder, encoding: "utf8" });
assert.equal(refused.status, 2, refused.stderr);
assert.match(refused.stderr, /--browser: there is no program \/no\/such\/browser/);
assert.ok(!existsSync(join(rehearsed.folder, "study.simulated.sqlite")));
const ended = spawnSync(program, [...simulate, "--browser=/bin/false", ...simulator], { cwd: rehearsed.folder, encoding: "utf8" });
assert.equal(ended.status, 4, ended.stderr);
assert.match(ended.stderr, /--browser: \/bin\/false ended \(exit status: 1\); 0 of \d+ participants have finished/);
assert.ok(!existsSync(join(rehearsed.folder, "truth.csv")));

const before = new Set(readdirSync(tmpdir()));
const began = Date.now();
rehearsed.cocarry(...simulate, BROWSER, "--at-once", atOnce, ...simulator);
const seconds = Math.round((Date.now() - began) / 1000);
planned.cocarry(...simulate);
for (const { cocarry } of [rehearsed, planned]) cocarry(...collect);

// the same people, whoever has which number
const people = (of) => of.table("truth.csv");
const [here, there] = [people(rehearsed), people(planned)];
const known = ({ alpha, gamma, eta }) => [alpha, gamma, eta];
assert.deepEqual(here.map(known), there.map(known));
const number = new Map(here.map(({ participant }, i) => [participant, there[i].participant]));
const key = ({ participant, world, option }) => [number.get(participant) ?? participant, world, option].join(" ");
const rows = (of, name) => new Map(of.table(`answers/${name}`).map((row) => [key(row), row]));
const answers = rows(rehearsed, "answers.csv"), switches = rows(rehearsed, "switches.csv");
for (const [key, { percent }] of rows(planned, "answers.csv")) assert.equal(answers.get(key).percent, percent, key);
let exact = 0;
const stops = rows(planned, "switches.csv");
for (const [key, { step }] of stops) {
  const got = switches.get(key).step;
  assert.equal(got === "", step === "", `${key}: ${step} became ${got}`);
  exact += got === step;
  // a browser that is slow presses late, never early
  assert.ok(step === "" || (Number(got) >= Number(step) && Number(got) <= Number(step) + 5), `${key}: ${step} became ${got}`);
}
assert.equal(switches.size, stops.size);
assert.equal(rehearsed.table("answers/participants.csv").filter(({ finished_utc }) => finished_utc).length, here.length);
const { integrity } = stored(rehearsed, "study.simulated.sqlite");
assert.deepEqual(integrity, [["ok"]]);
console.log(`${here.length} participants on the page in ${seconds} s; ${answers.size} shares as without it, ${exact} of ${stops.size} stops in the same step`);
if (carries) {
  const carried = rehearsed.table("answers/carries.csv");
  assert.deepEqual(carried.filter(({ differs_within_s }) => differs_within_s !== ""), []);
  assert.equal(carried.length, here.length);
  console.log(`${carried.length} carries replay equal; ${carried.filter(({ outcome }) => outcome === "arrived").length} arrived`);
}

covered(rehearsed, here.map((truth) => ({ truth, number: truth.participant })));

// people's page knows nothing of it
rehearsed.cocarry("study", "build", "study.toml", "-o", "site", ...simulator);
assert.ok(!existsSync(join(rehearsed.folder, "site/simulated.js")));
assert.doesNotMatch(readFileSync(join(rehearsed.folder, "site/index.html"), "utf8"), /simulated/);
// others are not mixed with these
const again = spawnSync(program, [...simulate, "--overwrite", BROWSER, ...simulator], { cwd: rehearsed.folder, encoding: "utf8" });
assert.match(again.stderr, /study\.simulated\.sqlite: has other simulated participants; remove the file first/);
// no browser leaves a folder
assert.deepEqual(readdirSync(tmpdir()).filter((name) => name.startsWith("cocarry-browser-") && !before.has(name)), []);
for (const { folder } of [rehearsed, planned]) rmSync(folder, { recursive: true });
