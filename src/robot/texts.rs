//! The source texts of a robot: its robot file and the URDF that it names, read from files.

use super::file::RobotFile;
use super::mesh::MeshFolders;
use super::urdf::{Hulls, Urdf};
use super::urdf_text::{check_kind, decoded};
use super::urdf_xml::{is_xacro, with_document};
use super::warning::RobotWarning;
use crate::bounds;
use crate::error::{Error, Place};
use crate::located::{self, Source};
use crate::suggestion;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Expands a xacro to the text of a URDF. The simulator itself starts no program.
pub type Expand = dyn Fn(&Path) -> Result<String, Error> + Sync;

/// The name of a robot file's kind, in errors.
pub(super) const KIND: &str = "robot file";

/// The source texts of a robot, from which it can be built again without the files.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotTexts {
    /// The robot file, as the caller named it.
    pub file: String,
    /// Text of the robot file.
    pub text: String,
    /// The URDF that the robot file names.
    pub urdf_file: String,
    /// Text of the URDF.
    pub urdf: String,
    /// Vertices of the hulls of collision meshes, or of their convex parts, in the units of their files, by
    /// the names of the meshes in the URDF; where there are hulls, shapes stand in for those that are
    /// missing. `None` if every link that collides has a shape in the URDF itself, and for robots of
    /// recordings by versions without hulls, whose meshes do not collide.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    hulls: Option<SharedHulls>,
    /// The folders in which meshes are searched for.
    #[serde(skip)]
    meshes: MeshFolder,
}

/// The folders of a URDF's meshes, where they are at hand. They do not belong to the robot: recordings
/// and snapshots do not have them.
#[derive(Clone, Debug, Default)]
struct MeshFolder(Option<MeshFolders>);

/// Hulls. Their numbers come from a file, so they are never NaN.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
struct SharedHulls(Hulls);

impl Eq for SharedHulls {}

impl PartialEq for MeshFolder {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Eq for MeshFolder {}

impl RobotTexts {
    /// The same without the folders of its meshes, as in a recording.
    #[must_use]
    pub fn without_folders(&self) -> Self {
        Self { meshes: MeshFolder::default(), ..self.clone() }
    }

    /// Reads a robot file (`.toml`) and the URDF that it names, or a URDF (`.urdf`, `.xml`) and the robot
    /// file of the same name next to it. A xacro is refused without `expand`.
    pub(super) fn read(path: &Path, expand: Option<&Expand>) -> Result<Self, Error> {
        let file = path.display().to_string();
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_lowercase();
        let robot_file = match extension.as_str() {
            "toml" => path.to_owned(),
            "urdf" | "xml" => path.with_extension("toml"),
            // of `robot.urdf.xacro` as well as of `robot.xacro`
            "xacro" if path.exists() => path.with_extension("").with_extension("toml"),
            "xacro" => return Err(xacro(path)),
            _ => {
                let hint = hint_of_file(path);
                let what = something_else(path).map_or(String::new(), |what| format!("{what}; "));
                return Err(Error::at(
                    Place::file(file),
                    format_args!(
                        "{what}expected a robot file (.toml), or a URDF (.urdf or .xml) with a robot file next to it{hint}"
                    ),
                ));
            }
        };
        let asked = (extension != "toml").then_some(path);
        if let Some(urdf) = asked
            && urdf.exists()
            && !robot_file.exists()
        {
            if let Some(what) = something_else(urdf) {
                return Err(Error::at(Place::file(file), what));
            }
            return Err(Error::at(
                Place::file(&file),
                format_args!(
                    "needs a robot file next to it, {}, which names urdf, base_link, grasp_frame, left_wheel and right_wheel (or another drive), base_width_m, grasp_height_m and a [[posture]]; `cocarry robot init {}` drafts one",
                    robot_file.display(),
                    suggestion::shell_word(&file)
                ),
            ));
        }
        let (name, text) = (robot_file.display().to_string(), located::read(&bounds::SETTINGS, &robot_file)?);
        let source = Source { file: &name, text: &text };
        let entries: RobotFile = source.parse(KIND)?;
        let folder = robot_file.parent().unwrap_or(Path::new(""));
        let urdf = folder.join(entries.urdf.get_ref());
        if let Some(asked) = asked.filter(|&asked| !is_same(asked, &urdf)) {
            return Err(Error::value(
                source.place(&entries.urdf, "urdf"),
                format_args!(
                    "{:?}; expected {}, which was asked for",
                    entries.urdf.get_ref(),
                    asked.display()
                ),
            ));
        }
        let urdf_text = read_urdf(&urdf, expand)?;
        let packages = entries.packages.iter().map(|package| folder.join(package));
        let meshes = MeshFolder(Some(MeshFolders::new(&urdf, packages)));
        let urdf_file = urdf.display().to_string();
        Ok(Self { file: name, text, urdf_file, urdf: urdf_text, hulls: None, meshes })
    }

