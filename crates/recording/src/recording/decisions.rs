//! The attachment of a recording with the decisions of custom partners: replays repeat them.

use super::records::Attachment;
use super::{ReadError, Reader};
use cocarry::bounds;
use cocarry::scenario::{Decisions, MAX_MOTION};

/// The name of the attachment with the decisions.
pub const DECISIONS: &str = "decisions.json";

/// As an attachment; `None` for an empty log, or one that JSON cannot represent.
pub(super) fn attachment(decisions: &Decisions) -> Option<Attachment> {
    let data = serde_json::to_vec(decisions).ok().filter(|_| !decisions.is_empty())?;
    Some(Attachment { name: DECISIONS.to_owned(), media_type: "application/json".to_owned(), data })
}

/// Reads an attachment.
pub(super) fn read<R: std::io::Read>(
    reader: &Reader<R>,
    attachment: &Attachment,
) -> Result<Decisions, ReadError> {
    let lacks = |what: String| ReadError::Lacks { file: reader.name().to_owned(), what };
    let limit = bounds::DECISIONS.bytes();
    if attachment.data.len() as u64 > limit {
        return Err(lacks(format!("its attachment {DECISIONS} is larger than {limit} bytes")));
    }
    let log: Decisions = serde_json::from_slice(&attachment.data)
        .map_err(|error| lacks(format!("its attachment {DECISIONS} is not a log of decisions: {error}")))?;
    match log.is_bounded() {
        true => Ok(log),
        false => Err(lacks(format!("its attachment {DECISIONS} has a motion beyond {MAX_MOTION}"))),
    }
}
