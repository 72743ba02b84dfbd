//! The worlds named in participants' answers.

use crate::model::{BeliefArguments, load_world_near};
use crate::output::Failure;
use anyhow::Context;
use cocarry::world::World;
use std::error::Error;
use std::path::{Path, PathBuf};

/// The files that a fit reads: the answers in `file`, their worlds, and the samples of the belief.
pub(crate) fn inputs<T>(file: &Path, worlds: &[(String, T)], belief: &BeliefArguments) -> Vec<PathBuf> {
    let folder = file.parent().unwrap_or(Path::new(""));
    let worlds = worlds.iter().flat_map(|(world, _)| [folder.join(world), PathBuf::from(world)]);
    worlds.chain([file.to_owned()]).chain(belief.belief_samples.clone()).collect()
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
