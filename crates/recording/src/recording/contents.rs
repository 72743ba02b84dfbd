//! Summaries of the contents of recordings.

use super::decode::MAX_MESSAGE_BYTES;
use super::provenance::{METADATA, RECOVERED};
use super::{Channel, Entry, ReadError, Reader};
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::Read;

/// The largest number of attachments and metadata records that are listed.
const MAX_RECORDS: usize = 1000;
/// The largest number of channels that are listed.
const MAX_CHANNELS: usize = 10_000;

/// The contents of a recording.
#[derive(Clone, Debug, Default)]
pub struct Contents {
    /// Its provenance.
    pub provenance: BTreeMap<String, String>,
    /// The losses of a recovered recording; `None` if it was not recovered.
    pub recovered: Option<BTreeMap<String, String>>,
    /// Name, media type and length (bytes) of the attachments.
    pub attachments: Vec<(String, String, usize)>,
    /// The channels, by topic.
    pub channels: BTreeMap<String, ChannelContents>,
    /// The message on `/outcome`; `None` in an incomplete recording.
    pub outcome: Option<Value>,
    /// The last message on `/cost`.
    pub cost: Option<Value>,
}

/// The contents of a channel.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ChannelContents {
    /// The name of its schema.
    pub schema: String,
    /// The encoding of its messages.
    pub encoding: String,
    /// The number of messages.
    pub messages: u64,
    /// The times of the first and the last message, ns.
    pub span: Option<[u64; 2]>,
}

impl Contents {
    /// Reads a recording to its end.
    ///
    /// # Errors
    /// [`ReadError`].
    pub fn read<R: Read>(reader: &mut Reader<R>) -> Result<Self, ReadError> {
        let mut contents = Self::default();
        let mut listed = 0;
        let mut cost = Vec::new();
        let file = reader.name().to_owned();
        while let Some(entry) = reader.next()? {
            match entry {
                Entry::Metadata { name, entries } => {
                    listed += 1;
                    match &*name {
                        METADATA => contents.provenance = entries,
                        RECOVERED => contents.recovered = Some(entries),
                        _ => {}
                    }
                }
                Entry::Attachment(attachment) => {
                    listed += 1;
                    let length = attachment.data.len();
                    contents.attachments.push((attachment.name, attachment.media_type, length));
                }
                Entry::Channel { definition, .. } => {
                    let schema = definition.schema.as_ref().map_or(String::new(), |s| s.name.clone());
                    let encoding = definition.encoding.clone();
                    let fresh = ChannelContents { schema, encoding, ..ChannelContents::default() };
                    contents.channels.entry(definition.topic.clone()).or_insert(fresh);
                    if contents.channels.len() > MAX_CHANNELS {
                        let what = format!("has more than {MAX_CHANNELS} channels, too many to list");
                        return Err(ReadError::Lacks { file, what });
                    }
                }
                Entry::Message(message) => {
                    if let Some(channel) = contents.channels.get_mut(&message.channel.topic) {
                        channel.messages += 1;
                        let [first, last] = channel.span.unwrap_or([message.time; 2]);
                        channel.span = Some([first.min(message.time), last.max(message.time)]);
                    }
                    if message.data.len() <= MAX_MESSAGE_BYTES {
                        match Channel::of_topic(&message.channel.topic) {
                            Some(Channel::Cost) => {
                                cost.clear();
                                cost.extend_from_slice(message.data);
                            }
                            Some(Channel::Outcome) => {
                                contents.outcome = serde_json::from_slice(message.data).ok();
                            }
                            _ => {}
                        }
                    }
                }
            }
            if listed > MAX_RECORDS {
                let what =
                    format!("has more than {MAX_RECORDS} attachments and metadata records, too many to list");
                return Err(ReadError::Lacks { file, what });
            }
        }
        contents.cost = serde_json::from_slice(&cost).ok();
        Ok(contents)
    }

    /// The times of the first and the last message of all channels, ns; `None` without messages.
    pub fn span(&self) -> Option<[u64; 2]> {
        let spans = self.channels.values().filter_map(|c| c.span);
        spans.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
    }
}
