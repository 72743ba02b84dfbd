// Bundles the player into one page, ../assets/player.html, which the crate embeds, and the page that runs the simulator into
// the folder dist/page, next to its WebAssembly module (../crates/web/build makes that): node build.mjs
// The player carries a digest of its sources, so that a test of the crate can tell when it is older than they are.
import { build } from "esbuild";
import { existsSync, mkdirSync, readFileSync, readdirSync, writeFileSync } from "node:fs";
import { crc32 } from "node:zlib";

const here = (name) => new URL(name, import.meta.url);
const read = (name) => readFileSync(here(name), "utf8");

const sources = ["build.mjs", "package-lock.json", "package.json"];
sources.push(...readdirSync(here("src")).map((name) => `src/${name}`));
const digest = sources.sort().reduce((sum, name) => crc32(`${name}\n${read(name)}`, sum), 0);

const bundle = async (entry, options) => {
  const shared = { bundle: true, minify: true, target: "es2020", legalComments: "none", write: false };
  const { outputFiles } = await build({ entryPoints: [here(entry).pathname], ...shared, ...options });
  return outputFiles[0].text;
};
const parts = {
  DIGEST: digest.toString(16).padStart(8, "0"),
  STYLE: read("src/page.css"),
  // a closing tag in a string would end the element
  SCRIPT: (await bundle("src/main.js", { format: "iife" })).replaceAll("</script", "<\\/script"),
};
const player = read("src/page.html").replace(/%(\w+)%/g, (_, name) => parts[name]);
writeFileSync(here("../assets/player.html"), player);
console.log(`assets/player.html: ${player.length} bytes, sources ${parts.DIGEST}`);

// the page: what a web host serves as it is
if (!existsSync(here("../crates/web/cocarry.js"))) {
  console.log("skipped: dist/page; it needs ../crates/web/cocarry.js");
  process.exit();
}
const page = {
  "index.html": read("page/index.html"),
  "page.css": read("src/page.css") + read("page/style.css"),
  "page.js": await bundle("page/main.js", { format: "esm", banner: { js: "// Uses three.js (MIT licence) and smol-toml (BSD-3-Clause licence); NOTICE.txt has their texts." } }),
  "NOTICE.txt": ["three", "smol-toml"].map((name) => `${name}\n\n${read(`node_modules/${name}/LICENSE`)}`).join("\n\n"),
};
mkdirSync(here("dist/page"), { recursive: true });
for (const [name, text] of Object.entries(page)) writeFileSync(here(`dist/page/${name}`), text);
const sizes = Object.entries(page).map(([name, text]) => `${name} ${Buffer.byteLength(text)}`).join(", ");
console.log(`dist/page: ${sizes} bytes${existsSync(here("dist/page/cocarry.wasm")) ? "" : "; cocarry.wasm is missing: ../crates/web/build"}`);
