// The meshes of a robot's links, which the page holds as the bytes of their files.
import { Box3, Mesh } from "three";
import { ColladaLoader } from "three/examples/jsm/loaders/ColladaLoader.js";
import { OBJLoader } from "three/examples/jsm/loaders/OBJLoader.js";
import { STLLoader } from "three/examples/jsm/loaders/STLLoader.js";
import { MeshLambertMaterial } from "three";

const parsed = new Map();

function parse(mesh) {
  const bytes = Uint8Array.from(atob(mesh.base64), (c) => c.charCodeAt(0));
  const text = () => new TextDecoder().decode(bytes);
  if (mesh.format === "stl") return new Mesh(new STLLoader().parse(bytes.buffer), new MeshLambertMaterial({ color: "#d9dde2" }));
  if (mesh.format === "obj") return new OBJLoader().parse(text());
  return new ColladaLoader().parse(text(), "").scene;
}

// Adds a mesh file to a link, in the colour of the URDF if it gives one.
export function addMeshes(link, mesh, scale, material, redraw) {
  if (!parsed.has(mesh)) parsed.set(mesh, parse(mesh));
  const drawn = parsed.get(mesh).clone();
  drawn.scale.multiply({ x: scale[0], y: scale[1], z: scale[2] });
  drawn.traverse((part) => {
    if (!part.isMesh) return;
    part.castShadow = part.receiveShadow = true;
    if (material) part.material = material;
  });
  if (!new Box3().setFromObject(drawn).isEmpty()) link.add(drawn);
  redraw();
}
