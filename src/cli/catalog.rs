//! The files that the program contains: worlds, robots, studies and answers.

use crate::world::BUILT_IN_WORLDS;

/// A built-in file, or files that belong together.
pub(super) struct BuiltIn {
    pub name: &'static str,
    pub about: &'static str,
    /// Names and texts of its files.
    pub files: Vec<(String, &'static str)>,
}

/// The name of the built-in robot.
pub(super) const ROBOT: &str = "carrier";
pub(super) const ROBOT_FILE: &str = include_str!("../../assets/robots/carrier.toml");
pub(super) const ROBOT_URDF: &str = include_str!("../../assets/robots/carrier.urdf");

/// Names, descriptions and texts of the studies.
const STUDIES: [[&str; 3]; 3] = [
    ["h1", "Study: the choices of random humans (Table I)", include_str!("../../docs/studies/h1.toml")],
    ["h2", "Study: objective cost by method (Table II)", include_str!("../../docs/studies/h2.toml")],
    [
        "h3",
        "Study: control cost with and without pose optimisation (Table III)",
        include_str!("../../docs/studies/h3.toml"),
    ],
];

/// Everything built in: worlds, robots, studies, answers.
pub(super) fn all() -> Vec<BuiltIn> {
    let file = |name: &str, ending: &str, text| (format!("{name}.{ending}"), text);
    let worlds = BUILT_IN_WORLDS.iter().map(|world| BuiltIn {
        name: world.name,
        about: "World: see `cocarry worlds`",
        files: vec![file(world.name, "toml", world.text)],
    });
    let omni_carrier = BuiltIn {
        name: "omni-carrier",
        about: "The same robot on an omnidirectional base: robot file and URDF",
        files: vec![
            file("omni-carrier", "toml", include_str!("../../assets/robots/omni-carrier.toml")),
            file("omni-carrier", "urdf", include_str!("../../assets/robots/omni-carrier.urdf")),
        ],
    };
    let robot = BuiltIn {
        name: ROBOT,
        about: "The built-in robot: robot file and URDF",
        files: vec![file(ROBOT, "toml", ROBOT_FILE), file(ROBOT, "urdf", ROBOT_URDF)],
    };
    let studies =
        STUDIES.map(|[name, about, text]| BuiltIn { name, about, files: vec![file(name, "toml", text)] });
    let answers = BuiltIn {
        name: "table-1-humans",
        about: "Answers of the paper's participants, for `cocarry fit risk-weight`",
        files: vec![file("table-1-humans", "csv", include_str!("../../docs/data/table-1-humans.csv"))],
    };
    worlds.chain([robot, omni_carrier]).chain(studies).chain([answers]).collect()
}
