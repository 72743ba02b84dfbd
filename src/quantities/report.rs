//! The report of an episode in sentences, for `cocarry run` and the page.

use super::View;
use crate::episode::{ControlSummary, GRASP_WARNING_RMS_M, HumanSummary};
use crate::robot::{JointVector, Robot};
use std::fmt::Write;

/// The share of a limit from which on it is reached.
const AT_LIMIT: f64 = 0.98;
/// A joint nearer to its limit is there, rad or m.
const AT_END: f64 = 0.01;

/// Names in a sentence, each once.
fn named(mut names: Vec<&str>) -> String {
    names.dedup();
    names.join(", ")
}

impl View<'_> {
    /// What the episode came to: costs, the human's part, and the robot's, in indented lines.
    pub fn conclusion(&self) -> String {
        let summary = self.episode.summary();
        let mut text = format!("  accumulated objective cost {:.2} m\n", summary.accumulated_cost);
        let HumanSummary { stubbornness, discomfort, subjective_cost, .. } = summary.human;
        let subjective =
            subjective_cost.map_or(String::new(), |cost| format!("; accumulated subjective cost {cost:.2}"));
        let _ = writeln!(
            text,
            "  human: final phi {stubbornness:.3}, discomfort g {discomfort:.2}; spent {:.0} % of the steps on an option they did not prefer{subjective}",
            100.0 * summary.human.share_off_preference(summary.steps)
        );
        if let (Some((robot, setup)), Some(control)) =
            (self.prepared.robot().zip(self.prepared.scenario().plant.robot_setup()), &summary.control)
        {
            text += &self.control_text(robot, &setup.posture, control);
        }
        text
    }

    fn control_text(&self, robot: &Robot, posture: &str, control: &ControlSummary) -> String {
        let steps = self.episode.summary().steps;
        let mut text = format!(
            "\nThe robot ({}, starting from `{}`)\n  control cost C {:.1}: tracking {:.1}, effort {:.1}, pose {:.1}\n",
            robot.name,
            posture,
            control.cost(),
            control.tracking,
            control.effort,
            control.pose
        );
        let _ = writeln!(
            text,
            "  tracking error {:.1} mm rms, {:.1} mm at most; limits active in {} of {steps} steps, configuration changed in {}",
            1e3 * control.error_rms(steps),
            1e3 * control.largest_error,
            control.constrained_steps,
            control.pose_changes
        );
        if control.least_clearance.is_finite() {
            let _ = writeln!(
                text,
                "  base at least {:.3} m clear of obstacles{}",
                control.least_clearance,
                if control.overlapping_steps > 0 { ": it overlaps one, which this plant allows" } else { "" }
            );
        }
        if let Some(interaction) = &self.episode.summary().interaction {
            let _ = writeln!(
                text,
                "  the human's force on the object: mean {:.1} N, rms {:.1} N; neither grip exceeds {:.0} N or gives way by more than {:.1} cm",
                interaction.mean_force(),
                interaction.rms_force(),
                interaction.peak_force,
                100.0 * interaction.deflection
            );
            let _ = writeln!(
                text,
                "  the arm's motors exert at most {:.0} % of their effort limits{}",
                100.0 * interaction.effort_share,
                at_limit(robot, &interaction.time_at_limit)
            );
        }
        if control.fallback_steps > 0 {
            let _ =
                writeln!(text, "  eq. (7) had no solution in {} steps: see --ticks", control.fallback_steps);
        }
        text
    }

    /// The limits at which the robot was: of effort in the episode, of speed and reach in its last step.
    fn reached_limits(&self) -> Option<String> {
        let (robot, tick) = self.prepared.robot().zip(self.episode.tick().robot)?;
        let mut reached = Vec::new();
        let share = self.episode.summary().interaction.map_or(0.0, |interaction| interaction.effort_share);
        if share >= AT_LIMIT {
            reached.push(format!("effort (a motor of the arm at {:.0} % of its own)", 100.0 * share));
        }
        let limits = robot.input_limits();
        let is_fast = |i: &usize| tick.input[*i].abs() >= AT_LIMIT * limits[*i];
        let base = robot.drive.inputs();
        let fast: Vec<&str> = (0..base + robot.joint_count())
            .filter(is_fast)
            .map(|i| if i < base { "the base" } else { &robot.joints[i - base].name })
            .collect();
        if !fast.is_empty() {
            reached.push(format!("speed ({} in the last step)", named(fast)));
        }
        let joints = robot.joints.iter().zip(tick.configuration.joints.iter());
        let ends: Vec<&str> = joints
            .filter(|(joint, at)| (joint.upper - **at).min(**at - joint.lower) < AT_END)
            .map(|(joint, _)| joint.name.as_str())
            .collect();
        if !ends.is_empty() {
            reached.push(format!("reach ({} in the last step)", named(ends)));
        }
        (!reached.is_empty()).then(|| reached.join(", "))
    }

    /// Warnings about the episode: a grasp far from its reference, and a robot that touched itself.
    pub fn warnings(&self) -> Vec<String> {
        let control = self
            .episode
            .summary()
            .control
            .map(|control| (control.error_rms(self.episode.summary().steps), control));
        let limits = self.reached_limits();
        let off = control.filter(|(rms, _)| *rms >= GRASP_WARNING_RMS_M).map(|(rms, control)| {
            let limits = limits.as_ref().map_or(String::new(), |limits| format!("; the robot was at its limits of {limits}"));
            format!(
                "the grasp is {:.1} cm (rms), {:.1} cm at most, from its reference on the planned path: the robot does not keep up, \
                 or the hand leaves the path{limits}",
                100.0 * rms,
                100.0 * control.largest_error
            )
        });
        // told once
        let is_lost = off.is_none() && self.episode.summary().loss.is_some();
        let lost =
            limits.filter(|_| is_lost).map(|limits| format!("the robot was at its limits of {limits}"));
        let off = off.or(lost);
        off.into_iter().chain(self.self_contact()).collect()
    }
}

/// Which motors were at their limits, and how long; empty if none was.
fn at_limit(robot: &Robot, times: &JointVector) -> String {
    let of_joints = robot.joints.iter().zip(times.iter()).filter(|(_, time)| **time > 0.0);
    let of_joints = of_joints.map(|(joint, time)| {
        let unit = joint.motion.effort_unit();
        format!("`{}` for {time:.2} s at {:.1} {unit}", joint.name, joint.effort_limit)
    });
    let of_joints: Vec<String> = of_joints.collect();
    if of_joints.is_empty() { String::new() } else { format!(": {}", of_joints.join(", ")) }
}
