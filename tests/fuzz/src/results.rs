//! Tables: of participants, and of results.

use crate::file;
use cocarry_studies::fit::{AnswerFile, EvidenceKind, SwitchFile};
use cocarry_studies::study::{Comparing, Results, Summary};

pub fn answers(bytes: &[u8]) {
    let file = file("answers.csv", bytes);
    match EvidenceKind::of(&file) {
        Ok(EvidenceKind::Answers) => drop(AnswerFile::read(&file)),
        Ok(EvidenceKind::Switches) => drop(SwitchFile::read(&file)),
        Err(_) => {}
    }
}

pub fn rows(bytes: &[u8]) {
    let _ = Summary::load(&[Results::File(&file("rows.csv", bytes))], &Comparing::default());
}

pub fn columns(bytes: &[u8]) {
    let _ = Summary::load(&[Results::File(&file("rows.parquet", bytes))], &Comparing::default());
}
