//! A summary of what is in a recording.

use super::decode::LONGEST;
use super::provenance::{METADATA, RECOVERED};
use super::{Channel, Entry, ReadError, Reader};
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::Read;

/// The most attachments and metadata records that are listed.
const MOST: usize = 1000;

/// What is in a recording.
#[derive(Clone, Debug, Default)]
pub struct Contents {
    /// Where it comes from.
    pub provenance: BTreeMap<String, String>,
    /// What was lost, where it was recovered from a cut one.
    pub recovered: Option<BTreeMap<String, String>>,
    /// Name, media type and length (B) of the attachments.
    pub attachments: Vec<(String, String, usize)>,
    /// The channels, by topic.
    pub channels: BTreeMap<String, ChannelContents>,
    /// The message on `/outcome`; `None` where the recording was cut.
    pub outcome: Option<Value>,
    /// The last message on `/cost`.
    pub cost: Option<Value>,
}

/// What is on a channel.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ChannelContents {
    /// Name of its schema.
    pub schema: String,
    /// How messages are encoded.
    pub encoding: String,
    /// How many there are.
    pub messages: u64,
    /// Time of the first and the last, ns.
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
                }
                Entry::Message(message) => {
                    if let Some(channel) = contents.channels.get_mut(&message.channel.topic) {
                        channel.messages += 1;
                        let [first, last] = channel.span.unwrap_or([message.time; 2]);
                        channel.span = Some([first.min(message.time), last.max(message.time)]);
                    }
                    if message.data.len() <= LONGEST {
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
            if listed > MOST {
                let what =
                    format!("has more than {MOST} attachments and metadata records; so many are not listed");
                return Err(ReadError::Lacks { file, what });
            }
        }
        contents.cost = serde_json::from_slice(&cost).ok();
        Ok(contents)
    }

    /// From the first message to the last, ns; `None` without messages.
    pub fn span(&self) -> Option<[u64; 2]> {
        let spans = self.channels.values().filter_map(|c| c.span);
        spans.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
    }
}
