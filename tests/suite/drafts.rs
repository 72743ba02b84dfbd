//! Drafts of robot files: which link is the tool, which joints are held, what the base is, and what is refused.

use crate::support::{cocarry, stderr, stdout};
use cocarry::robot::{Draft, DraftRequest, DriveKind, Robot};
use std::path::PathBuf;
use tempfile::TempDir;

/// A URDF, link by link.
#[derive(Clone)]
pub struct Urdf(String);

/// Where a joint is, its angles, and its axis.
pub type Frame<'a> = (&'a str, &'a str, &'a str);

const BOX: &str = "<box size=\"0.45 0.4 0.2\"/>";
const WHEEL: &str = "<cylinder radius=\"0.1\" length=\"0.04\"/>";
const ACROSS: &str = "1.5707963267948966 0 0";
pub const NONE: &str = "0 0 0";
pub const Y: &str = "0 1 0";
pub const Z: &str = "0 0 1";

impl Urdf {
    /// A robot of one link with a shape, of 30 kg.
    fn root(name: &str) -> Self {
        Self(String::new()).link(name, 30.0, &shape("0 0 0.1", NONE, BOX))
    }

    /// The same on two wheels.
    pub fn on_wheels() -> Self {
        let wheel = |urdf: Self, side: &str, y: &str| {
            let (name, at) = (format!("{side}_wheel"), format!("0 {y} 0"));
            urdf.wheel(&name, "base_link", (&at, NONE, Y), &shape(NONE, ACROSS, WHEEL))
        };
        wheel(wheel(Self::root("base_link"), "left", "0.2"), "right", "-0.2")
    }

    fn link(self, name: &str, mass: f64, shapes: &str) -> Self {
        let inertia = mass * 0.01;
        Self(format!(
            "{}<link name=\"{name}\"><inertial><mass value=\"{mass}\"/><inertia ixx=\"{inertia}\" ixy=\"0\" \
             ixz=\"0\" iyy=\"{inertia}\" iyz=\"0\" izz=\"{inertia}\"/></inertial>{shapes}</link>\n",
            self.0
        ))
    }

    /// A joint with the limits of its kind.
    fn joint(self, kind: &str, name: &str, ends: [&str; 2], (at, rpy, axis): Frame) -> Self {
        let limit = match kind {
            "prismatic" => "<limit lower=\"0\" upper=\"0.4\" velocity=\"1\" effort=\"300\"/>",
            "continuous" => "<limit velocity=\"15\" effort=\"300\"/>",
            "fixed" => "",
            _ => "<limit lower=\"-2.9\" upper=\"2.9\" velocity=\"3\" effort=\"300\"/>",
        };
        let [parent, child] = ends;
        Self(format!(
            "{}<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
             <origin xyz=\"{at}\" rpy=\"{rpy}\"/><axis xyz=\"{axis}\"/>{limit}</joint>\n",
            self.0
        ))
    }

    fn wheel(self, name: &str, parent: &str, frame: Frame, shapes: &str) -> Self {
        let joint = format!("{name}_joint");
        self.link(name, 1.0, shapes).joint("continuous", &joint, [parent, name], frame)
    }

    /// A moving link of the arm with a cylinder along z.
    pub fn limb(self, kind: &str, name: &str, parent: &str, frame: Frame) -> Self {
        let cylinder = shape("0 0 0.05", NONE, "<cylinder radius=\"0.03\" length=\"0.08\"/>");
        self.link(name, 1.0, &cylinder).joint(kind, &format!("{name}_joint"), [parent, name], frame)
    }

    /// A frame fixed to a link.
    pub fn frame(self, name: &str, parent: &str, at: &str, rpy: &str) -> Self {
        let joint = format!("{name}_mount");
        Self(format!("{}<link name=\"{name}\"/>\n", self.0)).joint(
            "fixed",
            &joint,
            [parent, name],
            (at, rpy, Z),
        )
    }

    /// Links that turn about z and y in turn, each 8 cm above the one before: `name_0`, `name_1`, ...
    fn torso(mut self, name: &str, count: usize) -> (Self, String) {
        let mut parent = "base_link".to_owned();
        for i in 0..count {
            let child = format!("{name}_{i}");
            let axis = if i % 2 == 0 { Z } else { Y };
            self = self.limb("revolute", &child, &parent, ("0 0 0.08", NONE, axis));
            parent = child;
        }
        (self, parent)
    }

