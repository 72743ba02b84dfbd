//! The files of the benchmark, as they ship. They do not change: a benchmark that does has another name.

/// The name of the benchmark.
pub const NAME: &str = "cocarry bench 1";

/// The page about it, of its files the only one that may change.
pub(super) const README: &str = "README.md";

/// Its best known results: the set, the world, the policy, and what it reached.
pub(super) const BEST: &str = include_str!("../../../../../assets/bench-1/best.csv");

/// Lists files of `assets/bench-1/` with their bytes.
macro_rules! files {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_bytes!(concat!("../../../../../assets/bench-1/", $name)))),*]
    };
}

/// Names, relative to the benchmark's folder, and contents of its files: two studies, their worlds and robots,
/// and a page about it.
#[rustfmt::skip]
pub const FILES: &[(&str, &[u8])] = files![
    "README.md", "full.toml", "small.toml",
    "worlds/clutter-1.toml", "worlds/clutter-2.toml", "worlds/clutter-3.toml", "worlds/clutter-4.toml",
    "worlds/depot-1.toml", "worlds/depot-2.toml", "worlds/doors-1.toml", "worlds/doors-2.toml", "worlds/doors-3.toml",
    "worlds/posts-1.toml", "worlds/posts-2.toml", "worlds/posts-3.toml",
    "worlds/slots-1.toml", "worlds/slots-2.toml", "worlds/slots-3.toml", "worlds/twins-1.toml",
    "worlds/walls-1.toml", "worlds/walls-2.toml", "worlds/walls-3.toml", "worlds/walls-4.toml", "worlds/walls-5.toml",
    "worlds/walls-6.toml", "worlds/warehouse-1.toml", "worlds/warehouse-2.toml", "worlds/warehouse-3.toml",
    "robots/omni-carrier.toml", "robots/omni-carrier.urdf", "robots/porter.toml", "robots/porter.urdf",
    "robots/porter/base.stl", "robots/porter/base_amber.obj", "robots/porter/base_black.obj",
    "robots/porter/base_grey.obj", "robots/porter/base_white.obj", "robots/porter/column.stl",
    "robots/porter/column_grey.obj", "robots/porter/column_white.obj", "robots/porter/forearm.stl",
    "robots/porter/forearm_white.obj", "robots/porter/gripper.stl", "robots/porter/gripper_black.obj",
    "robots/porter/gripper_grey.obj", "robots/porter/lift.stl", "robots/porter/lift_teal.obj",
    "robots/porter/shoulder_pan.stl", "robots/porter/shoulder_pan_grey.obj", "robots/porter/shoulder_pan_teal.obj",
    "robots/porter/tool.stl", "robots/porter/tool_teal.obj", "robots/porter/upper_arm.stl",
    "robots/porter/upper_arm_teal.obj", "robots/porter/upper_arm_white.obj", "robots/porter/wheel_black.obj",
    "robots/porter/wheel_grey.obj", "robots/porter/wrist.stl", "robots/porter/wrist_roll.stl",
    "robots/porter/wrist_roll_grey.obj", "robots/porter/wrist_roll_teal.obj", "robots/porter/wrist_white.obj",
];
