//! The groups of participants by their eta, as the paper's second study has them.

use cocarry_studies::fit::{Eta, Switch, fit_eta};
use std::collections::BTreeMap;

/// The eta of the group that each participant belongs to: the nearest one by ratio to the estimate of
/// `cocarry fit eta`. Who never switched has a lower bound only, and belongs to the last group if the bound
/// does. Participants whose walks do not say are missing.
pub(super) fn of_participants(groups: &[f64], episodes: &[Switch]) -> BTreeMap<String, String> {
    if groups.is_empty() || episodes.is_empty() {
        return BTreeMap::new();
    }
    let fit = fit_eta(episodes);
    let group = |eta: &Eta| Some((eta.participant.clone(), of(groups, eta)?.to_string()));
    fit.participants.iter().filter_map(group).collect()
}

fn of(groups: &[f64], eta: &Eta) -> Option<f64> {
    match eta.eta {
        Some(estimate) => nearest(groups, estimate),
        None => {
            let [lower, _] = eta.interval?;
            nearest(groups, lower).filter(|group| Some(group) == groups.last())
        }
    }
}

/// The group with the smallest ratio to an eta.
fn nearest(groups: &[f64], eta: f64) -> Option<f64> {
    let ratio = |group: f64| (group / eta).max(eta / group);
    groups.iter().copied().min_by(|a, b| ratio(*a).total_cmp(&ratio(*b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use cocarry_studies::fit::Executed;

    #[test]
    fn a_participant_belongs_to_the_nearest_eta_and_who_never_switched_to_the_last_or_to_none() {
        let episode = |participant: &str, etas: [f64; 2]| Switch {
            line: 0,
            participant: participant.to_owned(),
            world: "w".to_owned(),
            executed: Executed::Option("1".to_owned()),
            step: Some(1),
            etas: vec![etas],
        };
        let episodes = [
            episode("sensitive", [4.0, 6.0]),
            episode("medium", [9.0, 10.0]),
            episode("patient", [18.0, 40.0]),
            episode("never, late", [14.0, f64::INFINITY]),
            episode("never, early", [3.0, f64::INFINITY]),
        ];
        let groups = of_participants(&[5.0, 10.5, 15.0], &episodes);
        let of = |name: &str| groups.get(name).map(String::as_str);
        assert_eq!(of("sensitive"), Some("5"));
        assert_eq!(of("medium"), Some("10.5"));
        assert_eq!(of("patient"), Some("15"));
        assert_eq!(of("never, late"), Some("15"));
        assert_eq!(of("never, early"), None);
        assert!(of_participants(&[], &episodes).is_empty());
    }
}
