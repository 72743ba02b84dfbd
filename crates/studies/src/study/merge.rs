//! The merge of a study's shards into the file that one machine would write, byte for byte.

use super::origin::Origin;
use super::partial::Shard;
use super::results::{self, Identity, Rows, check_values};
use super::{SweepError, row};
use cocarry_output::output_file::{OutputError, OutputFile, Outputs};
use std::io::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The largest number of shards tried in order to name the missing one.
const MAX_SHARDS: u64 = 10_000;

/// The file of a shard.
struct Part {
    rows: Rows<'static>,
    first: Identity,
}

/// Writes the results of all shards into one file, complete or not at all. Returns the number of episodes.
///
/// # Errors
/// [`SweepError`], which names the file that does not belong to the others, or the episodes that are missing.
pub fn merge(path: &Path, shards: &[PathBuf], overwrite: bool) -> Result<u64, SweepError> {
    results::check_name(path)?;
    Outputs::new(overwrite, shards.iter().cloned()).check(path)?;
    let mut parts = parts(shards)?;
    let Some(study) = parts.first().map(|part| part.first.clone()) else {
        let files: Vec<_> = shards.iter().map(|path| path.display().to_string()).collect();
        return Err(SweepError::empty(files.join(", ")));
    };
    parts.sort_by_key(|part| part.first.episode);
    // an unfinished sweep of that name must not be lost
    let mut file = OutputFile::anew(path, overwrite)?;
    let text = parts.iter().find_map(|part| part.rows.study_text()).map(str::to_owned);
    write(&mut file, parts, &study)?;
    let origin = Origin { text, episodes: study.episodes, study: study.study, arithmetic: study.arithmetic };
    results::finish(file, path, &origin)?;
    Ok(origin.episodes)
}

/// Opens all files. Files without rows are left out.
fn parts(shards: &[PathBuf]) -> Result<Vec<Part>, SweepError> {
    let mut parts: Vec<Part> = Vec::new();
    for path in shards {
        let mut rows = Rows::open(path)?;
        let Some(first) = rows.next()? else { continue };
        if let Some(other) = parts.first() {
            check_study(&rows.file, &first, &other.rows.file, &other.first)?;
        }
        parts.push(Part { rows, first });
    }
    Ok(parts)
}

fn check_study(file: &str, found: &Identity, first: &str, expected: &Identity) -> Result<(), SweepError> {
    if (&found.study, found.episodes) == (&expected.study, expected.episodes) {
        return match found.arithmetic == expected.arithmetic {
            true => Ok(()),
            false => Err(SweepError::other_arithmetic(
                file.to_owned(),
                found.arithmetic.clone(),
                first.to_owned(),
                expected.arithmetic.clone(),
            )),
        };
    }
    Err(SweepError::foreign(
        file.to_owned(),
        found.study.clone(),
        found.episodes,
        first.to_owned(),
        expected.study.clone(),
        expected.episodes,
    ))
}

/// Writes the rows of all parts. The parts are in order.
fn write(out: &mut OutputFile, parts: Vec<Part>, study: &Identity) -> Result<(), SweepError> {
    let partial = out.partial().to_owned();
    let unwritable = |source| OutputError::write(&partial, source);
    out.write_all(&row::header()).map_err(unwritable)?;
    let mut before: Option<String> = None;
    let mut covered: Vec<Range<u64>> = Vec::new();
    for mut part in parts {
        let begin = part.first.episode;
        if let Some(other) = before.filter(|_| covered.last().is_some_and(|range| begin < range.end)) {
            return Err(SweepError::overlap(part.rows.file, begin, other));
        }
        let mut next = begin;
        let mut row = Some(part.first);
        while let Some(identity) = row {
            check_study(&part.rows.file, &identity, "its first row", study)?;
            if identity.episode != next {
                return Err(SweepError::row(
                    part.rows.position(),
                    part.rows.file,
                    format!("episode {}", identity.episode),
                    format!("episode {next}"),
                ));
            }
            check_values(&part.rows.line, &part.rows.file, part.rows.position())?;
            out.write_all(&part.rows.line).map_err(unwritable)?;
            next += 1;
            row = part.rows.next()?;
        }
        covered.push(begin..next);
        before = Some(part.rows.file);
    }
    out.flush().map_err(unwritable)?;
    first_gap(&covered, study.episodes)
}

/// The missing episodes: between the ranges, or before or after all of them.
fn first_gap(covered: &[Range<u64>], episodes: u64) -> Result<(), SweepError> {
    let ends = [0].into_iter().chain(covered.iter().map(|range| range.end));
    let begins = covered.iter().map(|range| range.start).chain([episodes]);
    match ends.zip(begins).find(|(end, begin)| end < begin) {
        None => Ok(()),
        Some((first, begin)) => {
            let hint = missing_shards(covered, episodes).unwrap_or_default();
            Err(SweepError::gap(first, begin - 1, episodes, hint))
        }
    }
}

/// The missing shards, if all ranges belong to the same number of shards.
fn missing_shards(covered: &[Range<u64>], episodes: u64) -> Option<String> {
    let of = (covered.len() as u64 + 1..=MAX_SHARDS.min(episodes)).find(|&of| {
        covered.iter().all(|range| {
            // rounding moves the beginning of a shard by less than one shard
            let near = (u128::from(range.start) * u128::from(of) / u128::from(episodes)) as u64;
            (near..=near + 2).any(|number| Shard { number, of }.episodes(episodes) == *range)
        })
    })?;
    let missing = (1..=of).filter(|&number| !covered.contains(&Shard { number, of }.episodes(episodes)));
    let missing: Vec<_> = missing.map(|number| format!("{number}/{of}")).collect();
    Some(format!(": probably shard {}", missing.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_a_missing_shard_is_named() {
        let shard = |number| Shard { number, of: 4 }.episodes(30);
        assert!(first_gap(&[shard(1), shard(2), shard(3), shard(4)], 30).is_ok());
        for missing in 1..=4 {
            let covered: Vec<_> = (1..=4).filter(|n| *n != missing).map(shard).collect();
            let error = first_gap(&covered, 30).unwrap_err().to_string();
            assert!(error.contains(&format!("shard {missing}/4")), "{error}");
        }
    }
}
