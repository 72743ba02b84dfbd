//! The order in which participants see the worlds: a Latin square by index, balanced for what follows what.

use crate::study::{PeopleStudy, Task};
use serde::Serialize;

/// A page that a participant sees. Numbers count from 0, in the order of the study.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "task", rename_all = "lowercase")]
pub enum Trial {
    /// The consent.
    Consent,
    /// The instructions of a task.
    Instructions {
        /// The task.
        of: Task,
    },
    /// Percentages for the options of a world.
    Percentages {
        /// The world.
        world: usize,
        /// Whether the answer does not count.
        practice: bool,
    },
    /// A robot that leads on an option.
    Switch {
        /// The world.
        world: usize,
        /// The option.
        option: usize,
        /// How often the walk was shown before, and once more.
        repetition: u64,
        /// Whether the answer does not count.
        practice: bool,
    },
    /// Carrying along in a world.
    Carry {
        /// The world.
        world: usize,
        /// The name of the robot's method.
        method: &'static str,
        /// Whether it does not count.
        practice: bool,
    },
    /// A question with a right answer.
    Question {
        /// The question.
        question: usize,
    },
    /// A scale.
    Scale {
        /// The scale.
        scale: usize,
    },
}

impl Trial {
    /// What it asks, in words for tables: the task, then where.
    pub(crate) fn words(&self, study: &PeopleStudy) -> String {
        let world = |world: usize| &study.worlds[world].name;
        let practice = |is_practice: bool| if is_practice { ", practice" } else { "" };
        match *self {
            Self::Consent => "consent".to_owned(),
            Self::Instructions { of } => format!("instructions: {}", of.name()),
            Self::Percentages { world: at, practice: p } => {
                format!("percentages: {}{}", world(at), practice(p))
            }
            Self::Switch { world: at, option, repetition, practice: p } => {
                let again =
                    if study.switch_trials > 1 { format!(", walk {repetition}") } else { String::new() };
                let option = &study.worlds[at].options[option];
                format!("switch: {}, option {option}{again}{}", world(at), practice(p))
            }
            Self::Carry { world: at, method, practice: p } => {
                format!("carry: {}, {method}{}", world(at), practice(p))
            }
            Self::Question { question } => format!("question: {}", question + 1),
            Self::Scale { scale } => format!("scale: {}", study.scales[scale].name),
        }
    }
}

/// The orders of `count` items by which every item comes equally often at every place, and equally often
/// directly after every other (Williams). An odd number needs the mirrored orders too.
fn latin_square(count: usize) -> Vec<Vec<usize>> {
    // 0, 1, n - 1, 2, n - 2, ...
    let first: Vec<usize> =
        (0..count).map(|at| if at % 2 == 1 { at.div_ceil(2) } else { (count - at / 2) % count }).collect();
    let row = |shift: usize| first.iter().map(|item| (item + shift) % count).collect::<Vec<_>>();
    let rows: Vec<_> = (0..count).map(row).collect();
    let mirrored = rows.iter().map(|row| row.iter().rev().copied().collect());
    let mirrored: Vec<_> = if count % 2 == 1 && count > 1 { mirrored.collect() } else { Vec::new() };
    rows.into_iter().chain(mirrored).collect()
}

/// The pages of participants, one list for each row of the Latin square: participant i sees row i modulo their
/// number. The options of a world, and the robot's methods in it, begin with another one in each row.
pub fn orders(study: &PeopleStudy) -> Vec<Vec<Trial>> {
    // the practice world is the last one
    let count = study.measured_worlds();
    let rows = if study.has_latin_square { latin_square(count) } else { vec![(0..count).collect()] };
    rows.iter().enumerate().map(|(row, worlds)| pages(study, row, worlds)).collect()
}

fn pages(study: &PeopleStudy, row: usize, worlds: &[usize]) -> Vec<Trial> {
    let practice = study.practice_world();
    let (before, between): (Vec<usize>, Vec<usize>) =
        (0..study.questions.len()).partition(|&q| !study.questions[q].is_between);
    let ask = |questions: &[usize]| -> Vec<Trial> {
        questions.iter().map(|&question| Trial::Question { question }).collect()
    };
    let mut pages = vec![Trial::Consent];
    for (at, &task) in study.tasks.iter().enumerate() {
        pages.push(Trial::Instructions { of: task });
        if let Some(world) = practice {
            pages.push(match task {
                Task::Percentages => Trial::Percentages { world, practice: true },
                Task::Switch => Trial::Switch { world, option: 0, repetition: 1, practice: true },
                Task::Carry => Trial::Carry { world, method: study.methods[0].name(), practice: true },
            });
        }
        if at == 0 {
            pages.extend(ask(&before));
        }
        for repetition in 1..=study.trials(task) {
            for (place, &world) in worlds.iter().enumerate() {
                // another one comes first in each row, place and repetition
                let shift = row + place + repetition as usize - 1;
                pages.extend(measured(study, task, world, shift, repetition));
            }
        }
        if at == 0 {
            pages.extend(ask(&between));
        }
    }
    pages.extend(scales(study, false));
    pages
}

/// The pages of a task in a world, its options or methods rotated by `shift`, with the scales after every
/// carry.
fn measured(study: &PeopleStudy, task: Task, world: usize, shift: usize, repetition: u64) -> Vec<Trial> {
    let rotated = |count: usize| (0..count).map(move |at| (at + shift) % count);
    let practice = false;
    match task {
        Task::Percentages => vec![Trial::Percentages { world, practice }],
        Task::Switch => rotated(study.worlds[world].options.len())
            .map(|option| Trial::Switch { world, option, repetition, practice })
            .collect(),
        Task::Carry => rotated(study.methods.len())
            .map(|method| Trial::Carry { world, method: study.methods[method].name(), practice })
            .flat_map(|carry| [carry].into_iter().chain(scales(study, true)))
            .collect(),
    }
}

/// The pages of scales: of those after every carry, or of the others.
fn scales(study: &PeopleStudy, is_after_carry: bool) -> impl Iterator<Item = Trial> {
    let asked = move |scale: &usize| study.scales[*scale].is_after_carry == is_after_carry;
    (0..study.scales.len()).filter(asked).map(|scale| Trial::Scale { scale })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn property_every_item_has_every_place_and_follows_every_other_equally_often() {
        for count in 1..=9 {
            let rows = latin_square(count);
            assert_eq!(rows.len(), if count % 2 == 1 && count > 1 { 2 * count } else { count });
            let (mut places, mut after) = (BTreeMap::new(), BTreeMap::new());
            for row in &rows {
                for (place, &item) in row.iter().enumerate() {
                    *places.entry((place, item)).or_insert(0) += 1;
                }
                for pair in row.windows(2) {
                    *after.entry((pair[0], pair[1])).or_insert(0) += 1;
                }
            }
            let even = rows.len() / count;
            assert!(places.len() == count * count && places.values().all(|&n| n == even), "{rows:?}");
            assert!(after.len() == count * (count - 1) && after.values().all(|&n| n == even), "{rows:?}");
        }
    }
}
