// Bundles the page on which participants answer into ../../assets/people, which the program embeds: node build.mjs
// It carries a digest of its sources, so that a test of the program can tell when it is older than they are.
import { build } from "esbuild";
import { readFileSync, readdirSync, writeFileSync } from "node:fs";
import { crc32 } from "node:zlib";

const here = (name) => new URL(name, import.meta.url);
const read = (name) => readFileSync(here(name), "utf8");

const sources = ["build.mjs", "package-lock.json", "package.json", "../page/carry.js", "../../crates/web/cocarry.js", ...readdirSync(here("src")).map((name) => `src/${name}`)];
const digest = sources.sort().reduce((sum, name) => crc32(`${name}\n${read(name)}`, sum), 0);
const bundle = async (entry, options) => {
  const { outputFiles } = await build({
    entryPoints: [here(entry).pathname], bundle: true, minify: true, target: "es2022", legalComments: "none", write: false, ...options,
  });
  return outputFiles[0].text;
};
// the licence of a package; what its file says before does not belong to it
const licence = (name, file) => `${name}\n\n${read(`node_modules/${name}/${file}`).replace(/^[^]*LICENSE \(MIT\)\n-+\n/, "").trim()}`;
const files = {
  "index.html": read("src/index.html").replace("%DIGEST%", digest.toString(16).padStart(8, "0")),
  "study.js": await bundle("src/main.js", { format: "esm", banner: { js: "// Uses jsPsych, auto-bind, random-words, seedrandom (MIT licence) and idb (ISC licence); NOTICE.txt has their texts." } }),
  "simulated.js": await bundle("src/simulated.js", { format: "esm" }),
  "study.css": await bundle("src/style.css", {}),
  "NOTICE.txt": [read("src/notice.txt"), licence("idb", "LICENSE"), licence("auto-bind", "license"), licence("random-words", "LICENSE"), licence("seedrandom", "README.md")].join("\n\n"),
};
for (const [name, text] of Object.entries(files)) writeFileSync(here(`../../assets/people/${name}`), text);
console.log(Object.entries(files).map(([name, text]) => `${name} ${Buffer.byteLength(text)}`).join(", "), "bytes");
