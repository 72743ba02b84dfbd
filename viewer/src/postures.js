// The page of a robot: its postures in place of events, its joints in place of charts, and the shapes that collide.
import { AxesHelper, Group, Mesh, MeshBasicMaterial, Path, RingGeometry, Shape, ShapeGeometry, Vector2 } from "three";

const VIEWS = { overview: "Corner", follow: "Side", shoulder: "Above" };

// Fits the player's page to a robot; `choose` takes whether shapes are those that collide.
export function robotControls(choose) {
  document.getElementById("player").classList.add("robot");
  document.querySelector("#events h2").textContent = "Postures";
  document.getElementById("view").setAttribute("aria-label", "The robot. Drag to turn the camera, scroll or pinch to zoom.");
  for (const [camera, words] of Object.entries(VIEWS)) {
    const button = document.querySelector(`[data-camera="${camera}"]`);
    button.textContent = words;
    button.setAttribute("aria-label", `Camera: ${words.toLowerCase()}`);
  }
  document.getElementById("keys").innerHTML =
    "<kbd>Space</kbd> play, <kbd>←</kbd> <kbd>→</kbd> posture, <kbd>1</kbd> <kbd>2</kbd> <kbd>3</kbd> camera, <kbd>C</kbd> shapes";
  const group = document.createElement("div");
  group.id = "shapes";
  group.setAttribute("role", "group");
  group.setAttribute("aria-label", "Shapes");
  for (const [words, isColliding] of [["As drawn", false], ["As it collides", true]]) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = words;
    button.dataset.shapes = isColliding ? "collisions" : "visuals";
    button.setAttribute("aria-keyshortcuts", "C");
    button.addEventListener("click", () => choose(isColliding));
    group.append(button);
  }
  document.getElementById("stage").append(group);
}

// Marks the shapes that are shown.
export function mark(isColliding) {
  const shown = isColliding ? "collisions" : "visuals";
  document.querySelectorAll("#shapes button").forEach((b) => b.setAttribute("aria-pressed", b.dataset.shapes === shown));
}

// The outline of the base in clearances, and the axes of the grasp: x red, y green, z blue.
export function marks({ robot_width_m: width, footprint_m: corners }) {
  const material = new MeshBasicMaterial({ color: "#c2570c", transparent: true, opacity: 0.7 });
  const half = 0.006;
  const ring = new Mesh(corners ? border(corners, half) : new RingGeometry(width / 2 - half, width / 2 + half, 96), material);
  ring.position.z = 0.004;
  const grasp = new Group();
  const axes = new AxesHelper(0.14);
  // through the gripper
  axes.material.depthTest = false;
  axes.renderOrder = 1;
  grasp.add(axes);
  return { ring, grasp };
}

// A line of twice this width along the sides of a convex polygon.
function border(corners, half) {
  const moved = (by) => {
    const middle = corners.reduce((sum, [x, y]) => sum.add(new Vector2(x, y)), new Vector2()).divideScalar(corners.length);
    return corners.map(([x, y]) => {
      const from = new Vector2(x, y).sub(middle);
      return from.setLength(from.length() + by).add(middle);
    });
  };
  const shape = new Shape(moved(half));
  shape.holes.push(new Path(moved(-half)));
  return new ShapeGeometry(shape);
}

// The panel: joints with their limits and where they are, and what the program says of the robot.
export class Postures {
  constructor(folder, { postures, frames, world }) {
    Object.assign(this, { postures, times: frames.time_s });
    const unit = ({ turns }) => (turns ? "°" : " m");
    const panel = document.createElement("section");
    panel.className = "chart";
    panel.id = "joints";
    panel.innerHTML = "<h2>Joints</h2><table><thead><tr><th>Joint</th><th>from</th><th>is at</th><th>to</th></tr></thead><tbody></tbody></table>";
    this.cells = postures.joints.map((joint) => {
      const row = panel.querySelector("tbody").insertRow();
      const limit = (value) => (value === null ? "free" : value.toFixed(joint.turns ? 0 : 2) + unit(joint));
      const output = document.createElement("output");
      output.dataset.joint = joint.name;
      for (const content of [joint.name, limit(joint.lower), output, limit(joint.upper)]) row.insertCell().append(content);
      return { output, joint };
    });
    const width = document.createElement("p");
    width.className = "none";
    const line = world.footprint_m ? "outline on the floor" : "ring";
    width.textContent = `The ${line} is the base for clearances, ${world.robot_width_m.toFixed(2)} m wide. The axes are those of the grasp: x, ahead, is red.`;
    panel.append(width);
    folder.append(panel);
    if (postures.remarks.length) {
      const notes = document.createElement("section");
      notes.className = "chart";
      notes.id = "notes";
      notes.innerHTML = "<h2>Notes</h2><ul></ul>";
      for (const words of postures.remarks) {
        const item = document.createElement("li");
        item.textContent = words.replaceAll("`", "");
        notes.lastChild.append(item);
      }
      folder.append(notes);
    }
  }

  layout() {}

  update({ before, after, part }) {
    const { at } = this.postures;
    this.cells.forEach(({ output, joint }, j) => {
      const value = at[before][j] + part * (at[after][j] - at[before][j]);
      output.textContent = joint.turns ? `${((value * 180) / Math.PI).toFixed(1).replace(/^-0\.0$/, "0.0")}°` : `${value.toFixed(3)} m`;
    });
  }
}
