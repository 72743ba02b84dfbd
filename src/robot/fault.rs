//! Faults of a robot's tree, arm, wheels or postures, with names and numbers.

use thiserror::Error;

/// The reason why links do not form one tree.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum TreeFault {
    /// Two joints have the same child link.
    #[error("is the child of two joints, `{first}` and `{second}`; a URDF is a tree")]
    TwoParents {
        /// One joint.
        first: String,
        /// The other.
        second: String,
    },
    /// Two links have no parent.
    #[error("has no parent, like `{other}`; a URDF has one root")]
    TwoRoots {
        /// The other root.
        other: String,
    },
    /// A cycle of links.
    #[error("is its own ancestor; a URDF is a tree")]
    Circle,
}

/// The reason why no arm leads from the base to the grasp.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ArmFault {
    /// The grasp is the base.
    #[error("is the base link itself; name the link at the end of the arm")]
    GraspIsBase,
    /// The grasp does not descend from the base.
    #[error("does not descend from `{base}`: its root is `{root}`")]
    Elsewhere {
        /// The base link.
        base: String,
        /// The root above the grasp.
        root: String,
    },
    /// No joint of the arm moves.
    #[error("no joint between it and `{base}` moves independently")]
    NothingMoves {
        /// The base link.
        base: String,
    },
    /// Too many joints move independently.
    #[error(
        "{count} joints move independently between it and `{base}`, more than {most}; fix some of them under [hold]: {joints}"
    )]
    TooManyJoints {
        /// The base link.
        base: String,
        /// Their number.
        count: usize,
        /// The most there may be.
        most: usize,
        /// Their names.
        joints: String,
    },
    /// Too many joints move, mimicking joints included.
    #[error("{count} joints move between it and `{base}`, mimicking joints included, more than {most}")]
    TooManyMoving {
        /// The base link.
        base: String,
        /// Their number.
        count: usize,
        /// The most there may be.
        most: usize,
    },
    /// A kind of joint that an arm cannot have.
    #[error(
        "is {kind}; between the base and the grasp a joint must be revolute, continuous, prismatic or fixed"
    )]
    Kind {
        /// The joint's kind.
        kind: &'static str,
    },
}

/// The reason why a posture could not be closed.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PostureFault {
    /// No solution near the given angles.
    #[error("no angles near the given ones achieve that")]
    NoSolution,
    /// An arm that cannot place its grasp in any pose cannot hold it level either, not even nearly.
    #[error(
        "the arm moves its grasp in {free} of 6 directions, and does not come within {height} m and {turn} rad of that; \
         give closer angles or another grasp_height_m"
    )]
    NotFree {
        /// Degrees of freedom of the arm.
        free: usize,
        /// Tolerance of the height, m.
        height: f64,
        /// Tolerance of the orientation, rad.
        turn: f64,
    },
    /// The solution is too far from the given angles.
    #[error("`{joint}` would have to move by {by:.4}, more than {most} (rad or m); give closer angles")]
    Far {
        /// The first such joint.
        joint: String,
        /// Distance to the solution, rad or m.
        by: f64,
        /// Largest distance allowed, rad or m.
        most: f64,
    },
    /// The solution is beyond a joint limit.
    #[error(
        "`{joint}` would have to be at {position:.6}, beyond its limits from {lower} to {upper} (rad or m)"
    )]
    Limit {
        /// The joint.
        joint: String,
        /// Its position, rad or m.
        position: f64,
        /// Least position, rad or m.
        lower: f64,
        /// Largest position, rad or m.
        upper: f64,
    },
}

/// The reason why a base cannot move as its robot file says.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum DriveFault {
    /// Mecanum or omnidirectional wheels on a base with another drive.
    #[error(
        "this base has mecanum or omnidirectional wheels: {wheels}; it is not a {drive} one; write drive = \"omnidirectional\""
    )]
    Mecanum {
        /// Their joints.
        wheels: String,
        /// The drive that the robot file gives.
        drive: &'static str,
    },
    /// More wheels than the two that are named, and no word on the drive.
    #[error(
        "this base has other wheels that may be driven: {wheels}; say which drive it has: drive = \"skid-steer\", \"omnidirectional\" (mecanum), or \"differential\" if they roll freely"
    )]
    OtherWheels {
        /// Their joints.
        wheels: String,
    },
}

