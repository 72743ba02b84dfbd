//! The human of the scene: a figure whose legs walk with the distance covered and whose arms reach the object.
//!
//! Everything is in the frame [`HUMAN`](super::frames::HUMAN): on the floor below the torso, x ahead, z up. The
//! pose depends on the state of the episode alone, so that it is the same however the episode came there.

use super::frames::{HUMAN, WORLD, transform};
use super::shapes::{Shapes, moving, rgba};
use cocarry::geometry::Pose;
use cocarry_output::figure::{
    ANKLE, FOREARM, GRIP, HIP, HIP_HALF, LIMBS, REACH, SHIN, SHOULDER, STANCE, STRIDE, THIGH, UPPER_ARM,
};
use cocarry_output::palette;
use foxglove::messages::{FrameTransform, Quaternion, SceneEntity};
use nalgebra::{Matrix3, Rotation3, Translation3, Vector3};

/// Coordinates are whole multiples of this, m; so they need few bytes.
const GRID: f64 = 1.0 / 8192.0;

/// The state that the figure shows.
pub(super) struct Stance {
    /// `world_from_torso`.
    pub torso: Pose,
    /// `world_from_hand`: the middle of the object's end.
    pub hand: Pose,
    /// Width of the object, m.
    pub width: f64,
    /// Distance walked, m.
    pub walked: f64,
    /// Whether the human walks backward.
    pub is_backward: bool,
}

fn side_frame(side: f64, part: &str) -> String {
    format!("{HUMAN}/{}_{part}", if side > 0.0 { "left" } else { "right" })
}

fn along_z(from: Vector3<f64>, to: Vector3<f64>) -> Pose {
    let z = (to - from).try_normalize(1e-9).unwrap_or(-Vector3::z());
    let y = z.cross(&Vector3::x()).try_normalize(1e-9).unwrap_or(Vector3::y());
    let turned = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[y.cross(&z), y, z]));
    Pose::from_parts(Translation3::from(from), turned)
}

/// Rounds a turn to the grid. The largest part follows from the others, so that the length is 1.
fn round_turn(turn: &mut Quaternion) {
    let mut parts = [&mut turn.x, &mut turn.y, &mut turn.z, &mut turn.w];
    parts.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    let [others @ .., largest] = parts;
    let mut left = 1.0;
    for part in others {
        *part = (*part / GRID).round() * GRID;
        left -= *part * *part;
    }
    *largest = left.sqrt().copysign(*largest);
}

impl Stance {
    /// The frames of the figure: the human on the floor, and the moving limbs below it.
    pub fn transforms(&self, time: u64) -> Vec<FrameTransform> {
        let world_from_human = upright(&self.torso);
        let human_from = |pose: &Pose| world_from_human.inverse() * pose;
        let mut frames = vec![transform(WORLD, HUMAN, &world_from_human, time)];
        let hand = human_from(&self.hand);
        for side in [1.0, -1.0] {
            let [thigh, shin, foot] = self.leg(side);
            let [upper_arm, forearm] = self.arm(side, &hand);
            let limbs = [("thigh", thigh), ("shin", shin), ("foot", foot)];
            for (part, pose) in limbs.into_iter().chain([("upper_arm", upper_arm), ("forearm", forearm)]) {
                let at = pose.translation.vector.map(|v| (v / GRID).round() * GRID);
                let pose = Pose::from_parts(Translation3::from(at), pose.rotation);
                let mut frame = transform(HUMAN, &side_frame(side, part), &pose, time);
                round_turn(frame.rotation.get_or_insert_default());
                frames.push(frame);
            }
        }
        frames
    }

