//! Motors and grips as actuators, and gears as equalities.

use super::text::{number, numbers};
use super::{AXES, FRONT};
use crate::xml::escaped;
use cocarry::simulation::{BodyModel, GripModel, JointModel, PlantModel};

/// Time constant, s, and damping ratio of the gear between a joint and one that mimics it.
const GEAR: &str = "0.002 1";

/// An actuator that takes a control.
pub struct Control {
    /// Its name.
    pub name: String,
    /// Its element.
    pub text: String,
    /// Its control at the start.
    pub start: f64,
}

/// The actuators that take a control.
pub fn controls(model: &PlantModel, arm_joints: usize, joint_names: &[String]) -> Vec<Control> {
    let gain = number(model.base_gain);
    let mut controls = Vec::new();
    for axis in ["x", "y", "yaw"] {
        let name = format!("base_{axis}");
        let text = format!(
            "    <general name=\"{name}\" joint=\"{name}\" gainprm=\"{gain}\" biastype=\"affine\" biasprm=\"0 0 -{gain}\"/>\n"
        );
        controls.push(Control { name, text, start: 0.0 });
    }
    // in the order of the robot's arm joints, as everywhere
    for arm_joint in 0..arm_joints {
        for (body, name) in model.bodies.iter().zip(joint_names) {
            let Some(joint) = &body.joint else { continue };
            if joint.mimics.is_some() || joint.arm_joint != arm_joint {
                continue;
            }
            let [stiffness, damping] = [joint.stiffness, joint.damping].map(number);
            let range = joint.effort_limit.map(|limit| format!(" {}", force_range(limit)));
            let text = format!(
                "    <general name=\"{0}\" joint=\"{0}\" gainprm=\"{stiffness}\" biastype=\"affine\" biasprm=\"0 -{stiffness} -{damping}\"{1}/>\n",
                escaped(name),
                range.unwrap_or_default()
            );
            controls.push(Control { name: name.clone(), text, start: joint.start });
        }
    }
    let grip = &model.hand_grip;
    let axes = ["x", "y", "z", "roll", "pitch", "yaw"];
    for (i, axis) in axes.into_iter().enumerate() {
        let mut gear = [0.0; 6];
        gear[i] = 1.0;
        let rest = if axis == "z" { grip.rest } else { 0.0 };
        let turning = GripModel {
            stiffness: grip.angular_stiffness,
            damping: grip.angular_damping,
            limits: [grip.limits[1]; 2],
            ..*grip
        };
        let along = if i < 3 { grip } else { &turning };
        let name = format!("hand_{axis}");
        let text = format!(
            "    <general name=\"{name}\" site=\"{FRONT}\" refsite=\"hand\" gear=\"{}\" gainprm=\"{}\" {}/>\n",
            numbers(&gear),
            number(along.damping),
            spring(along, rest)
        );
        controls.push(Control { name, text, start: 0.0 });
    }
    controls
}

/// The gripper's springs, which take no control.
pub fn gripper(grip: &GripModel) -> String {
    let springs = AXES.into_iter().zip([0.0, 0.0, grip.rest]).map(|(axis, rest)| {
        let spring = spring(grip, rest);
        format!("    <general name=\"gripper_{axis}\" joint=\"grip_{axis}\" gainprm=\"0\" {spring}/>\n")
    });
    springs.collect()
}

/// The gears of joints that mimic others.
pub fn gears(bodies: &[BodyModel], joint_names: &[String]) -> String {
    let mut text = String::new();
    for (body, name) in bodies.iter().zip(joint_names) {
        let Some((joint, [ratio, offset])) = body.joint.as_ref().and_then(|j| Some((j, j.mimics?))) else {
            continue;
        };
        let is_driver = |joint: &JointModel, arm| joint.mimics.is_none() && joint.arm_joint == arm;
        let driver =
            bodies.iter().position(|b| b.joint.as_ref().is_some_and(|j| is_driver(j, joint.arm_joint)));
        let Some(driver) = driver else { continue };
        text += &format!(
            "    <joint joint1=\"{}\" joint2=\"{}\" polycoef=\"{} 0 0 0\" solref=\"{GEAR}\"/>\n",
            escaped(name),
            escaped(&joint_names[driver]),
            numbers(&[offset, ratio])
        );
    }
    if text.is_empty() { text } else { format!("  <equality>\n{text}  </equality>\n") }
}

/// Spring and damper of a grip along an axis, as attributes of an actuator.
fn spring(grip: &GripModel, rest: f64) -> String {
    let GripModel { stiffness, damping, limits: [limit, _], .. } = *grip;
    format!(
        "biastype=\"affine\" biasprm=\"{}\" {}",
        numbers(&[stiffness * rest, -stiffness, -damping]),
        force_range(limit)
    )
}

fn force_range(limit: f64) -> String {
    format!("forcerange=\"{}\"", numbers(&[-limit, limit]))
}
