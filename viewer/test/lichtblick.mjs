// Draws a recording in Lichtblick: node test/lichtblick.mjs LICHTBLICK PROGRAM RECORDING PICTURE SECONDS.
import { execFileSync } from "node:child_process";
import { createReadStream, existsSync, mkdtempSync, readFileSync, rmSync, statSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { extname, join } from "node:path";
import { crc32 } from "node:zlib";
import { chromium } from "playwright-core";

const [lichtblick, program, recording, picture, seconds] = process.argv.slice(2);
const folder = mkdtempSync(join(tmpdir(), "lichtblick-"));
const layout = join(folder, "layout.json");
execFileSync(program, ["render", recording, "-o", layout]);

const TYPES = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".wasm": "application/wasm", ".json": "application/json", ".svg": "image/svg+xml" };
const LAYOUT = "/*LICHTBLICK_SUITE_DEFAULT_LAYOUT_PLACEHOLDER*/";

// Serves Lichtblick with the layout, and the recording, of which it reads parts.
const server = createServer((request, response) => {
  const path = new URL(request.url, "http://localhost").pathname;
  if (path === "/") {
    response.writeHead(200, { "content-type": "text/html" });
    return response.end(readFileSync(join(lichtblick, "index.html"), "utf8").replace(LAYOUT, () => readFileSync(layout, "utf8")));
  }
  const file = path === "/recording.mcap" ? recording : join(lichtblick, path);
  if (path.includes("..") || !existsSync(file)) return response.writeHead(404).end();
  const size = statSync(file).size;
  const head = { "content-type": TYPES[extname(file)] ?? "application/octet-stream", "accept-ranges": "bytes" };
  const range = /bytes=(\d+)-(\d*)/.exec(request.headers.range ?? "");
  const [start, end] = range ? [Number(range[1]), Math.min(Number(range[2] || size - 1), size - 1)] : [0, size - 1];
  if (range) head["content-range"] = `bytes ${start}-${end}/${size}`;
  response.writeHead(range ? 206 : 200, { ...head, "content-length": end - start + 1 });
  return createReadStream(file, { start, end }).pipe(response);
});
await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
const address = `http://127.0.0.1:${server.address().port}`;

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});
try {
  const tab = await browser.newPage({ viewport: { width: 1440, height: 860 } });
  const time = new Date(1000 * Number(seconds)).toISOString();
  await tab.goto(`${address}/?ds=remote-file&ds.url=${address}/recording.mcap&time=${time}`);
  // the titles are the layout's; the scene takes its time without a graphics processor
  for (const { foxglovePanelTitle } of Object.values(JSON.parse(readFileSync(layout, "utf8")).configById)) {
    await tab.getByText(foxglovePanelTitle, { exact: true }).first().waitFor({ timeout: 60000 });
  }
  await tab.waitForTimeout(12000);
  const image = await tab.screenshot({ clip: { x: 320, y: 43, width: 1120, height: 742 } });
  writeFileSync(picture, noted(image, `recording ${crc32(readFileSync(recording)).toString(16).padStart(8, "0")}`));
  console.log(`wrote ${picture}`);
} finally {
  await browser.close();
  server.close();
  rmSync(folder, { recursive: true });
}

// A PNG with a comment before its end.
function noted(png, comment) {
  const body = Buffer.from(`tEXtComment\0${comment}`, "latin1");
  const [length, sum] = [Buffer.alloc(4), Buffer.alloc(4)];
  length.writeUInt32BE(body.length - 4);
  sum.writeUInt32BE(crc32(body));
  return Buffer.concat([png.subarray(0, -12), length, body, sum, png.subarray(-12)]);
}
