//! s: the motion that the grasp should make, which eqs. (7) and (8) track.

use super::Way;
use crate::control::{HORIZON, Intent, Manipulator, PoseCriterion, Reference, reference};
use crate::coordination::Mode;
use crate::geometry::{Path, PlanarPose, Point, Pose, wrap_angle};
use crate::plant::Seen;
use crate::policy::Motion;
use crate::preference::ChoiceDistribution;
use crate::team::{Pace, PathAhead, Widened};

/// The references of every option with their weights, and the estimate of the human's intent behind them.
#[derive(Clone, Debug)]
pub struct References {
    pub(super) intent: Intent,
    pace: Pace,
    paths: Vec<Path>,
    /// s_o(1..H): of all options while the human leads, else of the leader's path.
    pub references: Vec<Reference>,
    /// The weight of each in eq. (8).
    pub weights: Vec<f64>,
    /// The option that the robot expects the human to walk; none while the robot leads.
    pub tracked: Option<usize>,
    /// The option on which the human was seen at the beginning of the planning step.
    seen_on: usize,
    /// Pose of the grasp at the beginning of the planning step.
    begun_at: PlanarPose,
    /// The poses of a policy's reference, one per control period; none where the reference is the leader's.
    pub(super) given: Option<[PlanarPose; HORIZON]>,
    widened: Widened,
}

impl References {
    /// References for a world with this number of options. `concentration` is that of a von Mises distribution
    /// of the walking direction on an option.
    pub fn new(concentration: f64, pace: Pace, options: usize) -> Self {
        Self {
            intent: Intent::new(concentration),
            pace,
            // longer than the paths of worlds: the remainder of an option may grow when the team turns away
            // from it
            paths: (0..options).map(|_| Path::with_capacity(64)).collect(),
            references: Vec::with_capacity(options),
            weights: Vec::with_capacity(options),
            tracked: None,
            seen_on: 0,
            begun_at: PlanarPose { position: Point::origin(), yaw: 0.0 },
            given: None,
            widened: Widened::default(),
        }
    }

    /// The reference to track in this period.
    pub fn to_track(&self) -> &Reference {
        &self.references[self.tracked.unwrap_or(0)]
    }

    /// Where the reference to track takes a grasp that is `at` a pose now, one pose per control period.
    pub fn poses(&self, at: &PlanarPose) -> [PlanarPose; HORIZON] {
        let reference = self.to_track();
        std::array::from_fn(|t| PlanarPose {
            position: at.position + reference.fixed_view::<2, 1>(0, t),
            yaw: at.yaw + reference[(5, t)],
        })
    }

