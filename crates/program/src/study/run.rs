//! The work of `cocarry study`.

use super::browsers::{answered, found};
use super::{
    Action, BuildArguments, CollectArguments, EthicsArguments, ForgetArguments, GivenSink, ModuleArguments,
    NewArguments, ServeArguments, SimulateArguments,
};
use super::{power, report};
use crate::demo::files::Pages;
use crate::export::write_all;
use crate::interrupt::Interrupt;
use crate::output::{Failure, OverwriteArguments, counted, input, print, print_verdict, warn, write_file};
use crate::replay_log::{Replayed, replayed};
use anyhow::{Context, anyhow};
use cocarry::episode::{EpisodeSettings, Outcome};
use cocarry::suggestion::shell_word;
use cocarry_people::{
    Admin, Browsers, CollectedCarry, PeopleStudy, Refusal, Serving, Sink, Site, Store, StoreError, TEMPLATE,
    Task, Trial, Truth, add_file, carries_table, collect, ethics_page, orders, serve, simulate, token,
};
use std::borrow::Cow;
use std::fmt::Write;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};

/// What is said of a page's seconds: reading a page of text, dividing 100 %, looking at a scale.
const TEXT_S: f64 = 30.0;
const PERCENTAGES_S: f64 = 40.0;
const CARRY_S: f64 = 60.0;

pub(super) fn run_action(action: &Action) -> Result<(), Failure> {
    match action {
        Action::New(arguments) => run_new(arguments),
        Action::Check(arguments) => run_check(&arguments.study),
        Action::Build(arguments) => run_build(arguments),
        Action::Serve(arguments) => run_serve(arguments),
        Action::Ethics(arguments) => run_ethics(arguments),
        Action::Collect(arguments) => run_collect(arguments),
        Action::Forget(arguments) => run_forget(arguments),
        Action::Simulate(arguments) => run_simulate(arguments),
        Action::Report(arguments) => report::run_report(arguments),
        Action::Power(arguments) => power::run_power(arguments),
    }
}

/// The study in a file, or in the folder of `study new`.
pub(super) fn read(file: &Path) -> Result<PeopleStudy, Failure> {
    const NAME: &str = "study.toml";
    let inside = file.join(NAME);
    let study =
        PeopleStudy::read(if file.is_dir() && inside.is_file() { &inside } else { file }).map_err(input)?;
    study.worlds.iter().flat_map(|world| world.world.warnings()).for_each(|warning| warn(&warning));
    Ok(study)
}

/// A failure of the store: bad input where the request is at fault.
pub(super) fn of_store(error: StoreError) -> Failure {
    match error {
        StoreError::Database { .. } => Failure::Output(error.into()),
        StoreError::Refused(_) | StoreError::File { .. } => input(error),
    }
}

fn made(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder)
        .with_context(|| format!("{}: cannot be created", folder.display()))
        .map_err(Failure::Output)
}

/// Seconds since 1970.
fn now() -> i64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |passed| passed.as_secs() as i64)
}

fn run_new(NewArguments { folder, overwrite }: &NewArguments) -> Result<(), Failure> {
    let file = folder.join("study.toml");
    if folder.exists() {
        overwrite.outputs([], [&file])?;
    }
    made(folder)?;
    write_all(*overwrite, &[(file.clone(), TEMPLATE)])?;
    let (file, answers) =
        (shell_word(&file.display().to_string()), shell_word(&folder.join("answers").display().to_string()));
    print(&format!(
        "\nTry:\n  cocarry study check {file}\n  cocarry study serve {file}\n  cocarry study collect {file} -o {answers}\n"
    ))
}