/// The reason why `base_footprint` is no outline of a base.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum FootprintFault {
    /// Neither the word nor a list.
    #[error(
        "base_footprint = {found}; it must be \"collision\", or a list of corners [[x, y], ...] in metres"
    )]
    Kind {
        /// What there is.
        found: String,
    },
    /// An entry of the list that is no corner.
    #[error("base_footprint[{corner}] = {found}; it must be a corner [x, y] in metres")]
    Corner {
        /// Its place in the list, from 0.
        corner: usize,
        /// What there is.
        found: String,
    },
    /// Too few or too many corners.
    #[error("base_footprint has {count} corners; it must have {fewest} to {most}")]
    Count {
        /// Their number.
        count: usize,
        /// The fewest there may be.
        fewest: usize,
        /// The most there may be.
        most: usize,
    },
    /// All corners are on a line, or nearly.
    #[error(
        "base_footprint is {narrowest:.4} m across where it is narrowest; its corners must be around an area at least {least} m across"
    )]
    Flat {
        /// Its least extent, m.
        narrowest: f64,
        /// The least that it may be, m.
        least: f64,
    },
    /// The middle of the drive is outside.
    #[error(
        "base_footprint, from x = {:.3} to {:.3} and y = {:.3} to {:.3} m, does not have the middle of the drive (0, 0) inside; its corners must be around it, x ahead and y to the left",
        x[0], x[1], y[0], y[1]
    )]
    Beside {
        /// Least and largest x, m.
        x: [f64; 2],
        /// Least and largest y, m.
        y: [f64; 2],
    },
    /// The base has nothing to be around.
    #[error(
        "base_footprint = \"collision\", but `{base}` has no collision shape; give corners [[x, y], ...] in metres"
    )]
    NoShapes {
        /// The base link.
        base: String,
    },
}

/// The reason why a joint is not a wheel.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum WheelFault {
    /// The joint is of another kind.
    #[error("its joint is {kind}; it must be continuous")]
    Kind {
        /// The joint's kind.
        kind: &'static str,
    },
    /// The joint mimics another one.
    #[error("it mimics `{joint}`; each wheel must turn independently")]
    Mimics {
        /// The other joint.
        joint: String,
    },
    /// The arm descends from it.
    #[error("the grasp, `{grasp}`, descends from it")]
    CarriesArm {
        /// The link at the grasp.
        grasp: String,
    },
    /// It does not descend from the base.
    #[error("it does not descend from `{base}`; its root is `{root}`")]
    Elsewhere {
        /// The base link.
        base: String,
        /// The root above it.
        root: String,
    },
    /// A moving joint lies between it and the base.
    #[error(
        "it is connected to `{base}` through `{joint}`, which is {kind}; it must be fixed, or held under [hold]"
    )]
    Loose {
        /// The base link.
        base: String,
        /// The joint between.
        joint: String,
        /// That joint's kind.
        kind: &'static str,
    },
    /// A wheel of an omnidirectional base whose axis is not level.
    #[error("its axis is ({x:.4}, {y:.4}, {z:.4}) in the base; it must be level")]
    NotLevel {
        /// x.
        x: f64,
        /// y.
        y: f64,
        /// z.
        z: f64,
    },
    /// Its axis has another direction.
    #[error("its axis is ({x:.4}, {y:.4}, {z:.4}) in the base; it must be along the base's y")]
    Axis {
        /// x.
        x: f64,
        /// y.
        y: f64,
        /// z.
        z: f64,
    },
    /// It has no shape to measure.
    #[error("it has no cylinder or sphere to measure; give wheel_radius_m in the robot file")]
    NoRadius,
    /// Its shape is not centred on the joint's axis.
    #[error("its {shape} is {by_m:.4} m or {by_deg:.2} deg off the joint's axis; it must be centred on it")]
    Eccentric {
        /// Cylinder or sphere.
        shape: &'static str,
        /// Distance of the shape's centre from the axis, m.
        by_m: f64,
        /// Angle between the two axes, degrees.
        by_deg: f64,
    },
    /// The measured radius and the given one differ.
    #[error(
        "its radius is {measured} m in the URDF, but wheel_radius_m = {given}; they must agree within 10 %"
    )]
    Radius {
        /// As measured, m.
        measured: f64,
        /// As given, m.
        given: f64,
    },
    /// The measured track and the given one differ.
    #[error(
        "the wheels are {measured:.4} m apart in the URDF, but wheel_separation_m = {given}; they must agree within 10 %"
    )]
    Track {
        /// As measured, m.
        measured: f64,
        /// As given, m.
        given: f64,
    },
    /// It has no valid rate limit.
    #[error(
        "limit velocity = {rate}; it must be greater than 0 and finite; give wheel_rate_limit_rad_s in the robot file"
    )]
    Rate {
        /// The limit found, rad/s.
        rate: f64,
    },
    /// It is on the wrong side.
    #[error("it is at y = {y:.4} m in the base; it must be on the {side}, where y is {sign}")]
    Side {
        /// y of its centre, m.
        y: f64,
        /// left or right.
        side: &'static str,
        /// positive or negative.
        sign: &'static str,
    },
    /// The two wheels are not mirror images.
    #[error("its {what} is {right} but that of `{left_joint}` is {left}; {rule}")]
    Unlike {
        /// The quantity that differs.
        what: &'static str,
        /// The other wheel.
        left_joint: String,
        /// Its value, SI.
        left: f64,
        /// This wheel's value, SI.
        right: f64,
        /// The rule that must hold.
        rule: &'static str,
    },
}
