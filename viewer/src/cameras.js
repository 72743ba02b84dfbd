// The cameras: overview, behind the team, over the human's shoulder. All can be turned by hand.
import { PerspectiveCamera, Vector3 } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

const up = new Vector3(0, 0, 1);

export class Cameras {
  constructor(canvas, stage, redraw) {
    this.stage = stage;
    this.camera = new PerspectiveCamera(42, 1, 0.05, 60 * stage.bounds.radius);
    this.camera.up.copy(up);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.maxPolarAngle = 0.49 * Math.PI;
    this.controls.enableDamping = false;
    this.controls.minDistance = 0.4;
    this.controls.maxDistance = 8 * stage.bounds.radius;
    this.controls.addEventListener("change", redraw);
    this.controls.addEventListener("start", () => (this.isTouched = true));
    this.anchor = null;
  }

  // A robot from a corner, from its side and from above, as large as the picture allows.
  frameRobot() {
    const { camera, controls, stage } = this;
    const from = { overview: new Vector3(0.75, -1, 0.5), follow: new Vector3(0, -1, 0.06), shoulder: new Vector3(-0.001, 0, 1) }[this.name].normalize();
    const { low, high } = stage.robotBox();
    const corners = [low.x, high.x].flatMap((x) => [low.y, high.y].flatMap((y) => [low.z, high.z].map((z) => new Vector3(x, y, z))));
    controls.target.addVectors(low, high).multiplyScalar(0.5);
    let near = 0.2, far = 20;
    for (let i = 0; i < 30; i++) {
      const distance = (near + far) / 2;
      camera.position.copy(controls.target).addScaledVector(from, distance);
      camera.lookAt(controls.target);
      camera.updateMatrixWorld();
      camera.updateProjectionMatrix();
      const fits = corners.every((corner) => {
        const { x, y, z } = corner.clone().project(camera);
        return z < 1 && Math.abs(x) < 0.92 && Math.abs(y) < 0.8;
      });
      if (fits) far = distance;
      else near = distance;
    }
  }

  // Chooses a camera and puts it where it begins.
  choose(name) {
    this.name = name;
    this.isTouched = false;
    this.camera.fov = this.stage.episode.postures ? 30 : name === "shoulder" ? 58 : 42;
    this.home();
  }

  resize(aspect) {
    this.camera.aspect = aspect;
    this.camera.updateProjectionMatrix();
    if (!this.isTouched) this.home();
  }

  // What the camera moves with: a place and a heading.
  moving() {
    const { object, torso } = this.stage;
    const body = this.name === "shoulder" ? torso : object;
    const ahead = new Vector3(1, 0, 0).applyQuaternion(body.quaternion);
    return { at: body.position.clone(), yaw: Math.atan2(ahead.y, ahead.x) };
  }

  home() {
    const { camera, controls } = this;
    const isRobot = this.stage.episode.postures;
    this.anchor = this.name === "overview" || isRobot ? null : this.moving();
    if (isRobot) {
      this.frameRobot();
    } else if (!this.anchor) {
      this.frameAll();
    } else {
      const [from, to] = this.name === "shoulder"
        ? [[-1.15, -0.48, 1.02], [3.2, 0.15, -0.55]]
        : [[-4.6, -2.1, 2.6], [0.5, 0, 0.1]];
      const place = ([x, y, z]) => new Vector3(x, y, z).applyAxisAngle(up, this.anchor.yaw).add(this.anchor.at);
      camera.position.copy(place(from));
      controls.target.copy(place(to));
    }
    camera.updateProjectionMatrix();
    controls.update();
  }

  // As close as everywhere the team may go still fits into the picture, in its middle.
  frameAll() {
    const { camera, controls, stage } = this;
    const { low, high } = stage.bounds.ways;
    const size = new Vector3().subVectors(high, low);
    // from the side on which the world is wider, so that it fills a wide picture
    const isTall = camera.aspect < 1;
    const from = (size.x >= size.y) !== isTall ? new Vector3(0, -1, 1.5) : new Vector3(-1, 0, 1.5);
    from.applyAxisAngle(up, 0.12).normalize();
    const corners = [low.x, high.x].flatMap((x) => [low.y, high.y].flatMap((y) => [0, 1].map((z) => new Vector3(x, y, z))));
    const target = new Vector3().addVectors(low, high).multiplyScalar(0.5).setZ(0);
    const seen = (distance) => {
      camera.position.copy(target).addScaledVector(from, distance);
      camera.lookAt(target);
      camera.updateMatrixWorld();
      camera.updateProjectionMatrix();
      return corners.map((corner) => corner.clone().project(camera));
    };
    let far = 12 * stage.bounds.radius;
    for (let round = 0; round < 4; round++) {
      let near = 1;
      far = 12 * stage.bounds.radius;
      for (let i = 0; i < 25; i++) {
        const distance = (near + far) / 2;
        const fits = seen(distance).every(({ x, y, z }) => z < 1 && Math.abs(x) < 0.97 && y < 0.84 && y > -0.86);
        if (fits) far = distance;
        else near = distance;
      }
      // the nearer part of the floor takes more room: the middle of the picture is not that of the world
      const ys = seen(far).map(({ y }) => y);
      const off = (Math.max(...ys) + Math.min(...ys)) / 2 + 0.01;
      const ahead = new Vector3(-from.x, -from.y, 0).normalize();
      target.addScaledVector(ahead, 0.5 * off * far * Math.tan((camera.fov * Math.PI) / 360) / from.z);
    }
    controls.target.copy(target);
    camera.position.copy(target).addScaledVector(from, far);
  }

  // Moves the camera with the team. `smooth` is the share of a turn that it takes up in this picture.
  follow(smooth) {
    if (!this.anchor) return;
    const { camera, controls, anchor } = this;
    const next = this.moving();
    const turn = Math.atan2(Math.sin(next.yaw - anchor.yaw), Math.cos(next.yaw - anchor.yaw)) * smooth;
    for (const place of [camera.position, controls.target]) {
      place.sub(anchor.at).applyAxisAngle(up, turn).add(next.at);
    }
    this.anchor = { at: next.at, yaw: anchor.yaw + turn };
    controls.update();
  }
}
