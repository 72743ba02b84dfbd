//! How often the intervals of `cocarry fit` hold what simulated studies were made from. The whole table is a
//! part of `cocarry reproduce all`.

use cocarry::math;
use cocarry_studies::fit::{EtaDesign, EtaFit, risk_weight_coverage};

const ONCE: EtaDesign =
    EtaDesign { people: 8, episodes: 1, longest: A_THIRD, spread: 0.4, scatter: 0.0, resolution: 0.04 };
/// Standard deviations above the median beyond which are 30, 50, 70 and 97 % of a normal distribution.
const A_THIRD: f64 = 0.524_400_512_708_041;
const HALF: f64 = 0.0;
const MOST: f64 = -A_THIRD;
const ALMOST_ALL: f64 = -1.880_793_608_151_251;
const NONE: f64 = f64::INFINITY;

/// 3 standard errors of 100 studies that hold in 95 % of the cases are 6.5 points.
#[test]
fn intervals_of_the_median_eta_hold_it_as_often_as_they_say() {
    for (people, longest) in [(4, NONE), (5, HALF), (8, A_THIRD), (20, MOST)] {
        let [all, _] = EtaDesign { people, longest, ..ONCE }.coverage(100, &|| ());
        assert!(all.stated >= 60, "{people} people, up to {longest}: {} stated", all.stated);
        assert!(all.percent() >= 88.5, "{people} people, up to {longest}: {} %", all.percent());
    }
}

#[test]
fn intervals_of_who_scatters_hold_their_median() {
    let design = EtaDesign { people: 1, episodes: 5, scatter: 0.3, ..ONCE };
    let [_, own] = design.coverage(100, &|| ());
    assert!(own.stated >= 80 && own.percent() >= 88.5, "{} of {}", own.holds, own.stated);
    // everyone contradicts themselves, many are censored: the median of all
    let [all, _] = EtaDesign { people: 4, episodes: 3, ..design }.coverage(15, &|| ());
    assert!(all.stated >= 12 && all.holds + 2 >= all.stated, "{} of {}", all.holds, all.stated);
}

#[test]
fn few_switches_determine_no_median() {
    let [all, _] = EtaDesign { people: 3, longest: NONE, ..ONCE }.coverage(10, &|| ());
    assert_eq!(all.stated, 0);
    let [all, _] = EtaDesign { people: 6, longest: ALMOST_ALL, ..ONCE }.coverage(40, &|| ());
    assert!(all.stated <= 4, "{}", all.stated);
}

#[test]
fn intervals_from_few_switches_are_called_cautious() {
    let cautious = |longest: f64| {
        let fits = (0..60).map(|seed| EtaDesign { longest, ..ONCE }.study(seed).0);
        let stated: Vec<EtaFit> = fits.filter(|fit| fit.median_interval.is_some()).collect();
        (stated.iter().filter(|fit| fit.is_cautious).count(), stated.len())
    };
    assert_eq!(cautious(NONE), (0, 60));
    let (few, of) = cautious(MOST);
    assert!(of > 30 && 4 * few > 3 * of, "{few} of {of}");
}

/// Lapses bias least squares, which do not know them; the likelihood's intervals, from a bootstrap of 20
/// people, hold c_r far more often.
#[test]
fn diffuse_answers_spoil_least_squares_but_not_the_likelihood() {
    let [likelihood, squares] = risk_weight_coverage(5.0, 30, &|| ()).expect("fits");
    assert!(likelihood.holds >= 20, "{likelihood:?}");
    assert!(squares.holds <= 5, "{squares:?}");
}

/// Of people whose eta varies as designed, 70 % lie beyond the longest episode that leaves 70 %; 3 standard
/// errors of 400 people are 0.07.
#[test]
fn simulated_people_are_censored_as_often_as_designed() {
    let design = EtaDesign { people: 400, longest: MOST, ..ONCE };
    let beyond = design.study(0).1.into_iter().filter(|eta| *eta >= 10.0 * math::exp(0.4 * MOST)).count();
    assert!((beyond as f64 / 400.0 - 0.7).abs() < 0.07, "{beyond} of 400");
}
