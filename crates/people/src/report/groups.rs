//! The participants that figures are made of: all who finished, and those without flags.

use super::read::StudyPerson;

/// Participants whose figures are given together.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct AnalysedGroup {
    /// Its name as the beginning of a key.
    pub key: String,
    /// Its name.
    pub name: String,
    /// The pseudonyms, sorted.
    pub members: Vec<String>,
}

/// All flags, in alphabetical order, of those who finished.
pub(super) fn flags(people: &[StudyPerson]) -> Vec<String> {
    let mut flags: Vec<String> =
        people.iter().filter(|person| person.is_finished).flat_map(|person| person.flags.clone()).collect();
    flags.sort();
    flags.dedup();
    flags
}

/// All who finished; then those without any flag, and, if there are several, without each.
pub(super) fn groups(people: &[StudyPerson]) -> Vec<AnalysedGroup> {
    let of = |key: &str, name: &str, is_in: &dyn Fn(&StudyPerson) -> bool| {
        let members = people.iter().filter(|person| person.is_finished && is_in(person));
        let mut members: Vec<String> = members.map(|person| person.name.clone()).collect();
        members.sort();
        AnalysedGroup { key: key.to_owned(), name: name.to_owned(), members }
    };
    let flags = flags(people);
    let mut groups = vec![of("all", "all who finished", &|_| true)];
    if !flags.is_empty() {
        groups.push(of("without_flagged", "without flagged", &|person| person.flags.is_empty()));
    }
    for flag in flags.iter().filter(|_| flags.len() > 1) {
        let key = format!("without_{}", flag.replace('-', "_"));
        groups.push(of(&key, &format!("without {flag}"), &|person| !person.flags.contains(flag)));
    }
    groups
}
