//! `cocarry export WORLD --mjcf`: writes a scenario for MuJoCo, and the controls of its episode.

use super::export::ExportArguments;
use super::interrupt::Interrupt;
use super::motor_log::MotorLog;
use super::output::{Failure, Progress, counted, input, print, print_message, unwritten, warn, with_spinner};
use super::scenario::inputs_of;
use anyhow::anyhow;
use cocarry::geometry::PlanarPose;
use cocarry::scenario::PreparedScenario;
use cocarry::simulation::PlantModel;
use cocarry_output::mjcf::{Mjcf, Scene, mjcf};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The largest number of bodies of a robot, each of which may be an element within the last one.
const MAX_BODIES: usize = 1000;

pub(super) fn export_mjcf(arguments: &ExportArguments, file: &Path) -> Result<ExitCode, Failure> {
    let scenario = arguments.team.scenario_in(arguments.world())?;
    if scenario.plant.physics().is_none() {
        return Err(input(anyhow!(
            "--mjcf needs bodies, which --plant {} does not have; use --plant rapier",
            scenario.plant.kind().name()
        )));
    }
    if let Some((policy, log)) = arguments.team.custom_policy().zip(arguments.motors.as_ref()) {
        return Err(input(anyhow!(
            "--motors {}: it runs the built-in methods, not the policy `{policy}`; leave --method or --motors out",
            log.display()
        )));
    }
    let files: Vec<PathBuf> =
        [Some(file.to_owned()), arguments.motors.clone()].into_iter().flatten().collect();
    let samples = arguments.team.belief_samples().map(PathBuf::as_path);
    let outputs = arguments.overwrite().outputs(inputs_of(&scenario).chain(samples), &files)?;
    let prepared = with_spinner("preparing the world", || scenario.prepare()).map_err(input)?;
    prepared.warnings().iter().for_each(warn);
    let written = scene(&prepared)?;
    let text = outputs.begin(file, &written.text).map_err(unwritten)?;
    let Some(motors) = &arguments.motors else {
        text.finish().map_err(unwritten)?;
        print(&format!("wrote {}\n{}", file.display(), told(&written)))?;
        return Ok(ExitCode::SUCCESS);
    };

    let interrupt = Interrupt::caught()?;
    let log = MotorLog::begin(
        outputs.create(motors).map_err(unwritten)?,
        motors,
        &written.controls,
        prepared.robot().map_or(0, |robot| robot.joints.len()),
    )?;
    let observer = log.observer();
    let mut episode =
        prepared.builder().map_err(input)?.with_step_observer(observer).begin().map_err(input)?;
    let bar = Progress::new(episode.expected_steps() as usize, "episode");
    while !interrupt.is_set() && !log.has_failed() && episode.step().is_none() {
        bar.step();
    }
    bar.finish();
    let outcome = episode.summary().outcome;
    if interrupt.is_set() {
        print_message("interrupted; nothing was written");
        return Ok(ExitCode::from(130));
    }
    // with its observer
    drop(episode);
    let (steps, output) = log.finish()?;
    text.finish().map_err(unwritten)?;
    output.finish().map_err(unwritten)?;
    print(&format!(
        "wrote {}\nwrote {}: {}; the episode ended: {}\n{}",
        file.display(),
        motors.display(),
        counted(steps, "physics step"),
        outcome.name(),
        told(&written)
    ))?;
    Ok(ExitCode::SUCCESS)
}

/// The scene of a prepared scenario.
fn scene(prepared: &PreparedScenario) -> Result<Mjcf, Failure> {
    let missing = || input(anyhow!("--mjcf needs a robot and bodies; use --plant rapier"));
    let scenario = prepared.scenario();
    let (manipulator, physics) = prepared.manipulator().zip(scenario.plant.physics()).ok_or_else(missing)?;
    // where the team stands, and that it can
    let episode = prepared.episode().map_err(input)?;
    let team = PlanarPose::from_above(&episode.observation().ok_or_else(missing)?.object);
    let (world, robot) = (prepared.world(), manipulator.robot);
    let model = PlantModel::new(world, robot, &manipulator.posture, &team, physics);
    if model.bodies.len() > MAX_BODIES {
        return Err(input(anyhow!(
            "{}: {} links move against each other; a file for MuJoCo has at most {MAX_BODIES}",
            robot.texts.file,
            model.bodies.len()
        )));
    }
    Ok(mjcf(&Scene { name: &world.name, world, robot, model: &model }))
}

/// What the file does not express, for people.
fn told(written: &Mjcf) -> String {
    let notes: String = written.notes.iter().map(|note| format!("- {note}\n")).collect();
    format!("its first lines say what it does not express, such as the human's motion\n{notes}")
}
