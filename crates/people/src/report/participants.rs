//! Who took part: begun, finished, drop-outs by page, flags.

use super::groups::flags;
use super::read::StudyPerson;
use cocarry_studies::report::Block;
use cocarry_studies::table::Columns;
use std::collections::BTreeMap;

pub(super) fn blocks(people: &[StudyPerson]) -> Vec<Block> {
    let finished = people.iter().filter(|person| person.is_finished).count();
    let flagged = people.iter().filter(|person| person.is_finished && !person.flags.is_empty()).count();
    let counts = [
        ("begun", people.len()),
        ("finished", finished),
        ("did not finish", people.len() - finished),
        ("finished, with a flag", flagged),
        ("finished, without a flag", finished - flagged),
    ];
    let counts = Columns::of(&counts)
        .text("participants", "participants", |(name, _)| *name)
        .count("number", "number", |(_, count)| *count as u64)
        .table("participants", "Participants")
        .with_note("Figures are of those who finished. Nobody is excluded for a flag: the next section has the figures with and without them.");
    vec![Block::Table(counts), drop_outs(people), by_flag(people)]
}

/// Where those who did not finish stopped.
fn drop_outs(people: &[StudyPerson]) -> Block {
    let mut pages: BTreeMap<(u64, String), u64> = BTreeMap::new();
    for person in people.iter().filter(|person| !person.is_finished) {
        // the worlds come in another order for others
        let task = person.left_at.split(':').next().unwrap_or_default();
        let task = if task.is_empty() { "not known" } else { task };
        *pages.entry((person.pages_done + 1, task.to_owned())).or_default() += 1;
    }
    if pages.is_empty() {
        return Block::Text("Nobody left before the end.".to_owned());
    }
    let pages: Vec<_> = pages.into_iter().collect();
    let table = Columns::of(&pages)
        .count("page", "page", |((page, _), _)| *page)
        .text("task", "task", |((_, task), _)| task.clone())
        .count("left there", "left", |(_, count)| *count);
    Block::Table(table.table("drop-outs", "Drop-outs, by the first page that was not completed"))
}

fn by_flag(people: &[StudyPerson]) -> Block {
    let rows: Vec<(String, u64)> = flags(people)
        .into_iter()
        .map(|flag| {
            let has = |person: &&StudyPerson| person.is_finished && person.flags.contains(&flag);
            let count = people.iter().filter(has).count() as u64;
            (flag, count)
        })
        .collect();
    if rows.is_empty() {
        return Block::Text("Nobody who finished has a flag.".to_owned());
    }
    let table = Columns::of(&rows)
        .text("flag", "flag", |(flag, _)| flag.clone())
        .count("participants", "participants", |(_, count)| *count)
        .table("flags", "Flags of those who finished")
        .with_note("A participant may have several.");
    Block::Table(table)
}
