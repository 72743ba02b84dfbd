//! The policies that installed packages register, for the command-line program.

use crate::error::words;
use crate::partners::{Fault, Own};
use cocarry::Error;
use cocarry::episode::Episode;
use cocarry::scenario::{Decisions, PreparedScenario};
use cocarry_program::CustomPolicies;
use pyo3::prelude::*;

/// The registered policies.
struct Registered {
    names: Vec<(&'static str, &'static str)>,
    fault: Fault,
}

/// Brings the registered policies to the program. A registry that cannot be read is told when a policy of it
/// is asked for.
pub fn provide(py: Python<'_>) {
    let names: Vec<(String, String)> =
        registry(py).and_then(|registry| registry.call_method0("listed")?.extract()).unwrap_or_default();
    // the program's arguments live as long as the process
    let leaked = |text: String| -> &'static str { Box::leak(text.into_boxed_str()) };
    let names = names.into_iter().map(|(name, about)| (leaked(name), leaked(about))).collect();
    cocarry_program::provide(Box::new(Registered { names, fault: Fault::default() }));
}

fn registry(py: Python<'_>) -> PyResult<Bound<'_, PyModule>> {
    py.import("cocarry._registry")
}

/// The error of the program for an exception of a policy.
fn failed(what: &str, error: &PyErr) -> Error {
    Error::new(format!("{what}: {}", words(error)))
}

impl Registered {
    fn of<T>(&self, name: &str, act: impl FnOnce(Python<'_>) -> PyResult<T>) -> Result<T, Error> {
        Python::attach(act).map_err(|error| failed(&format!("the policy `{name}`"), &error))
    }
}

impl CustomPolicies for Registered {
    fn list(&self) -> Vec<(&'static str, &'static str)> {
        self.names.clone()
    }

    fn code(&self, name: &str) -> Result<String, Error> {
        self.of(name, |py| registry(py)?.call_method1("code", (name,))?.extract())
    }

    fn begin<'s>(
        &self,
        name: &str,
        prepared: &'s PreparedScenario,
    ) -> Result<(Episode<'s>, Decisions), Error> {
        let own = self.of(name, |py| {
            let policy = registry(py)?.call_method1("load", ("policy", name))?;
            Own::of(Some(&policy), None)?.copied(py)
        })?;
        let fault = self.fault.clone();
        let partners = own.clone().partners(prepared, &fault);
        let episode = prepared.episode_of(partners)?;
        // after the trial of the first step, which it tells of
        Ok((episode, Python::attach(|py| own.log(py, &fault))))
    }

    fn failure(&self) -> Option<Error> {
        self.fault.take().err().map(|error| failed("the custom policy", &error))
    }
}
