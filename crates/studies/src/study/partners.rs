//! The policies and humans that a caller gives a study in place of its own: built-in ones by name, and custom
//! ones, which the rows tell by name, version and a digest of their code.

use super::cell::Cell;
use super::file::Contents;
use super::row;
use cocarry::Error;
use cocarry::episode::Episode;
use cocarry::human::ModelName;
use cocarry::policy::Method;
use cocarry::scenario::{PreparedScenario, SETTINGS, Value};
use std::collections::BTreeSet;

/// The keys of the settings that partners take the place of, and the columns of their code.
const KEYS: [[&str; 2]; 2] = [["method", "policy_code"], ["human_model", "human_code"]];
/// The largest number of policies, and of humans.
pub(super) const MAX_PARTNERS: usize = 100;
/// The longest name, version or digest, characters.
const MAX_TEXT: usize = 100;

/// A policy of the robot, or a human.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Partner {
    /// A method or human model of the program, as in a study.
    BuiltIn(String),
    /// One whose code the program does not know.
    Custom {
        /// The name in the rows' column `method` or `human_model`.
        name: String,
        /// What is known of its code: a version, a digest. A sweep resumes only where it is equal.
        code: String,
    },
}

/// The policies and humans of a study in place of those that its file names. None: those of the file.
#[derive(Clone, Debug, Default)]
pub struct Partners([Vec<Partner>; 2]);

/// The custom partners of an episode: indices into the lists given to [`Partners::new`]; `None` for those that
/// the program makes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Custom {
    /// The robot's policy.
    pub policy: Option<usize>,
    /// The human.
    pub human: Option<usize>,
}

/// Makes the episodes of a study with custom partners, on any thread.
pub trait EpisodeMaker: Sync {
    /// The episode of a prepared scenario with these partners, before its first step.
    ///
    /// # Errors
    /// The episode cannot begin: its row says why.
    fn begin<'s>(&self, prepared: &'s PreparedScenario, custom: Custom) -> Result<Episode<'s>, Error>;

    /// Whether episodes are given up: no row is made of them.
    fn is_over(&self) -> bool {
        false
    }
}

/// The episodes of a study without custom partners.
pub(super) struct BuiltIn;

impl EpisodeMaker for BuiltIn {
    fn begin<'s>(&self, prepared: &'s PreparedScenario, _: Custom) -> Result<Episode<'s>, Error> {
        prepared.episode()
    }
}

impl Partners {
    /// Policies and humans, each in the order of the rows.
    ///
    /// # Errors
    /// A name is that of two, or a custom one has the name of a built-in one, or a built-in one is not known.
    pub fn new(policies: Vec<Partner>, humans: Vec<Partner>) -> Result<Self, Error> {
        check(&policies, "policy", &|name| name.parse::<Method>().map(drop).map_err(|e| e.to_string()))?;
        check(&humans, "human", &|name| name.parse::<ModelName>().map(drop).map_err(|e| e.to_string()))?;
        Ok(Self([policies, humans]))
    }

    /// Whether one of them is custom.
    pub fn are_custom(&self) -> bool {
        self.0.iter().flatten().any(|partner| matches!(partner, Partner::Custom { .. }))
    }

    /// Puts the partners in the place of those of every combination. Combinations that differed in these only
    /// become one.
    pub(super) fn apply(self, contents: &mut Contents) {
        // cells are told apart by the names of their partners
        contents.partners = self.clone();
        for (which, partners) in self.0.iter().enumerate().filter(|(_, partners)| !partners.is_empty()) {
            for i in 0..contents.runs.len() {
                let cells = std::mem::take(&mut contents.runs[i].0.cells);
                contents.runs[i].0.cells = crossed(contents, cells, which, partners);
            }
        }
    }

    /// The name and the code of a cell's custom policy (0) or human (1).
    pub(super) fn custom(&self, which: usize, cell: &Cell) -> Option<[&str; 2]> {
        match &self.0[which][[cell.custom.policy, cell.custom.human][which]?] {
            Partner::Custom { name, code } => Some([name, code]),
            Partner::BuiltIn(_) => None,
        }
    }

    /// The name of a custom partner that takes the place of this setting.
    pub(super) fn name_of(&self, key: &str, cell: &Cell) -> Option<&str> {
        let which = KEYS.iter().position(|[setting, _]| *setting == key)?;
        self.custom(which, cell).map(|[name, _]| name)
    }
}

/// Every combination with every partner, without repetition.
fn crossed(contents: &Contents, cells: Vec<Cell>, which: usize, partners: &[Partner]) -> Vec<Cell> {
    let setting = SETTINGS.iter().position(|setting| setting.key == KEYS[which][0]);
    let at = setting.expect("partners take the place of settings");
    let mut known = BTreeSet::new();
    let mut crossed = Vec::with_capacity(cells.len() * partners.len());
    for mut cell in cells {
        // custom ones run on the defaults
        cell.values[at] = SETTINGS[at].get(&cocarry::scenario::Scenario::defaults());
        if !known.insert(row::inputs(contents, &cell)) {
            continue;
        }
        for (i, partner) in partners.iter().enumerate() {
            let mut cell = cell.clone();
            match partner {
                Partner::BuiltIn(name) => cell.values[at] = Some(Value::Text(name.clone())),
                Partner::Custom { .. } if which == 0 => cell.custom.policy = Some(i),
                Partner::Custom { .. } => cell.custom.human = Some(i),
            }
            crossed.push(cell);
        }
    }
    crossed
}

/// The check of a list of partners; `built_in` says why a name is not one of the program's.
fn check(
    partners: &[Partner],
    what: &str,
    built_in: &dyn Fn(&str) -> Result<(), String>,
) -> Result<(), Error> {
    let refused = |words: String| Err(Error::new(format!("{what}: {words}")));
    if partners.len() > MAX_PARTNERS {
        return refused(format!("{} of them; there must be at most {MAX_PARTNERS}", partners.len()));
    }
    for (i, partner) in partners.iter().enumerate() {
        let name = match partner {
            Partner::BuiltIn(name) => {
                if let Err(words) = built_in(name) {
                    return refused(words);
                }
                name
            }
            Partner::Custom { name, code } => {
                let is_text = |text: &&String| {
                    !text.is_empty()
                        && text.chars().count() <= MAX_TEXT
                        && !text.chars().any(char::is_control)
                };
                if let Some(wrong) = [name, code].into_iter().find(|text| !is_text(text)) {
                    return refused(format!(
                        "{wrong:?}; a name or version must have 1 to {MAX_TEXT} characters, none of them a control character"
                    ));
                }
                if built_in(name).is_ok() {
                    return refused(format!(
                        "a custom {what} is called `{name}`, as a built-in one; give it another name"
                    ));
                }
                name
            }
        };
        let names = partners[..i].iter().map(|(Partner::BuiltIn(name) | Partner::Custom { name, .. })| name);
        if names.into_iter().any(|other| other == name) {
            return refused(format!("two are called `{name}`; give each a name of its own"));
        }
    }
    Ok(())
}