fn run_check(file: &Path) -> Result<(), Failure> {
    let study = read(file)?;
    let orders = orders(&study);
    let mut text = format!("{}\n", study.title);
    let _ = writeln!(
        text,
        "{} of {}, {} in {}",
        counted(orders[0].len() as u64, "page"),
        counted(study.participants, "participant"),
        counted(study.measured_worlds() as u64, "world"),
        counted(orders.len() as u64, "order")
    );
    let walks: Vec<f64> = study.worlds[..study.measured_worlds()]
        .iter()
        .flat_map(|world| {
            world.prospects.iter().map(|prospect| prospect.length / EpisodeSettings::default().speed)
        })
        .collect();
    let scales = orders[0].iter().filter(|page| matches!(page, Trial::Scale { .. })).count();
    let mut seconds = TEXT_S * (1 + study.tasks.len() + study.questions.len() + scales) as f64;
    for task in &study.tasks {
        let (what, took) = match task {
            Task::Percentages => (
                counted(study.measured_worlds() as u64, "map"),
                PERCENTAGES_S * study.measured_worlds() as f64,
            ),
            Task::Carry => {
                let carries = study.measured_worlds() * study.methods.len();
                (counted(carries as u64, "carry"), CARRY_S * carries as f64)
            }
            Task::Switch => {
                let shown = walks.len() as u64 * study.switch_trials;
                (counted(shown, "walk"), study.switch_trials as f64 * walks.iter().sum::<f64>())
            }
        };
        seconds += took;
        let _ = writeln!(text, "{}: {what}", task.name());
    }
    let _ = writeln!(text, "about {:.0} min, if nobody stops a walk", (seconds / 60.0).ceil());
    let dominated: Vec<String> = study
        .worlds
        .iter()
        .flat_map(|world| {
            let options = (0..world.options.len()).filter(|&option| world.is_dominated(option));
            options.map(|option| format!("{} of {}", world.options[option], world.name)).collect::<Vec<_>>()
        })
        .collect();
    if !dominated.is_empty() {
        let _ = writeln!(text, "longer and riskier than another option: {}", dominated.join(", "));
    }
    print(&text)?;
    if study.database().is_file() {
        let store = Store::open(&study.database()).map_err(of_store)?;
        let faults = store.faults().map_err(of_store)?;
        if let Some(fault) = faults.first() {
            return Err(Failure::Input(anyhow!("{}: damaged: {fault}", study.database().display())));
        }
        let [begun, finished] = store.counts().map_err(of_store)?;
        print(&format!("{}: sound; {begun} began, {finished} finished\n", study.database().display()))?;
    }
    Ok(())
}

/// The page of a study, with the simulator if people carry in it.
fn site(study: &PeopleStudy, sink: Sink, module: &ModuleArguments) -> Result<Site, Failure> {
    Site::new(study, sink, carry_module(study, module)?).map_err(input)
}

/// The simulator as a WebAssembly module, if people carry.
fn carry_module(
    study: &PeopleStudy,
    ModuleArguments { page }: &ModuleArguments,
) -> Result<Option<Cow<'static, [u8]>>, Failure> {
    const MODULE: &str = "/cocarry.wasm";
    if !study.has_carry() {
        return Ok(None);
    }
    let pages = Pages::find(page.as_deref()).context("the task `carry`").map_err(input)?;
    let module = pages.get(MODULE);
    let module = module.ok_or_else(|| input(anyhow!("the task `carry`: the page has no cocarry.wasm")))?;
    Ok(Some(module.bytes))
}

fn run_build(arguments: &BuildArguments) -> Result<(), Failure> {
    let BuildArguments { study, output, sink, module, overwrite } = arguments;
    let sink = match sink {
        GivenSink::Download => Sink::Download,
        GivenSink::Jatos => Sink::Jatos,
        GivenSink::DataPipe(experiment) => Sink::DataPipe(experiment.clone()),
    };
    let site = site(&read(study)?, sink, module)?;
    let files: Vec<(PathBuf, &[u8])> =
        site.files.iter().map(|file| (output.join(&*file.name), &*file.bytes)).collect();
    // before folders are made, which have no files then
    if output.exists() {
        let existing =
            files.iter().map(|(file, _)| file).filter(|file| file.parent().is_some_and(Path::is_dir));
        overwrite.outputs([study.as_path()], existing)?;
    }
    for folder in files.iter().filter_map(|(file, _)| file.parent()) {
        made(folder)?;
    }
    write_all(*overwrite, &files)
}

/// A listener at a port of this computer, and the port.
fn listening(flag: &str, port: u16) -> Result<(TcpListener, u16), Failure> {
    let listener = TcpListener::bind(SocketAddr::from((Ipv4Addr::LOCALHOST, port)))
        .map_err(|error| input(anyhow!("{flag} {port}: {error}; use another port, or 0 for a free one")))?;
    let port = listener.local_addr().context("the port is not known").map_err(Failure::Output)?.port();
    Ok((listener, port))
}

fn run_serve(arguments: &ServeArguments) -> Result<(), Failure> {
    let ServeArguments { study, port, admin_port, public, module } = arguments;
    let study = read(study)?;
    let site = site(&study, Sink::Server, module)?;
    let store = Store::open(&study.database()).map_err(of_store)?;
    let (listener, port) = listening("--port", *port)?;
    let (admin_listener, admin_port) = listening("--admin-port", *admin_port)?;
    let token = token().context("a token for the administrator's page").map_err(Failure::Output)?;
    let mut hosts = vec![format!("127.0.0.1:{port}"), format!("localhost:{port}")];
    hosts.extend(
        public.iter().filter_map(|address| address.split_once("://")).map(|(_, host)| host.to_owned()),
    );
    let interrupt = Interrupt::caught()?;
    let proxy = public.as_ref().map_or(String::new(), |address| {
        format!("a proxy on this computer must pass on {address} with its host's name\n")
    });
    print(&format!(
        "the study is at http://127.0.0.1:{port}/\n{proxy}\
         for you alone: http://admin:{token}@127.0.0.1:{admin_port}/\n\
         answers go to {}\nCtrl-C ends it\n",
        study.database().display()
    ))?;
    let admin = Some(Admin { listener: admin_listener, token });
    serve(listener, Serving { study, site, store, hosts, admin }, || interrupt.is_set())
        .context("the study cannot be served")
        .map_err(Failure::Output)
}

