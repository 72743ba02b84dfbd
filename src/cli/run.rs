//! `cocarry run`: a world and a human in; one episode, told, tabulated, drawn or logged tick by tick, out.

use super::model::{ModelArguments, initial_stubbornness, load_world, perception, positive, world_text};
use super::output::{Failure, Progress, input, print, print_json, table, table_text, write_file};
use super::record::RecordArguments;
use super::robot::{Chosen, RobotArguments};
use super::tick_log;
use crate::control::RobotObstacles;
use crate::coordination::{self, Method};
use crate::drawing::{self, Track};
use crate::episode::{ControlSummary, Episode, Manipulator, Outcome, Settings, Summary, Tick};
use crate::experiments::paper::EXAMPLE_HUMAN;
use crate::geometry::Point;
use crate::options::OptionSet;
use crate::preference::{Belief, Perception};
use crate::recording::{self, Attachment, Provenance, Stage};
use crate::world::World;
use anyhow::Context;
use clap::{Args, ValueEnum};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Run one episode: a human and a robot carry an object from A to B
#[derive(Args, Debug)]
pub(super) struct Arguments {
    /// World file (TOML), or a built-in world: environment-1 to environment-4
    #[arg(default_value = "environment-4")]
    world: PathBuf,
    /// Who decides the way
    #[arg(long, value_enum, default_value_t = MethodArgument::Mutual)]
    method: MethodArgument,
    /// The human's perception of distance (D^alpha); drawn from the belief if not given
    #[arg(long, value_parser = perception, allow_negative_numbers = true)]
    alpha: Option<f64>,
    /// The human's perception of risk (Prelec's gamma); drawn from the belief if not given
    #[arg(long, value_parser = perception, allow_negative_numbers = true)]
    gamma: Option<f64>,
    /// Tolerance of the human: the larger, the slower stubbornness grows (paper: 5, 10.5, 15)
    #[arg(long, default_value_t = coordination::Settings::default().eta, value_parser = positive, allow_negative_numbers = true)]
    eta: f64,
    /// Stubbornness at the start, in (0, 1]
    #[arg(long, value_name = "PHI", default_value_t = coordination::Settings::default().initial_stubbornness, value_parser = initial_stubbornness, allow_negative_numbers = true)]
    initial_stubbornness: f64,
    /// Seed from which the human is drawn
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Give up after this many steps of 0.2 s [default: ten times what the longest option takes]
    #[arg(long, value_name = "STEPS")]
    max_steps: Option<u64>,
    #[command(flatten)]
    model: ModelArguments,
    #[command(flatten)]
    carrier: RobotArguments,
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
    /// Write every tick to this file: .csv, or .jsonl for JSON lines
    #[arg(long, value_name = "FILE", value_parser = tick_log::file)]
    ticks: Option<tick_log::File>,
    /// Draw trajectory and stubbornness into this file
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    #[command(flatten)]
    recording: RecordArguments,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum MethodArgument {
    /// The robot leads until the human's stubbornness passes 1, then follows
    Mutual,
    /// The human leads from start to end, on the option preferred at the start
    WithoutModel,
    /// The human leads from start to end, choosing anew at every step
    HumanLed,
    /// The robot leads from start to end
    RobotLed,
}

impl From<MethodArgument> for Method {
    fn from(argument: MethodArgument) -> Self {
        match argument {
            MethodArgument::Mutual => Self::Mutual,
            MethodArgument::WithoutModel => Self::WithoutModel,
            MethodArgument::HumanLed => Self::HumanLed,
            MethodArgument::RobotLed => Self::RobotLed,
        }
    }
}

impl MethodArgument {
    fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |v| v.get_name().to_owned())
    }
}

/// An episode that is over, with all that is told of it.
struct Told<'a> {
    arguments: &'a Arguments,
    world: &'a World,
    set: &'a OptionSet,
    settings: &'a Settings,
    carrier: Option<&'a Chosen>,
    human: Perception,
    summary: Summary,
    ticks: Vec<Tick>,
}

