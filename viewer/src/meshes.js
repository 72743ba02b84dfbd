// The meshes of a robot's links, which the page holds as the bytes of their files.
import { Box3, LoadingManager, Mesh, MeshLambertMaterial } from "three";
import { ColladaLoader } from "three/examples/jsm/loaders/ColladaLoader.js";
import { OBJLoader } from "three/examples/jsm/loaders/OBJLoader.js";
import { STLLoader } from "three/examples/jsm/loaders/STLLoader.js";

const parsed = new Map();

// A page asks for no files: a mesh's textures are white.
const WHITE = "data:image/gif;base64,R0lGODlhAQABAIAAAP///////yH5BAAAAAAALAAAAAABAAEAAAICRAEAOw==";
const textures = new LoadingManager().setURLModifier(() => WHITE);

function parse(mesh, plain) {
  const bytes = Uint8Array.from(atob(mesh.base64), (c) => c.charCodeAt(0));
  const text = () => new TextDecoder().decode(bytes);
  if (mesh.format === "stl") return new Mesh(new STLLoader().parse(bytes.buffer), new MeshLambertMaterial({ color: plain }));
  if (mesh.format === "obj") {
    // its materials are in another file
    const drawn = new OBJLoader().parse(text());
    drawn.traverse((part) => part.isMesh && (part.material = new MeshLambertMaterial({ color: plain })));
    return drawn;
  }
  // as in other viewers of robots, a file's axes are those of its link; the loader does not turn files whose
  // vertical axis is y
  const unturned = text().replace(/<up_axis>[^<]*<\/up_axis>/, "<up_axis>Y_UP</up_axis>");
  const { scene } = new ColladaLoader(textures).parse(unturned, "");
  // lamps and cameras of the drawing program
  scene.traverse((part) => (part.isLight || part.isCamera) && (part.visible = false));
  return scene;
}

// Adds a mesh file to a link, in the colour of the URDF if it gives one; `plain` is for files without colours.
export function addMeshes(link, mesh, scale, material, plain, redraw) {
  if (!parsed.has(mesh)) parsed.set(mesh, parse(mesh, plain));
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
