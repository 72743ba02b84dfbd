//! Studies with people: a study file, the page on which participants answer, its server, the store of what they
//! answer, and the tables that `cocarry fit` and `cocarry infer` read.
//!
//! ```text
//! study file -> PeopleStudy -> Site -> page -> chunks -> Store -> Collected -> answers.csv, switches.csv, ...
//! tables -> StudyTables -> report; simulated people -> power
//! ```
//!
//! What a participant sees and answers is measured on a page: choices and timing, not forces. A mouse is not
//! a beam in the hands.

mod browser;
mod carry;
mod collect;
mod digest;
mod ethics;
mod html;
mod import;
mod order;
mod power;
mod report;
mod server;
mod simulate;
mod site;
mod store;
mod study;
mod walk;

pub use browser::Browsers;
pub use carry::carry_scenario;
pub use collect::{Collected, CollectedCarry, carries_table, collect};
pub use ethics::ethics_page;
pub use import::{Added, add_file};
pub use order::{Trial, orders};
pub use power::{Effect, PowerRow, PowerSettings, power, power_document};
pub use report::{
    Carried, MEASURES, MIN_PEOPLE, Matched, Measure, ReportSettings, StudyPerson, StudyTables, report,
    report_units,
};
pub use server::{Admin, Serving, serve, token};
pub use simulate::{Truth, simulate};
pub use site::{Sink, Site, SiteFile};
pub use store::{Begin, Chunk, Forgotten, Put, Refusal, Session, Store, StoreError, StoredSession};
pub use study::{End, MAX_PARTICIPANTS, PeopleStudy, Question, Scale, ScaleKind, StudyWorld, TEMPLATE, Task};
