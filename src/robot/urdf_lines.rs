//! The lines of a URDF's links, joints and shapes, for errors.

use std::collections::BTreeMap;

/// The beginnings of a text's lines.
pub(super) struct LineStarts(Vec<u32>);

impl LineStarts {
    pub fn new(text: &str) -> Self {
        let ends = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        Self(ends.map(|(end, _)| end as u32 + 1).collect())
    }

    /// The line of a byte, counted from 1.
    pub fn line(&self, byte: usize) -> usize {
        1 + self.0.partition_point(|start| *start as usize <= byte)
    }
}

/// The lines of items.
#[derive(Clone, Debug, Default)]
pub(super) struct ItemLines(BTreeMap<String, Item>);

/// The line of a link or joint, and those of its parts by their names, such as `visual 2`.
#[derive(Clone, Debug, Default)]
struct Item {
    line: usize,
    parts: BTreeMap<String, usize>,
}

impl ItemLines {
    /// Adds an item as errors name it, such as ``link `arm` `` or ``link `arm`, visual 2``.
    pub fn add(&mut self, item: &str, line: usize) {
        let (whole, part) = split(item);
        match (part, self.0.get_mut(whole)) {
            (Some(part), Some(whole)) => drop(whole.parts.insert(part.to_owned(), line)),
            (Some(_), None) => {}
            (None, _) => drop(self.0.insert(whole.to_owned(), Item { line, parts: BTreeMap::new() })),
        }
    }

    /// The line of an item, or of the link or joint that it is a part of.
    pub fn line(&self, item: &str) -> Option<usize> {
        let (whole, part) = split(item);
        let whole = self.0.get(whole)?;
        Some(part.and_then(|part| whole.parts.get(part)).copied().unwrap_or(whole.line))
    }
}

/// The link or joint, and what follows it.
fn split(item: &str) -> (&str, Option<&str>) {
    let end = item.find("`, ").map_or(item.len(), |at| at + 1);
    (&item[..end], item.get(end + 2..))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_lines_of_bytes_and_items() {
        let starts = LineStarts::new("a\nb\n\nc");
        assert_eq!([0, 1, 2, 3, 4, 5, 9].map(|byte| starts.line(byte)), [1, 1, 2, 2, 3, 4, 4]);
        let mut lines = ItemLines::default();
        lines.add("link `a`", 3);
        lines.add("link `a`, visual 2", 5);
        lines.add("joint `b`", 7);
        let of = |item| lines.line(item);
        assert_eq!(
            [of("link `a`"), of("link `a`, visual 2"), of("link `a`, visual 1")],
            [Some(3), Some(5), Some(3)]
        );
        assert_eq!([of("joint `b`, which `c` mimics,"), of("joint `a`"), of("robot")], [Some(7), None, None]);
    }
}
