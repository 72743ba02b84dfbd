//! Sets of numbers as intervals: the eta that agree with one episode or with several.

/// Intervals [lower, upper], ascending and disjoint; the last may end at infinity.
pub type Set = Vec<[f64; 2]>;

/// The intersection of all sets; empty without sets.
pub(super) fn intersection(sets: &[Set]) -> Set {
    let Some((first, others)) = sets.split_first() else { return Set::new() };
    others.iter().fold(first.clone(), |common, set| {
        let pairs = common.iter().flat_map(|a| set.iter().map(move |b| [a[0].max(b[0]), a[1].min(b[1])]));
        pairs.filter(|[low, high]| low < high).collect()
    })
}

/// The interval from the smallest to the largest number; `None` for an empty set.
pub(super) fn hull(set: &Set) -> Option<[f64; 2]> {
    Some([set.first()?[0], set.last()?[1]])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_pieces_are_cut_by_pieces() {
        let sets = [vec![[0.0, 2.0], [3.0, 6.0], [8.0, f64::INFINITY]], vec![[1.0, 4.0], [5.0, 9.0]]];
        let common = intersection(&sets);
        assert_eq!(common, [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0], [8.0, 9.0]]);
        assert_eq!(hull(&common), Some([1.0, 9.0]));
        assert_eq!(intersection(&[vec![[0.0, 1.0]], vec![[1.0, 2.0]]]), Set::new());
        assert_eq!((intersection(&[]), hull(&Set::new())), (Set::new(), None));
    }
}
