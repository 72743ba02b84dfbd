//! `cocarry plot`: pictures of a study's results.

use super::output::{Failure, OverwriteArguments, examples, has_extension, input, note, print, write_file};
use super::render::picture_width;
use clap::builder::PossibleValuesParser;
use clap::{Args, ValueEnum};
use cocarry_output::drawing::{Letters, Sheet};
use cocarry_recording::rendering::{Width, pdf, png};
use cocarry_studies::study::{Comparing, Drawn, OUTCOMES, Results, picture};
use std::path::{Path, PathBuf};
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
    #[arg(long, value_name = "WIDTH", value_parser = picture_width)]
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

/// The width of a picture that is printed.
const PRINTED: Width = Width::Inches(7.0);

/// The format of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PictureFormat {
    Svg,
    Pdf,
    Png,
}

impl PictureFormat {
    const ALL: [(&str, Self); 3] = [("svg", Self::Svg), ("pdf", Self::Pdf), ("png", Self::Png)];

    /// The format by a file's extension, which the command line has checked.
    fn of(file: &Path) -> Self {
        let known = Self::ALL.into_iter().find(|(extension, _)| has_extension(file, extension));
        known.map_or(Self::Svg, |(_, format)| format)
    }

    fn sheet(self, width: Option<Width>) -> Sheet {
        match (self, width) {
            (Self::Svg, None) => Sheet::default(),
            (Self::Svg, Some(width)) => width.sheet(Letters::Text),
            (Self::Pdf | Self::Png, width) => width.unwrap_or(PRINTED).sheet(Letters::Outlines),
        }
    }
}

/// A parser of the name of a picture.
fn picture_file(name: &str) -> Result<PathBuf, String> {
    let file = PathBuf::from(name);
    match PictureFormat::ALL.iter().any(|(extension, _)| has_extension(&file, extension)) {
        true => Ok(file),
        false => Err("expected one of the extensions .svg, .pdf, .png".to_owned()),
    }
}

pub(super) fn run_plot(arguments: &PlotArguments) -> Result<ExitCode, Failure> {
    let PlotArguments { results, output, width, kind, quantity, by, cells, overwrite } = arguments;
    let outputs = overwrite.outputs(results.iter().map(PathBuf::as_path), [output])?;
    let drawn = match kind {
        Picture::Means => Drawn::Means,
        Picture::Differences => {
            let quantities = std::slice::from_ref(quantity);
            Drawn::Differences(Comparing::new(by.as_deref(), &[], quantities).map_err(input)?)
        }
        Picture::Map => Drawn::Map(usize::from(*cells)),
    };
    let files: Vec<Results> = results.iter().map(|file| Results::File(file)).collect();
    let format = PictureFormat::of(output);
    let (svg, notes) = picture(&files, quantity, &drawn, format.sheet(*width)).map_err(input)?;
    notes.iter().for_each(note);
    let written = match format {
        PictureFormat::Svg => Ok(svg.into_bytes()),
        PictureFormat::Pdf => pdf(&svg, width.unwrap_or(PRINTED)),
        PictureFormat::Png => png(&svg, width.unwrap_or(PRINTED)),
    };
    write_file(&outputs, output, written.map_err(input)?)?;
    print(&format!("wrote {}\n", output.display()))?;
    Ok(ExitCode::SUCCESS)
}
