// The three-dimensional view of the page: the player's stage, cameras and labels, made anew for every episode.
import { ArrowHelper, Color, PCFShadowMap, Plane, Raycaster, RingGeometry, Mesh, MeshBasicMaterial, Vector2, Vector3, WebGLRenderer } from "three";
import { Cameras } from "../src/cameras.js";
import { Labels } from "../src/labels.js";
import { Stage } from "../src/scene.js";

// The length of a force's arrow, m per N, and the smallest force that has one, N.
const METRES_PER_NEWTON = 0.03, SMALLEST = 0.5;
// The fewest points of the picture per point of the page.
const COARSEST = 0.5;
// Until the reader chooses: the camera of the first picture.
const BEGIN = "follow";

export class View {
  // `covered` gives boxes in which no label may be.
  constructor({ canvas, box, labels, covered, onLost }) {
    Object.assign(this, { canvas, box, folder: labels, covered, name: BEGIN, isDirty: true });
    this.renderer = new WebGLRenderer({ canvas, antialias: true });
    this.renderer.debug.checkShaderErrors = false;
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      onLost(true);
    });
    canvas.addEventListener("webglcontextrestored", () => {
      onLost(false);
      this.redraw();
    });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      this.stage?.paint();
      this.forces?.forEach(({ arrow, colour }) => arrow.setColor(tint(colour)));
      this.target?.material.color.copy(tint("--human"));
      this.redraw();
    });
    this.ray = new Raycaster();
  }

  redraw = () => (this.isDirty = true);

  // Shows another episode: in the same stage, if its world and robot are the same.
  show(episode) {
    const { world, options, robot } = episode;
    const key = JSON.stringify([world, options.map(({ path }) => path), robot.map(({ shapes }) => shapes)]);
    if (this.key === key) {
      this.episode = episode;
      this.stage.take(episode);
      this.stage.update(0);
      this.cameras.home();
      return this.redraw();
    }
    this.key = key;
    this.cameras?.controls.dispose();
    this.stage?.scene.traverse((part) => {
      part.geometry?.dispose();
      [part.material].flat().forEach((material) => material?.dispose());
    });
    this.folder.replaceChildren();
    this.episode = episode;
    this.stage = new Stage(episode, this.redraw);
    this.stage.finish();
    this.stage.update(0);
    this.forces = [["hand_wrench_now", "--human"], ["grip_wrench_now", "--robot-force"]].map(([field, colour]) => {
      const arrow = new ArrowHelper(new Vector3(1, 0, 0), new Vector3(), 1, tint(colour), 0.16, 0.1);
      arrow.visible = false;
      this.stage.scene.add(arrow);
      return { field, arrow, colour };
    });
    this.target = new Mesh(new RingGeometry(0.1, 0.15, 40), new MeshBasicMaterial({ color: tint("--human"), transparent: true, opacity: 0.9, depthTest: false }));
    this.target.visible = false;
    this.target.renderOrder = 2;
    this.stage.scene.add(this.target);
    this.cameras = new Cameras(this.canvas, this.stage, this.redraw);
    this.labels = new Labels(this.folder, this.stage);
    this.resize();
    this.choose(this.name);
    this.steer(this.isSteered);
  }

  choose(name) {
    this.name = name;
    if (!this.cameras) return;
    this.cameras.choose(name);
    this.redraw();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.box;
    if (!width || !height || !this.cameras) return;
    this.renderer.setSize(width, height, false);
    this.cameras.resize(width / height);
    this.labels.measure();
    this.redraw();
  }

  // While a person carries, one finger or the first mouse button moves the hand, and does not turn the camera.
  steer(isSteered) {
    this.isSteered = isSteered;
    if (this.cameras) this.cameras.controls.enabled = !isSteered;
  }

  update(time) {
    this.stage.update(time);
    this.redraw();
  }

  // The cameras that move go along. `passed` is the time since the last picture, s.
  follow(passed) {
    this.cameras?.follow(1 - Math.exp(-2.5 * passed));
  }

  // Shows the horizontal forces on the object now; without `isNow`, none.
  arrows(isNow) {
    const { object, hand } = this.stage;
    const length = this.episode.world.object_m[0];
    for (const { field, arrow } of this.forces) {
      const [x, y] = isNow && this.episode.isFelt ? this.episode.pull(field) : [0, 0];
      const size = Math.hypot(x, y);
      arrow.visible = size > SMALLEST;
      if (!arrow.visible) continue;
      const at = field === "hand_wrench_now" ? hand.position : new Vector3(-length / 2, 0, 0).applyQuaternion(object.quaternion).add(object.position);
      arrow.position.set(at.x, at.y, at.z + 0.28);
      arrow.setDirection(new Vector3(x / size, y / size, 0));
      arrow.setLength(0.18 + METRES_PER_NEWTON * size, 0.16, 0.1);
    }
  }

  // Marks where the hand shall go.
  mark(place) {
    this.target.visible = Boolean(place);
    if (place) {
      this.target.position.set(place[0], place[1], 0.06);
    }
    this.redraw();
  }

  // The place on the floor (m) at a point of the window; null above the horizon.
  floor(x, y) {
    if (!this.cameras) return null;
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    this.ray.setFromCamera(new Vector2((2 * (x - left)) / width - 1, 1 - (2 * (y - top)) / height), this.cameras.camera);
    const at = this.ray.ray.intersectPlane(new Plane(new Vector3(0, 0, 1), 0), new Vector3());
    return at && Math.hypot(at.x, at.y) < 1e3 ? [at.x, at.y] : null;
  }

  // Which way is up in the picture, as an angle on the floor.
  bearing() {
    const ahead = this.cameras.camera.getWorldDirection(new Vector3());
    return Math.atan2(ahead.y, ahead.x);
  }

  draw() {
    if (!this.isDirty || !this.stage) return false;
    this.isDirty = this.stage.clear(this.cameras.camera);
    this.renderer.render(this.stage.scene, this.cameras.camera);
    const { clientWidth: width, clientHeight: height } = this.box;
    this.labels.update(this.cameras.camera, width, height, [...this.covered(), ...this.outline(width, height)]);
    return true;
  }

  // The box of the picture in which the team is.
  outline(width, height) {
    const team = this.stage.outline().map((place) => place.project(this.cameras.camera)).filter(({ z }) => z < 1);
    if (!team.length) return [];
    const [xs, ys] = [team.map(({ x }) => ((x + 1) / 2) * width), team.map(({ y }) => ((1 - y) / 2) * height)];
    return [[Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)]];
  }

  // Draws fewer points: on a machine without graphics, a coarser picture that moves is better than a fine one that stands.
  coarser() {
    const ratio = this.renderer.getPixelRatio();
    if (ratio <= COARSEST) return;
    this.renderer.setPixelRatio(Math.max(COARSEST, 0.75 * ratio));
    this.resize();
  }

  // Waits until the graphics processor has drawn.
  settle() {
    const context = this.renderer.getContext();
    context.readPixels(0, 0, 1, 1, context.RGBA, context.UNSIGNED_BYTE, new Uint8Array(4));
  }
}

// A colour of the page.
const tint = (name) => new Color(getComputedStyle(document.documentElement).getPropertyValue(name).trim());
