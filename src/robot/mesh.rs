//! The file of a URDF's mesh.

use super::urdf_text::{LFS_POINTER, is_lfs_pointer};
use crate::suggestion;
use percent_encoding::percent_decode_str;
use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// The largest number of collision meshes of a robot: one takes up to a second. As many meshes that are missing
/// are searched for under names like theirs.
pub(super) const MAX_MESHES: usize = 200;
/// The largest number of files of a folder that are compared with a name.
const MAX_FILES: usize = 10_000;

/// The folders in which the meshes of a URDF are searched for.
#[derive(Clone, Debug, Default)]
pub(super) struct MeshFolders {
    /// The URDF's folder.
    pub urdf: PathBuf,
    /// Folders that are packages, or have packages as folders in them.
    pub packages: Vec<PathBuf>,
}

/// The file of a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct FoundMesh {
    pub file: PathBuf,
    /// Whether its name is written in another way than in the URDF.
    pub is_renamed: bool,
}

/// Finds meshes, each name once.
pub(super) struct MeshFinder<'a> {
    folders: Option<&'a MeshFolders>,
    known: RefCell<BTreeMap<String, Result<FoundMesh, String>>>,
    /// How many more names are compared with those of files.
    left: Cell<usize>,
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

    /// The folders in which a file of a package may be, each with the file's name there: a folder of the
    /// package's name at or above the URDF's folder, or next to one of those, and then the packages' folders.
    fn of_package(&self, package: &str, rest: &str) -> Vec<(PathBuf, String)> {
        // only a canonical path has all the folders above
        let start = self.urdf.canonicalize().unwrap_or_else(|_| self.urdf.clone());
        let is_package = |f: &Path| f.file_name().is_some_and(|name| name.eq_ignore_ascii_case(package));
        let within = |folder: &Path| match is_package(folder) {
            true => (folder.to_owned(), rest.to_owned()),
            false => (folder.to_owned(), format!("{package}/{rest}")),
        };
        start.ancestors().chain(self.packages.iter().map(PathBuf::as_path)).map(within).collect()
    }
}

impl<'a> MeshFinder<'a> {
    /// Without folders, every mesh has its name as its file.
    pub fn new(folders: Option<&'a MeshFolders>) -> Self {
        Self { folders, known: RefCell::default(), left: Cell::new(MAX_MESHES) }
    }

    /// The file that `mesh` names; the error says where it was searched for, or why it is of no use.
    pub fn find(&self, mesh: &str) -> Result<FoundMesh, String> {
        let Some(folders) = self.folders else {
            return Ok(FoundMesh { file: PathBuf::from(mesh), is_renamed: false });
        };
        if let Some(known) = self.known.borrow().get(mesh) {
            return known.clone();
        }
        let found = self.search(mesh, folders);
        self.known.borrow_mut().insert(mesh.to_owned(), found.clone());
        found
    }

    /// As the file is written in the URDF, then with what was done to its name undone, then in any case.
    fn search(&self, mesh: &str, folders: &MeshFolders) -> Result<FoundMesh, String> {
        let spellings = spellings(mesh);
        let places: Vec<_> = spellings.iter().flat_map(|name| places(name, folders)).collect();
        let exact = || places.iter().map(|(folder, name)| folder.join(name)).find(|file| file.is_file());
        let is_left = || self.left.get().checked_sub(1).map(|left| self.left.set(left)).is_some();
        let in_any_case =
            || is_left().then(|| places.iter().find_map(|(folder, name)| alike(folder, name)))?;
        let file = exact().or_else(in_any_case).ok_or_else(|| self.not_found(mesh, folders))?;
        if is_pointer(&file) {
            return Err(format!("{} {LFS_POINTER}", file.display()));
        }
        let is_renamed = !places_as_written(mesh, folders).contains(&file);
        Ok(FoundMesh { file, is_renamed })
    }

    fn not_found(&self, mesh: &str, folders: &MeshFolders) -> String {
        let Some((package, rest)) = in_package(mesh) else {
            let file = folders.urdf.join(mesh.strip_prefix("file://").unwrap_or(mesh));
            let hint = if self.left.get() > 0 { suggestion::hint_of_files(&file) } else { String::new() };
            return format!("searched for `{}`{hint}", file.display());
        };
        if package.is_empty() || rest.is_empty() {
            return format!("searched for `{rest}` in package `{package}`");
        }
        let start = folders.urdf.canonicalize().unwrap_or_else(|_| folders.urdf.clone());
        let above = format!("searched for `{rest}` in folders `{package}` at or above `{}`", start.display());
        match folders.packages.len() {
            0 => {
                format!("{above}; set `packages` in the robot file, or ROS_PACKAGE_PATH, to search elsewhere")
            }
            count => format!("{above}, and in {count} folders of packages"),
        }
    }
}

/// The name as it is, with `/` for `\`, and with its percent-encoding decoded.
fn spellings(mesh: &str) -> Vec<String> {
    let slashed = mesh.replace('\\', "/");
    let decoded = percent_decode_str(&slashed).decode_utf8().map_or_else(|_| slashed.clone(), Into::into);
    let mut spellings = vec![mesh.to_owned(), slashed, decoded];
    spellings.dedup();
    spellings
}

/// The package that a name is in, and its name there. Models of Gazebo are packages.
fn in_package(mesh: &str) -> Option<(&str, &str)> {
    let rest = mesh.strip_prefix("package://").or_else(|| mesh.strip_prefix("model://"))?;
    let rest = rest.trim_start_matches('/');
    Some(rest.split_once('/').unwrap_or((rest, "")))
}

/// The folders in which a mesh may be, each with its name there. `file://` and absolute paths are taken as they
/// are, and other names are relative to the URDF's folder.
fn places(mesh: &str, folders: &MeshFolders) -> Vec<(PathBuf, String)> {
    match in_package(mesh) {
        Some((package, rest)) if package.is_empty() || rest.is_empty() => Vec::new(),
        Some((package, rest)) => folders.of_package(package, rest),
        None => vec![(folders.urdf.clone(), mesh.strip_prefix("file://").unwrap_or(mesh).to_owned())],
    }
}

/// The files that a mesh may be, as its name is written.
fn places_as_written(mesh: &str, folders: &MeshFolders) -> Vec<PathBuf> {
    places(mesh, folders).into_iter().map(|(folder, name)| folder.join(name)).collect()
}

/// The file of a name in a folder, where upper and lower case differ. Two that are alike are none.
fn alike(folder: &Path, name: &str) -> Option<PathBuf> {
    let mut at = folder.to_owned();
    for part in Path::new(name).components() {
        let exact = at.join(part);
        at = if exact.exists() { exact } else { only_like(&at, part.as_os_str().to_str()?)? };
    }
    at.is_file().then_some(at)
}

fn only_like(folder: &Path, name: &str) -> Option<PathBuf> {
    let name = name.to_lowercase();
    let is_like = |path: &PathBuf| {
        path.file_name().and_then(|other| other.to_str()).is_some_and(|other| other.to_lowercase() == name)
    };
    let entries = std::fs::read_dir(folder).ok()?.take(MAX_FILES).flatten();
    let mut like = entries.map(|entry| entry.path()).filter(is_like);
    let first = like.next()?;
    like.next().is_none().then_some(first)
}

/// Whether a file is a Git LFS pointer.
fn is_pointer(file: &Path) -> bool {
    let mut head = [0; 64];
    File::open(file)
        .and_then(|mut file| file.read(&mut head))
        .is_ok_and(|length| is_lfs_pointer(&head[..length]))
}
