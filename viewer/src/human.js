// The human as a figure: it walks with feet that stay where they are put, and its arms reach the object. Its measures
// are those of the recording's figure (episode.measures). The recording's gait follows from the distance walked alone;
// here the whole way is known, so that feet are planted and turning takes steps.
import {
  CapsuleGeometry, CylinderGeometry, Group, Mesh, MeshLambertMaterial, Quaternion, SphereGeometry, Vector3,
} from "three";
import { last, read } from "./episode.js";

// Turning on the spot takes steps, too: metres of walking per radian.
const TURNING = 0.25;

const up = new Vector3(0, 0, 1);

export class Human {
  constructor(episode) {
    const measures = this.measures = episode.measures;
    this.group = new Group();
    const material = Object.fromEntries(Object.entries(episode.colours).map(([name, color]) => [name, new MeshLambertMaterial({ color })]));
    const add = (geometry, colour) => {
      const mesh = new Mesh(geometry, material[colour]);
      mesh.castShadow = mesh.receiveShadow = true;
      this.group.add(mesh);
      return mesh;
    };
    const limb = ([from, to], colour) => {
      const bone = add(new CylinderGeometry(to, from, 1, 14), colour);
      const joint = add(new SphereGeometry(from, 14, 10), colour);
      const end = add(new SphereGeometry(to, 14, 10), colour);
      return (a, b) => {
        bone.position.addVectors(a, b).multiplyScalar(0.5);
        bone.scale.y = a.distanceTo(b);
        bone.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), new Vector3().subVectors(b, a).normalize());
        joint.position.copy(a);
        end.position.copy(b);
      };
    };
    this.pelvis = add(new CapsuleGeometry(0.1, 0.13, 6, 14), "trousers");
    this.waist = limb([0.122, 0.13], "human");
    this.chest = add(new CapsuleGeometry(0.115, 0.17, 6, 16), "human");
    this.yoke = limb([0.075, 0.075], "human");
    this.neck = limb([0.055, 0.05], "skin");
    this.head = add(new SphereGeometry(0.105, 22, 16), "skin");
    this.hair = add(new SphereGeometry(0.112, 22, 12, 0, 2 * Math.PI, 0, 1.65), "hair");
    this.nose = add(new SphereGeometry(0.018, 8, 6), "skin");
    this.sides = [1, -1].map((side) => ({
      side,
      upper: limb(measures.upper_arm.radii_m, "human"),
      fore: limb(measures.forearm.radii_m, "skin"),
      hand: add(new SphereGeometry(0.048, 12, 8), "skin"),
      thigh: limb(measures.thigh.radii_m, "trousers"),
      shin: limb(measures.shin.radii_m, "trousers"),
      shoe: add(new CapsuleGeometry(0.045, 0.15, 4, 10), "shoes"),
    }));
    this.take(episode);
  }

  // Walks through another episode.
  take(episode) {
    this.episode = episode;
    this.walked = [0];
    this.measure();
  }

  // The distance walked at every frame, which sets the phase of the gait. An episode that still runs gets more frames.
  measure() {
    const { torso, time_s: times } = this.episode.frames;
    const a = new Vector3(), b = new Vector3(), p = new Quaternion(), q = new Quaternion();
    for (let i = this.walked.length; i < times.length; i++) {
      read(torso, i - 1, a, p);
      read(torso, i, b, q);
      this.walked.push(this.walked[i - 1] + a.distanceTo(b) + TURNING * p.angleTo(q));
    }
  }

  // Position on the floor and heading of the body after a distance walked.
  body(distance) {
    const { torso } = this.episode.frames, { walked } = this;
    const end = walked[walked.length - 1];
    const limited = Math.min(Math.max(distance, 0), end);
    const after = Math.min(Math.max(1, last(walked, limited) + 1), walked.length - 1), before = Math.max(0, after - 1);
    const span = walked[after] - walked[before];
    const part = span > 0 ? Math.min(1, Math.max(0, (limited - walked[before]) / span)) : 0;
    const a = new Vector3(), b = new Vector3(), p = new Quaternion(), q = new Quaternion();
    read(torso, before, a, p);
    read(torso, after, b, q);
    const [at, turned] = [a.lerp(b, part).setZ(0), p.slerp(q, part)];
    // where an episode that still runs goes on is not known: straight ahead
    if (this.episode.isRunning && distance > end) at.addScaledVector(new Vector3(1, 0, 0).applyQuaternion(turned), distance - end);
    return { at, turned };
  }

  // Where a foot is: planted, or on its way to the next foothold.
  foot(side, distance) {
    const { hip_m: [, hip], stride_m: stride, stance_share: stance } = this.measures;
    const phase = distance / stride - (side > 0 ? 0 : 0.5);
    const hold = (n) => {
      const { at, turned } = this.body((n + (side > 0 ? 0 : 0.5)) * stride);
      return { at: at.add(new Vector3(0, side * hip, 0).applyQuaternion(turned)), turned };
    };
    const n = Math.round(phase);
    const off = phase - n;
    const planted = hold(n);
    if (Math.abs(off) <= stance / 2) {
      // the heel rises before the foot leaves the floor
      const heel = Math.max(0, (off - 0.12) / (stance / 2 - 0.12));
      return { ...planted, lift: 0.05 * heel, pitch: 0.5 * heel };
    }
    const from = off > 0 ? planted : hold(n - 1), to = off > 0 ? hold(n + 1) : planted;
    const part = ((off > 0 ? off : 1 + off) - stance / 2) / (1 - stance);
    const smooth = part * part * (3 - 2 * part);
    return {
      at: from.at.lerp(to.at, smooth),
      turned: from.turned.slerp(to.turned, smooth),
      lift: 0.05 * (1 - part) + 0.07 * Math.sin(Math.PI * part),
      pitch: 0.5 * (1 - part) - 0.25 * Math.sin(Math.PI * part),
    };
  }

  // Moves the figure to a place in the recording.
  update(place, torso, hand) {
    const { before, after, part } = place;
    if (this.walked.length < this.episode.frames.time_s.length) this.measure();
    const { hip_m, shoulder_m, stride_m, ankle_m, reach_m, grip_m, thigh, shin, upper_arm, forearm } = this.measures;
    const hipHeight = hip_m[2], shoulderHeight = shoulder_m[2];
    const distance = this.walked[before] + part * (this.walked[after] - this.walked[before]);
    const turned = torso.quaternion;
    const swing = (2 * Math.PI * distance) / stride_m;
    const local = (x, y, z) => new Vector3(x, y, 0).applyQuaternion(turned).add(torso.position).setZ(z);
    const bob = 0.012 * Math.cos(2 * swing), sway = 0.018 * Math.cos(swing);
    const hips = local(0, sway, hipHeight + 0.02 + bob);
    // the carrier leans back toward what is carried behind
    const chest = local(-0.055, sway * 0.6, 1.24 + bob);
    this.pelvis.position.copy(hips);
    this.pelvis.quaternion.copy(turned);
    this.waist(local(0, sway, hipHeight + 0.08 + bob), local(-0.04, sway * 0.7, 1.16 + bob));
    this.chest.position.copy(chest);
    this.chest.quaternion.copy(turned);
    this.chest.scale.set(0.95, 1, 1.25);
    const head = local(-0.03, sway * 0.4, 1.585 + bob);
    this.neck(local(-0.06, sway * 0.5, 1.38 + bob), head);
    for (const mesh of [this.head, this.hair]) mesh.position.copy(head);
    this.head.scale.set(1.02, 0.86, 1.16);
    this.head.quaternion.copy(turned);
    // the hair's dome opens forward and down
    const dome = new Quaternion().setFromAxisAngle(new Vector3(1, 0, 0), Math.PI / 2);
    const tilt = new Quaternion().setFromAxisAngle(new Vector3(0, 1, 0), -0.5);
    this.hair.quaternion.copy(turned).multiply(tilt).multiply(dome);
    this.hair.scale.set(1, 1.1, 0.86);
    this.nose.position.copy(head).add(new Vector3(0.108, 0, -0.015).applyQuaternion(turned));
    this.yoke(local(-0.058, 0.15 + sway * 0.6, shoulderHeight + bob), local(-0.058, -0.15 + sway * 0.6, shoulderHeight + bob));
    const half = Math.max(0.035, this.episode.world.object_m[1] / 2);
    for (const parts of this.sides) {
      const { side } = parts;
      const shoulder = local(shoulder_m[0], side * shoulder_m[1] + sway * 0.6, shoulderHeight + bob);
      const grip = new Vector3(0, side * Math.min(half + grip_m, reach_m), 0).applyQuaternion(hand.quaternion).add(hand.position);
      const elbow = bent(shoulder, grip, upper_arm.length_m, forearm.length_m, local(-0.6, side * 0.5, 0).sub(local(0, 0, 0)));
      parts.upper(shoulder, elbow);
      parts.fore(elbow, grip);
      parts.hand.position.copy(grip);
      const foot = this.foot(side, distance);
      const heading = new Vector3(1, 0, 0).applyQuaternion(foot.turned);
      const ankle = foot.at.clone().setZ(ankle_m + foot.lift);
      const hip = local(0, side * hip_m[1] + sway, hipHeight + bob);
      const knee = bent(hip, ankle, thigh.length_m, shin.length_m, heading);
      parts.thigh(hip, knee);
      parts.shin(knee, ankle);
      const sole = heading.clone().multiplyScalar(0.055);
      parts.shoe.position.copy(ankle).add(sole).add(new Vector3(0, 0, -0.03 - 0.05 * foot.pitch));
      const along = heading.clone().multiplyScalar(Math.cos(foot.pitch)).addScaledVector(up, -Math.sin(foot.pitch));
      parts.shoe.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), along);
    }
  }
}

// The joint between two bones from `a` to `b` that bends toward `pole`; straight where `b` is too far away.
function bent(a, b, first, second, pole) {
  const along = new Vector3().subVectors(b, a);
  const reach = along.length();
  along.normalize();
  if (reach >= first + second) return a.clone().addScaledVector(along, (reach * first) / (first + second));
  const on = (first * first - second * second + reach * reach) / (2 * reach);
  const off = Math.sqrt(Math.max(0, first * first - on * on));
  const aside = pole.clone().addScaledVector(along, -pole.dot(along)).normalize();
  return a.clone().addScaledVector(along, on).addScaledVector(aside, off);
}
