//! The best known results of the benchmark, as they ship with the program.

use super::Set;
use super::files::BEST;

/// A best known result.
#[derive(Clone, Debug, PartialEq)]
pub struct Best {
    /// The set.
    pub set: Set,
    /// The world, as in the column `world`.
    pub world: String,
    /// The policy that reached it.
    pub policy: String,
    /// Mean of 1 / (accumulated objective cost) of episodes that succeeded and 0 of others, 1/m.
    pub result: f64,
}

impl Best {
    /// All best known results, in the order of the worlds.
    pub fn all() -> impl Iterator<Item = Self> {
        BEST.lines().skip(1).map(|line| Self::of_line(line).expect("a line of the file that ships"))
    }

    fn of_line(line: &str) -> Option<Self> {
        let mut cells = line.split(',');
        let mut next = || cells.next();
        let (set, world, policy, result) = (next()?, next()?, next()?, next()?);
        let set = Set::ALL.into_iter().find(|known| known.name() == set)?;
        let result = result.parse::<f64>().ok()? / 1000.0;
        Some(Self { set, world: world.to_owned(), policy: policy.to_owned(), result })
    }
}

/// The best known result in a world.
pub(super) fn of(set: Set, world: &str) -> Option<Best> {
    Best::all().find(|best| (best.set, best.world.as_str()) == (set, world))
}
