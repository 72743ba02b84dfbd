//! Notes about a URDF that was mended: equal ones in one sentence, with their links or joints and lines.

use super::urdf_lines::LineStarts;
use super::warning::RobotWarning;

/// The largest number of different notes; all others are counted.
const MAX_NOTES: usize = 20;
/// The largest number of places that a note names.
const MAX_PLACES: usize = 6;

/// Notes in the order in which they were first made.
#[derive(Default)]
pub(super) struct Notes {
    notes: Vec<Note>,
    others: usize,
}

struct Note {
    key: String,
    what: String,
    /// Items with their bytes in the text.
    places: Vec<(String, usize)>,
    count: usize,
}

impl Notes {
    /// Adds a note about an item that begins at a byte of the text. Notes with one `key` are one; `what` makes
    /// its sentence.
    pub fn add(&mut self, key: String, item: &str, at: usize, what: impl FnOnce() -> String) {
        let known = self.notes.iter().position(|note| note.key == key);
        let Some(i) = known.or_else(|| self.new_note(key, what)) else {
            self.others += 1;
            return;
        };
        let note = &mut self.notes[i];
        note.count += 1;
        if note.places.len() < MAX_PLACES {
            note.places.push((item.to_owned(), at));
        }
    }

    fn new_note(&mut self, key: String, what: impl FnOnce() -> String) -> Option<usize> {
        if self.notes.len() == MAX_NOTES {
            return None;
        }
        self.notes.push(Note { key, what: what(), places: Vec::new(), count: 0 });
        Some(self.notes.len() - 1)
    }

    /// The warnings: a sentence for each note.
    pub fn warnings(&self, starts: &LineStarts) -> Vec<RobotWarning> {
        let place = |(item, at): &(String, usize)| format!("{} (line {})", short(item), starts.line(*at));
        let sentence = |note: &Note| {
            let places = note.places.iter().map(place).collect::<Vec<_>>().join(", ");
            let more = match note.count - note.places.len() {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            RobotWarning::new(format!("{places}{more}: {}", note.what))
        };
        let others = (self.others > 0).then(|| format!("{} more notes about the URDF", self.others));
        self.notes.iter().map(sentence).chain(others.map(RobotWarning::new)).collect()
    }
}

/// A name or value of a file for a sentence, without the end of a long one.
pub(super) fn short(text: &str) -> String {
    const MAX_LENGTH: usize = 80;
    match text.char_indices().nth(MAX_LENGTH) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}
