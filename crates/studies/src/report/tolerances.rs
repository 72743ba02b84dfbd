//! The picture of everybody's eta.

use crate::fit::{Eta, EtaFit, Evidence};
use cocarry::Error;
use cocarry_output::drawing::{self, ToleranceRow};

/// Every participant's episodes and eta, and the distribution of all.
///
/// # Errors
/// There is no participant.
pub fn tolerances_picture(fit: &EtaFit) -> Result<String, Error> {
    let overall = fit.overall.map(|o| (o.median, o.log_std));
    drawing::tolerances(&rows(fit), overall, no_interval(fit).as_deref())
}

/// The reason why the interval of all participants is missing, if it is.
pub fn no_interval(fit: &EtaFit) -> Option<String> {
    fit.no_interval
        .map(|reason| format!("the median's 95 % interval is not determined: participants: {reason}"))
}

fn rows(fit: &EtaFit) -> Vec<ToleranceRow> {
    let row = |eta: &Eta| ToleranceRow {
        label: eta.participant.clone(),
        bounds: eta.bounds.clone(),
        estimate: eta.eta,
        interval: eta.interval,
        is_scattered: eta.evidence == Evidence::Scattered,
    };
    fit.participants.iter().map(row).collect()
}
