//! The human's preference: P_o, its regions and expected costs.

use crate::error::{Error, ScenarioError, raise};
use crate::scenario::{Scenario, belief_of};
use cocarry::episode::prospects;
use cocarry::preference::{
    ChoiceDistribution, Perception, Predictor, Prospect, Regions, human_choice, objective_cost,
    subjective_cost,
};
use cocarry::scenario::PERCEPTION;
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

/// How humans choose between options, given the distribution of their alpha and gamma.
#[pyclass(frozen, module = "cocarry", name = "Preference")]
pub struct Preference {
    prospects: Vec<Prospect>,
    predictor: Predictor,
    probabilities: Vec<f64>,
    expected: Vec<f64>,
}

impl Preference {
    fn of_prospects(prospects: Vec<Prospect>, mut predictor: Predictor) -> Self {
        let (mut choice, mut expected) = (ChoiceDistribution::default(), Vec::new());
        predictor.predict(&prospects, &mut choice);
        predictor.expected_costs(&prospects, &mut expected);
        Self { prospects, predictor, probabilities: choice.probabilities().to_vec(), expected }
    }

    fn perception(alpha: f64, gamma: f64) -> PyResult<Perception> {
        for (key, value) in [("alpha", alpha), ("gamma", gamma)] {
            if !PERCEPTION.contains(value) {
                return Err(Error::new_err(format!("{key} = {value}; it must be {PERCEPTION}")));
            }
        }
        Ok(Perception { alpha, gamma })
    }
}

#[pymethods]
impl Preference {
    #[new]
    #[pyo3(signature = (length_m, risk, *, risk_weight_m = 10.0, belief_alpha = "uniform(0.55,0.95)",
        belief_gamma = "uniform(0.5,1.1)", belief_samples = None))]
    fn new(
        length_m: Vec<f64>,
        risk: Vec<f64>,
        risk_weight_m: f64,
        belief_alpha: &str,
        belief_gamma: &str,
        belief_samples: Option<PyReadonlyArray2<'_, f64>>,
    ) -> PyResult<Self> {
        if length_m.len() != risk.len() || length_m.is_empty() {
            return Err(Error::new_err(format!(
                "length_m has {} numbers and risk {}; both must have one for every option, and at least one",
                length_m.len(),
                risk.len()
            )));
        }
        if let Some(wrong) = length_m.iter().find(|length| !(0.0..=1e6).contains(*length)) {
            return Err(Error::new_err(format!(
                "length_m has {wrong}; lengths must be numbers from 0 to 1000000"
            )));
        }
        if let Some(wrong) = risk.iter().find(|risk| !(0.0..=1.0).contains(*risk)) {
            return Err(Error::new_err(format!("risk has {wrong}; risks must be numbers from 0 to 1")));
        }
        let belief = belief_of(belief_alpha, belief_gamma, belief_samples)?;
        let predictor = Predictor::new(belief, risk_weight_m).map_err(|e| raise::<ScenarioError>(&e))?;
        let prospects = length_m.into_iter().zip(risk).map(|(length, risk)| Prospect::new(length, risk));
        Ok(Self::of_prospects(prospects.collect(), predictor))
    }

    /// Of a scenario's options from its start, with its belief and c_r.
    #[staticmethod]
    fn of(py: Python<'_>, scenario: &Bound<'_, Scenario>) -> PyResult<Self> {
        let prepared = scenario.get().prepared(py)?;
        let prospects = prospects(prepared.options(), &prepared.options().begin());
        Ok(Self::of_prospects(prospects, prepared.scenario().settings.predictor.clone()))
    }

    #[getter]
    fn length_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, self.prospects.iter().map(|p| p.length))
    }

    #[getter]
    fn risk<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, self.prospects.iter().map(|p| p.risk))
    }

    #[getter]
    fn probability<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.probabilities)
    }

    #[getter]
    fn expected_subjective_cost<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.expected)
    }

    #[getter]
    fn objective_cost_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let weight = self.predictor.risk_weight();
        PyArray1::from_iter(py, self.prospects.iter().map(|p| objective_cost(*p, weight)))
    }

    fn subjective_cost<'py>(
        &self,
        py: Python<'py>,
        alpha: f64,
        gamma: f64,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (perception, weight) = (Self::perception(alpha, gamma)?, self.predictor.risk_weight());
        Ok(PyArray1::from_iter(py, self.prospects.iter().map(|p| subjective_cost(*p, weight, perception))))
    }

    fn choice(&self, alpha: f64, gamma: f64) -> PyResult<usize> {
        let perception = Self::perception(alpha, gamma)?;
        Ok(human_choice(&self.prospects, self.predictor.risk_weight(), perception, None))
    }

    fn choices<'py>(
        &self,
        py: Python<'py>,
        alpha: PyReadonlyArray1<'_, f64>,
        gamma: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<Bound<'py, PyArray1<i64>>> {
        let (alpha, gamma) = (alpha.as_array().to_vec(), gamma.as_array().to_vec());
        if alpha.len() != gamma.len() {
            return Err(Error::new_err(format!(
                "alpha has {} numbers and gamma {}; they must have equally many",
                alpha.len(),
                gamma.len()
            )));
        }
        let choices = alpha.iter().zip(&gamma).map(|(alpha, gamma)| Ok(self.choice(*alpha, *gamma)? as i64));
        Ok(PyArray1::from_vec(py, choices.collect::<PyResult<Vec<_>>>()?))
    }

    /// R_o: every region as its option and its outline (n, 2) of alpha and gamma.
    #[pyo3(signature = (alpha = None, gamma = None))]
    fn regions<'py>(
        &self,
        py: Python<'py>,
        alpha: Option<[f64; 2]>,
        gamma: Option<[f64; 2]>,
    ) -> PyResult<Vec<(usize, Bound<'py, PyArray2<f64>>)>> {
        let [of_alpha, of_gamma] = self.predictor.belief().ranges();
        let (alpha, gamma) = (alpha.unwrap_or(of_alpha), gamma.unwrap_or(of_gamma));
        for (key, [lower, upper]) in [("alpha", alpha), ("gamma", gamma)] {
            if !(PERCEPTION.contains(lower) && PERCEPTION.contains(upper) && lower < upper) {
                return Err(Error::new_err(format!(
                    "{key} = ({lower}, {upper}); it must be a lower and a larger upper end, each {PERCEPTION}"
                )));
            }
        }
        let regions = py.detach(|| Regions::new(&self.prospects, self.predictor.risk_weight(), alpha, gamma));
        let outline = |region: &cocarry::preference::Region| {
            let points: Vec<Vec<f64>> = region.outline.iter().map(|p| vec![p.alpha, p.gamma]).collect();
            Ok((region.option, PyArray2::from_vec2(py, &points)?))
        };
        regions.parts.iter().map(outline).collect()
    }

    fn __len__(&self) -> usize {
        self.prospects.len()
    }

    fn __repr__(&self) -> String {
        format!("<cocarry.Preference, {} options, P_o {:.3?}>", self.prospects.len(), self.probabilities)
    }
}