fn run_ethics(EthicsArguments { study, output, overwrite }: &EthicsArguments) -> Result<(), Failure> {
    let study = read(study)?;
    let file = output.clone().unwrap_or_else(|| study.file.with_extension("ethics.html"));
    if file.extension().is_none_or(|extension| extension != "html") {
        return Err(input(anyhow!("{}: the page is HTML; use the extension .html", file.display())));
    }
    overwrite.outputs([study.file.as_path()], [&file])?;
    let html = ethics_page(&study).map_err(input)?;
    write_all(*overwrite, &[(file, html)])
}

fn run_collect(arguments: &CollectArguments) -> Result<(), Failure> {
    let study = read(&arguments.study)?;
    let database = if arguments.simulated { study.simulated_database() } else { study.database() };
    let mut store = match arguments.add.is_empty() {
        true => Store::open_existing(&database),
        false => Store::open(&database),
    }
    .map_err(of_store)?;
    if !arguments.add.is_empty() {
        let digest = Site::new(&study, Sink::Download, None).map_err(input)?.digest;
        for file in &arguments.add {
            for added in add_file(&study, &digest, &mut store, file, now()).map_err(input)? {
                let end = if added.is_finished { "" } else { ", which has no end" };
                print(&format!("added {} as {}{end}\n", file.display(), added.participant))?;
            }
        }
    }
    let collected =
        collect_into(&study, &store, arguments.with_unfinished, &arguments.output, arguments.overwrite)?;
    print(&format!("{}\n", counted(collected as u64, "participant")))
}

/// Writes the tables of a study into a folder. Returns the number of participants in them.
pub(super) fn collect_into(
    study: &PeopleStudy,
    store: &Store,
    with_unfinished: bool,
    folder: &Path,
    overwrite: OverwriteArguments,
) -> Result<usize, Failure> {
    let sessions = store.sessions().map_err(of_store)?;
    let collected = collect(study, &sessions, with_unfinished);
    let files: Vec<(PathBuf, Vec<u8>)> =
        collected.files.into_iter().map(|(name, bytes)| (folder.join(name), bytes)).collect();
    if folder.exists() {
        let existing =
            files.iter().map(|(file, _)| file).filter(|file| file.parent().is_some_and(Path::is_dir));
        overwrite.outputs([study.file.as_path()], existing)?;
    }
    for folder in files.iter().filter_map(|(file, _)| file.parent()) {
        made(folder)?;
    }
    write_all(overwrite, &files)?;
    replay_carries(&collected.carries, folder, overwrite)?;
    collected.left_out.iter().for_each(|line| warn(&format_args!("left out: {line}")));
    Ok(collected.participants)
}

/// Runs every carry again, records it, and writes their table.
fn replay_carries(
    carries: &[CollectedCarry],
    folder: &Path,
    overwrite: OverwriteArguments,
) -> Result<(), Failure> {
    if carries.is_empty() {
        return Ok(());
    }
    let recordings = folder.join("carries");
    made(&recordings)?;
    let mut rows = Vec::new();
    for carry in carries {
        let name = format!("{}-{}.mcap", carry.participant, carry.page);
        let file = recordings.join(&name);
        overwrite.outputs([], [&file])?;
        let done = match replayed(&carry.log, &name, Some((&file, overwrite.overwrite))) {
            Ok(done) => done,
            // one that cannot be run again keeps no other one from the table
            Err(Failure::Input(error)) => {
                warn(&format_args!("left out: {name}: {error:#}"));
                continue;
            }
            Err(failure) => return Err(failure),
        };
        let Replayed { same, difference, seconds, outcome, human_led_from, option, ways, .. } = done;
        let [mean_force, peak_force] =
            [0, 1].map(|which| done.forces.map_or(String::new(), |forces| format!("{:.3}", forces[which])));
        let time = |seconds: f64| format!("{seconds:.2}");
        let differs_within = difference.as_ref().map(|_| time(seconds));
        if let Some(difference) = difference {
            warn(&format_args!(
                "{name}: differs within {seconds:.1} s, after {}: {difference}",
                counted(same, "equal digest")
            ));
        }
        rows.push([
            carry.participant.clone(),
            carry.world.clone(),
            carry.method.clone(),
            format!("carries/{name}"),
            outcome.map_or("", Outcome::name).to_owned(),
            option,
            time(seconds),
            human_led_from.map_or(String::new(), time),
            time(done.human_led),
            done.transitions.to_string(),
            format!("{:.3}", done.walked),
            mean_force,
            peak_force,
            differs_within.unwrap_or_default(),
            carry.stalls.to_string(),
            carry.lost.to_string(),
            ways.join("; "),
        ]);
    }
    let (name, table) = carries_table(rows);
    write_all(overwrite, &[(folder.join(name), table)])
}

