//! The world and the robot that a scenario is given: their texts, and what is parsed from them, once.

use crate::error::Error;
use crate::options::OptionSet;
use crate::robot::{Robot, RobotTexts};
use crate::world::World;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// A world file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorldText {
    /// Its name in errors.
    pub file: String,
    /// Its text.
    pub text: String,
}

/// The world of a scenario: a world, or the text of a world file, which is parsed when it is first needed. In
/// files it is its [`WorldText`]. Clones share what was parsed.
#[derive(Clone)]
pub struct GivenWorld(Arc<WorldParts>);

struct WorldParts {
    world: TextOr<WorldText, World>,
    /// The options found last, and their c_r (m).
    options: Mutex<Option<(f64, Arc<OptionSet>)>>,
}

/// The robot of a scenario: a robot, or its texts, which are parsed when it is first needed. In files it is
/// its [`RobotTexts`]. Clones share what was parsed.
#[derive(Clone)]
pub struct GivenRobot(Arc<TextOr<RobotTexts, Robot>>);

/// A text and what is parsed from it; or what was parsed before, which has its text within it.
enum TextOr<Text, Parsed> {
    Text(Text, OnceLock<Arc<Parsed>>),
    Parsed(Arc<Parsed>),
}

impl<Text, Parsed> TextOr<Text, Parsed> {
    /// The parsed part, if it was parsed.
    fn parsed(&self) -> Option<&Arc<Parsed>> {
        match self {
            Self::Text(_, parsed) => parsed.get(),
            Self::Parsed(parsed) => Some(parsed),
        }
    }

    /// Keeps what was just parsed from the text.
    fn keep(&self, just_parsed: Arc<Parsed>) -> Arc<Parsed> {
        match self {
            Self::Text(_, parsed) => Arc::clone(parsed.get_or_init(|| just_parsed)),
            Self::Parsed(parsed) => Arc::clone(parsed),
        }
    }
}

impl GivenWorld {
    /// The name of the world file.
    pub fn file(&self) -> &str {
        match &self.0.world {
            TextOr::Text(world, _) => &world.file,
            TextOr::Parsed(world) => &world.file,
        }
    }

    /// The text of the world file.
    pub fn text(&self) -> &str {
        match &self.0.world {
            TextOr::Text(world, _) => &world.text,
            TextOr::Parsed(world) => &world.text,
        }
    }

    /// The world as written.
    ///
    /// # Errors
    /// As [`World::parse`].
    pub fn world(&self) -> Result<Arc<World>, Error> {
        self.for_width(0.0)
    }

    /// The world for a robot of at least this width (m).
    ///
    /// # Errors
    /// As [`World::parse_for`].
    pub fn for_width(&self, width: f64) -> Result<Arc<World>, Error> {
        if let Some(world) = self.0.world.parsed().filter(|world| world.has_room_for(width)) {
            return Ok(Arc::clone(world));
        }
        let world = Arc::new(World::parse_for(self.file(), self.text(), width)?);
        Ok(if world.is_widened { world } else { self.0.world.keep(world) })
    }

    /// The options of the world as written, with c_r = `risk_weight` (m). Those found last are kept.
    ///
    /// # Errors
    /// As [`OptionSet::new`].
    pub fn options(&self, risk_weight: f64) -> Result<Arc<OptionSet>, Error> {
        let mut known = self.0.options.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, options)) = known.as_ref().filter(|(other, _)| *other == risk_weight) {
            return Ok(Arc::clone(options));
        }
        let options = Arc::new(OptionSet::new(&*self.world()?, risk_weight)?);
        *known = Some((risk_weight, Arc::clone(&options)));
        Ok(options)
    }
}

impl From<TextOr<WorldText, World>> for GivenWorld {
    fn from(world: TextOr<WorldText, World>) -> Self {
        Self(Arc::new(WorldParts { world, options: Mutex::default() }))
    }
}

impl GivenRobot {
    /// The texts of the robot.
    pub fn texts(&self) -> &RobotTexts {
        match &*self.0 {
            TextOr::Text(texts, _) => texts,
            TextOr::Parsed(robot) => &robot.texts,
        }
    }

    /// The robot.
    ///
    /// # Errors
    /// As [`Robot::parse`].
    pub fn robot(&self) -> Result<Arc<Robot>, Error> {
        match self.0.parsed() {
            Some(robot) => Ok(Arc::clone(robot)),
            None => Ok(self.0.keep(Arc::new(Robot::parse(self.texts())?))),
        }
    }
}

impl From<World> for GivenWorld {
    /// A world that was parsed from its text. Changes made to its other fields since then are not part of a
    /// scenario.
    fn from(world: World) -> Self {
        match world.is_widened {
            true => WorldText { file: world.file, text: world.text }.into(),
            false => TextOr::Parsed(Arc::new(world)).into(),
        }
    }
}

impl From<WorldText> for GivenWorld {
    fn from(text: WorldText) -> Self {
        TextOr::Text(text, OnceLock::new()).into()
    }
}

impl From<Arc<Robot>> for GivenRobot {
    fn from(robot: Arc<Robot>) -> Self {
        Self(Arc::new(TextOr::Parsed(robot)))
    }
}

impl From<Robot> for GivenRobot {
    fn from(robot: Robot) -> Self {
        Arc::new(robot).into()
    }
}

impl From<RobotTexts> for GivenRobot {
    fn from(texts: RobotTexts) -> Self {
        Self(Arc::new(TextOr::Text(texts, OnceLock::new())))
    }
}

impl Default for GivenWorld {
    fn default() -> Self {
        WorldText::default().into()
    }
}

impl Default for GivenRobot {
    fn default() -> Self {
        RobotTexts::default().into()
    }
}

/// Worlds are equal if their files are.
impl PartialEq for GivenWorld {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || (self.file(), self.text()) == (other.file(), other.text())
    }
}

/// Robots are equal if their texts are.
impl PartialEq for GivenRobot {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.texts() == other.texts()
    }
}

impl fmt::Debug for GivenWorld {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("GivenWorld").field("file", &self.file()).field("text", &self.text()).finish()
    }
}

impl fmt::Debug for GivenRobot {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_tuple("GivenRobot").field(self.texts()).finish()
    }
}

impl Serialize for GivenWorld {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        #[serde(rename = "WorldText")]
        struct Written<'a> {
            file: &'a str,
            text: &'a str,
        }
        Written { file: self.file(), text: self.text() }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for GivenWorld {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        WorldText::deserialize(deserializer).map(Self::from)
    }
}

impl Serialize for GivenRobot {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.texts().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for GivenRobot {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        RobotTexts::deserialize(deserializer).map(Self::from)
    }
}
