//! A page about a study for an ethics board, from the study file alone: what participants read and do, what is
//! stored of them, and how it is removed.

use crate::collect::flags;
use crate::html::{STYLE, escaped, page, paragraphs, table};
use crate::order::orders;
use crate::site::{Sink, Site};
use crate::store::{MAX_CHUNK_BYTES, MAX_SESSION_BYTES};
use crate::study::{PeopleStudy, ScaleKind, Task};
use crate::walk::Shots;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use cocarry::Error;
use std::fmt::Write;
use std::path::Path;

/// The page about a study. Equal studies give equal bytes.
///
/// # Errors
/// The scenario of a carry cannot be written.
pub fn ethics_page(study: &PeopleStudy) -> Result<String, Error> {
    let digest = Site::new(study, Sink::Server, None)?.digest;
    let parts = [
        format!("<h1>{}</h1>\n", escaped(&study.title)),
        about(study, &digest),
        "<h2>Consent</h2>\n".to_owned(),
        consent(study),
        "<h2>What participants are asked</h2>\n".to_owned(),
        course(study),
        tasks(study),
        questions(study),
        scales(study),
        end(study),
        "<h2>What is stored</h2>\n".to_owned(),
        stored(study),
        not_stored(),
        "<h2>How long, and who can read it</h2>\n".to_owned(),
        kept(study),
        "<h2>How it is removed</h2>\n".to_owned(),
        removed(study),
        "<h2>Exclusions</h2>\n".to_owned(),
        exclusions(),
        "<h2>Risks, and what is not measured</h2>\n".to_owned(),
        risks(study),
    ];
    Ok(page(
        &format!("{}: for the ethics board", study.title),
        &format!("<style>\n{STYLE}</style>"),
        &parts.concat(),
    ))
}

/// The name of a file without its folder, which is different on every computer.
fn name(file: &Path) -> String {
    escaped(&file.file_name().unwrap_or_default().to_string_lossy())
}

fn about(study: &PeopleStudy, digest: &str) -> String {
    format!(
        "<p class=\"quiet\">Written by cocarry {} from <code>{}</code>. Version of what participants see: <code>{}</code>. \
         It describes the study as <code>cocarry study serve</code> runs it; on the host of others their rules hold too.</p>\n",
        env!("CARGO_PKG_VERSION"),
        name(&study.file),
        &digest[..12],
    )
}

fn consent(study: &PeopleStudy) -> String {
    let [version, text] = &study.consent;
    format!(
        "<p>Version {}. Everybody reads this first, and nothing is asked before the box “I have read this and take part of my own \
         will” is ticked. The version is stored with the participant.</p>\n<blockquote>\n{}</blockquote>\n",
        escaped(version),
        paragraphs(text)
    )
}

fn course(study: &PeopleStudy) -> String {
    let orders = orders(study);
    let order = match (study.has_latin_square, orders.len()) {
        (true, 2..) => format!(
            "The worlds come in one of {} orders (a Latin square by the participant's number).",
            orders.len()
        ),
        _ => "The worlds come in the same order for everybody.".to_owned(),
    };
    format!(
        "<p>At most {} participants; {} pages each. {order} A participant may stop at any time by closing the page, and go on later in \
         the same browser. Every task begins with {}.</p>\n",
        study.participants,
        orders[0].len(),
        match study.has_practice {
            true => "one practice answer, which does not count",
            false => "the first answer that counts",
        }
    )
}

fn tasks(study: &PeopleStudy) -> String {
    let mut html = String::new();
    for (task, text) in study.tasks.iter().zip(&study.instructions) {
        let does = match task {
            Task::Percentages => {
                "The participant sees the map of a world and divides 100 % between the ways on it."
            }
            Task::Switch => {
                "The participant watches a robot lead on each way, and stops it by a key or a button, or never."
            }
            Task::Carry => {
                "The participant moves the hand of a simulated person by mouse, touch or keys; a simulated robot carries with them."
            }
        };
        // writing to a text does not fail
        let _ = write!(
            html,
            "<h3>Task “{}”</h3>\n<p>{does}</p>\n<blockquote>\n{}</blockquote>\n",
            task.name(),
            paragraphs(text)
        );
    }
    html += "<h3>The maps</h3>\n";
    for world in &study.worlds[..study.measured_worlds()] {
        let map = Shots::of(world, study.shows_openings).map;
        let name = escaped(&world.name);
        let _ = writeln!(
            html,
            "<figure><img src=\"data:image/svg+xml;base64,{}\" alt=\"Map of {name} with the ways on it\"><figcaption class=\"quiet\">{name}</figcaption></figure>",
            BASE64_STANDARD.encode(map)
        );
    }
    html
}

fn questions(study: &PeopleStudy) -> String {
    if study.questions.is_empty() {
        return String::new();
    }
    let row = |question: &crate::study::Question| {
        vec![
            question.text.clone(),
            question.answers.join(" / "),
            question.answers[question.right].clone(),
            question.attempts.to_string(),
        ]
    };
    let rows: Vec<_> = study.questions.iter().map(row).collect();
    table("Questions that show whether somebody reads", &["question", "answers", "right", "attempts"], &rows)
}

fn scales(study: &PeopleStudy) -> String {
    let mut rows = Vec::new();
    for scale in &study.scales {
        let range = match scale.kind {
            ScaleKind::NasaTlx => "0 to 100 (NASA Task Load Index)".to_owned(),
            ScaleKind::Likert | ScaleKind::Fluency => {
                format!("1 ({}) to {} ({})", scale.ends[0], scale.points, scale.ends[1])
            }
        };
        let item = |item: &&str| vec![scale.name.clone(), (*item).to_owned(), range.clone()];
        rows.extend(scale.items().iter().map(item));
    }
    match rows.is_empty() {
        true => String::new(),
        false => table("Scales", &["scale", "statement", "answers"], &rows),
    }
}

