//! The worlds named in participants' answers.

use crate::model::{BeliefArguments, load_world_near};
use crate::output::{Failure, note};
use anyhow::Context;
use cocarry::world::World;
use cocarry_studies::fit::similar_names;
use std::error::Error;
use std::path::{Path, PathBuf};

/// The files that a fit reads: the answers in `file`, their worlds, and the samples of the belief.
pub(crate) fn inputs<T>(file: &Path, worlds: &[(String, T)], belief: &BeliefArguments) -> Vec<PathBuf> {
    let folder = file.parent().unwrap_or(Path::new(""));
    let worlds = worlds.iter().flat_map(|(world, _)| [folder.join(world), PathBuf::from(world)]);
    worlds.chain([file.to_owned()]).chain(belief.belief_samples.clone()).collect()
}

/// The largest number of notes on names.
const MAX_NOTES: usize = 10;

/// A name with its letters beyond ASCII by number, too, since two forms of a letter look the same.
fn quoted(name: &str) -> String {
    match name.is_ascii() {
        true => format!("`{name}`"),
        false => format!("`{name}` ({})", name.escape_default()),
    }
}

/// Notes participants whose names look alike: they are taken as different people.
pub(crate) fn note_similar<'n>(participants: impl IntoIterator<Item = &'n str>) {
    for [first, second] in similar_names(participants).into_iter().take(MAX_NOTES) {
        note(&format_args!(
            "participants {} and {} differ only by case or by Unicode form, and are taken as two people",
            quoted(first),
            quoted(second)
        ));
    }
}

/// The worlds that `file` names, each prepared by `prepared`, with the first line that names it.
pub(crate) fn load<T, E: Error + Send + Sync + 'static>(
    file: &Path,
    worlds: Vec<(String, u64)>,
    prepared: impl Fn(World) -> Result<T, E>,
) -> Result<Vec<(String, T)>, Failure> {
    let folder = file.parent().unwrap_or(Path::new(""));
    let load = |(name, line): (String, u64)| {
        let place = || format!("{}:{line}: world = {name:?}", file.display());
        let world = load_world_near(folder, &name).map_err(|failure| match failure {
            Failure::Input(error) => Failure::Input(error.context(place())),
            other => other,
        })?;
        let prepared = prepared(world).with_context(place).map_err(Failure::Input)?;
        Ok((name, prepared))
    };
    worlds.into_iter().map(load).collect()
}
