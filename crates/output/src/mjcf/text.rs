//! Names, numbers and poses as MJCF has them.

use crate::xml::printable;
use cocarry::geometry::Pose;
use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use std::collections::BTreeMap;

/// Names that are taken, each with the number that the next of the same name gets.
#[derive(Default)]
pub struct Names(BTreeMap<String, u64>);

impl Names {
    /// A name with its prefix that is not taken yet, and is now.
    pub fn unique(&mut self, prefix: &str, name: &str) -> String {
        let plain = format!("{prefix}{}", printable(name));
        let mut free = plain.clone();
        while self.0.contains_key(&free) {
            let number = self.0.entry(plain.clone()).or_insert(2);
            free = format!("{plain}:{number}");
            *number += 1;
        }
        self.0.insert(free.clone(), 2);
        free
    }
}

/// A text for a comment, which two hyphens would end.
pub fn for_comment(text: &str) -> String {
    let mut text = printable(text);
    while text.contains("--") {
        text = text.replace("--", "- -");
    }
    text
}

/// A pose as attributes.
pub fn placed(pose: &Pose) -> String {
    let mut text = format!("pos=\"{}\"", vector(&pose.translation.vector));
    if pose.rotation != Rotation3::identity() {
        text += &format!(" quat=\"{}\"", quaternion(pose));
    }
    text
}

/// The rotation of a pose: w, x, y, z.
pub fn quaternion(pose: &Pose) -> String {
    let turn = UnitQuaternion::from_rotation_matrix(&pose.rotation);
    numbers(&[turn.w, turn.i, turn.j, turn.k])
}

/// A vector.
pub fn vector(vector: &Vector3<f64>) -> String {
    numbers(vector.as_slice())
}

/// Numbers, with blanks in between.
pub fn numbers(numbers: &[f64]) -> String {
    numbers.iter().map(|value| number(*value)).collect::<Vec<_>>().join(" ")
}

/// A number that is read back with the same bits.
pub fn number(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        1e-5..1e16 => format!("{value}"),
        _ => format!("{value:e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::xml::escaped;

    #[test]
    fn texts_cannot_leave_their_place() {
        assert_eq!(escaped("a\"><b&\u{1}\n"), "a&quot;&gt;&lt;b&amp;\u{fffd} ");
        assert!(!for_comment("-->--").contains("--"));
        let mut names = Names::default();
        let given = ["a", "a\u{1}", "a\u{2}", "a", "a:2", "a"];
        let named: Vec<String> = given.map(|name| names.unique("r/", name)).into();
        assert_eq!(named, ["r/a", "r/a\u{fffd}", "r/a\u{fffd}:2", "r/a:2", "r/a:2:2", "r/a:3"]);
    }

    #[test]
    fn numbers_are_read_back_with_the_same_bits() {
        for value in [0.1 + 0.2, -1e-300, 1e300, -0.0, 12_345.678, 5e-324] {
            assert_eq!(number(value).parse::<f64>().unwrap(), value);
        }
    }
}