/// What runs when no command is given.
pub(super) fn example() -> Result<ExitCode, Failure> {
    use clap::Parser;
    #[derive(Parser)]
    struct Defaults {
        #[command(flatten)]
        arguments: Arguments,
    }
    let Perception { alpha, gamma } = EXAMPLE_HUMAN;
    let line = format!("run environment-4 --alpha {alpha} --gamma {gamma}");
    print(&format!("$ cocarry {line}      (the default; see cocarry --help)\n\n"))?;
    run(&Defaults::parse_from(line.split(' ')).arguments)
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let world = load_world(&arguments.world)?;
    let predictor = arguments.model.predictor()?;
    let human = human(arguments, predictor.belief());
    let settings = Settings {
        predictor,
        coordination: coordination::Settings {
            initial_stubbornness: arguments.initial_stubbornness,
            eta: arguments.eta,
        },
        method: arguments.method.into(),
        tick_limit: arguments.max_steps,
        ..Settings::default()
    };
    let set = OptionSet::new(&world, settings.predictor.risk_weight()).map_err(input)?;
    let carrier = arguments.carrier.load()?;
    let obstacles = RobotObstacles::new(&world);
    let mut episode = Episode::new(&set, &settings, human);
    if let Some(Chosen { robot, posture, control, physics }) = &carrier {
        let manipulator =
            Manipulator { robot, posture: posture.joints, control: *control, obstacles: &obstacles };
        episode = match physics {
            None => episode.with_robot(manipulator),
            Some(physics) => {
                episode.with_physics(manipulator, &world, physics, arguments.seed).map_err(input)?
            }
        };
    }
    let mut ticks = Vec::new();
    let bar = Progress::new(episode.expected_steps() as usize, "episode");
    let robot = carrier.as_ref().map(|c| &c.robot);
    let stage = Stage { world: &world, options: &set, robot, period: settings.period };
    let provenance = provenance(arguments, &world, human)?;
    let mut recording = arguments.recording.begin(stage, &provenance, &episode)?;
    while !recording.is_interrupted() && episode.step().is_none() {
        recording.step(&episode)?;
        ticks.push(episode.tick().clone());
        bar.step();
    }
    bar.finish();
    if let Some(interrupted) = recording.finish(&episode)? {
        return Ok(interrupted);
    }
    let told = Told {
        arguments,
        world: &world,
        set: &set,
        settings: &settings,
        carrier: carrier.as_ref(),
        human,
        summary: episode.summary().clone(),
        ticks,
    };
    if let Some(file) = &arguments.ticks {
        let joints = carrier.as_ref().map_or(&[][..], |c| &c.robot.joints);
        file.write(&told.ticks, &tick_log::Names { options: &set, joints })?;
    }
    if let Some(path) = &arguments.svg {
        let svg = drawing::adaptation(&world, &[told.track()], settings.period)
            .with_context(|| path.display().to_string())
            .map_err(Failure::Output)?;
        write_file(path, &svg)?;
    }
    if arguments.json {
        print_json(&told.as_json())?;
    } else {
        print(&told.as_text())?;
    }
    Ok(match told.summary.outcome {
        Outcome::Arrived => ExitCode::SUCCESS,
        _ => ExitCode::from(3),
    })
}

/// What a recording says of where it comes from.
fn provenance(arguments: &Arguments, world: &World, human: Perception) -> Result<Provenance, Failure> {
    let facts = [
        ("crate_version", env!("CARGO_PKG_VERSION").to_owned()),
        ("world", world.name.clone()),
        ("method", arguments.method.name()),
        ("alpha", human.alpha.to_string()),
        ("gamma", human.gamma.to_string()),
        ("eta", arguments.eta.to_string()),
        ("initial_stubbornness", arguments.initial_stubbornness.to_string()),
        ("seed", arguments.seed.to_string()),
    ];
    let world = Attachment {
        name: recording::WORLD.to_owned(),
        media_type: "application/toml".to_owned(),
        data: world_text(&arguments.world)?.into_bytes(),
    };
    Ok(Provenance {
        metadata: facts.map(|(key, value)| (key.to_owned(), value)).into(),
        attachments: vec![world],
    })
}

/// The human: as given, the rest drawn from the seed.
fn human(arguments: &Arguments, belief: &Belief) -> Perception {
    let drawn = belief.sample(&mut ChaCha8Rng::seed_from_u64(arguments.seed));
    Perception {
        alpha: arguments.alpha.unwrap_or(drawn.alpha),
        gamma: arguments.gamma.unwrap_or(drawn.gamma),
    }
}

