//! Tests of the power of studies.

use super::page::verdict;
use super::*;
use crate::study::TEMPLATE;
use statrs::distribution::{ChiSquared, Continuous, ContinuousCDF, Normal, StudentsT};

fn study() -> PeopleStudy {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("study.toml");
    std::fs::write(&file, TEMPLATE).unwrap();
    PeopleStudy::read(&file).unwrap()
}

fn settings(participants: &[u64], studies: usize) -> PowerSettings {
    PowerSettings { participants: participants.to_vec(), studies, comparisons: 1, power: 0.8, seed: 1 }
}

/// The power of a two-sided paired t-test, by the non-central t distribution: the integral over the
/// distribution of the sample's variance.
fn closed_form(n: u64, d: f64, level: f64) -> f64 {
    let freedom = (n - 1) as f64;
    let critical = StudentsT::new(0.0, 1.0, freedom).unwrap().inverse_cdf(1.0 - level / 2.0);
    let (normal, chi) = (Normal::new(0.0, 1.0).unwrap(), ChiSquared::new(freedom).unwrap());
    let shift = d * (n as f64).sqrt();
    let most = freedom + 40.0 * (2.0 * freedom).sqrt();
    let step = most / 200_000.0;
    let found = |v: f64| {
        let at = critical * (v / freedom).sqrt();
        chi.pdf(v) * (1.0 - normal.cdf(at - shift) + normal.cdf(-at - shift))
    };
    (0..200_000).map(|i| step * found(step * (f64::from(i) + 0.5))).sum()
}

#[test]
fn closed_form_the_power_of_a_paired_t_test_is_that_of_the_noncentral_t() {
    // Cohen (1988): 34 pairs find d = 0.5 with 80 %
    assert!((closed_form(34, 0.5, 0.05) - 0.808).abs() < 1e-3);
    let study = study();
    for (d, comparisons) in [(0.5, 1), (0.8, 3)] {
        let settings = PowerSettings { comparisons, ..settings(&[8, 15, 34, 60], 4000) };
        for row in power(&study, Effect::Difference(d), &settings, &|| ()).unwrap() {
            let wanted = closed_form(row.participants, d, 0.05 / comparisons as f64);
            // 4 standard errors: a chance of 1 in 2000 for all eight
            let error = 4.0 * (wanted * (1.0 - wanted) / 4000.0).sqrt() + 1e-3;
            assert!((row.power - wanted).abs() < error, "{d}: {row:?}, wanted {wanted}");
            assert!(row.interval[0] <= row.power && row.power <= row.interval[1]);
        }
    }
}

#[test]
fn more_people_give_narrower_intervals_and_threads_do_not_matter() {
    let study = study();
    let settings = settings(&[8, 24], 6);
    for effect in [Effect::Eta(4.0), Effect::Alpha(0.1), Effect::Gamma(0.2)] {
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| power(&study, effect, &settings, &|| ())).unwrap()
        };
        let rows = on(1);
        assert_eq!(rows, on(2), "{effect}");
        // 10 %, 50 % and 90 % quantile
        let [few, many] = [0, 1].map(|row: usize| rows[row].widths.unwrap());
        assert!(few.iter().zip(many).all(|(few, many)| many < *few), "{effect}: {rows:?}");
        let document = power_document("T", &[(effect, rows)], &settings).unwrap();
        assert!(document.markdown.contains("Share of studies that find a 95 % interval"));
    }
}

#[test]
fn an_effect_is_a_name_and_a_positive_number() {
    assert_eq!("eta=3".parse(), Ok(Effect::Eta(3.0)));
    assert_eq!("difference=0.5".parse(), Ok(Effect::Difference(0.5)));
    for (text, said) in
        [("eta", "such as"), ("eta=0", "above 0"), ("force=1", "such as"), ("eta=nan", "above 0")]
    {
        let error = text.parse::<Effect>().unwrap_err();
        assert!(error.contains(said), "{text}: {error}");
    }
}

#[test]
fn the_number_that_is_enough_is_said() {
    let row = |participants, found| PowerRow {
        participants,
        studies: 1000,
        found,
        power: found as f64 / 1000.0,
        interval: wilson(found, 1000),
        widths: None,
        undetermined: 0,
    };
    let settings = settings(&[], 1000);
    let said = |rows: &[PowerRow]| verdict(rows, &settings);
    assert!(
        said(&[row(10, 500), row(20, 810), row(30, 900)])
            .contains("from 20 participants on; with its Monte-Carlo interval, from 30")
    );
    assert!(said(&[row(10, 500)]).contains("None of these"));
    assert!(said(&[row(10, 900)]).contains("from 10 participants on, its Monte-Carlo interval included"));
    assert!(said(&[row(10, 810)]).contains("reaches below"));
}
