//! The built-in worlds, by their names.

use super::{World, WorldError};
use crate::suggestion;
use std::path::Path;

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

    /// Reads the world.
    ///
    /// # Errors
    /// Never in a build that passes its tests: the file is part of the program.
    pub fn world(&self) -> Result<World, WorldError> {
        World::parse(self.name, self.text)
    }
}

/// The names of all built-in worlds, for messages.
pub(super) fn names() -> String {
    BUILT_IN_WORLDS.iter().map(|world| world.name).collect::<Vec<_>>().join(", ")
}

impl World {
    /// The world in the file `path`, or, if there is no such file, the built-in world `name`.
    ///
    /// # Errors
    /// [`WorldError`]; if there is neither, it suggests a name.
    pub fn find(path: &Path, name: &str) -> Result<Self, WorldError> {
        match BuiltInWorld::named(name) {
            _ if path.exists() => Self::load(path),
            Some(built_in) => built_in.world(),
            None => {
                let hint = suggestion::hint(name, BUILT_IN_WORLDS.iter().map(|world| world.name));
                let hint = if hint.is_empty() { suggestion::hint_of_files(path) } else { hint };
                Err(WorldError::NoSuchWorld { name: name.to_owned(), hint })
            }
        }
    }
}
