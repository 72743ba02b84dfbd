// Pictures of robots' pages as WebP on no background: node tests/gallery/picture.mjs PAGE PICTURE [PAGE PICTURE ...]. Needs
// Chromium, and viewer/node_modules (`npm ci` in viewer/).
import { statSync, writeFileSync } from "node:fs";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { chromium } from "../../viewer/node_modules/playwright-core/index.mjs";

// The longer side of a picture, and the margin around the robot, in pixels
const SIZE = 520, MARGIN = 8;

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});
try {
  const files = process.argv.slice(2);
  for (let i = 0; i < files.length; i += 2) {
    const tab = await browser.newPage({ viewport: { width: 1200, height: 1200 } });
    await tab.goto(`${pathToFileURL(resolve(files[i]))}#play=0&picture`);
    await tab.waitForFunction(() => document.body.dataset.drawn);
    // meshes come after the first picture
    await tab.waitForTimeout(1500);
    const png = (await tab.screenshot({ omitBackground: true })).toString("base64");
    const webp = await tab.evaluate(async ([png, size, margin]) => {
      const image = new Image();
      image.src = `data:image/png;base64,${png}`;
      await image.decode();
      const context = (width, height) => Object.assign(document.createElement("canvas"), { width, height }).getContext("2d");
      const whole = context(image.width, image.height);
      whole.drawImage(image, 0, 0);
      // the robot alone
      const { data, width } = whole.getImageData(0, 0, image.width, image.height);
      let [left, top, right, bottom] = [Infinity, Infinity, 0, 0];
      for (let i = 3; i < data.length; i += 4) {
        if (!data[i]) continue;
        const [x, y] = [((i - 3) / 4) % width, Math.floor((i - 3) / 4 / width)];
        [left, top, right, bottom] = [Math.min(left, x), Math.min(top, y), Math.max(right, x + 1), Math.max(bottom, y + 1)];
      }
      const scale = (size - 2 * margin) / Math.max(right - left, bottom - top);
      const [w, h] = [right - left, bottom - top].map((side) => Math.round(side * scale));
      const cut = context(w + 2 * margin, h + 2 * margin);
      cut.imageSmoothingQuality = "high";
      cut.drawImage(image, left, top, right - left, bottom - top, margin, margin, w, h);
      return cut.canvas.toDataURL("image/webp", 0.85).split(",")[1];
    }, [png, SIZE, MARGIN]);
    writeFileSync(files[i + 1], Buffer.from(webp, "base64"));
    console.log(`${files[i + 1]}: ${statSync(files[i + 1]).size} bytes`);
    await tab.close();
  }
} finally {
  await browser.close();
}
