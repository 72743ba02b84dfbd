//! The built-in worlds, by their names.

/// A built-in world.
#[derive(Debug, PartialEq, Eq)]
pub struct BuiltInWorld {
    /// Its name on the command line and in studies.
    pub name: &'static str,
    /// Its world file.
    pub text: &'static str,
}

/// Defines the list from the names of files in `worlds/`.
macro_rules! built_in {
    ($($name:literal),*) => {
        &[$(BuiltInWorld { name: $name, text: include_str!(concat!("../../worlds/", $name, ".toml")) }),*]
    };
}

/// All built-in worlds: the paper's four environments, and a workshop.
pub const BUILT_IN_WORLDS: &[BuiltInWorld] =
    built_in!["environment-1", "environment-2", "environment-3", "environment-4", "free-form"];

impl BuiltInWorld {
    /// The built-in world of that name.
    pub fn named(name: &str) -> Option<&'static Self> {
        BUILT_IN_WORLDS.iter().find(|world| world.name == name)
    }
}

/// The names of all built-in worlds, for messages.
pub(super) fn names() -> String {
    BUILT_IN_WORLDS.iter().map(|world| world.name).collect::<Vec<_>>().join(", ")
}
