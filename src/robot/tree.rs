//! The order of links in which parents come before children.

use super::MAX_LISTED;
use super::urdf::Urdf;
use crate::error::Error;
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
pub(super) fn order(urdf: Urdf, names: Vec<&str>, joints: &[Edge]) -> Result<Vec<Spot>, Error> {
    let fault = |link: &str, why: String| Error::at(urdf.place(format!("link `{link}`")), why);
    let index: BTreeMap<&str, usize> = names.iter().enumerate().map(|(i, &n)| (n, i)).collect();
    let mut carrier: Vec<Option<usize>> = vec![None; names.len()];
    let mut children: Vec<Vec<(usize, usize)>> = vec![Vec::new(); names.len()];
    for (j, edge) in joints.iter().enumerate() {
        let find = |name: &str| {
            index.get(name).copied().ok_or_else(|| {
                let place = urdf.place(format!("joint `{}`", edge.joint));
                Error::unknown(place, "link", name, names.iter().copied(), MAX_LISTED)
            })
        };
        let (parent, child) = (find(edge.parent)?, find(edge.child)?);
        if let Some(first) = carrier[child].replace(j) {
            let (first, second) = (joints[first].joint, edge.joint);
            return Err(fault(
                names[child],
                format!("is the child of two joints, `{first}` and `{second}`; a URDF is a tree"),
            ));
        }
        children[parent].push((j, child));
    }
    let mut roots = (0..names.len()).filter(|&i| carrier[i].is_none());
    let root = roots.next();
    if let (Some(root), Some(other)) = (root, roots.next()) {
        let why = format!("has no parent, like `{}`; a URDF has one root", names[root]);
        return Err(fault(names[other], why));
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
        Some(astray) => Err(fault(names[astray], "is its own ancestor; a URDF is a tree".to_owned())),
        None => Ok(order),
    }
}
