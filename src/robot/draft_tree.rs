//! The tree of a URDF's links, for its draft: paths, what moves, and what names say.

use super::link::{Geometry, Joint, JointKind, Link, Shape};
use std::iter::successors;

/// A link and the links above it, up to the root.
pub(super) fn upward(links: &[Link], at: usize) -> impl Iterator<Item = usize> {
    successors(Some(at), |&at| links[at].parent)
}

/// Whether a link is `top` or below it.
pub(super) fn is_within(links: &[Link], at: usize, top: usize) -> bool {
    upward(links, at).any(|above| above == top)
}

/// The links from behind `base` to `tip`; `None` if `tip` is not below `base`.
pub(super) fn path(links: &[Link], base: usize, tip: usize) -> Option<Vec<usize>> {
    let mut path: Vec<usize> = upward(links, tip).take_while(|&at| at != base).collect();
    let hangs = path.last().is_some_and(|&top| links[top].parent == Some(base));
    path.reverse();
    hangs.then_some(path)
}

/// The lowest link above all of these.
pub(super) fn common(links: &[Link], below: &[usize]) -> usize {
    let above = |i: usize| -> Vec<usize> { upward(links, i).skip(1).collect() };
    let of_others: Vec<Vec<usize>> = below.iter().skip(1).map(|&i| above(i)).collect();
    let first = below.first().map(|&i| above(i)).unwrap_or_default();
    first.into_iter().find(|at| of_others.iter().all(|above| above.contains(at))).unwrap_or(0)
}

/// The joint that carries a link, if that moves: as a revolute, continuous or prismatic joint does.
pub(super) fn moving(links: &[Link], i: usize) -> Option<&Joint> {
    let kinds = [JointKind::Revolute, JointKind::Continuous, JointKind::Prismatic];
    links[i].joint.as_ref().filter(|joint| kinds.contains(&joint.kind))
}

/// As [`moving`], if the joint does not mimic another one.
pub(super) fn independent(links: &[Link], i: usize) -> Option<&Joint> {
    moving(links, i).filter(|joint| joint.mimic.is_none())
}

/// The link whose joint moves a link, the link itself or one above it, but below `base`; else `base`.
pub(super) fn carrier(links: &[Link], base: usize, at: usize) -> usize {
    upward(links, at).take_while(|&at| at != base).find(|&at| moving(links, at).is_some()).unwrap_or(base)
}

/// The name of the joint that carries a link.
pub(super) fn joint_name(links: &[Link], i: usize) -> &str {
    links[i].joint.as_ref().map_or("", |joint| joint.name.as_str())
}

/// The joints that carry these links, each in backticks.
pub(super) fn listed(links: &[Link], of: &[usize]) -> String {
    of.iter().map(|&i| format!("`{}`", joint_name(links, i))).collect::<Vec<_>>().join(", ")
}

/// The link that the joint of this name carries.
pub(super) fn carried_by(links: &[Link], joint: &str) -> Option<usize> {
    (0..links.len()).find(|&i| joint_name(links, i) == joint && !joint.is_empty())
}

/// The collision shapes of a link, then its visual ones.
pub(super) fn shapes(link: &Link) -> impl Iterator<Item = &Geometry> {
    link.collisions.iter().chain(&link.visuals)
}

/// The names that tell what a link is: its own, its joint's, and those of its meshes' files.
pub(super) fn names(link: &Link) -> Vec<String> {
    let meshes = shapes(link).filter_map(|geometry| match &geometry.shape {
        Shape::Mesh { file, .. } => file.file_stem().map(|stem| stem.to_string_lossy().into_owned()),
        _ => None,
    });
    let joint = link.joint.iter().map(|joint| joint.name.clone());
    std::iter::once(link.name.clone()).chain(joint).chain(meshes).collect()
}

/// The words of a name in lower case: parted at signs, at digits, and where a capital letter begins one.
pub(super) fn words(name: &str) -> Vec<String> {
    let letters: Vec<char> = name.chars().collect();
    let mut words = vec![String::new()];
    for (i, &letter) in letters.iter().enumerate() {
        let before = i.checked_sub(1).map(|before| letters[before]);
        let after = letters.get(i + 1);
        let is_capital = letter.is_uppercase()
            && (before.is_some_and(char::is_lowercase) || after.is_some_and(|after| after.is_lowercase()));
        if is_capital || !letter.is_alphabetic() {
            words.push(String::new());
        }
        if letter.is_alphabetic() {
            words.last_mut().expect("there is a word").extend(letter.to_lowercase());
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

/// Whether a name has one of these words. A word of more than four letters may be part of a longer one, as
/// `wheel` is of `omniwheel`; a shorter one stands alone: `left_` has `ft_` in it.
pub(super) fn says(name: &str, any: &[&str]) -> bool {
    let whole = name.to_lowercase();
    let words = words(name);
    any.iter().any(|&word| {
        let is_long = word.len() > 4 && whole.contains(word);
        is_long || words.iter().any(|found| found == word)
    })
}

/// As [`says`], for the names of a link and of its joint.
pub(super) fn link_says(links: &[Link], i: usize, any: &[&str]) -> bool {
    says(&links[i].name, any) || says(joint_name(links, i), any)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_parted_into_words() {
        assert_eq!(words("wheel_motor_link1"), ["wheel", "motor", "link"]);
        assert_eq!(words("LHipYaw"), ["l", "hip", "yaw"]);
        assert_eq!(words("WheelFL_link"), ["wheel", "fl", "link"]);
        assert_eq!(words("EOAT"), ["eoat"]);
        assert!(says("omniwheel-3", &["wheel"]) && says("ee_right", &["ee"]));
        assert!(!says("left_arm", &["ft"]) && !says("wheel", &["ee"]) && !says("base_footprint", &["foot"]));
    }
}
