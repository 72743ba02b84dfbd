//! The order of links in which parents come before children.

use super::error::{RobotError, known};
use super::fault::TreeFault;
use crate::located::Place;
use std::collections::BTreeMap;

/// A joint with the two links that it connects.
pub(super) struct Edge<'a> {
    pub joint: &'a str,
    pub parent: &'a str,
    pub child: &'a str,
}

/// A link's place in the tree.
pub(super) struct Spot {
    /// The link: index into the names given.
    pub link: usize,
    /// The parent link: index into the spots.
    pub parent: Option<usize>,
    /// The joint between the two: index into the given joints.
    pub joint: Option<usize>,
}

/// The links of the tree from its root, branch by branch in the order of their joints; or the reason why they
/// are not a tree.
pub(super) fn order(file: &str, names: Vec<&str>, joints: &[Edge]) -> Result<Vec<Spot>, RobotError> {
    let place = |item: String| Place { file: file.to_owned(), line: None, item };
    let fault = |link: &str, why| RobotError::NotATree { place: place(format!("link `{link}`")), why };
    let index: BTreeMap<&str, usize> = names.iter().enumerate().map(|(i, &n)| (n, i)).collect();
    let mut carrier: Vec<Option<usize>> = vec![None; names.len()];
    let mut children: Vec<Vec<(usize, usize)>> = vec![Vec::new(); names.len()];
    for (j, edge) in joints.iter().enumerate() {
        let find = |name: &str| {
            index.get(name).copied().ok_or_else(|| RobotError::Unknown {
                place: place(format!("joint `{}`", edge.joint)),
                kind: "link",
                name: name.to_owned(),
                known: known(names.iter().copied()),
            })
        };
        let (parent, child) = (find(edge.parent)?, find(edge.child)?);
        if let Some(first) = carrier[child].replace(j) {
            let (first, second) = (joints[first].joint.to_owned(), edge.joint.to_owned());
            return Err(fault(names[child], TreeFault::TwoParents { first, second }));
        }
        children[parent].push((j, child));
    }
    let mut roots = (0..names.len()).filter(|&i| carrier[i].is_none());
    let root = roots.next();
    if let (Some(root), Some(other)) = (root, roots.next()) {
        return Err(fault(names[other], TreeFault::TwoRoots { other: names[root].to_owned() }));
    }
    let mut order: Vec<Spot> = Vec::with_capacity(names.len());
    let mut is_placed = vec![false; names.len()];
    let mut next: Vec<Spot> = root.map(|link| Spot { link, parent: None, joint: None }).into_iter().collect();
    while let Some(spot) = next.pop() {
        is_placed[spot.link] = true;
        let parent = Some(order.len());
        let below = children[spot.link].iter().rev();
        next.extend(below.map(|&(j, link)| Spot { link, parent, joint: Some(j) }));
        order.push(spot);
    }
    match is_placed.iter().position(|placed| !placed) {
        Some(astray) => Err(fault(names[astray], TreeFault::Circle)),
        None => Ok(order),
    }
}
