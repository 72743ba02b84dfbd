//! Simulated participants who answer on the page itself, in browsers.

use crate::order::orders;
use crate::simulate::{Answers, Truth, answers};
use crate::site::{Sink, Site};
use crate::store::{Store, StoreError};
use crate::study::PeopleStudy;
use cocarry::Error;
use serde_json::{Map, Value, json};
use std::borrow::Cow;

/// The parameter of the page's address that says which participant answers.
const PARAMETER: &str = "simulated";

/// Simulated participants, and the browsers in which they answer.
#[derive(Clone, Copy, Debug)]
pub struct Browsers {
    /// The number of participants.
    pub participants: u64,
    /// The seed of the draws.
    pub seed: u64,
    /// The number of browsers. Participant i answers in browser i modulo this number.
    pub at_once: u64,
}

impl Browsers {
    /// The page of a study as [`Site::new`] makes it, with a script that answers it as these participants
    /// would. They are those of [`simulate`](crate::simulate()).
    ///
    /// # Errors
    /// As [`Site::new`].
    pub fn site(&self, study: &PeopleStudy, module: Option<Cow<'static, [u8]>>) -> Result<Site, Error> {
        let orders = orders(study);
        let person = |i| {
            let next = Some(i + self.at_once).filter(|next| *next < self.participants);
            let plan = json!({
                "answers": answers(study, &orders[i as usize % orders.len()], self.seed, i).pages,
                "leads": i % 2 == 1,
                "next": next.map(|next| self.query(next)),
            });
            (identity(i), plan)
        };
        let people: Map<String, Value> = (0..self.participants).map(person).collect();
        let plan = json!({ "parameter": PARAMETER, "people": people });
        Ok(Site::new(study, Sink::Server, module)?.answering(PARAMETER, &plan))
    }

    /// The end of the page's address by which a participant begins. A browser goes on with its others.
    pub fn query(&self, participant: u64) -> String {
        format!("?{PARAMETER}={}", identity(participant))
    }

    /// What the participants are who answered into a store, by their numbers there.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn truths(&self, study: &PeopleStudy, store: &Store) -> Result<Vec<Truth>, StoreError> {
        let mut truths = Vec::new();
        for person in 0..self.participants {
            let Answers { perception, eta, .. } = answers(study, &[], self.seed, person);
            let participants = store.participants_of(&identity(person))?;
            let truth = |participant| Truth { participant, perception, eta };
            truths.extend(participants.into_iter().map(truth));
        }
        Ok(truths)
    }
}

/// By which the store knows a simulated participant.
fn identity(participant: u64) -> String {
    format!("{PARAMETER}-{participant}")
}
