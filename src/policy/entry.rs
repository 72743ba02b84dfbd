//! An entry in the list of methods.

use super::RobotPolicy;

/// A robot policy with a name.
#[derive(Debug)]
pub struct MethodEntry {
    /// Name, as in files and on the command line.
    pub name: &'static str,
    /// A description in one sentence.
    pub about: &'static str,
    /// Makes the policy.
    pub(super) make: fn() -> Box<dyn RobotPolicy>,
}
