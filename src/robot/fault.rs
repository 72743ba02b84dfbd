//! In what way the tree, the arm, a wheel or a posture of a robot is not what it must be, with names and numbers.

use thiserror::Error;

/// In what way links do not form one tree.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum TreeFault {
    /// Two joints carry one link.
    #[error("is the child of two joints, `{first}` and `{second}`; a URDF is a tree")]
    TwoParents {
        /// One joint.
        first: String,
        /// The other.
        second: String,
    },
    /// Two links hang on nothing.
    #[error("hangs on nothing, and neither does `{other}`; a URDF has one root")]
    TwoRoots {
        /// The other root.
        other: String,
    },
    /// Links carry each other.
    #[error("carries itself: its parents lead back to it; a URDF is a tree")]
    Circle,
}

/// In what way there is no arm from the base to the grasp.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ArmFault {
    /// The grasp is the base.
    #[error("is the base link itself; name the link at the end of the arm")]
    GraspIsBase,
    /// The grasp hangs elsewhere.
    #[error("does not hang on `{base}`: its root is `{root}`")]
    Elsewhere {
        /// The base link.
        base: String,
        /// The last of the grasp's parents.
        root: String,
    },
    /// No joint moves.
    #[error("no joint between it and `{base}` moves on its own")]
    NothingMoves {
        /// The base link.
        base: String,
    },
    /// Too many joints.
    #[error(
        "{count} joints move on their own between it and `{base}`, more than {most}; hold some of them still under [hold]: {joints}"
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
    /// Too many joints, those that mimic included.
    #[error("{count} joints move between it and `{base}`, those that mimic included, more than {most}")]
    TooManyMoving {
        /// The base link.
        base: String,
        /// Their number.
        count: usize,
        /// The most there may be.
        most: usize,
    },
    /// A joint of a kind that an arm cannot have.
    #[error(
        "is {kind}; between the base and the grasp a joint must be revolute, continuous, prismatic or fixed"
    )]
    Kind {
        /// The joint's kind.
        kind: &'static str,
    },
}

/// Why a posture could not be brought to hold the object as it must.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PostureFault {
    /// No angles near those given do it.
    #[error("no angles near those given do that")]
    NoSolution,
    /// The angles needed are not those given.
    #[error(
        "`{joint}` would have to move by {by:.4}, more than {most} (rad or m); give angles that are nearer"
    )]
    Far {
        /// The first such joint.
        joint: String,
        /// How far, rad or m.
        by: f64,
        /// The most allowed, rad or m.
        most: f64,
    },
    /// The angles needed are beyond a limit.
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

/// In what way a joint is not a wheel.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum WheelFault {
    /// Another kind of joint.
    #[error("its joint is {kind}; it must be continuous")]
    Kind {
        /// The joint's kind.
        kind: &'static str,
    },
    /// It follows another joint.
    #[error("it mimics `{joint}`; each wheel must turn on its own")]
    Mimics {
        /// The other joint.
        joint: String,
    },
    /// The arm hangs on it.
    #[error("the grasp, `{grasp}`, hangs on it")]
    CarriesArm {
        /// The link at the grasp.
        grasp: String,
    },
    /// It hangs elsewhere.
    #[error("it does not hang on `{base}`; its root is `{root}`")]
    Elsewhere {
        /// The base link.
        base: String,
        /// The last of its parents.
        root: String,
    },
    /// It hangs on something that moves.
    #[error("it hangs on `{base}` through `{joint}`, which is {kind}; it must be fixed")]
    Loose {
        /// The base link.
        base: String,
        /// The joint between.
        joint: String,
        /// That joint's kind.
        kind: &'static str,
    },
    /// It turns about another axis.
    #[error("its axis is ({x:.4}, {y:.4}, {z:.4}) in the base; it must be along the base's y")]
    Axis {
        /// x.
        x: f64,
        /// y.
        y: f64,
        /// z.
        z: f64,
    },
    /// No shape to measure.
    #[error("it has no cylinder or sphere to measure; give wheel_radius_m in the robot file")]
    NoRadius,
    /// The shape does not turn about its middle.
    #[error("its {shape} is {by_m:.4} m or {by_deg:.2} deg off the joint's axis; it must turn about its own")]
    Eccentric {
        /// Cylinder or sphere.
        shape: &'static str,
        /// Distance of the shape's middle from the axis, m.
        by_m: f64,
        /// Angle between the two axes, degrees.
        by_deg: f64,
    },
    /// The two radii given differ.
    #[error(
        "its radius is {measured} m in the URDF, but wheel_radius_m = {given}; they must agree within 1 mm"
    )]
    Radius {
        /// As measured, m.
        measured: f64,
        /// As given, m.
        given: f64,
    },
    /// No rate limit.
    #[error("limit velocity = {rate}; it must be greater than 0 and finite")]
    Rate {
        /// The limit found, rad/s.
        rate: f64,
    },
    /// It is on the other side.
    #[error("it is at y = {y:.4} m in the base; it must be on the {side}, where y is {sign}")]
    Side {
        /// Its middle, m.
        y: f64,
        /// left or right.
        side: &'static str,
        /// positive or negative.
        sign: &'static str,
    },
    /// The two wheels do not mirror each other.
    #[error("its {what} is {right} but that of `{left_joint}` is {left}; {rule}")]
    Unlike {
        /// What differs.
        what: &'static str,
        /// The other wheel.
        left_joint: String,
        /// Its value, SI.
        left: f64,
        /// This wheel's value, SI.
        right: f64,
        /// What must hold.
        rule: &'static str,
    },
}
