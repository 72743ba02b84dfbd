//! The file that a URDF's mesh name stands for.

use super::error::{Place, RobotError};
use std::path::{Path, PathBuf};

/// The file that `mesh` names: `package://pkg/rest` from a folder `pkg` at or above `folder` or beside one of those, `file://` and
/// absolute paths as they are, others from `folder`, which is the URDF's. Without a folder, the name as it is.
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
        // the folders above are known only from the root on
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
