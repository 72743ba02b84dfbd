//! The carrier with one thing spoiled, and the message about it.

use crate::support::repository;
use cocarry::robot::Robot;

pub const TOML: &str = "carrier.toml";
pub const URDF: &str = "carrier.urdf";

pub fn original(name: &str) -> String {
    std::fs::read_to_string(repository("assets/robots").join(name)).expect("text")
}

/// The two files, in a folder of their own.
pub struct Files {
    pub folder: tempfile::TempDir,
    pub toml: String,
    pub urdf: String,
}

impl Files {
    pub fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        Self { folder, toml: original(TOML), urdf: original(URDF) }
    }

    /// Replaces the one place where `from` stands.
    pub fn with(mut self, file: &str, from: &str, to: &str) -> Self {
        let text = if file == TOML { &mut self.toml } else { &mut self.urdf };
        assert_eq!(text.matches(from).count(), 1, "{from:?}");
        *text = text.replace(from, to);
        self
    }

    /// Replaces what stands after `from` the first time that it comes after `item`.
    pub fn within(mut self, item: &str, from: &str, to: &str) -> Self {
        let start = self.urdf.find(item).expect("the item");
        let at = start + self.urdf[start..].find(from).expect("the text");
        self.urdf.replace_range(at..at + from.len(), to);
        self
    }

    /// Takes the collision shapes of the base and of what is rigid with it away, but its wheels'.
    pub fn without_base_shapes(mut self) -> Self {
        for link in ["base_link", "front_caster_link", "rear_caster_link", "torso_link"] {
            let start = self.urdf.find(&format!("<link name=\"{link}\">")).expect("the link");
            let at = |text: &str| start + self.urdf[start..].find(text).expect("a collision shape");
            let (from, to) = (at("<collision>"), at("</collision>") + "</collision>".len());
            self.urdf.replace_range(from..to, "");
        }
        self
    }

    pub fn load(&self, name: &str) -> Result<Robot, String> {
        std::fs::write(self.folder.path().join(TOML), &self.toml).expect("a file");
        std::fs::write(self.folder.path().join(URDF), &self.urdf).expect("a file");
        self.load_as_is(name)
    }

    pub fn load_as_is(&self, name: &str) -> Result<Robot, String> {
        // the chain of causes, as the program prints it
        let chain = |e| format!("{:#}", anyhow::Error::from(e));
        Robot::load(&self.folder.path().join(name)).map_err(chain)
    }

    /// The error must contain all of these.
    pub fn says(&self, said: &[&str]) {
        check(self.load(TOML), said);
    }
}

pub fn check(robot: Result<Robot, String>, said: &[&str]) {
    let Err(error) = robot else { panic!("the robot is accepted, but {said:?} was to be said") };
    for part in said {
        assert!(error.contains(part), "{part:?} is missing from: {error}");
    }
}

pub fn toml(from: &str, to: &str, said: &[&str]) {
    Files::new().with(TOML, from, to).says(&[&["carrier.toml"], said].concat());
}

pub fn urdf(from: &str, to: &str, said: &[&str]) {
    Files::new().with(URDF, from, to).says(&[&["carrier.urdf"], said].concat());
}

/// Spoils something of one joint or link of the URDF.
pub fn item(name: &str, from: &str, to: &str, said: &[&str]) {
    let opening = format!("name=\"{name}\"");
    let files = Files::new().within(&opening, from, to);
    files.says(&[&["carrier.urdf", &format!("`{name}`")], said].concat());
}