    /// Thigh, shin and foot.
    fn leg(&self, side: f64) -> [Pose; 3] {
        let phase = self.walked / STRIDE - if side > 0.0 { 0.0 } else { 0.5 };
        let off = phase - phase.round();
        let reach = STANCE / 2.0 * STRIDE;
        // on the floor the foot stays behind; off the floor it overtakes the body
        let (ahead, lift) = if off.abs() <= STANCE / 2.0 {
            (-off * STRIDE, 0.0)
        } else {
            let part = (if off > 0.0 { off } else { 1.0 + off } - STANCE / 2.0) / (1.0 - STANCE);
            let smooth = part * part * (3.0 - 2.0 * part);
            (reach * (2.0 * smooth - 1.0), 0.36 * part * (1.0 - part))
        };
        let ahead = if self.is_backward { -ahead } else { ahead };
        let hip = Vector3::new(0.0, side * HIP_HALF, HIP);
        let ankle = Vector3::new(ahead, side * HIP_HALF, ANKLE + lift);
        let knee = joint(hip, ankle, [THIGH, SHIN], Vector3::x());
        [along_z(hip, knee), along_z(knee, ankle), Pose::translation(ankle.x, ankle.y, ankle.z)]
    }

    /// Upper arm and forearm, to the object.
    fn arm(&self, side: f64, hand: &Pose) -> [Pose; 2] {
        let [x, y, z] = SHOULDER;
        let shoulder = Vector3::new(x, side * y, z);
        let aside = (self.width / 2.0).max(0.035) + GRIP;
        let grip = (hand * Translation3::new(0.0, side * aside.min(REACH), 0.0)).translation.vector;
        let elbow = joint(shoulder, grip, [UPPER_ARM, FOREARM], Vector3::new(-0.6, side * 0.5, 0.0));
        [along_z(shoulder, elbow), along_z(elbow, grip)]
    }
}

/// The pose on the floor below a body, level.
pub(super) fn upright(body: &Pose) -> Pose {
    let at = body.translation.vector;
    let ahead = body.rotation * Vector3::x();
    let x = Vector3::new(ahead.x, ahead.y, 0.0).try_normalize(1e-9).unwrap_or(Vector3::x());
    let turned = Matrix3::from_columns(&[x, Vector3::z().cross(&x), Vector3::z()]);
    Pose::from_parts(Translation3::new(at.x, at.y, 0.0), Rotation3::from_matrix_unchecked(turned))
}

/// The joint between two bones from `a` to `b`, bent toward `pole`; on the line where `b` is too far away.
fn joint(a: Vector3<f64>, b: Vector3<f64>, [first, second]: [f64; 2], pole: Vector3<f64>) -> Vector3<f64> {
    let reach = (b - a).norm();
    let along = (b - a).try_normalize(1e-9).unwrap_or(-Vector3::z());
    if reach >= first + second {
        return a + along * first;
    }
    let on = (first * first - second * second + reach * reach) / (2.0 * reach.max(1e-9));
    let off = (first * first - on * on).max(0.0).sqrt();
    let aside = (pole - along * pole.dot(&along)).try_normalize(1e-9).unwrap_or_default();
    a + along * on + aside * off
}