fn run_forget(ForgetArguments { study, id }: &ForgetArguments) -> Result<(), Failure> {
    let database = read(study)?.database();
    let mut store = Store::open_existing(&database).map_err(of_store)?;
    let forgotten = store.forget(id).map_err(of_store)?;
    print_verdict(
        &format!(
            "{} is removed: {} and {} of a platform. {} of {} were searched: no trace of them\n",
            forgotten.participant,
            counted(forgotten.chunks, "chunk"),
            counted(forgotten.platform_ids, "parameter"),
            counted(forgotten.searched_bytes, "byte"),
            database.display()
        ),
        true,
    )
}

fn run_simulate(arguments: &SimulateArguments) -> Result<(), Failure> {
    let SimulateArguments { participants, seed, truth, browser, at_once, module, .. } = arguments;
    let study = read(&arguments.study)?;
    let outputs = arguments.overwrite.outputs([study.file.as_path()], truth)?;
    let truths = match browser {
        Some(program) => {
            let browsers = Browsers { participants: *participants, seed: *seed, at_once: *at_once };
            rehearsed(&study, browsers, program.as_deref(), module)?
        }
        None => simulated(&study, *participants, *seed)?,
    };
    if let Some(file) = truth {
        let mut table = csv::Writer::from_writer(Vec::new());
        let header = ["participant", "alpha", "gamma", "eta"].map(str::to_owned);
        let rows = truths.iter().map(|truth| {
            let numbers = [truth.perception.alpha, truth.perception.gamma, truth.eta];
            let [alpha, gamma, eta] = numbers.map(|number| format!("{number:.4}"));
            [truth.participant.clone(), alpha, gamma, eta]
        });
        for row in [header].into_iter().chain(rows) {
            table.write_record(&row).expect("a table in memory is always written");
        }
        write_file(&outputs, file, table.into_inner().expect("a table in memory is always written"))?;
    }
    let (people, file) = (counted(*participants, "participant"), study.simulated_database());
    print(&format!("{people} answered into {}\n", file.display()))
}

/// Participants who answer without a browser.
fn simulated(study: &PeopleStudy, participants: u64, seed: u64) -> Result<Vec<Truth>, Failure> {
    if study.has_carry() {
        warn(
            &"simulated participants do not carry: their pages of the task `carry` stay empty; with --browser they do",
        );
    }
    let digest = Site::new(study, Sink::Server, None).map_err(input)?.digest;
    let mut store = Store::open(&study.simulated_database()).map_err(of_store)?;
    simulate(study, &digest, &mut store, participants, seed).map_err(|error| match error {
        StoreError::Refused(Refusal::Full) => others(study),
        other => of_store(other),
    })
}

fn others(study: &PeopleStudy) -> Failure {
    let file = study.simulated_database();
    input(anyhow!("{}: has other simulated participants; remove the file first", file.display()))
}

/// Participants who answer on the page.
fn rehearsed(
    study: &PeopleStudy,
    browsers: Browsers,
    program: Option<&Path>,
    module: &ModuleArguments,
) -> Result<Vec<Truth>, Failure> {
    let program = found(program)?;
    let site = browsers.site(study, carry_module(study, module)?).map_err(input)?;
    let database = study.simulated_database();
    let store = Store::open(&database).map_err(of_store)?;
    if store.counts().map_err(of_store)?[0] > 0 {
        return Err(others(study));
    }
    let (listener, port) = listening("--port", 0)?;
    let study = PeopleStudy { participants: browsers.participants, ..study.clone() };
    let serving =
        Serving { study: study.clone(), site, store, hosts: vec![format!("127.0.0.1:{port}")], admin: None };
    let interrupt = Interrupt::caught()?;
    let watched = Store::open_existing(&database).map_err(of_store)?;
    let is_over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let served = scope.spawn(|| serve(listener, serving, || is_over.load(Ordering::Relaxed)));
        let answered = answered(&program, port, browsers, &watched, &interrupt);
        is_over.store(true, Ordering::Relaxed);
        let served = served.join().expect("the server does not panic");
        answered.and(served.context("the study cannot be served").map_err(Failure::Output))
    })?;
    browsers.truths(&study, &watched).map_err(of_store)
}
