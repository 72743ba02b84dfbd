// Meshes lie on their links as in other viewers of robots, in every format: node test/meshes.mjs. Runs in
// Chromium, whose XML parser the COLLADA loader uses.
import assert from "node:assert/strict";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";
import { chromium } from "playwright-core";

const bundled = await build({
  stdin: {
    contents: `
      import { Box3, Group } from "three";
      import { addMeshes } from "../src/meshes.js";
      window.extent = (format, text, scale) => {
        const link = new Group();
        addMeshes(link, { format, base64: btoa(text) }, scale, null, "#ffffff", () => {});
        link.updateMatrixWorld(true);
        const { min, max } = new Box3().setFromObject(link);
        return [min.toArray(), max.toArray()].map((corner) => corner.map((v) => Math.round(1e6 * v) / 1e6));
      };`,
    resolveDir: fileURLToPath(new URL(".", import.meta.url)),
  },
  bundle: true,
  format: "iife",
  write: false,
});

// A corner of a box of 1 x 2 x 3 m on the floor.
const corners = [[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]];
const faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
const facet = (face) => `facet normal 0 0 0\nouter loop\n${face.map((i) => `vertex ${corners[i].join(" ")}`).join("\n")}\nendloop\nendfacet\n`;
const stl = `solid a\n${faces.map(facet).join("")}endsolid a\n`;
const obj = [...corners.map((c) => `v ${c.join(" ")}`), ...faces.map((f) => `f ${f.map((i) => i + 1).join(" ")}`)].join("\n");
const dae = (axis, meter) => `<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="${meter}" name="u"/>${axis && `<up_axis>${axis}</up_axis>`}</asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="12">${corners.flat().map((v) => v / meter).join(" ")}</float_array>
<technique_common><accessor source="#pa" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>${faces.flat().join(" ")}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>`;

const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox"] });
try {
  const tab = await browser.newPage();
  await tab.addScriptTag({ content: bundled.outputFiles[0].text });
  const cases = [["stl", stl], ["obj", obj], ["dae", dae("Z_UP", 1)], ["dae", dae("Y_UP", 1)], ["dae", dae("", 1)], ["dae", dae("Z_UP", 0.001)]];
  for (const [i, [format, text]] of cases.entries()) {
    const extent = (scale) => tab.evaluate(([f, t, s]) => window.extent(f, t, s), [format, text, scale]);
    assert.deepEqual(await extent([1, 1, 1]), [[0, 0, 0], [1, 2, 3]], `${i}: ${format}`);
    assert.deepEqual(await extent([2, 1, 0.5]), [[0, 0, 0], [2, 2, 1.5]], `${i}: ${format}, scaled`);
  }
  console.log(`meshes: ${cases.length} files lie as their links do`);
} finally {
  await browser.close();
}