/// The shapes of the figure, in its frames.
pub(super) fn shapes(time: u64) -> Vec<SceneEntity> {
    let [shirt, skin, trousers, hair, shoes] =
        [palette::HUMAN, palette::SKIN, palette::TROUSERS, palette::HAIR, palette::SHOES].map(rgba);
    let at = |x, y, z| Pose::translation(x, y, z);
    // a bone from a point to another, round at both ends
    let bone = |drawn: &mut SceneEntity, from: [f64; 3], to: [f64; 3], radius: f64, colour| {
        let (from, to) = (Vector3::from(from), Vector3::from(to));
        let middle = along_z(from, to) * Translation3::new(0.0, 0.0, (to - from).norm() / 2.0);
        drawn.capsule(&middle, radius, (to - from).norm(), colour);
    };
    let mut body = moving(HUMAN, time);
    bone(&mut body, [0.0, -0.07, HIP + 0.02], [0.0, 0.07, HIP + 0.02], 0.1, trousers);
    bone(&mut body, [0.0, 0.0, HIP + 0.08], [-0.04, 0.0, 1.16], 0.125, shirt);
    bone(&mut body, [-0.05, -0.06, 1.2], [-0.05, 0.06, 1.2], 0.12, shirt);
    bone(&mut body, [-0.058, -0.15, 1.36], [-0.058, 0.15, 1.36], 0.075, shirt);
    bone(&mut body, [-0.055, 0.0, 1.22], [-0.055, 0.0, 1.34], 0.12, shirt);
    bone(&mut body, [-0.06, 0.0, 1.38], [-0.03, 0.0, 1.54], 0.052, skin);
    body.ball(&at(-0.03, 0.0, 1.585), Vector3::new(0.21, 0.18, 0.24), skin);
    body.ball(&at(-0.05, 0.0, 1.612), Vector3::new(0.205, 0.19, 0.21), hair);
    body.ball(&at(0.078, 0.0, 1.57), Vector3::repeat(0.036), skin);
    let mut drawn = vec![body];
    for side in [1.0, -1.0] {
        for (part, [from, to], length, rgb) in LIMBS {
            let mut limb = moving(&side_frame(side, part), time);
            limb.limb([from, to], length, rgba(rgb));
            if part == "forearm" {
                limb.ball(&at(0.0, 0.0, length), Vector3::repeat(0.096), skin);
            }
            drawn.push(limb);
        }
        let mut foot = moving(&side_frame(side, "foot"), time);
        bone(&mut foot, [-0.02, 0.0, -0.03], [0.13, 0.0, -0.03], 0.045, shoes);
        drawn.push(foot);
    }
    drawn
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stance(walked: f64, is_backward: bool) -> Stance {
        let hand = Pose::translation(-0.35, 0.0, 0.8);
        Stance { torso: Pose::translation(0.0, 0.0, 0.85), hand, width: 0.1, walked, is_backward }
    }

    /// The position of a point of a limb, by the distance along it.
    fn along(limb: &Pose, distance: f64) -> Vector3<f64> {
        (limb * Translation3::new(0.0, 0.0, distance)).translation.vector
    }

    #[test]
    fn property_bones_keep_their_lengths_and_meet_whatever_the_phase() {
        for i in 0..200 {
            let stance = stance(0.013 * f64::from(i), i % 2 == 0);
            for side in [1.0, -1.0] {
                let [thigh, shin, foot] = stance.leg(side);
                let gap = (along(&thigh, THIGH) - shin.translation.vector).norm();
                assert!(gap < 1e-9, "knee {i}: {gap}");
                let gap = (along(&shin, SHIN) - foot.translation.vector).norm();
                assert!(gap < 1e-9, "ankle {i}: {gap}");
                let [upper, fore] = stance.arm(side, &stance.hand);
                assert!((along(&upper, UPPER_ARM) - fore.translation.vector).norm() < 1e-9, "elbow {i}");
                let grip = along(&fore, FOREARM);
                assert!((grip - Vector3::new(-0.35, side * 0.062, 0.8)).norm() < 1e-9, "hand {i}: {grip}");
            }
        }
    }

    #[test]
    fn a_foot_on_the_floor_stays_where_it_is_while_the_body_walks() {
        for is_backward in [false, true] {
            let sign = if is_backward { -1.0 } else { 1.0 };
            let foot = |walked: f64| {
                let [_, _, foot] = stance(walked, is_backward).leg(1.0);
                foot.translation.vector + Vector3::x() * (sign * walked)
            };
            // the left foot is down around the whole strides
            let down: Vec<_> = (-28..=28).map(|i| foot(STRIDE + 0.01 * f64::from(i))).collect();
            assert!(down.iter().all(|p| (p - down[0]).norm() < 1e-9 && p.z == ANKLE), "{down:?}");
            assert!(foot(1.5 * STRIDE).z > ANKLE + 0.05);
        }
    }
}
