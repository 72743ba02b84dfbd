//! The belief for a prior of independent alpha and gamma: the density, and the regions of the options at hand.

use super::plane::Plane;
use crate::preference::curve::{Curve, pareto_front};
use crate::preference::rule::Rule;
use crate::preference::strips::{Domain, Strips};
use crate::preference::ties::Ties;
use crate::preference::{Marginal, Prospect};

/// A density relative to a prior of independent alpha and gamma, with the memory to update it.
#[derive(Debug, Clone)]
pub(super) struct Independent {
    pub domain: Domain,
    pub rule: Rule,
    pub plane: Plane,
    pub front: Vec<Curve>,
    pub strips: Strips,
    single: Vec<f64>,
    /// The prospects that the front and the outline were found for.
    outlined: Vec<Prospect>,
}

impl Independent {
    /// The prior.
    pub fn new(alpha: Marginal, gamma: Marginal) -> Self {
        let (alpha_panels, gamma_panels) = (alpha.panels(), gamma.panels());
        let domain = Domain { alpha, alpha_panels, gamma, gamma_panels };
        let rule = Rule::new();
        let mut strips = Strips::new();
        strips.outline = Some(Default::default());
        let plane = Plane::new(&rule, &domain);
        Self {
            domain,
            rule,
            plane,
            front: Vec::new(),
            strips,
            single: Vec::new(),
            outlined: Default::default(),
        }
    }

    /// Finds the regions of these options, unless they are those of the last call. False if one option is the
    /// cheapest everywhere: `front` then has only that.
    pub fn outline(&mut self, prospects: &[Prospect], ties: &Ties, risk_weight: f64) -> bool {
        if self.outlined == prospects {
            return self.front.len() >= 2;
        }
        self.outlined.clear();
        self.outlined.extend_from_slice(prospects);
        pareto_front(ties, risk_weight > 0.0, &mut self.front);
        if self.front.len() < 2 {
            return false;
        }
        self.single.clear();
        self.single.resize(prospects.len(), 0.0);
        self.strips.nodes = 0;
        self.strips.integrate(&self.front, risk_weight, &self.domain, &mut self.single);
        true
    }
}
