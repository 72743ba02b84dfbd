// Parts of the page that need no browser: addresses, and changes of worlds: node test/page_parts.mjs.
import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { BEGIN, Choices } from "../page/choices.js";
import * as edit from "../page/edit.js";
import { choicesOf, kindOf } from "../page/given.js";
import * as link from "../page/link.js";
import { packed } from "../src/packed.js";

const catalogue = Object.fromEntries(Object.entries({
  worlds: ["environment-4", "free-form"], robots: ["carrier", "omni-carrier"], plants: ["rapier", "kinematic", "point"], methods: ["mutual", "human-led"],
}).map(([key, names]) => [key, names.map((name) => ({ name }))]));
// ranges as the module has them
const range = (least, least_is_open, most) => ({ least, least_is_open, most });
catalogue.perception = range(0, true, 10);
catalogue.settings = Object.entries({
  eta: range(0, true, 1e6), initial_stubbornness: range(0, true, 1), belief_rationality: range(0, true, 1e3), control_period_s: range(0.01, false, 60),
}).map(([key, own]) => ({ key, ...own }));

// what is as at the beginning makes no address; everything else comes back, to the last bit
assert.equal(await link.written(BEGIN, null), "");
const chosen = {
  ...BEGIN, world: "free-form", robot: "omni-carrier", plant: "kinematic", human: "boltzmann", rationality: 0.1 + 0.2, alpha: 1 / 3, gamma: 0.7,
  eta: 15, stubbornness: 0.3, seed: 2 ** 52 + 1, method: "human-led", belief: "learn", carry: true, period: 0.05,
};
const log = { version: "1", steps: 3, decisions: { hands: [[0.5, -1.25], null] } };
let read = await link.read(`#${await link.written(chosen, log)}`, catalogue);
assert.deepEqual([{ ...BEGIN, ...read.choices }, read.log, read.faults], [chosen, log, []]);
const world = readFileSync(new URL("../../worlds/free-form.toml", import.meta.url), "utf8");
read = await link.read(await link.written({ ...BEGIN, toml: world }, null), catalogue);
assert.equal(read.choices.toml, world);
console.log("addresses: everything that is chosen comes back");

read = await link.read(await link.written({ ...chosen, scenario: "seed = 1", carry: true }, null), catalogue);
assert.deepEqual(read.choices, { scenario: "seed = 1", carry: true }, "a scenario says everything");

// a value that cannot be is left out, with a sentence; the others hold
read = await link.read("#alpha=-1&gamma=x&eta=15&world=nowhere&seed=1.5&phi=2&file=%21%21&log=AAAA&camera=map", catalogue);
assert.deepEqual(read.choices, { eta: 15 });
assert.equal(read.log, null);
assert.deepEqual(read.view, { camera: "map" });
assert.equal(read.faults.length, 7, read.faults.join("\n"));
for (const key of ["alpha=-1", "gamma=x", "world=nowhere", "seed=1.5", "phi=2", "file=!!", "log=AAAA"]) {
  assert.ok(read.faults.some((fault) => fault.startsWith(`${key}: expected`)), `${key}: ${read.faults}`);
}
assert.equal((await link.read("stubbornness=1.5&eta=2000000&alpha=11&period=0.001", catalogue)).faults.length, 4, "numbers beyond what the program takes");
read = await link.read("t=9.4&object=1,2.5,-3&carry=1", catalogue);
assert.deepEqual([read.view, read.faults], [{ t: 9.4, object: [1, 2.5, -3] }, []]);
assert.equal((await link.read("t=x&object=1,2", catalogue)).faults.length, 2);
assert.match(await link.written(chosen, log, 10), /&t=10$/);
// no link unpacks to more than a page can bear, and a long one is not read
const bomb = await packed("a".repeat(5 << 20));
assert.equal((await link.read(`file=${bomb}`, catalogue)).faults.length, 1);
assert.match((await link.read(`file=${"A".repeat(1 << 19)}`, catalogue)).faults[0], /characters/);
console.log("addresses: what cannot be has a sentence");

// files of all built-in worlds survive being read and written
const folder = new URL("../../worlds/", import.meta.url);
for (const name of readdirSync(folder)) {
  const file = edit.read(readFileSync(new URL(name, folder), "utf8"));
  assert.deepEqual(edit.read(edit.written(file)), file, name);
}
const file = edit.read(readFileSync(new URL("environment-4.toml", folder), "utf8"));
const index = file.obstacle.findIndex(({ name }) => name === "wall-3");
const [x, y] = file.obstacle[index].center_m;
const moved = edit.move(file, index, [0.1, -0.25]);
assert.deepEqual(moved.obstacle[index].center_m, [x + 0.1, y - 0.25].map((v) => Math.round(v * 100) / 100));
assert.deepEqual(file.obstacle[index].center_m, [x, y], "the world before stays");
assert.deepEqual(edit.moveEnd(file, "start_m", [1, 0]).start_m[1], Math.round(file.start_m[1] * 100) / 100);
const drawn = edit.wall(file, [1, 0], [1, 2]).obstacle.at(-1);
assert.deepEqual([drawn.center_m, drawn.size_m, drawn.yaw_deg, drawn.name], [[1, 1], [2, 0.1], 90, "drawn-1"]);
assert.equal(edit.wall(file, [1, 0], [1.1, 0]), file, "a click draws no wall");
assert.deepEqual(edit.turn(edit.wall(file, [1, 0], [1, 2]), file.obstacle.length, 95).obstacle.at(-1).yaw_deg, -175);
assert.ok(!/\[\[(opening|option)\]\]/.test(edit.written(file, true)), "openings are found anew");
assert.ok(/\[\[opening\]\]/.test(edit.written(file)));
console.log("worlds: obstacles and ends move, walls are drawn");

// what a given file is
const scenario = "seed = 3\n[world]\nfile = \"w\"\ntext = \"\"\"name = 1\"\"\"\n[settings.coordination]\ninitial_stubbornness = 0.25";
assert.deepEqual(kindOf(world), { world });
assert.deepEqual(kindOf(scenario), { scenario });
assert.deepEqual(kindOf(JSON.stringify({ scenario, steps: 1 })), { scenario, log: { scenario, steps: 1 } });
assert.deepEqual(kindOf("not [ toml"), { world: "not [ toml" }, "the module says what is wrong");
assert.throws(() => kindOf("{}"), /not an episode/);
const of = choicesOf(scenario, { plant: "point", method: "mutual", seed: 3, alpha: 0.6, gamma: 0.7, eta: 5, learns: true, human_model: "boltzmann(2.5)" });
assert.deepEqual([of.toml, of.stubbornness, of.belief, of.human, of.rationality], ["name = 1", 0.25, "learn", "boltzmann", 2.5]);

// what is asked of the module
const choices = new Choices({ human: "boltzmann", plant: "point" });
assert.equal(choices.scenario().settings.human_model, "boltzmann(2)");
assert.ok(!("robot" in choices.scenario()), "no robot on the planning level");
assert.equal(new Choices({ robot: "omni-carrier" }).scenario().robot, "omni-carrier");
const heard = [];
choices.onChange((keys) => heard.push(keys));
choices.change({ alpha: BEGIN.alpha, carry: true, period: 0.05 });
assert.deepEqual(heard, [["carry", "period"]], "only what is new is told");
assert.equal(choices.scenario().settings.control_period_s, 0.05);