impl Told<'_> {
    fn option_name(&self, option: usize) -> &str {
        &self.set.options()[option].name
    }

    fn openings(&self, option: usize) -> Vec<&str> {
        let crossings = &self.set.options()[option].crossings;
        crossings.iter().map(|c| self.world.openings[c.opening].name.as_str()).collect()
    }

    /// Ticks at which the executed option changed, with the option before.
    fn changes(&self) -> impl Iterator<Item = (usize, &Tick)> {
        self.ticks.windows(2).filter(|w| w[0].executed != w[1].executed).map(|w| (w[0].executed, &w[1]))
    }

    fn seconds(&self, step: u64) -> f64 {
        step as f64 * self.settings.period
    }

    fn track(&self) -> Track {
        Track::new(self.arguments.method.name(), &self.ticks, self.end())
    }

    /// The target, if the team arrived there.
    fn end(&self) -> Option<Point> {
        (self.summary.outcome == Outcome::Arrived).then(|| self.set.target())
    }

    fn as_text(&self) -> String {
        let Told { arguments, world, summary, .. } = self;
        let mut text = format!("{} ({})\n", world.name, world.file);
        let method = arguments.method.name();
        let Perception { alpha, gamma } = self.human;
        text += &format!(
            "human: alpha {alpha:.4}, gamma {gamma:.4}; method {method}, eta {}, phi(0) {}\n\nOptions at the start\n",
            arguments.eta, arguments.initial_stubbornness
        );
        let headings = ["option", "openings", "D (m)", "risk S", "cost J (m)", "subjective J~ (m)", "P (%)"];
        let mut options = table(headings, 2);
        for (o, option) in self.ticks.first().into_iter().flat_map(|t| t.options.iter().enumerate()) {
            options.add_row([
                self.option_name(o).to_owned(),
                self.openings(o).join(" "),
                format!("{:.2}", option.remaining.length),
                format!("{:.3}", option.remaining.risk),
                format!("{:.2}", option.objective),
                number_or_dash(option.expected, 2),
                format!("{:.1}", 100.0 * option.probability),
            ]);
        }
        text += &table_text(&options);
        text += "\nWhat happened\n";
        for event in self.events() {
            let _ = writeln!(text, "  {event}");
        }
        text += &format!("  accumulated objective cost {:.2} m\n", summary.accumulated_cost);
        if let (Some(carrier), Some(control)) = (self.carrier, &summary.control) {
            text += &self.control_text(carrier, control);
        }
        text
    }

    fn control_text(&self, carrier: &Chosen, control: &ControlSummary) -> String {
        let steps = self.summary.steps;
        let mut text = format!(
            "\nThe robot ({}, starting from `{}`)\n  control cost C {:.1}: tracking {:.1}, effort {:.1}, pose {:.1}\n",
            carrier.robot.name,
            carrier.posture.name,
            control.cost(),
            control.tracking,
            control.effort,
            control.pose
        );
        let _ = writeln!(
            text,
            "  tracking error {:.1} mm rms; limits active in {} of {steps} steps, configuration changed in {}",
            1e3 * control.error_rms(steps),
            control.constrained_steps,
            control.pose_changes
        );
        if control.least_clearance.is_finite() {
            let _ = writeln!(
                text,
                "  base at least {:.3} m clear of obstacles{}",
                control.least_clearance,
                if control.overlapping_steps > 0 {
                    ": it overlaps one; this plant does not stop it"
                } else {
                    ""
                }
            );
        }
        if let Some(interaction) = &self.summary.interaction {
            let _ = writeln!(
                text,
                "  the human's force on the object: mean {:.1} N, rms {:.1} N; either grip at most {:.0} N, yielding at most {:.1} cm",
                interaction.mean_force(),
                interaction.rms_force(),
                interaction.peak_force,
                100.0 * interaction.stretch
            );
        }
        if control.fallback_steps > 0 {
            let _ =
                writeln!(text, "  no solution of eq. (7) in {} steps: see --ticks", control.fallback_steps);
        }
        text
    }

    fn events(&self) -> Vec<String> {
        let summary = &self.summary;
        let Some(first) = self.ticks.first() else {
            return vec!["no step was taken".to_owned()];
        };
        let leader = |tick: &Tick| match tick.mode {
            coordination::Mode::RobotLed => "the robot leads",
            coordination::Mode::HumanLed => "the human leads",
        };
        let at = |tick: &Tick| {
            format!(
                "step {:>4} ({:5.1} s) at ({:.2}, {:.2}) m",
                tick.step, tick.time, tick.position.x, tick.position.y
            )
        };
        let mut events = vec![(
            first.step,
            format!(
                "{}: {} on option {}; this human prefers option {}",
                at(first),
                leader(first),
                self.option_name(first.executed),
                self.option_name(first.preferred)
            ),
        )];
        if let Some(tick) = summary.transition.and_then(|t| self.ticks.get(t.step as usize)) {
            let event = format!(
                "{}: stubbornness passes 1 ({:.3}), the human takes the lead",
                at(tick),
                tick.stubbornness
            );
            events.push((tick.step, event));
        }
        for (before, tick) in self.changes() {
            let (from, to) = (self.option_name(before), self.option_name(tick.executed));
            events.push((
                tick.step,
                format!("{}: {} from option {from} to option {to}", at(tick), leader(tick)),
            ));
        }
        events.sort_by_key(|(step, _)| *step);
        let mut events: Vec<String> = events.into_iter().map(|(_, event)| event).collect();
        let end = match summary.outcome {
            Outcome::Arrived => "arrived at B",
            Outcome::OutOfTime => "did not arrive: the step limit is reached",
            Outcome::NoWay => "did not arrive: no way leads on from here",
            Outcome::Collided => "did not arrive: collided",
            Outcome::Stuck => "did not arrive: stuck for ten seconds",
            Outcome::Dropped => "did not arrive: the object fell",
            Outcome::NonFinite => "did not arrive: the physics broke down",
        };
        if let Some(contact) = &summary.collision {
            let [first, second] = &contact.between;
            events.push(format!(
                "the {}'s {} touched {} at ({:.2}, {:.2}, {:.2}) m, {:.1} mm deep, {:.0} N",
                first.party.name(),
                first.name,
                second.name,
                contact.point.x,
                contact.point.y,
                contact.point.z,
                1e3 * contact.depth,
                contact.force
            ));
        }
        events.push(format!(
            "step {:>4} ({:5.1} s): {end} on option {} after {:.2} m",
            summary.steps,
            self.seconds(summary.steps),
            self.option_name(summary.last_option),
            summary.walked
        ));
        events
    }

    fn as_json(&self) -> Value {
        let summary = &self.summary;
        json!({
            "world": self.world.name,
            "file": self.world.file,
            "human": { "alpha": self.human.alpha, "gamma": self.human.gamma },
            "method": self.arguments.method.name(),
            "eta": self.arguments.eta,
            "initial_stubbornness": self.arguments.initial_stubbornness,
            "risk_weight_m": self.settings.predictor.risk_weight(),
            "seed": self.arguments.seed,
            "period_s": self.settings.period,
            "speed_m_per_s": self.settings.speed,
            "options": self.ticks.first().into_iter().flat_map(|t| t.options.iter().enumerate()).map(|(o, option)| json!({
                "name": self.option_name(o),
                "openings": self.openings(o),
                "length_m": option.remaining.length,
                "risk": option.remaining.risk,
                "objective": option.objective,
                "expected_subjective": option.expected,
                "probability": option.probability,
            })).collect::<Vec<_>>(),
            "preferred_at_start": self.ticks.first().map(|t| self.option_name(t.preferred)),
            "first_option": self.option_name(summary.first_option),
            "last_option": self.option_name(summary.last_option),
            "option_changes": self.changes().map(|(before, tick)| json!({
                "step": tick.step,
                "from": self.option_name(before),
                "to": self.option_name(tick.executed),
            })).collect::<Vec<_>>(),
            "transition": summary.transition.map(|t| json!({
                "step": t.step,
                "time_s": self.seconds(t.step),
                "position_m": [t.position.x, t.position.y],
            })),
            "outcome": summary.outcome.name(),
            "steps": summary.steps,
            "time_s": self.seconds(summary.steps),
            "walked_m": summary.walked,
            "accumulated_objective_cost_m": summary.accumulated_cost,
            "robot": self.carrier.map(|c| json!({
                "name": c.robot.name,
                "file": c.robot.file,
                "posture": c.posture.name,
                "candidates": c.control.candidates,
                "criterion": c.control.criterion,
                "avoid": c.control.avoid,
            })),
            "control": summary.control.map(|c| json!({
                "cost": c.cost(),
                "tracking": c.tracking,
                "effort": c.effort,
                "pose": c.pose,
                "position_error_rms_m": c.error_rms(summary.steps),
                "constrained_steps": c.constrained_steps,
                "fallback_steps": c.fallback_steps,
                "pose_changes": c.pose_changes,
                "overlapping_steps": c.overlapping_steps,
                "least_base_clearance_m": c.least_clearance,
            })),
            "interaction": summary.interaction.map(|i| json!({
                "hand_force_mean_n": i.mean_force(),
                "hand_force_rms_n": i.rms_force(),
                "peak_force_n": i.peak_force,
                "robot_work_j": i.work[0],
                "human_work_j": i.work[1],
                "squared_jerk_m2_per_s5": i.squared_jerk,
                "largest_stretch_m": i.stretch,
            })),
            "collision": summary.collision.as_ref().map(|c| json!({
                "between": c.between.each_ref().map(|part| json!({
                    "party": part.party.name(),
                    "name": part.name,
                })),
                "point_m": [c.point.x, c.point.y, c.point.z],
                "depth_m": c.depth,
                "force_n": c.force,
            })),
        })
    }
}

fn number_or_dash(value: f64, digits: usize) -> String {
    if value.is_finite() { format!("{value:.digits$}") } else { "-".to_owned() }
}
