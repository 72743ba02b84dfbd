//! `cocarry inspect`: shows the contents of a recording as text, JSON, CSV or a picture.

use super::output::{
    Failure, OverwriteArguments, examples, input, print, print_json, short_number, svg_file, table,
    table_text, unwritten, visible, write_file,
};
use anyhow::{Context, anyhow};
use clap::Args;
use cocarry::geometry::Point;
use cocarry_output::drawing::{self, Sheet, Track};
use cocarry_output::output_file::Outputs;
use cocarry_recording::recording::{Channel, Contents, ReadError, Reader, columns, decode, rows, scenario};
use cocarry_studies::table::{plain, text_cell};
use serde_json::{Value, json};
use std::borrow::Cow;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Show the contents of a recording
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry inspect run.mcap", "provenance, channels, outcome"),
    ("cocarry inspect run.mcap --csv /coordination", "a channel as a table"),
    ("cocarry inspect run.mcap --svg run.svg", "trajectory and stubbornness"),
]))]
pub(super) struct InspectArguments {
    /// Recording (MCAP)
    file: PathBuf,
    /// Print one JSON object instead of text
    #[arg(long, conflicts_with = "csv")]
    json: bool,
    /// Print the messages on this channel as CSV instead, one line per message: /options, /joints, ...
    #[arg(long, value_name = "CHANNEL")]
    csv: Option<String>,
    /// Write the CSV into this file [default: standard output]
    #[arg(short, long, value_name = "FILE", requires = "csv")]
    output: Option<PathBuf>,
    /// Draw trajectory and stubbornness into this SVG file
    #[arg(long, value_name = "FILE", value_parser = svg_file)]
    svg: Option<PathBuf>,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

/// The largest number of steps in a picture.
const MAX_STEPS: usize = 1_000_000;

pub(super) fn run_inspect(arguments: &InspectArguments) -> Result<ExitCode, Failure> {
    let files = arguments.svg.iter().chain(&arguments.output);
    let outputs = arguments.overwrite.outputs([arguments.file.as_path()], files)?;
    if let Some(file) = &arguments.svg {
        write_file(&outputs, file, &picture(&arguments.file)?)?;
    }
    if let Some(topic) = &arguments.csv {
        return csv(&arguments.file, topic, arguments.output.as_deref(), &outputs);
    }
    let contents = Contents::read(&mut Reader::open(&arguments.file).map_err(input)?).map_err(input)?;
    if arguments.json {
        print_json(&as_json(&contents))?;
    } else {
        print(&as_text(&arguments.file, &contents))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn seconds(time: u64) -> f64 {
    time as f64 / 1e9
}

fn as_text(file: &Path, contents: &Contents) -> String {
    let mut text = format!("{}\n", file.display());
    for (key, value) in &contents.provenance {
        text += &format!("  {key}: {value}\n");
    }
    for (name, media_type, length) in &contents.attachments {
        text += &format!("  attached: {name} ({media_type}, {length} bytes)\n");
    }
    if let Some(recovered) = &contents.recovered {
        for lost in recovered.values() {
            text += &format!("  recovered; lost: {lost}\n");
        }
    }
    if let Some([first, last]) = contents.span() {
        text += &format!("  from {:.1} to {:.1} s\n", seconds(first), seconds(last));
    }
    text += "\nChannels\n";
    let mut channels = table(["topic", "schema", "encoding", "messages", "from (s)", "to (s)"], 3);
    for (topic, channel) in &contents.channels {
        let time = |i: usize| channel.span.map_or("-".to_owned(), |span| format!("{:.1}", seconds(span[i])));
        let (schema, encoding) = (channel.schema.clone(), channel.encoding.clone());
        channels.add_row([topic.clone(), schema, encoding, channel.messages.to_string(), time(0), time(1)]);
    }
    text += &table_text(&channels);
    match &contents.outcome {
        None => text += "\nNo outcome: the recording is incomplete\n",
        Some(outcome) => {
            text += "\nOutcome\n";
            for (key, value) in outcome.as_object().into_iter().flatten() {
                let number = value.as_f64().filter(|_| value.is_f64()).map(short_number);
                text += &format!("  {key}: {}\n", number.unwrap_or_else(|| plain(value)));
            }
        }
    }
    text
}

fn as_json(contents: &Contents) -> Value {
    let attachments = contents.attachments.iter().map(
        |(name, media_type, length)| json!({ "name": name, "media_type": media_type, "length": length }),
    );
    let channels = contents.channels.iter().map(|(topic, channel)| {
        json!({
            "topic": topic,
            "schema": channel.schema,
            "encoding": channel.encoding,
            "messages": channel.messages,
            "span_s": channel.span.map(|span| span.map(seconds)),
        })
    });
    json!({
        "provenance": contents.provenance,
        "recovered": contents.recovered,
        "attachments": attachments.collect::<Vec<_>>(),
        "span_s": contents.span().map(|span| span.map(seconds)),
        "channels": channels.collect::<Vec<_>>(),
        "outcome": contents.outcome,
        "cost": contents.cost,
    })
}

/// The error that stops a table.
enum Stop {
    Read(ReadError),
    Write(csv::Error),
}

impl From<ReadError> for Stop {
    fn from(error: ReadError) -> Self {
        Self::Read(error)
    }
}

fn csv(file: &Path, topic: &str, to: Option<&Path>, outputs: &Outputs) -> Result<ExitCode, Failure> {
    let open = || Reader::open(file).map_err(input);
    let columns = columns(&mut open()?, topic).map_err(input)?;
    let mut reader = open()?;
    match to {
        None => {
            let out = std::io::stdout().lock();
            write_table(&mut reader, topic, &columns, out, "standard output")?;
        }
        Some(to) => {
            let mut out = outputs.create(to).map_err(unwritten)?;
            write_table(&mut reader, topic, &columns, &mut out, &to.display().to_string())?;
            out.finish().map_err(unwritten)?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn write_table<R: std::io::Read>(
    reader: &mut Reader<R>,
    topic: &str,
    columns: &[String],
    to: impl Write,
    name: &str,
) -> Result<(), Failure> {
    let failed = |error: csv::Error| {
        // as a system error where it is one: a broken pipe is not an error
        let error = match error.into_kind() {
            csv::ErrorKind::Io(error) => anyhow!(error),
            other => anyhow!("{other:?}"),
        };
        Failure::Output(error.context(name.to_owned()))
    };
    let mut writer = csv::Writer::from_writer(to);
    let heading = std::iter::once("time_s".into())
        .chain(columns.iter().map(|column| visible(&text_cell(column)).into_owned().into()));
    writer.write_record(heading.map(Cow::into_owned)).map_err(failed)?;
    let written = rows(reader, topic, columns, |time, cells| {
        let cells = cells
            .iter()
            .map(|cell| cell.map_or_else(String::new, |cell| visible(&text_cell(&plain(cell))).into()));
        let row = std::iter::once(seconds(time).to_string()).chain(cells);
        writer.write_record(row).map_err(Stop::Write)
    });
    match written {
        Err(Stop::Read(error)) => return Err(input(error)),
        Err(Stop::Write(error)) => return Err(failed(error)),
        Ok(()) => {}
    }
    writer.flush().map_err(|error| failed(error.into()))
}

/// The picture of trajectory and stubbornness.
fn picture(file: &Path) -> Result<String, Failure> {
    let name = file.display().to_string();
    let lacks = |what: &str| input(anyhow!("{name}: {what}"));
    let mut reader = Reader::open(file).map_err(input)?;
    let scenario = scenario(&mut reader).map_err(input)?;
    let world = scenario.world.world();
    let world = world.with_context(|| name.clone()).map_err(Failure::Input)?;
    let mut track = Track { label: scenario.settings.method.name().to_owned(), ..Track::default() };
    let mut led_by_robot = 0;
    let mut arrived = false;
    while let Some(entry) = reader.next().map_err(input)? {
        let Some(message) = entry.message() else { continue };
        let known = Channel::of_topic(&message.channel.topic);
        if known != Some(Channel::Coordination) && known != Some(Channel::Outcome) {
            continue;
        }
        let damaged = || {
            lacks(&format!(
                "the message on {} at {} s is damaged",
                message.channel.topic,
                seconds(message.time)
            ))
        };
        let value = decode(message.channel, message.data).ok_or_else(damaged)?;
        if known == Some(Channel::Outcome) {
            arrived = value["outcome"] == "arrived";
            continue;
        }
        let number = |key: &str| value[key].as_f64().ok_or_else(damaged);
        if track.positions.len() == MAX_STEPS {
            return Err(lacks(&format!("has more than {MAX_STEPS} steps, too many to draw")));
        }
        track.positions.push(Point::new(number("x_m")?, number("y_m")?));
        track.stubbornness.push(number("stubbornness")?);
        if value["mode"] == "robot-led" && led_by_robot + 1 == track.positions.len() {
            led_by_robot += 1;
        }
    }
    let steps = track.positions.len();
    track.transition = (led_by_robot > 0 && led_by_robot < steps).then_some(led_by_robot);
    if led_by_robot == 0 {
        track.stubbornness.clear();
    }
    track.positions.extend(arrived.then_some(world.target));
    drawing::adaptation(&world, &[track], scenario.settings.planning_step, Sheet::default())
        .context(name.clone())
        .map_err(Failure::Input)
}