    /// An arm of six joints, `name_1` to `name_6`, without a tool.
    fn arm(mut self, name: &str, parent: &str, at: &str) -> Self {
        let joints =
            [(at, Z), ("0 0 0.1", Y), ("0 0 0.4", Y), ("0 0 0.35", Z), ("0 0 0.1", Y), ("0 0 0.1", Z)];
        let mut parent = parent.to_owned();
        for (i, (at, axis)) in joints.into_iter().enumerate() {
            let child = format!("{name}_{}", i + 1);
            self = self.limb("revolute", &child, &parent, (at, NONE, axis));
            parent = child;
        }
        self
    }

    /// The wheels, an arm of six joints and a tool.
    fn sound() -> Self {
        Self::on_wheels().arm("arm", "base_link", "0.05 0 0.3").frame("tool", "arm_6", "0 0 0.1", NONE)
    }

    pub fn with(self, from: &str, to: &str) -> Self {
        assert!(self.0.contains(from), "{from}");
        Self(self.0.replace(from, to))
    }

    pub fn written(&self) -> (TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("r.urdf");
        std::fs::write(&file, format!("<robot name=\"r\">{}</robot>", self.0)).unwrap();
        (folder, file)
    }

    fn draft(&self, request: &DraftRequest) -> Result<Draft, String> {
        let (_folder, file) = self.written();
        let chain = |error| format!("{:#}", anyhow::Error::from(error));
        Draft::new(&file, "r.urdf", "drafted.toml", request).map_err(chain)
    }

    pub fn drafted(&self, request: &DraftRequest) -> Draft {
        self.draft(request).unwrap_or_else(|error| panic!("{error}"))
    }

    /// The draft is refused with a sentence that has all of these, and about no file that does not exist.
    pub fn refused(&self, request: &DraftRequest, parts: &[&str]) {
        let error = self.draft(request).expect_err("refused");
        for part in parts {
            assert!(error.contains(part), "{part:?} is missing from: {error}");
        }
        assert!(error.contains("r.urdf") && !error.contains("drafted.toml"), "{error}");
    }
}

/// A shape that is drawn and collides.
fn shape(xyz: &str, rpy: &str, geometry: &str) -> String {
    let of = |kind: &str| {
        format!("<{kind}><origin xyz=\"{xyz}\" rpy=\"{rpy}\"/><geometry>{geometry}</geometry></{kind}>")
    };
    of("visual") + &of("collision")
}

pub fn found() -> DraftRequest {
    DraftRequest::default()
}

fn with_tool(name: &str) -> DraftRequest {
    DraftRequest { tool: Some(name.to_owned()), ..found() }
}

fn on(drive: DriveKind) -> DraftRequest {
    DraftRequest { drive: Some(drive), ..found() }
}

fn tool(robot: &Robot) -> &str {
    let grasp = &robot.links[robot.grasp_link];
    let parent = grasp.parent.map(|parent| robot.links[parent].name.as_str());
    if grasp.name.contains("_grasp") { parent.unwrap_or("") } else { &grasp.name }
}

fn held(draft: &Draft) -> Vec<String> {
    let table: toml::Table = draft.text.parse().unwrap_or_else(|error| panic!("{error}: {}", draft.text));
    let hold = table.get("hold").and_then(toml::Value::as_table);
    hold.map_or(Vec::new(), |hold| hold.keys().cloned().collect())
}

#[track_caller]
fn assert_told(draft: &Draft, parts: &[&str]) {
    let all = draft.assumed.join("\n");
    for part in parts {
        assert!(all.contains(part), "{part:?} is missing from: {all}");
    }
}

/// The error and the exit code of `robot init` for a file, with which nothing is written.
fn program_refuses(urdf: &Urdf, flags: &[&str]) -> String {
    let (folder, file) = urdf.written();
    let toml = folder.path().join("out.toml").display().to_string();
    let file = file.display().to_string();
    let output = cocarry(&[&["robot", "init", &file, "-o", &toml], flags].concat());
    assert_eq!(output.status.code(), Some(2), "{}", stdout(&output));
    assert!(!folder.path().join("out.toml").exists());
    stderr(&output)
}

