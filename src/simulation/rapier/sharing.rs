//! How partners share what they carry: which part of their forces moves it, and which part cancels.

/// The forces of any number of partners along one axis (N), taken apart: the motive part, their sum, and the
/// internal part, which others cancel: the lesser of what acts ahead and what acts back. For two partners it is
/// the lesser of two opposed forces, and 0 where they are not: the interaction force in one dimension of
/// arXiv:2408.01543.
pub fn motive_and_internal(forces: impl IntoIterator<Item = f64>) -> [f64; 2] {
    let (mut ahead, mut back) = (0.0, 0.0);
    for force in forces {
        if force > 0.0 { ahead += force } else { back -= force }
    }
    [ahead - back, f64::min(ahead, back)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_of_two_and_of_more_partners() {
        assert_eq!(motive_and_internal([5.0, 3.0]), [8.0, 0.0]);
        assert_eq!(motive_and_internal([5.0, -3.0]), [2.0, 3.0]);
        assert_eq!(motive_and_internal([-7.0, 7.0]), [0.0, 7.0]);
        assert_eq!(motive_and_internal([5.0, -3.0, -4.0, 1.0]), [-1.0, 6.0]);
        assert_eq!(motive_and_internal([]), [0.0, 0.0]);
    }
}
