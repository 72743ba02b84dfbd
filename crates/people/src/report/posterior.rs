//! The posterior of every person and of the population, as `cocarry infer` has it.

use super::MAX_DRAWN;
use cocarry::Error;
use cocarry_output::drawing::{IntervalMarks, IntervalPanel, IntervalRow, intervals};
use cocarry_studies::fit::{
    Figure as Distribution, HeldOut, Inference, InferenceSettings, Person, Population,
};
use cocarry_studies::report::{Block, Figure, people_columns, population_table, shown_interval};
use cocarry_studies::table::{Columns, Table};

pub(super) fn blocks(inference: &Inference, settings: &InferenceSettings) -> Result<Vec<Block>, Error> {
    let mut blocks = Vec::new();
    match &inference.population {
        Some(population) => {
            blocks.push(Block::Table(population_table(population)));
            blocks.push(Block::Figure(population_picture(population)?));
        }
        None => blocks.push(Block::Text(
            "No population of \u{3b1} and \u{3b3}: that needs percentages of two participants or more."
                .to_owned(),
        )),
    }
    blocks.push(Block::Table(people(inference, settings)));
    blocks.push(Block::Figure(picture(&inference.people)?));
    if !inference.held_out.is_empty() {
        blocks.push(Block::Table(held_out(&inference.held_out)));
    }
    Ok(blocks)
}

fn shown(figure: Option<Distribution>) -> String {
    let text = |f: Distribution| {
        let [half, most] = [f.interval_50, f.interval].map(|ends| shown_interval(ends, 2));
        format!("{:.2} ({half}; {most})", f.median)
    };
    figure.map_or("-".to_owned(), text)
}

fn people(inference: &Inference, settings: &InferenceSettings) -> Table {
    let is_asked = |person: &Person| person.answers + person.sightings > 0;
    people_columns(&inference.people)
        .derived("alpha", move |p| shown(is_asked(p).then_some(p.alpha)))
        .derived("gamma", move |p| shown(is_asked(p).then_some(p.gamma)))
        .derived("eta", |p| shown(p.eta))
        .table("people", "Posterior of each participant: median (50 % interval; 95 % interval)")
        .with_note(format!(
            "Each from the participant's own answers; lapse rate {}. The CSV file also has them within the population ({} draws, seed {}).",
            settings.lapse_rate,
            settings.draws * cocarry_studies::fit::CHAINS,
            settings.seed
        ))
}

/// The row of a distribution in a picture.
fn row(label: &str, figure: Option<Distribution>, reference: Option<f64>) -> IntervalRow {
    IntervalRow {
        label: label.to_owned(),
        estimate: figure.map(|f| f.median),
        intervals: figure.map_or([None; 2], |f| [Some(f.interval_50), Some(f.interval)]),
        reference,
    }
}

fn picture(people: &[Person]) -> Result<Figure, Error> {
    let drawn = &people[..people.len().min(MAX_DRAWN)];
    let is_asked = drawn.iter().any(|person| person.answers > 0);
    let panel = |title: &str, rows: Vec<IntervalRow>| IntervalPanel {
        title: title.to_owned(),
        rows,
        ..IntervalPanel::default()
    };
    let perceived = |which: usize| {
        let of = |p: &Person| {
            let within = p.within_population.map(|figures| figures[which].median);
            let own = if which == 0 { p.alpha } else { p.gamma };
            row(&p.participant, (p.answers > 0).then_some(own), within)
        };
        drawn.iter().map(of).collect()
    };
    let mut panels = Vec::new();
    if is_asked {
        panels.extend([panel("\u{3b1}", perceived(0)), panel("\u{3b3}", perceived(1))]);
    }
    if drawn.iter().any(|person| person.eta.is_some()) {
        panels.push(panel("\u{3b7}", drawn.iter().map(|p| row(&p.participant, p.eta, None)).collect()));
    }
    let has_population = drawn.iter().any(|person| person.within_population.is_some());
    let marks = IntervalMarks {
        estimate: "median, 95 %",
        narrow: "50 %",
        reference: if has_population { "within the population" } else { "" },
    };
    let few = match people.len() > MAX_DRAWN {
        true => format!(" The first {MAX_DRAWN} of {} participants.", people.len()),
        false => String::new(),
    };
    Ok(Figure {
        name: "people".to_owned(),
        caption: format!("Every participant's posterior: median, 50 % and 95 % intervals.{few}"),
        is_half: false,
        svg: intervals(&panels, true, marks)?,
    })
}

fn population_picture(population: &Population) -> Result<Figure, Error> {
    let panel = |title: &str, [mean, spread]: [usize; 2]| {
        let both = |which: usize| (population.posterior[which], population.prior[which]);
        let rows = [("mean", both(mean)), ("spread", both(spread))];
        let of = |(name, (posterior, prior)): (&str, (Distribution, Distribution))| {
            [row(name, Some(posterior), None), row(&format!("{name}, a priori"), Some(prior), None)]
        };
        IntervalPanel {
            title: title.to_owned(),
            rows: rows.into_iter().flat_map(of).collect(),
            ..IntervalPanel::default()
        }
    };
    let panels = [panel("\u{3b1} over people", [0, 1]), panel("\u{3b3} over people", [2, 3])];
    let marks = IntervalMarks { estimate: "median, 95 %", narrow: "50 %", reference: "" };
    Ok(Figure {
        name: "population".to_owned(),
        caption: "Mean and standard deviation of \u{3b1} and \u{3b3} over people: posterior, and what was assumed before."
            .to_owned(),
        is_half: false,
        svg: intervals(&panels, true, marks)?,
    })
}

fn held_out(rows: &[HeldOut]) -> Table {
    Columns::of(rows)
        .text("held out", "world", |row| row.world.clone().unwrap_or_else(|| "all".to_owned()))
        .count("answers", "answers", |row| row.answers as u64)
        .number("own posterior", "posterior_log_score", 3, |row| row.posterior.log_score.unwrap_or(f64::NEG_INFINITY))
        .number("prior", "prior_log_score", 3, |row| row.prior.log_score.unwrap_or(f64::NEG_INFINITY))
        .number("hits, own posterior", "posterior_hits", 2, |row| row.posterior.hits)
        .number("hits, prior", "prior_hits", 2, |row| row.prior.hits)
        .table("held-out", "Answers in a world, predicted from the participant's other worlds: mean log score, and share of hits")
        .with_note("A hit: the most probable option has the largest percentage. prior: P_o with the default ranges.")
}
