//! A simulator of a human and a mobile manipulator that carry an object together through openings between
//! obstacles but prefer different paths.
//!
//! `cocarry` implements the framework of A. J. Mahmud, W. Li and X. Wang, *Mutual Adaptation in Human-Robot
//! Co-Transportation with Human Preference Uncertainty*, and reproduces its tables. Equation numbers in this
//! documentation are that paper's. The command-line program of the same name gives access to all of it; see
//! its `--help`. The book, in `book/src`, explains the model with its symbols, the files, and
//! the results.
//!
//! # Bring your own partner
//!
//! Your own [`policy::RobotPolicy`], [`human::Human`], [`controller::Controller`] or [`plant::Plant`] needs no
//! change of this crate: see `examples/`.
//!
//! # Floors
//!
//! Data flows upward: a module uses only floors below its own.
//!
//! ```text
//! quantities     every figure of a planning step and an episode: key, unit, getter; events as sentences
//! scenario       the complete definition of an episode, as text; snapshots; episodes from both
//! episode        THE LOOP: observe, evaluate, predict, ask the human, ask the policy, execute, control, move
//! controller     the robot's controllers: eqs. (8) and (7) by what is seen, who leads, and P_o
//! team           how a team walks: its path, turns onto another path, the motion that the leader intends
//! plant          the bodies that a command and a human's motion move: point, kinematic, physical
//! policy         robot policies: who leads, on which option, with which motion
//! human          human models: which option, whether to take over, where the hand goes
//! arithmetic     the conformance stamp: a digest of fixed results
//! simulation     exact kinematics, or bodies with dynamics and contacts
//! control        MPC, pose optimisation, the human's intent
//! learning       alpha, gamma and eta of one human, from what the human does
//! coordination   stubbornness phi(k), the two modes, eq. (6)
//! preference     perception of risk and distance, P_o, expected subjective cost
//! options        openings in order, D_o and S_o from anywhere, shortest paths
//! world          a TOML file -> obstacles, openings, start, target
//! robot          a TOML file and a URDF -> drive, arm, grasp; forward kinematics and B(q)
//! geometry       points, poses, outlines, paths
//! math, suggestion, known_names; above them error, then located and saved
//!                transcendental functions with the same bits everywhere; "did you mean"; refusals of input; files
//!                read; saved states
//! ```
//!
//! This crate has no C code, no clock and no randomness from the operating system, and is for WebAssembly too
//! (`crates/web/build` makes a module of it). Other packages build on it: output files and drawings
//! (`crates/output`), recordings (`crates/recording`), studies (`crates/studies`) and the program
//! (`crates/program`).
//!
//! # Notation
//!
//! | paper | here | unit |
//! | --- | --- | --- |
//! | A, B | [`world::World::start`], [`world::World::target`] | m |
//! | d_r | [`world::World::robot_width`] | m |
//! | xi, w_xi, S_xi | [`world::Opening`], its `width`, its `risk` | -, m, - |
//! | o, D_o, S_o | [`options::PathOption`], [`options::Remaining::length`], [`options::Remaining::risk`] | -, m, - |
//! | c_r | `risk_weight` | m |
//! | J_o, eq. (1) | [`preference::objective_cost`] | m |
//! | alpha, gamma | [`preference::Perception`] | - |
//! | D^_o, S^_o | [`preference::perceived_distance`], [`preference::perceived_risk`] | m^alpha, - |
//! | J^_o, eq. (2) | [`preference::subjective_cost`] | - |
//! | o_h, eq. (3) | [`preference::human_choice`] | - |
//! | P_o, eq. (4) | [`preference::ChoiceDistribution`] | - |
//! | R_o (Sec. IV-A) | [`preference::Regions`] | - |
//! | J~_o, eq. (6) | [`preference::Predictor::expected_costs`] | - |
//! | phi(k), g(k), eta, eq. (5) | [`coordination::Stubbornness`], [`coordination::StubbornnessSettings`] | - |
//! | omega_o(k) | [`coordination::is_misaligned`] | - |
//! | o*(k), eq. (6) | [`coordination::robot_choice`] | - |
//! | q, q_c | [`robot::Configuration`] | m, rad |
//! | x, s | [`robot::Kinematics::grasp`], [`episode::RobotTick::grasp_goal`]; in eq. (7) relative to the grasp: [`control::Reference`] | m, rad |
//! | u, B(q), eq. (7) | [`robot::InputVector`], the period times [`robot::Kinematics::jacobian`] | m/s and rad/s, s |
//! | H, Q, R, kappa | [`control::HORIZON`], [`control::ControlSettings`] | - |
//! | G_o, eq. (7) | [`control::Plan::cost`] | - |
//! | Q (candidates), q*, eq. (8) | [`control::Neighbourhood::candidates`], [`control::PoseOptimiser`] | - |
//! | C (Sec. V-C) | [`episode::ControlSummary::cost`] | - |
//! | k | [`episode::Tick::step`], one planning step, by default 0.2 s | - |
//!
//! ```
//! use cocarry::episode::{Outcome, EpisodeSettings, run};
//! use cocarry::options::OptionSet;
//! use cocarry::preference::Perception;
//! use cocarry::world::World;
//!
//! let world = World::load("worlds/environment-4.toml".as_ref())?;
//! let settings = EpisodeSettings::default();
//! let options = OptionSet::new(&world, settings.predictor.risk_weight())?;
//! let human = Perception { alpha: 0.747, gamma: 0.765 };
//! let summary = run(&options, &settings, human, |tick| {
//!     assert!(tick.stubbornness > 0.0);
//! });
//! assert_eq!(summary.outcome, Outcome::Arrived);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod arithmetic;
pub mod bounds;
mod cbor;
pub mod control;
pub mod controller;
pub mod coordination;
pub mod episode;
pub mod error;
pub mod geometry;
pub mod guarded;
pub mod human;
mod known_names;
pub mod learning;
pub mod located;
pub mod math;
pub mod options;
pub mod plant;
pub mod policy;
pub mod preference;
pub mod quantities;
pub mod robot;
pub mod saved;
pub mod scenario;
pub mod simulation;
pub mod suggestion;
pub mod team;
pub mod world;
pub mod xml_extent;

pub use error::{Error, ErrorKind};
