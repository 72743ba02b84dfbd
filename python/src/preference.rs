//! The human's preference: P_o, its regions and expected costs.

use crate::arguments;
use crate::error::{Error, ScenarioError, SnapshotError, raise};
use crate::scenario::{Scenario, belief_of};
use cocarry::episode::prospects;
use cocarry::preference::{
    ChoiceDistribution, Perception, Predictor, Prospect, Regions, human_choice, objective_cost,
    subjective_cost,
};
use cocarry::saved::Saved;
use cocarry::scenario::PERCEPTION;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

/// How humans choose between options, if their alpha and gamma are distributed like the belief (Sec. III,
/// IV-A).
///
/// Of options with lengths D_o (m) and risks S_o (0 to 1). Raises Error with the value and what would
/// be right.
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

    fn chosen(&self, alpha: f64, gamma: f64) -> PyResult<usize> {
        let perception = Self::perception(alpha, gamma)?;
        Ok(human_choice(&self.prospects, self.predictor.risk_weight(), perception, None))
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
        #[pyo3(from_py_with = arguments::lengths)] length_m: Vec<f64>,
        #[pyo3(from_py_with = arguments::risks)] risk: Vec<f64>,
        #[pyo3(from_py_with = arguments::risk_weight)] risk_weight_m: f64,
        #[pyo3(from_py_with = arguments::belief_alpha)] belief_alpha: &str,
        #[pyo3(from_py_with = arguments::belief_gamma)] belief_gamma: &str,
        belief_samples: Option<&Bound<'_, PyAny>>,
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
    fn of(
        py: Python<'_>,
        #[pyo3(from_py_with = arguments::scenario)] scenario: Py<Scenario>,
    ) -> PyResult<Self> {
        let prepared = scenario.get().prepared(py)?;
        let prospects = prospects(prepared.options(), &prepared.options().begin());
        Ok(Self::of_prospects(prospects, prepared.scenario().settings.predictor.clone()))
    }

    /// D_o, m.
    #[getter]
    fn length_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, self.prospects.iter().map(|p| p.length))
    }

    /// S_o.
    #[getter]
    fn risk<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, self.prospects.iter().map(|p| p.risk))
    }

    /// P_o, eq. (4).
    #[getter]
    fn probability<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.probabilities)
    }

    /// J~_o of eq. (6), cost units.
    #[getter]
    fn expected_subjective_cost<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.expected)
    }

    /// J_o, eq. (1), m.
    #[getter]
    fn objective_cost_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let weight = self.predictor.risk_weight();
        PyArray1::from_iter(py, self.prospects.iter().map(|p| objective_cost(*p, weight)))
    }

    /// J^_o of a human, eq. (2), cost units.
    fn subjective_cost<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = arguments::alpha)] alpha: f64,
        #[pyo3(from_py_with = arguments::gamma)] gamma: f64,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (perception, weight) = (Self::perception(alpha, gamma)?, self.predictor.risk_weight());
        Ok(PyArray1::from_iter(py, self.prospects.iter().map(|p| subjective_cost(*p, weight, perception))))
    }

    /// The option that a human prefers, eq. (3).
    fn choice(
        &self,
        #[pyo3(from_py_with = arguments::alpha)] alpha: f64,
        #[pyo3(from_py_with = arguments::gamma)] gamma: f64,
    ) -> PyResult<usize> {
        self.chosen(alpha, gamma)
    }

    /// The options that humans prefer, for arrays of alpha and gamma.
    fn choices<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = arguments::alphas)] alpha: Vec<f64>,
        #[pyo3(from_py_with = arguments::gammas)] gamma: Vec<f64>,
    ) -> PyResult<Bound<'py, PyArray1<i64>>> {
        if alpha.len() != gamma.len() {
            return Err(Error::new_err(format!(
                "alpha has {} numbers and gamma {}; they must have equally many",
                alpha.len(),
                gamma.len()
            )));
        }
        let choices = alpha.iter().zip(&gamma).map(|(alpha, gamma)| Ok(self.chosen(*alpha, *gamma)? as i64));
        Ok(PyArray1::from_vec(py, choices.collect::<PyResult<Vec<_>>>()?))
    }

    /// R_o: parts of the plane with their option and outline, (n, 2) of alpha and gamma; by default of the
    /// belief.
    #[pyo3(signature = (alpha = None, gamma = None))]
    fn regions<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = arguments::range_of_alpha)] alpha: Option<[f64; 2]>,
        #[pyo3(from_py_with = arguments::range_of_gamma)] gamma: Option<[f64; 2]>,
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

    /// Pickles and copies.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        let this = slf.get();
        let state = Saved::of(&(&this.prospects, &this.predictor));
        let rebuild = slf.get_type().getattr("_rebuild")?;
        Ok((rebuild, (PyBytes::new(slf.py(), state.bytes()),)))
    }

    #[staticmethod]
    fn _rebuild(state: &[u8]) -> PyResult<Self> {
        let (prospects, predictor) = Saved::from_bytes(state)
            .read("preference")
            .map_err(|_| SnapshotError::new_err("the state of a preference is not valid"))?;
        Ok(Self::of_prospects(prospects, predictor))
    }

    fn __len__(&self) -> usize {
        self.prospects.len()
    }

    fn __repr__(&self) -> String {
        format!("<cocarry.Preference, {} options, P_o {:.3?}>", self.prospects.len(), self.probabilities)
    }
}
