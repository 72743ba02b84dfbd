// Compares episodes of the WebAssembly module with those of the program, to the bit.
// node compare.mjs MODULE.wasm COCARRY

import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";

const [, , file, cocarry] = process.argv;
const module = new WebAssembly.Module(readFileSync(file));
const imports = WebAssembly.Module.imports(module);
if (imports.length > 0) {
  throw new Error(`the module needs a host: ${JSON.stringify(imports)}`);
}
const { exports } = new WebAssembly.Instance(module);

const worlds = ["environment-1", "environment-2", "environment-3", "environment-4", "free-form"];
const plants = ["point", "kinematic", "rapier"];
const runs = [
  ...worlds.flatMap((world) => [0, 7].map((seed) => [world, "point", seed])),
  ["environment-1", "kinematic", 0],
  ["environment-4", "kinematic", 7],
  ["environment-1", "rapier", 0],
];
const figures = ["accumulated_objective_cost_m", "accumulated_control_cost"];
const bits = (value) => {
  const view = new DataView(new ArrayBuffer(8));
  view.setFloat64(0, value ?? NaN);
  return view.getBigUint64(0).toString(16);
};
let differences = 0;
for (const [world, plant, seed] of runs) {
  const text = execFileSync(cocarry, ["run", world, "--plant", plant, "--seed", String(seed), "--json"]);
  const native = JSON.parse(text);
  for (const figure of figures.slice(0, plant === "point" ? 1 : 2)) {
    const here = bits(exports[figure](worlds.indexOf(world), plants.indexOf(plant), BigInt(seed)));
    const there = bits(native[figure]);
    differences += here === there ? 0 : 1;
    const verdict = here === there ? "equal" : `WRONG: the program has ${there}`;
    console.log(`${world} ${plant} seed ${seed}: ${figure} ${here} ${verdict}`);
  }
}
if (differences > 0) {
  throw new Error(`${differences} figures differ`);
}
