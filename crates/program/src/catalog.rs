//! The files that the program contains: worlds, robots, studies and answers.

use super::catalog_robots::ROBOTS;
use cocarry::world::BUILT_IN_WORLDS;

/// A built-in file, or files that belong together.
pub(super) struct BuiltIn {
    pub name: &'static str,
    pub about: &'static str,
    /// Names and contents of its files. Those of meshes begin with a folder.
    pub files: Vec<(String, &'static [u8])>,
}

/// The name of the built-in robot.
pub(super) const ROBOT: &str = "carrier";
pub(super) const ROBOT_URDF: &str = include_str!("../../../assets/robots/carrier.urdf");

/// Names, descriptions and texts of the studies.
const STUDIES: [[&str; 3]; 3] = [
    ["h1", "Study: the choices of random humans (Table I)", include_str!("../../../docs/studies/h1.toml")],
    ["h2", "Study: objective cost by method (Table II)", include_str!("../../../docs/studies/h2.toml")],
    [
        "h3",
        "Study: control cost with and without pose optimisation (Table III)",
        include_str!("../../../docs/studies/h3.toml"),
    ],
];

/// Everything built in: worlds, robots, studies, answers.
pub(super) fn all() -> Vec<BuiltIn> {
    let file = |name: &str, ending: &str, text: &'static str| (format!("{name}.{ending}"), text.as_bytes());
    let worlds = BUILT_IN_WORLDS.iter().map(|world| BuiltIn {
        name: world.name,
        about: "World: see `cocarry worlds`",
        files: vec![file(world.name, "toml", world.text)],
    });
    let robots = ROBOTS.iter().map(|robot| BuiltIn {
        name: robot.name,
        about: robot.about,
        files: robot.files.iter().map(|(name, bytes)| ((*name).to_owned(), *bytes)).collect(),
    });
    let studies =
        STUDIES.map(|[name, about, text]| BuiltIn { name, about, files: vec![file(name, "toml", text)] });
    let answers = BuiltIn {
        name: "table-1-humans",
        about: "Answers of the paper's participants, for `cocarry fit risk-weight`",
        files: vec![file("table-1-humans", "csv", include_str!("../../../docs/data/table-1-humans.csv"))],
    };
    worlds.chain(robots).chain(studies).chain([answers]).collect()
}
