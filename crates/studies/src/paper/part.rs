//! A claim's part of the report: its runs, and its section.

use super::{arrivals, contacts, cycles as locked, h2, h3, h4, slots, starts};
use crate::parallel::OnDone;
use crate::table::Table;
use cocarry::Error;
use cocarry::episode::EpisodeSettings;
use cocarry::robot::Robot;

/// The extent of a report.
#[derive(Clone, Debug)]
pub struct Plan<'a> {
    /// The robot of Table III and of the team with bodies.
    pub robot: &'a Robot,
    /// Settings of the episodes.
    pub settings: EpisodeSettings,
    /// Number of random humans in each cell of Table III.
    pub episodes: usize,
    /// Number of random humans in each cell of Table III with bodies.
    pub episodes_with_bodies: usize,
    /// Number of humans in each world with each method, in the study of arrivals.
    pub seeds: usize,
    /// Number of humans in each cell of Table II with bodies.
    pub humans: usize,
    /// Number of random worlds in the search for locked cycles.
    pub worlds: usize,
    /// The same with a robot on the kinematic plant.
    pub worlds_with_robot: usize,
    /// The same with bodies.
    pub worlds_with_bodies: usize,
    /// The guides of the base that are compared.
    pub guides: &'static [h3::guide::Guide],
    /// Number of walks through each opening from each angle.
    pub walks: usize,
    /// Number of turns before and after a slot, the first of [`slots::OFFSETS_M`].
    pub slot_turns: usize,
    /// Number of walks through each slot with each turn.
    pub slot_walks: usize,
    /// Number of random indoor worlds in the study of starts.
    pub rooms: usize,
    /// Number of people of each kind in each group of worlds, about whom the robot learns.
    pub people: usize,
    /// Number of simulated studies in each cell of the coverage of the fits.
    pub fits: usize,
    /// Seed of all random draws.
    pub seed: u64,
}

impl<'a> Plan<'a> {
    /// The extent of the paper and of the commands for the single claims.
    pub fn new(robot: &'a Robot) -> Self {
        Self {
            robot,
            settings: EpisodeSettings::default(),
            episodes: h3::EPISODES,
            episodes_with_bodies: h3::EPISODES_WITH_BODIES,
            seeds: arrivals::SEEDS,
            humans: h2::SAMPLES,
            worlds: locked::WORLDS,
            worlds_with_robot: locked::WORLDS_WITH_ROBOT,
            worlds_with_bodies: locked::WORLDS_WITH_BODIES,
            guides: h3::guide::Guide::ALL,
            walks: contacts::WALKS,
            slot_turns: slots::OFFSETS_M.len(),
            slot_walks: slots::WALKS,
            rooms: starts::WORLDS,
            people: h4::HUMANS,
            fits: 500,
            seed: 0,
        }
    }

    /// A little of everything: a first look, and whether figures of the whole extent are still those of this
    /// program.
    pub fn short(robot: &'a Robot) -> Self {
        Self {
            episodes: 2,
            episodes_with_bodies: 1,
            seeds: 1,
            humans: 2,
            worlds: 1000,
            worlds_with_robot: 100,
            worlds_with_bodies: 40,
            guides: h3::guide::Guide::FEW,
            walks: 1,
            slot_turns: 1,
            slot_walks: 1,
            rooms: 4,
            people: 2,
            fits: 2,
            ..Self::new(robot)
        }
    }
}

/// A claim and its evaluation.
pub struct Part {
    /// Name in arguments and in the index of tables.
    pub id: &'static str,
    /// Name in a progress bar.
    pub name: &'static str,
    /// Number of episodes that it runs.
    pub episodes: fn(&Plan) -> usize,
    /// Number of simulated studies of people that it fits.
    pub studies: fn(&Plan) -> usize,
    /// Runs the episodes.
    pub run: fn(&Plan, OnDone) -> Result<Section, Error>,
}

/// For parts without episodes, or without simulated studies.
pub(super) fn none(_: &Plan) -> usize {
    0
}

/// A section of the report.
#[derive(Clone, Debug)]
pub struct Section {
    /// Its heading.
    pub title: String,
    /// The finding on the claim.
    pub finding: Finding,
    /// Contents.
    pub blocks: Vec<Block>,
}

/// The finding on a claim, in words and figures of this run.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The claim.
    pub claim: &'static str,
    /// Whether it holds.
    pub verdict: String,
    /// The figures behind the verdict.
    pub figures: String,
}

/// A piece of a section.
#[derive(Clone, Debug)]
pub enum Block {
    /// Paragraphs, as Markdown.
    Text(String),
    /// A table.
    Table(Table),
    /// A picture.
    Figure(Figure),
}

impl Block {
    /// The table, if it is one.
    pub fn table(&self) -> Option<&Table> {
        if let Self::Table(table) = self { Some(table) } else { None }
    }

    /// The picture, if it is one.
    pub fn figure(&self) -> Option<&Figure> {
        if let Self::Figure(figure) = self { Some(figure) } else { None }
    }
}

/// A picture with its caption.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// File name without extension.
    pub name: String,
    /// Caption.
    pub caption: String,
    /// Whether two such pictures are placed side by side, where there is room.
    pub is_half: bool,
    /// The picture, as SVG.
    pub svg: String,
}

/// `n of m` in words: whether a claim holds in all of them.
pub(crate) fn holds(n: usize, of: usize, what: &str) -> String {
    match n {
        _ if n == of => "holds".to_owned(),
        0 => "does not hold".to_owned(),
        _ => format!("holds in {n} of {of} {what}"),
    }
}

/// A number with separated thousands.
pub(crate) fn grouped(n: usize) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_words_for_numbers() {
        assert_eq!([0, 999, 1000, 25600, 1234567].map(grouped), ["0", "999", "1,000", "25,600", "1,234,567"]);
        assert_eq!(holds(16, 16, "cells"), "holds");
        assert_eq!(holds(0, 16, "cells"), "does not hold");
        assert_eq!(holds(3, 16, "cells"), "holds in 3 of 16 cells");
    }
}