#[test]
fn the_first_joints_of_a_long_arm_are_held() {
    let (torso, top) = Urdf::on_wheels().torso("torso", 5);
    let urdf = torso.arm("arm", &top, "0.05 0 0.2").frame("tool", "arm_6", "0 0 0.1", NONE);
    let first = ["torso_0_joint", "torso_1_joint", "torso_2_joint"];
    for request in [found(), with_tool("tool")] {
        let draft = urdf.drafted(&request);
        assert_eq!((tool(&draft.robot), draft.robot.joint_count()), ("tool", 8));
        assert_eq!(held(&draft), first);
        assert_told(&draft, &["held are `torso_0_joint` at "]);
    }
    let hold = [("torso_3_joint", 10.0), ("torso_4_joint", 0.0)].map(|(name, at)| (name.to_owned(), at));
    let draft = urdf.drafted(&DraftRequest { hold: hold.to_vec(), ..found() });
    assert_eq!(held(&draft), ["torso_0_joint", "torso_3_joint", "torso_4_joint"]);
    assert!(draft.text.contains("\"torso_3_joint\" = { angle_deg = 10"), "{}", draft.text);
    assert_eq!(draft.robot.joint_count(), 8);
    let held = |name: &str, at: f64| DraftRequest { hold: vec![(name.to_owned(), at)], ..found() };
    urdf.refused(&held("torso_9_joint", 0.0), &["unknown independent joint `torso_9_joint`", "did you mean"]);
    urdf.refused(
        &held("torso_0_joint", 400.0),
        &["--hold torso_0_joint = 400", "-166.158 to 166.158 (degrees)"],
    );
    let said = program_refuses(&urdf, &["--hold", "torso_0_joint"]);
    assert!(said.contains("JOINT=VALUE"), "{said}");
    let said = program_refuses(&urdf, &["--tool", "tol"]);
    assert!(said.contains("r.urdf: --tool: unknown link `tol`") && !said.contains("out.toml:"), "{said}");
}

#[test]
fn the_tool_is_an_end_and_no_finger_head_or_caster() {
    let fingers = |urdf: Urdf, hand: &str, names: [&str; 2]| {
        let finger = |urdf: Urdf, name: &str, y: &str| urdf.limb("prismatic", name, hand, (y, NONE, Y));
        finger(finger(urdf, names[0], "0 0.02 0.1"), names[1], "0 -0.02 0.1")
    };
    let arm = || Urdf::on_wheels().arm("arm", "base_link", "0.05 0 0.3");
    // by the names of fingers, and by two short parts side by side
    let named = fingers(arm(), "arm_6", ["left_finger", "right_finger"]);
    let nameless = fingers(arm(), "arm_6", ["p", "q"]);
    for urdf in [named, nameless] {
        let draft = urdf.drafted(&found());
        assert_eq!((tool(&draft.robot), draft.robot.joint_count()), ("arm_6", 6));
    }
    // a part that mimics a joint above it is the arm's, as where it keeps a wrist level
    let level = arm().limb("revolute", "level", "arm_6", ("0 0 0.1", NONE, Y)).with(
        "<joint name=\"level_joint\" type=\"revolute\">",
        "<joint name=\"level_joint\" type=\"revolute\"><mimic joint=\"arm_5_joint\" multiplier=\"-1\"/>",
    );
    let draft = level.drafted(&found());
    assert_eq!((tool(&draft.robot), draft.robot.joint_count()), ("level", 6));
    // of frames at the end, the one named as a tool; a camera is none
    let ends = arm()
        .frame("gripper_camera", "arm_6", "0.05 0 0.1", NONE)
        .frame("flange", "arm_6", "0 0 0.05", NONE)
        .frame("ee_link", "flange", "0 0 0.05", NONE);
    assert_eq!(tool(&ends.drafted(&found()).robot), "ee_link");
    // a lift with an arm of four joints and a head, and casters of three joints
    let mut robot = Urdf::on_wheels().limb("prismatic", "lift", "base_link", ("0 0 0.3", NONE, Z));
    robot = robot.limb("revolute", "pan", "lift", ("0 0 0.5", NONE, Z)).limb(
        "revolute",
        "tilt",
        "pan",
        (NONE, NONE, Y),
    );
    robot = robot.frame("eye_hand", "tilt", "0.05 0 0", NONE);
    for (i, axis) in [(1, Z), (2, Y), (3, Y), (4, Y), (5, Z)] {
        let parent = if i == 1 { "lift".to_owned() } else { format!("a{}", i - 1) };
        let at = if i == 1 { "0.1 0 0.1" } else { "0.2 0 0" };
        robot = robot.limb("revolute", &format!("a{i}"), &parent, (at, NONE, axis));
    }
    for (i, axis) in [(1, "1 0 0"), (2, Y), (3, Z), (4, Y), (5, Z), (6, Y), (7, Z)] {
        let parent = if i == 1 { "base_link".to_owned() } else { format!("caster_{}", i - 1) };
        robot = robot.limb("continuous", &format!("caster_{i}"), &parent, (NONE, NONE, axis));
    }
    let draft = robot.drafted(&found());
    assert_eq!((tool(&draft.robot), draft.robot.joint_count()), ("a5", 6));
}

