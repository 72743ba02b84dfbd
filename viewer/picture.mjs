// Films the episode of README.md's command in the player, camera Follow, a picture per planning step: node picture.mjs PROGRAM.
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const [program] = process.argv.slice(2);
const repository = fileURLToPath(new URL("..", import.meta.url));
const out = join(repository, "book/src/pictures/environment-4.webp");
// A picture is made after two of the player's, for each planning step of 0.2 s: how long they and it take, and the last one stays, ms.
const PASSED_MS = 100, SHOWN_MS = 100, LAST_MS = 2500;
const SIZE = { width: 480, height: 470 }, QUALITY = 72;
// The stage with its labels, and the chart of phi under it, in letters that are legible on a phone too.
const STYLE = `
  #player { display: flex; flex-direction: column; height: 100%; padding: 0; gap: 0; background: var(--card); }
  header, #transport, #cameras, #events, #keys, #charts .chart ~ .chart { display: none !important; }
  #stage { flex: 1; border: 0; border-radius: 0; }
  #panel { flex: none; overflow: hidden; }
  .chart { border: 0; border-radius: 0; }
  h2, .entry { font-size: 15px !important; } .chart text { font-size: 14px; }
  #labels > div { font-size: 14px; } #labels > .end { line-height: 17px; }
  #leader { top: 8px !important; left: 8px !important; font-size: 16px; }
  #caption { bottom: 0; max-width: 100%; padding: 4px 2px; border-radius: 0; width: 100%; font-size: 14px; letter-spacing: -0.01em; text-wrap: auto; }
  #caption.old { display: none; }
`;

// The command, and what the program says of the events: the note in the picture.
const readme = readFileSync(join(repository, "README.md"), "utf8");
const command = /^\$ cocarry (run .*?)(?: {2}|$)/m.exec(readme)[1];
const events = /^Events\n(?: .*\n)+/m.exec(readme)[0];

const folder = mkdtempSync(join(tmpdir(), "picture-"));
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});
try {
  const player = join(folder, "episode.html");
  execFileSync(program, [...command.split(" "), "--render", player], { cwd: repository });
  const tab = await browser.newPage({ viewport: SIZE, colorScheme: "light" });
  // the player's clock goes only when it is told to
  await tab.clock.install({ time: 0 });
  await tab.goto(`${pathToFileURL(player)}#camera=follow&play=0`);
  await tab.addStyleTag({ content: STYLE });
  await tab.clock.runFor(1000);
  await tab.waitForFunction(() => document.body.dataset.drawn);
  await tab.clock.pauseAt(60_000);
  await tab.evaluate(() => document.getElementById("play").click());
  const frames = [];
  const isPlaying = () => tab.evaluate(() => document.getElementById("play").getAttribute("aria-label") === "Pause");
  for (;;) {
    const frame = join(folder, `${frames.length}.png`);
    await tab.screenshot({ path: frame });
    frames.push(frame);
    if (!(await isPlaying())) break;
    for (let i = 0; i < 2; i++) await tab.clock.fastForward(PASSED_MS);
  }
  const last = frames.pop();
  const shown = ["-d", SHOWN_MS, ...frames, "-d", LAST_MS, last].map(String);
  const bare = join(folder, "bare.webp"), note = join(folder, "note");
  execFileSync("img2webp", ["-loop", "0", "-lossy", "-q", String(QUALITY), ...shown, "-o", bare], { stdio: "pipe" });
  writeFileSync(note, `cocarry ${command}\n${events}`);
  execFileSync("webpmux", ["-set", "xmp", note, bare, "-o", out], { stdio: "pipe" });
  console.log(`${out}: ${frames.length + 1} pictures, ${readFileSync(out).length} bytes; ${command}`);
} finally {
  await browser.close();
  rmSync(folder, { recursive: true });
}