fn end(study: &PeopleStudy) -> String {
    let code = match &study.end.code {
        Some(_) => "the same completion code for everybody",
        None => "a completion code of their own",
    };
    let redirect = study
        .end
        .redirect
        .as_ref()
        .map_or(String::new(), |address| format!(" A link leads to <code>{}</code>.", escaped(address)));
    format!(
        "<h3>The end</h3>\n<p>The last page shows {code}, and the participant's number.{redirect}</p>\n<blockquote>\n{}</blockquote>\n",
        paragraphs(&study.end.text)
    )
}

fn stored(study: &PeopleStudy) -> String {
    let database = study.database();
    let database = database.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let row = |what: &str, place: &str, why: &str| [what, place, why].map(str::to_owned).to_vec();
    let mut rows = vec![
        row(
            "a pseudonym, computed with a secret of the database; the participant's number",
            &database,
            "joins answers, without a name",
        ),
        row(
            "when the participant began and finished, and when each part arrived",
            &database,
            "progress; the server's clock",
        ),
        row("the version of the consent, and of what was shown", &database, "what was agreed to"),
        row(
            "answers to maps, questions and scales, and every change on the way to them, with times",
            &database,
            "the data of the study",
        ),
        row(
            "the size of the browser's window and the time by its clock when a page began; when the page was hidden",
            &database,
            "to judge the data",
        ),
    ];
    if study.tasks.contains(&Task::Switch) {
        rows.push(row(
            "of a walk: the step and time of stopping, and pictures that came late",
            &database,
            "the data of the study",
        ));
    }
    if study.has_carry() {
        rows.push(row("of a carry: where the hand was at every step, keys pressed for it, who led, and the whole simulated episode", &database, "the data of the study; it is run again from this"));
    }
    if !study.platform_ids.is_empty() {
        let what = format!("from the address of the page: {}", study.platform_ids.join(", "));
        let place = format!("{database}, in a table of its own");
        rows.push(row(
            &what,
            &place,
            "so that a person takes part once; in no table that is written for analysis",
        ));
    }
    rows.push(row(
        "a random key, and what has not been sent yet",
        "the participant's browser (IndexedDB)",
        "so that nothing is lost; answers are removed there at the end, the completion code stays for a reload",
    ));
    let sizes = format!(
        "<p>A part that is sent has at most {} MiB, all of a participant at most {} MiB. Answers are sent every second, also those of \
         participants who leave before the end.</p>\n",
        MAX_CHUNK_BYTES >> 20,
        MAX_SESSION_BYTES >> 20
    );
    table("What is stored, and where", &["what", "where", "why"], &rows) + &sizes
}

fn not_stored() -> String {
    "<p><strong>Not stored:</strong> network addresses, names, cookies, the kind of browser or computer, pictures, sound, what other \
     pages or programs are open. The page loads nothing from other hosts, and sends nothing to them. A proxy before the server, and a \
     recruiting platform, may keep more: their settings decide.</p>\n"
        .to_owned()
}

fn kept(study: &PeopleStudy) -> String {
    let database = name(&study.database());
    format!(
        "<p>Nothing is deleted by itself: it is stored until it is removed, as below, or until those who run the study delete \
         <code>{database}</code>.</p>\n<p>The file is not encrypted by the program. Whoever can read the files of the account under which \
         the study runs can read it; they also see progress and tables on the administrator's page, which this computer alone can open, \
         with a random token of each start. Participants can read their own answers in their browser, and nobody else's. On the way, \
         answers are protected by the encryption of the address (https).</p>\n\
         <p>The tables for analysis (<code>cocarry study collect</code>) have pseudonyms and no identity of a recruiting platform.</p>\n"
    )
}

fn removed(study: &PeopleStudy) -> String {
    let file = name(&study.file);
    format!(
        "<p>The last page shows a participant their number. Whoever wants their answers removed gives this number, or their identity at \
         the recruiting platform, to those who run the study:</p>\n<p><code>cocarry study forget {file} NUMBER</code></p>\n\
         <p>It removes session, answers and identities, overwrites their place in the file, then searches the files of the database for \
         pseudonym, key and identities, and fails if one is still there. It does not reach tables that were written before (they are \
         written anew), backups, copies given to others, and what a disk keeps of overwritten blocks.</p>\n"
    )
}

fn exclusions() -> String {
    let rows: Vec<_> =
        flags::ALL.iter().map(|&(flag, meaning)| vec![flag.to_owned(), meaning.to_owned()]).collect();
    "<p>The program excludes nobody. It marks participants, and those who run the study decide by rules that they write down before. \
     Who did not finish is a row of the table of participants; their answers are in the other tables only if asked for.</p>\n"
        .to_owned()
        + &table("Flags", &["flag", "meaning"], &rows)
}

fn risks(study: &PeopleStudy) -> String {
    let carry = match study.has_carry() {
        true => " In the task “carry” robot and object are simulated: the hand is a pointer in a picture.",
        false => "",
    };
    format!(
        "<p>The participant sits at a page. It measures choices and their timing, not forces: a mouse is not a beam in the hands.{carry} \
         No robot moves, nothing is carried, and no force acts on anybody. Pages can be used by keyboard alone, and on a phone.</p>\n"
    )
}