/// The direction of a tool does not depend on where the arm stands. `tool0` has z ahead, and `flange` x.
#[test]
fn a_tool_frame_at_the_last_joint_points_by_convention() {
    let quarter = "0 -1.5707963267948966 -1.5707963267948966";
    let back = "1.5707963267948966 0 1.5707963267948966";
    for (x, y, z) in
        [(0.0, 0.0, 0.3), (0.013, 0.0171, 0.3093), (0.117, 0.0684, 0.3837), (0.143, -0.0171, 0.4023)]
    {
        let urdf = Urdf::on_wheels()
            .arm("arm", "base_link", &format!("{x} {y} {z}"))
            .frame("flange", "arm_6", NONE, quarter)
            .frame("tool0", "flange", NONE, back);
        // without the shape of the last link, nothing tells the direction
        let (before, after) = urdf.0.split_once("<link name=\"arm_6\">").unwrap();
        let (_, after) = after.split_once("</link>").unwrap();
        let urdf = Urdf(format!("{before}<link name=\"arm_6\"/>{after}"));
        let (name, axis) = if x > 0.14 { ("flange", "x") } else { ("tool0", "z") };
        let draft = urdf.drafted(&with_tool(name));
        assert_told(&draft, &[&format!("points along its {axis} axis"), "by convention"]);
    }
    // what lies beyond the joint decides, here behind it
    let back = Urdf::on_wheels().arm("arm", "base_link", "0 0 0.3").frame(
        "tool0",
        "arm_6",
        "0 0 0.1",
        "0 3.141592653589793 0",
    );
    assert_told(&back.drafted(&found()), &["points along its -z axis, which becomes the grasp's x"]);
}

#[test]
fn of_two_arms_one_is_tucked_and_held() {
    let arms = |urdf: Urdf| {
        let urdf =
            urdf.arm("left", "base_link", "0.05 0.2 0.5").frame("left_tool", "left_6", "0 0 0.1", NONE);
        urdf.arm("right", "base_link", "0.05 -0.2 0.5").frame("right_tool", "right_6", "0 0 0.1", NONE)
    };
    let urdf = arms(Urdf::on_wheels());
    for (request, carries, other) in [(found(), "left", "right"), (with_tool("right_tool"), "right", "left")]
    {
        let draft = urdf.drafted(&request);
        assert_eq!(tool(&draft.robot), format!("{carries}_tool"));
        let joints: Vec<String> = (1..=6).map(|i| format!("{other}_{i}_joint")).collect();
        assert_eq!(held(&draft), joints);
        assert_told(&draft, &["tucked away and held", &format!("--tool {other}_tool carries with it")]);
        // stretched up it reaches 1.6 m; tucked, nothing of it is far from the axis
        let robot = &draft.robot;
        let poses = robot.link_poses(&cocarry::robot::Configuration {
            base: cocarry::geometry::PlanarPose { position: cocarry::geometry::Point::origin(), yaw: 0.0 },
            joints: robot.postures[0].joints,
        });
        for (link, pose) in robot.links.iter().zip(&poses).filter(|(link, _)| link.name.starts_with(other)) {
            let away = pose.translation.vector.xy().norm();
            assert!(away < 0.45, "{} is {away:.2} m from the axis", link.name);
        }
        assert!(draft.robot.postures.iter().all(|posture| robot.is_within_limits(&posture.joints)));
    }
}

