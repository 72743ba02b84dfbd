//! Policies of the robot that another program brings to this one, such as the Python package those of packages
//! that are installed beside it.

use super::output::{Failure, input};
use cocarry::Error;
use cocarry::episode::Episode;
use cocarry::scenario::{Decisions, PreparedScenario};
use cocarry_studies::study::{Custom, EpisodeMaker, Partner, Partners};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, OnceLock};

/// Custom policies, by name. They are called on several threads.
pub trait CustomPolicies: Send + Sync {
    /// Their names, each with a sentence about it.
    fn list(&self) -> Vec<(&'static str, &'static str)>;

    /// What is known of a policy's code: a version, a digest.
    ///
    /// # Errors
    /// The policy cannot be loaded.
    fn code(&self, name: &str) -> Result<String, Error>;

    /// An episode of a prepared scenario with a policy of its own, before its first step, and the log of the
    /// policy's decisions, which is still empty.
    ///
    /// # Errors
    /// The policy cannot be loaded, or the episode cannot begin.
    fn begin<'s>(
        &self,
        name: &str,
        prepared: &'s PreparedScenario,
    ) -> Result<(Episode<'s>, Decisions), Error>;

    /// Why a policy has failed since the last call.
    fn failure(&self) -> Option<Error>;
}

static CUSTOM: OnceLock<Box<dyn CustomPolicies>> = OnceLock::new();

/// Brings custom policies to the program, once in a process.
pub fn provide(policies: Box<dyn CustomPolicies>) {
    // those of the first call stay
    drop(CUSTOM.set(policies));
}

/// The names of the custom policies, each with a sentence about it.
pub(super) fn list() -> Vec<(&'static str, &'static str)> {
    CUSTOM.get().map_or_else(Vec::new, |policies| policies.list())
}

/// Whether a custom policy has this name.
pub(super) fn has(name: &str) -> bool {
    list().iter().any(|(known, _)| *known == name)
}

/// An episode with a custom policy, and the log of its decisions; with the scenario's partners without a name.
pub(super) fn begin<'s>(
    name: Option<&str>,
    prepared: &'s PreparedScenario,
) -> Result<(Episode<'s>, Decisions), Error> {
    match (name, CUSTOM.get()) {
        (Some(name), Some(policies)) => policies.begin(name, prepared),
        _ => Ok((prepared.episode()?, Decisions::default())),
    }
}

/// The check that no custom policy has failed.
pub(super) fn check() -> Result<(), Failure> {
    CUSTOM.get().and_then(|policies| policies.failure()).map_or(Ok(()), |error| Err(input(error)))
}

/// The episodes of a study with methods and custom policies by name.
pub(super) struct NamedPolicies<'a> {
    names: &'a [String],
    has_failed: AtomicBool,
    failure: Mutex<Option<Error>>,
}

impl<'a> NamedPolicies<'a> {
    pub fn new(names: &'a [String]) -> Self {
        Self { names, has_failed: AtomicBool::new(false), failure: Mutex::default() }
    }

    /// The policies for a study; none: those of its file.
    pub fn partners(&self) -> Result<Partners, Failure> {
        let partner = |name: &String| match (has(name), CUSTOM.get()) {
            (true, Some(policies)) => {
                Ok(Partner::Custom { name: name.clone(), code: policies.code(name).map_err(input)? })
            }
            _ => Ok(Partner::BuiltIn(name.clone())),
        };
        let policies = self.names.iter().map(partner).collect::<Result<_, Failure>>()?;
        Partners::new(policies, Vec::new()).map_err(input)
    }

    /// Why a policy has failed.
    pub fn failure(&self) -> Option<Error> {
        self.failure.lock().ok()?.take()
    }

    fn fail(&self, error: Error) {
        self.has_failed.store(true, Ordering::Relaxed);
        if let Ok(mut failure) = self.failure.lock() {
            failure.get_or_insert(error);
        }
    }
}

impl EpisodeMaker for NamedPolicies<'_> {
    fn begin<'s>(&self, prepared: &'s PreparedScenario, custom: Custom) -> Result<Episode<'s>, Error> {
        let name = custom.policy.and_then(|at| self.names.get(at));
        begin(name.map(String::as_str), prepared).map(|(episode, _)| episode)
    }

    fn is_over(&self) -> bool {
        if let Some(error) = CUSTOM.get().and_then(|policies| policies.failure()) {
            self.fail(error);
        }
        self.has_failed.load(Ordering::Relaxed)
    }
}
