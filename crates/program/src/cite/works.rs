//! The works that an episode may have used, each with the condition for it.

use super::reference::{Author, Reference, ReferenceKind};
use cocarry::preference::{CONDITIONAL_VALUE_AT_RISK, CUMULATIVE_PROSPECT, RiskPerception};
use cocarry::scenario::{PlantKind, Scenario};

/// A work and who used it.
pub(super) struct Work {
    /// Whether it is cited where there is no episode.
    pub is_general: bool,
    /// Whether an episode used it.
    pub is_used: fn(&Scenario) -> bool,
    pub reference: for<'a> fn(&'a Origin) -> Reference<'a>,
}

/// All works, in the order of the entries.
pub(super) const WORKS: [Work; 12] = [
    Work { is_general: true, is_used: |_| true, reference: |_| PAPER },
    Work { is_general: true, is_used: |_| true, reference: program },
    Work { is_general: false, is_used: |_| true, reference: |_| PRELEC },
    Work { is_general: false, is_used: |_| true, reference: |_| STEVENS },
    Work { is_general: false, is_used: chooses_by_logit, reference: |_| MCFADDEN },
    Work {
        is_general: false,
        is_used: |scenario| is_human(scenario, CUMULATIVE_PROSPECT.name()),
        reference: |_| TVERSKY,
    },
    Work {
        is_general: false,
        is_used: |scenario| is_human(scenario, CONDITIONAL_VALUE_AT_RISK.name()),
        reference: |_| ROCKAFELLAR,
    },
    Work { is_general: false, is_used: has_controller, reference: |_| JUDICE },
    Work { is_general: false, is_used: has_controller, reference: |_| LAWSON },
    Work {
        is_general: false,
        is_used: has_controller,
        reference: |origin| origin.with_version(CLARABEL, option_env!("CLARABEL_VERSION")),
    },
    Work {
        is_general: false,
        is_used: has_physics,
        reference: |origin| origin.with_version(RAPIER, option_env!("RAPIER_VERSION")),
    },
    Work {
        is_general: false,
        is_used: has_controller,
        reference: |origin| origin.with_version(PARRY, option_env!("PARRY_VERSION")),
    },
];

/// The human, or the humans of the robot's belief, choose with Boltzmann's probabilities.
fn chooses_by_logit(scenario: &Scenario) -> bool {
    is_human(scenario, "boltzmann") || scenario.settings.predictor.rationality().is_some()
}

fn is_human(scenario: &Scenario, model: &str) -> bool {
    scenario.human_model.model().name == model
}

fn has_controller(scenario: &Scenario) -> bool {
    scenario.plant.robot_setup().is_some()
}

fn has_physics(scenario: &Scenario) -> bool {
    scenario.plant.kind() == PlantKind::Rapier
}

/// The program that an episode ran in.
pub(super) struct Origin {
    is_recording: bool,
    version: Option<String>,
}

impl Origin {
    /// This program.
    pub fn of_program() -> Self {
        Self { is_recording: false, version: Some(OUR_VERSION.to_owned()) }
    }

    /// The program that wrote a recording of this version.
    pub fn of_recording(version: Option<String>) -> Self {
        Self { is_recording: true, version }
    }

    /// Whether it is this program, as far as versions tell.
    fn is_ours(&self) -> bool {
        self.version.as_deref() == Some(OUR_VERSION)
    }

    /// Software with the version that this program was built with, if it is this program.
    fn with_version(&self, software: Reference<'static>, version: Option<&'static str>) -> Reference<'_> {
        Reference { version: version.filter(|_| self.is_ours()), ..software }
    }

    /// What the entries do not say.
    pub fn notes(&self) -> Option<String> {
        match (&self.version, COMMIT) {
            (None, _) => Some("the recording does not name the version of the program that wrote it: add it".to_owned()),
            (Some(version), _) if !self.is_ours() => Some(format!(
                "version {version} wrote the recording, and this is version {OUR_VERSION}: add the commit of the former, and the versions of its packages"
            )),
            (_, None) => Some(
                "this build does not know its commit: add it, as `git rev-parse HEAD` prints it in the clone that the program was built from"
                    .to_owned(),
            ),
            (_, Some(_)) if self.is_recording => Some(
                "a recording names the version of the program that wrote it, not the commit: the commit is that of this program".to_owned(),
            ),
            (_, Some(_)) => None,
        }
    }
}