/// Small and low arms carry where they can; where none can, the draft says what the arm reaches.
#[test]
fn postures_are_sought_at_every_height_that_the_arm_reaches() {
    let small = |height: &str| {
        let joints = [(height, Z), ("0 0 0.04", Y), ("0.12 0 0", Y), ("0.12 0 0", Y)];
        let mut urdf =
            Urdf::on_wheels().with("0.45 0.4 0.2", "0.2 0.2 0.05").with("radius=\"0.1\"", "radius=\"0.04\"");
        for (i, (at, axis)) in joints.into_iter().enumerate() {
            let parent = if i == 0 { "base_link".to_owned() } else { format!("a{}", i - 1) };
            urdf = urdf.limb("revolute", &format!("a{i}"), &parent, (at, NONE, axis));
        }
        urdf.frame("gripper", "a3", "0.12 0 0", NONE)
    };
    let draft = small("0.05 0 0.1").drafted(&found());
    let height = draft.robot.grasp_height;
    assert!((0.15..0.45).contains(&height), "{height}");
    let far = DraftRequest { grasp_height: Some(1.5), ..found() };
    small("0.05 0 0.1")
        .refused(&far, &["no posture found", "1.5 m", "its arm reaches 0.00 to 0.", "--grasp-height"]);
}

#[test]
fn an_arm_without_a_base_needs_one_that_is_described() {
    let bare =
        || Urdf::root("base_link").arm("arm", "base_link", "0 0 0.2").frame("tool", "arm_6", "0 0 0.1", NONE);
    bare().refused(
        &on(DriveKind::Omnidirectional),
        &["no base that drives", "--base-size LENGTH,WIDTH,HEIGHT"],
    );
    bare().refused(&found(), &["no pair of driven wheels"]);
    let request = DraftRequest { base_size: Some([0.8, 0.6, 0.4]), base_mass: Some(75.0), ..found() };
    let draft = bare().drafted(&request);
    assert_told(&draft, &["a box 0.8 m long, 0.6 m wide and 0.4 m high, of 75 kg"]);
    let robot = &draft.robot;
    let described = robot.links.iter().find(|link| link.name == "base_link_base").expect("the base");
    assert_eq!(described.inertial.map(|inertial| inertial.mass), Some(75.0));
    assert!(described.visuals.len() == 1 && described.collisions.len() == 1);
    assert!((robot.drive_from_base().translation.z - 0.4).abs() < 1e-12);
    assert!(robot.base_extent().is_some_and(|extent| (extent - 0.5).abs() < 0.01));
    // a base of wheels is not described again
    let twice = DraftRequest { base_size: Some([0.8, 0.6, 0.4]), ..found() };
    Urdf::sound().refused(&twice, &["--base-size", "`left_wheel_joint`"]);
    // a platform without wheels that turn, as its name says
    let platform = bare().with("base_link", "mobile_base_link");
    assert_told(&platform.drafted(&on(DriveKind::Omnidirectional)), &["said by `mobile_base_link`"]);
    for (flags, part) in [
        (["--base-size", "0.8,0.6"], "LENGTH,WIDTH,HEIGHT"),
        (["--base-size", "0.8,0.6,-1"], "greater than 0"),
    ] {
        let said = program_refuses(&bare(), &flags);
        assert!(said.contains(part), "{said}");
    }
}

