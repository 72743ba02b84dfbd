//! The file of a URDF's mesh.

use super::error::RobotError;
use crate::located::Place;
use std::path::{Path, PathBuf};

/// The file that `mesh` names. `package://pkg/rest` is searched for in a folder `pkg` at or above `folder` or
/// beside one of those. `file://` and absolute paths are taken as they are. Other names are relative to
/// `folder`, the URDF's folder. Without a folder, the name is returned as it is.
pub(super) fn find(
    mesh: &str,
    folder: Option<&Path>,
    place: impl Fn() -> Place,
) -> Result<PathBuf, RobotError> {
    let Some(folder) = folder else { return Ok(PathBuf::from(mesh)) };
    let lost = |looked: String| RobotError::Mesh { place: place(), mesh: mesh.to_owned(), looked };
    if let Some(rest) = mesh.strip_prefix("package://") {
        let (package, rest) = rest.split_once('/').unwrap_or((rest, ""));
        if package.is_empty() || rest.is_empty() {
            return Err(lost(format!("`{rest}` in package `{package}`")));
        }
        // only a canonical path has all the folders above
        let start = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
        let is_package = |f: &Path| f.file_name().is_some_and(|name| name == package);
        let candidates: Vec<PathBuf> = start
            .ancestors()
            .map(|f| if is_package(f) { f.join(rest) } else { f.join(package).join(rest) })
            .collect();
        return candidates.iter().find(|f| f.is_file()).cloned().ok_or_else(|| {
            lost(format!("`{rest}` in folders `{package}` at or above `{}`", start.display()))
        });
    }
    let file = mesh.strip_prefix("file://").map(PathBuf::from);
    let file = file.unwrap_or_else(|| folder.join(mesh));
    if file.is_file() { Ok(file) } else { Err(lost(format!("`{}`", file.display()))) }
}