    /// A URDF without a robot file yet.
    pub(super) fn of_urdf(path: &Path, expand: Option<&Expand>) -> Result<Self, Error> {
        let urdf = read_urdf(path, expand)?;
        let urdf_file = path.display().to_string();
        let meshes = MeshFolder(Some(MeshFolders::new(path, std::iter::empty())));
        let (file, text) = (urdf_file.clone(), String::new());
        Ok(Self { file, text, urdf_file, urdf, hulls: None, meshes }.with_hulls().0)
    }

    /// Texts of a robot without meshes.
    pub(super) fn without_meshes([file, text]: [String; 2], [urdf_file, urdf]: [String; 2]) -> Self {
        Self { file, text, urdf_file, urdf, ..Self::default() }
    }

    /// The folders in which meshes are searched for; none for texts of recordings and snapshots.
    pub(super) fn folders(&self) -> Option<&MeshFolders> {
        self.meshes.0.as_ref()
    }

    /// The URDF, with its meshes in these folders.
    pub(super) fn as_urdf<'a>(&'a self, folders: Option<&'a MeshFolders>) -> Urdf<'a> {
        Urdf { file: &self.urdf_file, text: &self.urdf, folders, hulls: self.hulls(), lines: None }
    }

    /// The hulls of the collision meshes, if the texts have them.
    pub(super) fn hulls(&self) -> Option<&Hulls> {
        self.hulls.as_ref().map(|hulls| &hulls.0)
    }

    /// Removes the hulls, of a robot without collision meshes.
    pub(super) fn forget_hulls(&mut self) {
        self.hulls = None;
    }

    /// The same with the text of a robot file.
    pub(super) fn with(&self, text: String) -> Self {
        Self { text, ..self.clone() }
    }

    /// The same with the hulls of the URDF's collision meshes, and warnings about those that have none.
    pub(super) fn with_hulls(mut self) -> (Self, Vec<RobotWarning>) {
        let (hulls, warnings) = Urdf { hulls: None, ..self.as_urdf(self.folders()) }.collision_hulls();
        self.hulls = Some(SharedHulls(hulls));
        (self, warnings)
    }
}

/// The text of a URDF, or of a xacro expanded by `expand`.
fn read_urdf(path: &Path, expand: Option<&Expand>) -> Result<String, Error> {
    let expanded = || expand.ok_or_else(|| xacro(path)).and_then(|expand| expand(path));
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("xacro")) {
        return expanded();
    }
    let file = path.display().to_string();
    let bytes = located::read_file(&bounds::URDF, path)?;
    let text = text_of(&bytes).map_err(|what| Error::at(Place::file(&file), what))?;
    let is_bounded = with_document(&file, &text, |_| ()).is_ok();
    if is_bounded && is_xacro(&text) { expanded() } else { Ok(text) }
}

/// The text of a file that should be a URDF; or what it is instead, as a sentence without the file.
fn text_of(bytes: &[u8]) -> Result<String, String> {
    let text = decoded(bytes)?;
    check_kind(&text).map(|()| text)
}

/// What a file is instead of a URDF, if it can be read.
fn something_else(path: &Path) -> Option<String> {
    located::read_bytes(&bounds::URDF, path).ok().and_then(|bytes| text_of(&bytes).err())
}

/// The error that a URDF is a xacro, with the command that expands it.
pub(super) fn xacro(path: &Path) -> Error {
    let stem = path.with_extension("");
    let has_urdf = stem.extension().is_some_and(|e| e == "urdf");
    let expanded = if has_urdf { stem } else { stem.with_extension("urdf") };
    let expanded = if expanded == path { path.with_extension("expanded.urdf") } else { expanded };
    let word = |path: &Path| suggestion::shell_word(&path.display().to_string());
    Error::at(
        Place::file(path.display().to_string()),
        format_args!(
            "a xacro, not a URDF; xacro runs code that is in the file. If you trust it, expand it first: `xacro -- {} > {}` (`pip install xacro` has the program), or let `run`, `robot check` or `robot init` do it with --xacro, in Python with Robot(..., xacro=True)",
            word(path),
            word(&expanded)
        ),
    )
}

/// A hint for a file of an unknown kind: the built-in robot's name in studies, or a file next to it.
fn hint_of_file(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    match path.exists() {
        true => String::new(),
        false => Some(suggestion::hint(&name, ["built-in"]))
            .filter(|hint| !hint.is_empty())
            .unwrap_or_else(|| suggestion::hint_of_files(path)),
    }
}

fn is_same(a: &Path, b: &Path) -> bool {
    let same = |a: &Path, b: &Path| Some(a.canonicalize().ok()? == b.canonicalize().ok()?);
    a == b || same(a, b).unwrap_or(false)
}