/// The described base stands under the arm in an episode with bodies.
#[test]
fn a_described_base_carries() {
    let bare = Urdf::root("plate").arm("arm", "plate", "0 0 0.2").frame("tool", "arm_6", "0 0 0.1", NONE);
    let (folder, file) = bare.written();
    let toml = folder.path().join("out.toml").display().to_string();
    let file = file.display().to_string();
    let flags = ["--base-size", "0.5,0.45,0.3", "--base-mass", "60"];
    let output = cocarry(&[&["robot", "init", &file, "-o", &toml][..], &flags].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let run = cocarry(&["run", "environment-1", "--robot", &toml, "--seed", "1"]);
    assert_eq!(run.status.code(), Some(0), "{}{}", stdout(&run), stderr(&run));
}

/// What stands to the side out of the balls that eq. (7) keeps off obstacles has room within the width, and 5
/// cm more to each side.
#[test]
fn a_base_is_as_wide_as_an_elbow_that_stands_out() {
    let draft = Urdf::sound().drafted(&found());
    assert_told(&draft, &["the base is 0.44 m wide: its collision shapes seen from above"]);
    let link = "<link name=\"arm_3\">";
    let bar = "<collision><geometry><box size=\"0.06 1 0.06\"/></geometry></collision>";
    let draft = Urdf::sound().with(link, &format!("{link}{bar}")).drafted(&found());
    assert_told(&draft, &["the base is 0.61 m wide, and 1.10 m with its arm: a disc about the axle"]);
    assert_eq!(draft.robot.width(), 1.1);
}

#[test]
fn robots_on_legs_are_refused_by_their_names() {
    let leg = |urdf: Urdf, name: &str, at: &str| {
        let urdf = urdf.limb("revolute", &format!("{name}_hip"), "base_link", (at, NONE, "1 0 0"));
        let urdf = urdf.limb("revolute", &format!("{name}_thigh"), &format!("{name}_hip"), (NONE, NONE, Y));
        urdf.limb("revolute", &format!("{name}_calf"), &format!("{name}_thigh"), ("0 0 -0.3", NONE, Y))
    };
    let arm =
        || Urdf::root("base_link").arm("arm", "base_link", "0 0 0.2").frame("tool", "arm_6", "0 0 0.1", NONE);
    let mut dog = arm();
    for (name, at) in [("FL", "0.2 0.1 0"), ("FR", "0.2 -0.1 0"), ("RL", "-0.2 0.1 0"), ("RR", "-0.2 -0.1 0")]
    {
        dog = leg(dog, name, at);
    }
    let described = DraftRequest { base_size: Some([0.8, 0.6, 0.4]), ..found() };
    for request in [found(), on(DriveKind::Omnidirectional), described] {
        dog.refused(&request, &["a legged robot", "`FL_hip_joint`", "`RR_hip_joint`"]);
    }
    // a knee of one leg is a wheeled robot's
    let one = leg(Urdf::sound(), "middle", "-0.1 0 0");
    assert!(one.draft(&found()).is_ok());
}

#[test]
fn a_base_is_followed_to_the_link_that_carries_the_arm() {
    let leaf = |urdf: Urdf| urdf.with("base_link", "body").frame("base_link", "body", NONE, NONE);
    let draft = leaf(Urdf::sound()).drafted(&on(DriveKind::Omnidirectional));
    assert_eq!(draft.robot.links[draft.robot.base_link].name, "body");
    let base = |name: &str| DraftRequest { base: Some(name.to_owned()), ..on(DriveKind::Omnidirectional) };
    let draft = leaf(Urdf::sound()).drafted(&base("body"));
    assert_eq!(draft.robot.links[draft.robot.base_link].name, "body");
    leaf(Urdf::sound()).refused(&base("bodi"), &["--base: unknown link `bodi`", "did you mean `body`?"]);
    leaf(Urdf::sound()).refused(&base("base_link"), &["no arm descends from `base_link`", "--base"]);
    // wheels on a part below the arm's: the joints between are held
    let knee = Urdf::on_wheels()
        .with("base_link", "foot_plate")
        .link("trunk", 5.0, "")
        .joint("revolute", "knee", ["trunk", "foot_plate"], ("0 0 -0.3", NONE, Y))
        .arm("arm", "trunk", "0.05 0 0.2")
        .frame("tool", "arm_6", "0 0 0.1", NONE);
    let draft = knee.drafted(&found());
    assert_eq!(draft.robot.links[draft.robot.base_link].name, "trunk");
    assert_eq!(held(&draft), ["knee"]);
}

/// The wheels of [`Urdf::sound`] with one thing changed.
fn wheels(from: &str, to: &str) -> Urdf {
    Urdf::sound().with(from, to)
}

#[test]
fn wheels_as_published_are_measured() {
    let left = "<link name=\"left_wheel\">";
    let of_left = |change: &dyn Fn(&str) -> String| {
        let urdf = Urdf::sound().0;
        let (before, after) = urdf.split_once(left).unwrap();
        let (wheel, after) = after.split_once("</link>").unwrap();
        Urdf(format!("{before}{left}{}</link>{after}", change(wheel)))
    };
    let said = |draft: &Draft| draft.robot.warnings.iter().map(|w| format!("{w}\n")).collect::<String>();
    // calibrated radii
    let draft = of_left(&|wheel| wheel.replace("0.1\"", "0.1005\"")).drafted(&found());
    assert!((draft.robot.drive.wheel_radius - 0.10025).abs() < 1e-12);
    assert!(said(&draft).contains("0.1000 to 0.1005 m"), "{}", said(&draft));
    of_left(&|wheel| wheel.replace("0.1\"", "0.11\"")).refused(&found(), &["radius (m)", "must be the same"]);
    // cylinders drawn upright
    let draft = wheels(ACROSS, NONE).drafted(&found());
    assert_eq!(draft.robot.drive.wheel_radius, 0.1);
    assert!(said(&draft).contains("drawn 90 deg off"), "{}", said(&draft));
    wheels(ACROSS, "0.8 0 0").refused(&found(), &["deg off the joint's axis", "wheel_radius_m"]);
    let radius = DraftRequest { wheel_radius: Some(0.1), ..found() };
    assert_eq!(wheels(ACROSS, "0.8 0 0").drafted(&radius).robot.drive.wheel_radius, 0.1);
    // without a shape
    let bare = wheels(&shape(NONE, ACROSS, WHEEL), "");
    bare.refused(&found(), &["the radius of `left_wheel_joint` cannot be measured", "--wheel-radius"]);
    let draft = bare.drafted(&DraftRequest { wheel_radius: Some(0.09), ..found() });
    assert_eq!(draft.robot.drive.wheel_radius, 0.09);
    let on_floor = Urdf("<link name=\"base_footprint\"/>\n".to_owned() + &bare.0).joint(
        "fixed",
        "stand",
        ["base_footprint", "base_link"],
        ("0 0 0.08", NONE, Z),
    );
    assert_eq!(on_floor.drafted(&found()).robot.drive.wheel_radius, 0.08);
    // revolute by a turn, and fixed
    let joint = |kind: &str| format!("<joint name=\"left_wheel_joint\" type=\"{kind}\">");
    let turning = wheels(&joint("continuous"), &joint("revolute")).with(
        "<limit velocity=\"15\" effort=\"300\"/>",
        "<limit lower=\"-180\" upper=\"180\" velocity=\"15\" effort=\"300\"/>",
    );
    assert!(said(&turning.drafted(&found())).contains("taken as continuous"));
    for kind in ["fixed", "revolute"] {
        wheels(&joint("continuous"), &joint(kind))
            .refused(&found(), &["`left_wheel_joint`", "do not turn freely", "type=\"continuous\""]);
    }
    // without a rate, the speed is assumed
    let draft = wheels("<limit velocity=\"15\" effort=\"300\"/>", "").drafted(&found());
    assert!((draft.robot.drive.rim_speed_limit - 1.0).abs() < 1e-9, "{}", draft.robot.drive.rim_speed_limit);
}

#[test]
fn the_drive_follows_from_wheels_of_several_kinds() {
    let pair = |urdf: Urdf, name: &str, [x, z]: [&str; 2], size: &str| {
        let shapes = shape(NONE, ACROSS, &format!("<cylinder radius=\"{size}\" length=\"0.02\"/>"));
        let one = |urdf: Urdf, side: &str, y: &str| {
            let at = format!("{x} {y} {z}");
            urdf.wheel(&format!("{name}_{side}"), "base_link", (&at, NONE, Y), &shapes)
        };
        one(one(urdf, "left", "0.15"), "right", "-0.15")
    };
    // small wheels roll freely
    let six = pair(pair(Urdf::sound(), "front", ["0.2", "-0.06"], "0.04"), "back", ["-0.2", "-0.06"], "0.04");
    let draft = six.drafted(&found());
    assert_eq!(draft.robot.drive.kind, DriveKind::Differential);
    assert_told(&draft, &["`left_wheel_joint` and `right_wheel_joint`; the others roll freely"]);
    let equal = pair(pair(Urdf::sound(), "front", ["0.2", "0"], "0.1"), "back", ["-0.2", "0"], "0.1");
    equal.refused(&found(), &["6 wheels could be driven", "--drive skid-steer"]);
    // wheels that are all steered, on modules of their own
    let steer = |urdf: Urdf, n: usize, at: &str| {
        let module = format!("module_{n}");
        let urdf = urdf.limb("revolute", &module, "base_link", (at, NONE, Z));
        urdf.wheel(&format!("wheel_{n}"), &module, (NONE, NONE, Y), &shape(NONE, ACROSS, WHEEL))
    };
    let bare = || {
        Urdf::root("base_link").arm("arm", "base_link", "0.05 0 0.3").frame("tool", "arm_6", "0 0 0.1", NONE)
    };
    let swerve = steer(steer(steer(bare(), 1, "0.2 0.15 0.1"), 2, "0.2 -0.15 0.1"), 3, "-0.2 0 0.1");
    let draft = swerve.drafted(&found());
    assert_eq!(draft.robot.drive.kind, DriveKind::Omnidirectional);
    assert_told(&draft, &["all its wheels are steered, by `module_1_joint`"]);
    // a car
    let car = steer(steer(Urdf::sound(), 1, "0.3 0.15 0"), 2, "0.3 -0.15 0");
    car.refused(&found(), &["steers like a car", "`module_1_joint`"]);
    // three omnidirectional wheels
    let omni = |urdf: Urdf, n: usize, at: &str, axis: &str| {
        urdf.wheel(
            &format!("wheel_{n}"),
            "base_link",
            (at, NONE, axis),
            &shape(NONE, NONE, "<sphere radius=\"0.05\"/>"),
        )
    };
    let three = omni(bare(), 1, "0.2 0 0.05", "1 0 0");
    let three =
        omni(omni(three, 2, "-0.1 0.17 0.05", "-0.5 0.8660254 0"), 3, "-0.1 -0.17 0.05", "-0.5 -0.8660254 0");
    let draft = three.drafted(&found());
    assert_eq!((draft.robot.drive.kind, draft.robot.wheels.len()), (DriveKind::Omnidirectional, 3));
    // two wheels on a turntable under the base
    let table = Urdf::on_wheels()
        .with("base_link", "table")
        .link("base_link", 5.0, &shape("0 0 0.1", NONE, BOX))
        .joint("continuous", "table_joint", ["base_link", "table"], (NONE, NONE, Z))
        .arm("arm", "base_link", "0.05 0 0.3")
        .frame("tool", "arm_6", "0 0 0.1", NONE);
    let draft = table.drafted(&found());
    assert_eq!(draft.robot.drive.kind, DriveKind::Omnidirectional);
    assert_told(&draft, &["its two wheels turn under it about `table_joint`"]);
    assert_eq!(draft.robot.links[draft.robot.base_link].name, "base_link");
    // slides that stand for a base
    let slides =
        Urdf("<link name=\"world\"/>\n<link name=\"x\"/>\n<link name=\"y\"/>\n".to_owned() + &bare().0)
            .joint("prismatic", "to_x", ["world", "x"], (NONE, NONE, "1 0 0"))
            .joint("prismatic", "to_y", ["x", "y"], (NONE, NONE, Y))
            .joint("continuous", "to_yaw", ["y", "base_link"], (NONE, NONE, Z))
            .with("lower=\"0\" upper=\"0.4\"", "lower=\"-9\" upper=\"9\"");
    let draft = slides.drafted(&found());
    assert_eq!(draft.robot.drive.kind, DriveKind::Omnidirectional);
    assert_eq!((tool(&draft.robot), draft.robot.joint_count()), ("tool", 6));
    assert_eq!(draft.robot.links[draft.robot.base_link].name, "base_link");
}
