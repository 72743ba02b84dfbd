//! The worlds named in participants' answers.

use crate::cli::model::{BeliefArguments, load_world_near};
use crate::cli::output::Failure;
use crate::options::OptionSet;
use anyhow::Context;
use std::path::{Path, PathBuf};

/// The files that a fit reads: the answers in `file`, their worlds, and the samples of the belief.
pub(super) fn inputs(file: &Path, worlds: &[(String, OptionSet)], belief: &BeliefArguments) -> Vec<PathBuf> {
    let folder = file.parent().unwrap_or(Path::new(""));
    let worlds = worlds.iter().flat_map(|(world, _)| [folder.join(world), PathBuf::from(world)]);
    worlds.chain([file.to_owned()]).chain(belief.belief_samples.clone()).collect()
}

/// The options of the worlds that `file` names, each with the first line that names it. A world that lists no
/// options has those of `cocarry world` with `risk_weight` (m).
pub(super) fn options(
    file: &Path,
    worlds: Vec<(String, u64)>,
    risk_weight: f64,
) -> Result<Vec<(String, OptionSet)>, Failure> {
    let folder = file.parent().unwrap_or(Path::new(""));
    let load = |(world, line): (String, u64)| {
        let place = || format!("{}:{line}: world = {world:?}", file.display());
        let loaded = load_world_near(folder, &world).map_err(|failure| match failure {
            Failure::Input(error) => Failure::Input(error.context(place())),
            Failure::Output(error) => Failure::Output(error),
        })?;
        let set = OptionSet::new(&loaded, risk_weight).with_context(place).map_err(Failure::Input)?;
        Ok((world, set))
    };
    worlds.into_iter().map(load).collect()
}
