//! The file of a URDF's mesh.

use std::path::{Path, PathBuf};

/// The folders in which the meshes of a URDF are searched for.
#[derive(Clone, Debug, Default)]
pub(super) struct MeshFolders {
    /// The URDF's folder.
    pub urdf: PathBuf,
    /// Folders that are packages, or have packages as folders in them.
    pub packages: Vec<PathBuf>,
}

impl MeshFolders {
    /// The folders for a URDF: its own, those given, and those of ROS in the environment: `ROS_PACKAGE_PATH`,
    /// and `share` in the prefixes of `AMENT_PREFIX_PATH`.
    pub fn new(urdf: &Path, given: impl Iterator<Item = PathBuf>) -> Self {
        let listed = |name: &str| -> Vec<PathBuf> {
            std::env::var_os(name).map_or(Vec::new(), |all| std::env::split_paths(&all).collect())
        };
        let shared = listed("AMENT_PREFIX_PATH").into_iter().map(|prefix| prefix.join("share"));
        let packages = given.chain(listed("ROS_PACKAGE_PATH")).chain(shared);
        let packages = packages.filter(|folder| !folder.as_os_str().is_empty()).collect();
        // the folder of a bare file name is the current one
        let folder = urdf.parent().filter(|folder| !folder.as_os_str().is_empty());
        Self { urdf: folder.unwrap_or(Path::new(".")).to_owned(), packages }
    }
}

/// The file that `mesh` names. `package://pkg/rest` is searched for in a folder `pkg` at or above the URDF's
/// folder, or next to one of those, and then in the packages' folders. `file://` and absolute paths are taken
/// as they are. Other names are relative to the URDF's folder. The error lists the places searched.
pub(super) fn find(mesh: &str, folders: &MeshFolders) -> Result<PathBuf, String> {
    if let Some(rest) = mesh.strip_prefix("package://") {
        let rest = rest.trim_start_matches('/');
        let (package, rest) = rest.split_once('/').unwrap_or((rest, ""));
        if package.is_empty() || rest.is_empty() {
            return Err(format!("`{rest}` in package `{package}`"));
        }
        // only a canonical path has all the folders above
        let start = folders.urdf.canonicalize().unwrap_or_else(|_| folders.urdf.clone());
        let is_package = |f: &Path| f.file_name().is_some_and(|name| name == package);
        let within = |f: &Path| if is_package(f) { f.join(rest) } else { f.join(package).join(rest) };
        let above = start.ancestors().map(within);
        let listed = folders.packages.iter().map(|f| within(f));
        return above.chain(listed).find(|f| f.is_file()).ok_or_else(|| {
            let above = format!("`{rest}` in folders `{package}` at or above `{}`", start.display());
            match folders.packages.len() {
                0 => {
                    format!(
                        "{above}; set `packages` in the robot file, or ROS_PACKAGE_PATH, to search elsewhere"
                    )
                }
                count => format!("{above}, and in {count} folders of packages"),
            }
        });
    }
    let file = mesh.strip_prefix("file://").map(PathBuf::from);
    let file = file.unwrap_or_else(|| folders.urdf.join(mesh));
    if file.is_file() { Ok(file) } else { Err(format!("`{}`", file.display())) }
}
