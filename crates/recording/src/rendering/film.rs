//! An episode in the form in which pictures draw it, from its recording.

use crate::recording::{Channel, Frame, Playback};
use cocarry::geometry::PlanarPose;
use cocarry_output::drawing::{Film, Letters, Moment, STAND_IN, stand_in};

/// The film of an episode: a moment at the beginning of every step, and at the end.
pub fn film(playback: &Playback, letters: Letters) -> Film<'_> {
    let prepared = &playback.prepared;
    let steps = Steps::of(playback);
    Film {
        world: prepared.world(),
        options: prepared.options(),
        base: prepared.robot().map_or(&STAND_IN, |robot| &robot.footprint),
        moments: playback.frames.iter().map(|frame| steps.moment(playback, frame)).collect(),
        letters,
    }
}

/// The figures of the steps.
struct Steps {
    times: Vec<f64>,
    stubbornness: Vec<f64>,
    human_leads: Vec<bool>,
    probabilities: Vec<Vec<f64>>,
}

impl Steps {
    fn of(playback: &Playback) -> Self {
        let decided = playback.messages(Channel::Coordination).iter();
        let options = playback.prepared.options().options();
        let mut known = vec![f64::NAN; options.len()];
        let probabilities = playback.messages(Channel::Options).iter().map(|(_, step)| {
            // where P_o is not evaluated, it stays what it was
            for (option, known) in options.iter().zip(&mut known) {
                let found = step["options"].as_array().into_iter().flatten();
                let found =
                    found.filter(|o| o["name"] == *option.name).find_map(|o| o["probability"].as_f64());
                *known = found.unwrap_or(*known);
            }
            known.clone()
        });
        Self {
            times: playback.times(Channel::Coordination),
            stubbornness: playback.column(Channel::Coordination, "stubbornness"),
            human_leads: decided.map(|(_, step)| step["mode"] == "human-led").collect(),
            probabilities: probabilities.collect(),
        }
    }

    fn moment(&self, playback: &Playback, frame: &Frame) -> Moment {
        let time = frame.time as f64 / 1e9;
        let begun = self.times.partition_point(|begin| *begin <= time + 1e-6);
        let step = begun.saturating_sub(1);
        let object = PlanarPose::from_above(&frame.object);
        let (base, grasp) = match playback.prepared.robot() {
            Some(robot) => {
                let world_from_drive = frame.links[robot.base_link] * robot.drive_from_base().inverse();
                let grasp = PlanarPose::from_above(&frame.links[robot.grasp_link]);
                (PlanarPose::from_above(&world_from_drive), grasp.position)
            }
            None => stand_in(&object, playback.prepared.world().object.size[0]),
        };
        let happened = playback.events.iter().rev().find(|event| event.time <= frame.time);
        let together = playback.events.iter().filter(|e| happened.is_some_and(|last| last.time == e.time));
        let sentences: Vec<&str> = together.map(|event| event.sentence.as_str()).collect();
        Moment {
            time,
            base,
            grasp,
            object,
            human: PlanarPose::from_above(&frame.torso),
            stubbornness: self.stubbornness[step],
            human_leads: self.human_leads[step],
            probabilities: self.probabilities.get(step).cloned().unwrap_or_default(),
            sentence: sentences.join("; "),
        }
    }
}