/// The version of this program.
const OUR_VERSION: &str = env!("CARGO_PKG_VERSION");
/// The commit that this program was built from, if the build knows it.
const COMMIT: Option<&str> = option_env!("COMMIT_OF_BUILD");
/// The year of this version, as in CITATION.cff.
const YEAR: u16 = 2026;

fn program(origin: &Origin) -> Reference<'_> {
    Reference {
        version: origin.version.as_deref(),
        year: origin.is_ours().then_some(YEAR),
        commit: COMMIT.filter(|_| origin.is_ours()),
        ..PROGRAM
    }
}

const PAPER: Reference<'static> = Reference {
    year: Some(2025),
    arxiv: "2503.08895",
    ..Reference::new(
        "mahmud2025mutual",
        ReferenceKind::Preprint,
        &[
            Author::Person("Mahmud", "Al Jaber"),
            Author::Person("Li", "Weizi"),
            Author::Person("Wang", "Xuan"),
        ],
        "Mutual Adaptation in Human-Robot Co-Transportation with Human Preference Uncertainty",
        "the model that is simulated",
    )
};

const PROGRAM: Reference<'static> = Reference::new(
    "cocarry",
    ReferenceKind::Software,
    &[Author::Group("The cocarry authors")],
    "cocarry: a simulator of human-robot co-transportation",
    "the simulator",
);

const PRELEC: Reference<'static> = Reference {
    year: Some(1998),
    within: "Econometrica",
    volume: "66",
    issue: "3",
    pages: Some((497, 527)),
    doi: "10.2307/2998573",
    ..Reference::new(
        "prelec1998probability",
        ReferenceKind::Article,
        &[Author::Person("Prelec", "Drazen")],
        "The probability weighting function",
        "perceived risk, eq. (2)",
    )
};

const STEVENS: Reference<'static> = Reference {
    year: Some(1957),
    within: "Psychological Review",
    volume: "64",
    issue: "3",
    pages: Some((153, 181)),
    doi: "10.1037/h0046162",
    ..Reference::new(
        "stevens1957psychophysical",
        ReferenceKind::Article,
        &[Author::Person("Stevens", "Stanley Smith")],
        "On the psychophysical law",
        "perceived distance, eq. (2)",
    )
};

const MCFADDEN: Reference<'static> = Reference {
    year: Some(1974),
    within: "Frontiers in Econometrics",
    editors: &[Author::Person("Zarembka", "Paul")],
    pages: Some((105, 142)),
    publisher: "Academic Press",
    place: "New York",
    ..Reference::new(
        "mcfadden1974conditional",
        ReferenceKind::Chapter,
        &[Author::Person("McFadden", "Daniel")],
        "Conditional logit analysis of qualitative choice behavior",
        "humans who choose with Boltzmann's probabilities",
    )
};

const TVERSKY: Reference<'static> = Reference {
    year: Some(1992),
    within: "Journal of Risk and Uncertainty",
    volume: "5",
    issue: "4",
    pages: Some((297, 323)),
    doi: "10.1007/BF00122574",
    ..Reference::new(
        "tversky1992advances",
        ReferenceKind::Article,
        &[Author::Person("Tversky", "Amos"), Author::Person("Kahneman", "Daniel")],
        "Advances in prospect theory: cumulative representation of uncertainty",
        "humans who perceive risk by cumulative prospect theory",
    )
};

const ROCKAFELLAR: Reference<'static> = Reference {
    year: Some(2000),
    within: "Journal of Risk",
    volume: "2",
    issue: "3",
    pages: Some((21, 41)),
    doi: "10.21314/JOR.2000.038",
    ..Reference::new(
        "rockafellar2000optimization",
        ReferenceKind::Article,
        &[Author::Person("Rockafellar", "R. Tyrrell"), Author::Person("Uryasev", "Stanislav")],
        "Optimization of conditional value-at-risk",
        "humans who perceive risk by its conditional value at risk",
    )
};

