//! What the page of a recording needs to hand the episode to the page that runs the simulator, where its reader takes
//! over from the human.

use crate::recording::{Channel, Playback};
use cocarry::Error;
use cocarry::scenario::EpisodeLog;
use serde_json::{Value, json};

/// The port at which `cocarry demo` serves the page that runs the simulator, if it is free.
pub const DEMO_PORT: u16 = 8790;

/// The address of that page.
pub fn demo_address() -> String {
    format!("http://127.0.0.1:{DEMO_PORT}/")
}

/// The scenario, the decisions so far and the address of the simulator's page; or why the episode cannot go on there.
pub(super) fn take_over(playback: &Playback, address: &str) -> Result<Value, Error> {
    let Playback { prepared, decisions, .. } = playback;
    if decisions.has_custom_policy() || decisions.has_custom_human() {
        let sentence = "This episode cannot be taken over: a program decided for the human or the robot, and the \
                        recording has its decisions but not the program.";
        return Ok(json!({ "refused": sentence }));
    }
    let scenario = prepared.scenario().text()?;
    let log = (!decisions.is_empty()).then(|| EpisodeLog {
        version: EpisodeLog::VERSION,
        // the page fills it in: it is next to the log
        scenario: String::new(),
        arithmetic: String::new(),
        decisions: decisions.clone(),
        digests: Vec::new(),
        steps: playback.messages(Channel::Coordination).len() as u64,
        outcome: None,
    });
    Ok(json!({ "address": address, "scenario": scenario, "log": log }))
}
