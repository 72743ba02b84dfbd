//! The built-in robots that can be exported, with their meshes.

/// A robot's files: names as on disk, and their bytes.
pub(super) struct RobotFiles {
    pub name: &'static str,
    pub about: &'static str,
    pub files: &'static [(&'static str, &'static [u8])],
}

/// The robot file, the URDF and the meshes in the folder of the robot's name.
macro_rules! robot {
    ($name:literal, $about:literal $(, $mesh:literal)* $(,)?) => {
        RobotFiles {
            name: $name,
            about: $about,
            files: &[
                (concat!($name, ".toml"), include_bytes!(concat!("../../../assets/robots/", $name, ".toml"))),
                (concat!($name, ".urdf"), include_bytes!(concat!("../../../assets/robots/", $name, ".urdf"))),
                $((
                    concat!($name, "/", $mesh),
                    include_bytes!(concat!("../../../assets/robots/", $name, "/", $mesh)),
                ),)*
            ],
        }
    };
}

/// The robots, the built-in default first.
pub(super) const ROBOTS: [RobotFiles; 4] = [
    robot!("carrier", "The built-in robot: robot file and URDF"),
    robot!("omni-carrier", "The same robot on an omnidirectional base: robot file and URDF"),
    robot!(
        "porter",
        "A robot on two wheels with a lift and six joints: robot file, URDF and meshes",
        "base.stl",
        "base_amber.obj",
        "base_black.obj",
        "base_grey.obj",
        "base_white.obj",
        "column.stl",
        "column_grey.obj",
        "column_white.obj",
        "forearm.stl",
        "forearm_white.obj",
        "gripper.stl",
        "gripper_black.obj",
        "gripper_grey.obj",
        "lift.stl",
        "lift_teal.obj",
        "shoulder_pan.stl",
        "shoulder_pan_grey.obj",
        "shoulder_pan_teal.obj",
        "tool.stl",
        "tool_teal.obj",
        "upper_arm.stl",
        "upper_arm_teal.obj",
        "upper_arm_white.obj",
        "wheel_black.obj",
        "wheel_grey.obj",
        "wrist.stl",
        "wrist_roll.stl",
        "wrist_roll_grey.obj",
        "wrist_roll_teal.obj",
        "wrist_white.obj",
    ),
    robot!(
        "shuttle",
        "A robot on four mecanum wheels with six joints: robot file, URDF and meshes",
        "base.stl",
        "base_amber.obj",
        "base_grey.obj",
        "base_white.obj",
        "boom.stl",
        "boom_teal.obj",
        "boom_white.obj",
        "gripper.stl",
        "gripper_black.obj",
        "gripper_grey.obj",
        "mecanum_a_black.obj",
        "mecanum_a_grey.obj",
        "mecanum_b_black.obj",
        "mecanum_b_grey.obj",
        "pedestal.stl",
        "pedestal_grey.obj",
        "stick.stl",
        "stick_teal.obj",
        "stick_white.obj",
        "turret.stl",
        "turret_teal.obj",
        "turret_white.obj",
        "wrist_pitch.stl",
        "wrist_pitch_grey.obj",
        "wrist_roll.stl",
        "wrist_roll_teal.obj",
        "wrist_yaw.stl",
        "wrist_yaw_grey.obj",
        "wrist_yaw_teal.obj",
    ),
];