    /// Sets the references of this period, relative to the grasp. Returns the path ahead of the team.
    pub fn set<'s>(
        &mut self,
        seen: &Seen<'_>,
        way: &Way<'s>,
        belief: &ChoiceDistribution,
        grasp: &Pose,
        manipulator: &Manipulator<'_>,
    ) -> PathAhead<'s> {
        let height = manipulator.robot.grasp_height;
        let Way { mode, travel, path, along, walk, .. } = *way;
        let lead = match mode {
            Mode::RobotLed => 0.0,
            Mode::HumanLed => walk.lead(seen, path, along),
        };
        let ahead = PathAhead { mode, travel, path, along, lead, turn: None };
        (self.tracked, self.given) = (None, None);
        if way.period[0] == 0 {
            self.begun_at = PlanarPose::from_above(grasp);
        }
        match (way.motion, way.mode) {
            (Motion::Reference(poses), _) => {
                let [begun, count] = way.period.map(f64::from);
                let pose = |period| pose_between(&self.begun_at, poses, (begun + period) / count);
                let poses = std::array::from_fn(|period| pose((period + 1) as f64));
                self.given = Some(poses);
                self.only(reference(poses.into_iter(), grasp, height));
            }
            (_, Mode::HumanLed) => self.anticipate(seen, way, &ahead, belief, grasp, manipulator),
            // the robot knows its own path
            (_, Mode::RobotLed) => {
                self.only(way.walk.reference(seen, &ahead, self.pace.speed, grasp, height));
            }
        }
        ahead
    }

    fn only(&mut self, reference: Reference) {
        self.references.clear();
        self.references.push(reference);
        self.weights.clear();
        self.weights.push(1.0);
    }

    /// Sets s_o(1..H) of every option from the human's position.
    fn anticipate(
        &mut self,
        seen: &Seen<'_>,
        way: &Way<'_>,
        ahead: &PathAhead<'_>,
        belief: &ChoiceDistribution,
        grasp: &Pose,
        manipulator: &Manipulator<'_>,
    ) {
        let probabilities = belief.probabilities();
        let body = seen.body();
        // the human is looked at once in a planning step: in less, the way walked says less
        let looks = way.period[0] == 0;
        if looks {
            self.seen_on = self.intent.observe(body, probabilities);
            self.intent.see_hand(seen.hand(), self.pace.step);
        }
        let tracked = self.seen_on;
        let observed = way.walk.observed_speed(seen, &self.intent, way.travel);
        self.references.clear();
        for (option, path) in self.paths.iter_mut().enumerate().take(probabilities.len()) {
            way.options.write_path(way.progress, option, way.walk.passing(), path);
            way.walk.expect(way.path, way.along, path, &mut self.widened);
            let ahead = PathAhead { turn: Some(path), ..*ahead };
            let height = manipulator.robot.grasp_height;
            self.references.push(way.walk.reference(seen, &ahead, observed, grasp, height));
        }
        if looks {
            let step = observed * self.pace.step;
            let from = ahead.lead.max(0.0);
            self.intent.expect(self.paths.iter().map(|path| {
                let [from, to] = [from, from + step].map(|walked| path.point_at(walked).unwrap_or(body));
                to - from
            }));
        }
        self.weights.clear();
        let uniform = 1.0 / probabilities.len() as f64;
        let criterion = manipulator.control.criterion;
        self.weights.extend(probabilities.iter().enumerate().map(|(option, p)| match criterion {
            PoseCriterion::Expected | PoseCriterion::Manipulability => *p,
            PoseCriterion::Uniform => uniform,
            PoseCriterion::Tracked => f64::from(u8::from(option == tracked)),
        }));
        self.tracked = Some(tracked);
    }
}

/// The pose at a time in planning steps, among poses at the ends of the steps; before the first, from `begin`.
fn pose_between(begin: &PlanarPose, poses: &[PlanarPose; HORIZON], time: f64) -> PlanarPose {
    let at = |step: usize| match step {
        0 => *begin,
        _ => poses[(step - 1).min(HORIZON - 1)],
    };
    let (before, share) = (time.floor() as usize, time - time.floor());
    let from = at(before);
    if share == 0.0 {
        return from;
    }
    let to = at(before + 1);
    PlanarPose {
        position: from.position + (to.position - from.position) * share,
        yaw: wrap_angle(from.yaw + wrap_angle(to.yaw - from.yaw) * share),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_poses_between_planning_steps_are_on_straight_lines() {
        let begin = PlanarPose { position: Point::new(1.0, 0.0), yaw: 3.1 };
        let poses =
            std::array::from_fn(|i| PlanarPose { position: Point::new(2.0 + i as f64, 0.0), yaw: -3.1 });
        let quarter = pose_between(&begin, &poses, 0.25);
        assert!((quarter.position.x - 1.25).abs() < 1e-15);
        // the short way round: 0.083 rad in all
        assert!((wrap_angle(quarter.yaw - 3.1) - (std::f64::consts::TAU - 6.2) / 4.0).abs() < 1e-12);
        assert_eq!(pose_between(&begin, &poses, 3.0), poses[2]);
        assert_eq!(pose_between(&begin, &poses, 40.5), poses[HORIZON - 1]);
    }
}