const JUDICE: Reference<'static> = Reference {
    year: Some(1994),
    within: "Computers & Operations Research",
    volume: "21",
    issue: "5",
    pages: Some((587, 596)),
    doi: "10.1016/0305-0548(94)90106-6",
    ..Reference::new(
        "judice1994block",
        ReferenceKind::Article,
        &[Author::Person("Júdice", "J. J."), Author::Person("Pires", "F. M.")],
        "A block principal pivoting algorithm for large-scale strictly monotone linear complementarity problems",
        "the controller, eq. (7): the first method of its solver",
    )
};

const LAWSON: Reference<'static> = Reference {
    year: Some(1995),
    publisher: "SIAM",
    doi: "10.1137/1.9781611971217",
    ..Reference::new(
        "lawson1995solving",
        ReferenceKind::Book,
        &[Author::Person("Lawson", "Charles L."), Author::Person("Hanson", "Richard J.")],
        "Solving least squares problems",
        "the controller, eq. (7): the second method, where the first does not converge",
    )
};

const CLARABEL: Reference<'static> = Reference {
    year: Some(2024),
    arxiv: "2405.12762",
    ..Reference::new(
        "goulart2024clarabel",
        ReferenceKind::Preprint,
        &[Author::Person("Goulart", "Paul J."), Author::Person("Chen", "Yuwen")],
        "{Clarabel}: An interior-point solver for conic programs with quadratic objectives",
        "the controller, eq. (7): the solver where neither method converges",
    )
};

const RAPIER: Reference<'static> = Reference {
    url: "https://rapier.rs",
    ..Reference::new(
        "rapier",
        ReferenceKind::Software,
        &[Author::Person("Crozet", "Sébastien")],
        "{Rapier}: 2D and 3D physics engines for the {Rust} programming language",
        "the physics of the bodies",
    )
};

const PARRY: Reference<'static> = Reference {
    url: "https://parry.rs",
    ..Reference::new(
        "parry",
        ReferenceKind::Software,
        &[Author::Person("Crozet", "Sébastien")],
        "{Parry}: 2D and 3D geometric and collision detection libraries",
        "distances and contacts of shapes",
    )
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_edition_is_that_of_the_recordings_program() {
        let ours = Origin::of_recording(Some(OUR_VERSION.to_owned()));
        assert_eq!((program(&ours).version, program(&ours).year), (Some(OUR_VERSION), Some(YEAR)));
        assert!(ours.with_version(RAPIER, Some("1.2.3")).bibtex().contains("note = {Version 1.2.3}"));
        for (version, said) in
            [(Some("0.0.9"), "version 0.0.9 wrote the recording"), (None, "does not name the version")]
        {
            let other = Origin::of_recording(version.map(str::to_owned));
            let program = program(&other);
            assert_eq!((program.version, program.year, program.commit), (version, None, None));
            assert_eq!(other.with_version(RAPIER, Some("1.2.3")).version, None);
            assert!(other.notes().unwrap().contains(said));
        }
    }

    #[test]
    fn paper_and_program_are_those_of_the_citation_file() {
        let file = include_str!("../../../../CITATION.cff");
        let authors = PAPER.authors.iter().map(|author| match author {
            Author::Person(family, given) => format!("family-names: {family}\n        given-names: {given}"),
            Author::Group(name) => panic!("{name}"),
        });
        let unquoted = file.replace('"', "");
        for part in authors.chain([
            format!("title: {}\n", PROGRAM.title),
            format!("version: {OUR_VERSION}\n"),
            format!("date-released: {YEAR}-"),
            format!("title: {}\n", PAPER.title),
            format!("    year: {}\n", PAPER.year.unwrap()),
            format!("        value: arXiv:{}\n", PAPER.arxiv),
        ]) {
            assert!(unquoted.contains(&part), "{part}");
        }
    }

    #[test]
    fn keys_are_unique() {
        let mut keys: Vec<_> = WORKS.iter().map(|work| (work.reference)(&Origin::of_program()).key).collect();
        keys.sort_unstable();
        keys.dedup();
        assert_eq!(keys.len(), WORKS.len());
    }
}
