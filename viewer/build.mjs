// Bundles the player into one page, ../assets/player.html, which the crate embeds: node build.mjs
// The page carries a digest of its sources, so that a test of the crate can tell when it is older than they are.
import { build } from "esbuild";
import { readFileSync, readdirSync, writeFileSync } from "node:fs";
import { crc32 } from "node:zlib";

const here = (name) => new URL(name, import.meta.url);
const read = (name) => readFileSync(here(name), "utf8");

const sources = ["build.mjs", "package-lock.json", "package.json"];
sources.push(...readdirSync(here("src")).map((name) => `src/${name}`));
const digest = sources.sort().reduce((sum, name) => crc32(`${name}\n${read(name)}`, sum), 0);

const bundled = await build({
  entryPoints: [here("src/main.js").pathname],
  bundle: true,
  minify: true,
  format: "iife",
  target: "es2020",
  legalComments: "none",
  write: false,
});
const parts = {
  DIGEST: digest.toString(16).padStart(8, "0"),
  STYLE: read("src/page.css"),
  // a closing tag in a string would end the element
  SCRIPT: bundled.outputFiles[0].text.replaceAll("</script", "<\\/script"),
};
const page = read("src/page.html").replace(/%(\w+)%/g, (_, name) => parts[name]);
writeFileSync(here("../assets/player.html"), page);
console.log(`assets/player.html: ${page.length} bytes, sources ${parts.DIGEST}`);
