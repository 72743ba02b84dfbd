//! `cocarry plot`: pictures of a study's results.

use super::output::{Failure, OverwriteArguments, examples, input, note, print, write_file};
use anyhow::anyhow;
use clap::builder::PossibleValuesParser;
use clap::{Args, ValueEnum};
use cocarry_recording::rendering::{PictureFormat, Width};
use cocarry_studies::study::{Comparing, Drawn, OUTCOMES, Results, picture};
use std::path::PathBuf;
use std::process::ExitCode;

/// Draw the results of a study: means with intervals, paired differences, or a map over alpha and gamma
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry plot study.csv -o means.svg", "the costs of every combination, with 95 % intervals"),
    ("cocarry plot study.csv -o differences.svg --kind differences", "what the methods differ by, paired by seed"),
    ("cocarry plot study.csv -o means.pdf --width 3.5in", "for a column of a paper"),
    ("cocarry plot mine.csv study.csv -o differences.svg --kind differences", "of two sweeps with the same seeds"),
    ("cocarry plot study.csv -o map.svg --kind map --quantity final_discomfort", "which humans it is hard on"),
]))]
pub(super) struct PlotArguments {
    /// Results of `cocarry sweep`, CSV or Parquet
    #[arg(required = true, value_name = "RESULTS")]
    results: Vec<PathBuf>,
    /// Picture to write. The extension selects the format: .svg, .pdf or .png
    #[arg(short, long, value_name = "FILE", value_parser = picture_file)]
    output: PathBuf,
    /// Width of the picture, in inches or pixels: 3.5in, 1200px. Type is at least 7 pt from 3.5 inches on; a
    /// PNG has 300 pixels an inch [default: 7in; .svg: 720px]
    #[arg(long, value_name = "WIDTH", value_parser = clap::value_parser!(Width))]
    width: Option<Width>,
    /// What to draw
    #[arg(long, value_enum, default_value_t = Picture::Means)]
    kind: Picture,
    /// Quantity to draw; differences are of costs
    #[arg(long, value_name = "COLUMN", default_value = OUTCOMES[0], value_parser = PossibleValuesParser::new(OUTCOMES))]
    quantity: String,
    /// Input whose values are compared in differences [default: method and pose]
    #[arg(long, value_name = "COLUMN")]
    by: Option<String>,
    /// Intervals of alpha and of gamma in a map
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = clap::value_parser!(u16).range(2..=60))]
    cells: u16,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Picture {
    /// Means over humans, with 95 % intervals
    Means,
    /// Differences between methods or poses, or --by another input, with the same seeds, with 95 % intervals
    Differences,
    /// Means over the humans' alpha and gamma
    Map,
}

/// A parser of the name of a picture.
fn picture_file(name: &str) -> Result<PathBuf, String> {
    let file = PathBuf::from(name);
    PictureFormat::of(&file).map(|_| file)
}

pub(super) fn run_plot(arguments: &PlotArguments) -> Result<ExitCode, Failure> {
    let PlotArguments { results, output, width, kind, quantity, by, cells, overwrite } = arguments;
    let outputs = overwrite.outputs(results.iter().map(PathBuf::as_path), [output])?;
    let format = PictureFormat::of(output).map_err(|sentence| input(anyhow!(sentence)))?;
    let drawn = match kind {
        Picture::Means => Drawn::Means,
        Picture::Differences => {
            let quantities = std::slice::from_ref(quantity);
            Drawn::Differences(Comparing::new(by.as_deref(), &[], quantities).map_err(input)?)
        }
        Picture::Map => Drawn::Map(usize::from(*cells)),
    };
    let files: Vec<Results> = results.iter().map(|file| Results::File(file)).collect();
    let (svg, notes) = picture(&files, quantity, &drawn, format.sheet(*width)).map_err(input)?;
    notes.iter().for_each(note);
    write_file(&outputs, output, format.bytes(svg, *width).map_err(input)?)?;
    print(&format!("wrote {}\n", output.display()))?;
    Ok(ExitCode::SUCCESS)
}
