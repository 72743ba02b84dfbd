//! Recordings with what is in them, and snapshots.

use super::Bench;
use crate::forged_snapshots::{closed, opened};
use crate::limits::{attachment, channel, message, packed};
use crate::recording::{MAGIC, encoded, example, rapier, record, unpacked};
use cbor4ii::core::Value;
use cocarry::episode::EpisodeSettings;
use cocarry::scenario::{Plant, Scenario, WorldText};

/// As much as a recording may unpack to: its first half is an attachment, from which the other half's length
/// follows.
pub(super) fn recordings(bench: Bench) {
    let filler = attachment("filler", &vec![b'x'; bench.longest() - (1 << 20)]);
    let empty = message(b"").repeat(900_000);
    let wide = message(format!("[{}0]", "0,".repeat(2000)).as_bytes()).repeat(7000);
    for (chunk, lines) in [
        (empty, &["inspect m.mcap", "recover m.mcap -o out.mcap --overwrite"][..]),
        (wide, &["inspect m.mcap", "inspect m.mcap --csv /t --output out.csv --overwrite"]),
    ] {
        // 16 MiB of file may unpack to 100 times as much; a table has at most 20 million cells
        let count = if lines[1].contains("csv") { 1 } else { 50 };
        let chunks: Vec<_> = std::iter::once(channel("/t")).chain(vec![chunk; count]).collect();
        let end = [record(15, &[0; 4]), record(2, &[0; 20]), MAGIC.to_vec()].concat();
        let file = [MAGIC, &filler, &packed(&chunks)[MAGIC.len()..], &end].concat();
        assert!(file.len() < bench.longest());
        bench.write("m.mcap", file);
        lines.iter().for_each(|line| drop(bench.reads(line)));
    }
    // a record, and a chunk, that are longer than any
    for length in [32 << 20, (32 << 20) + 1] {
        let file = [MAGIC, &record(9, &[])[..1], &(length as u64).to_le_bytes(), &vec![0; length]].concat();
        bench.write("m.mcap", file);
        let words = if length > 32 << 20 { "at most 33554432" } else { "m.mcap" };
        bench.refuses("inspect m.mcap", words);
    }
    let zeros = packed(&[vec![0; (32 << 20) + 1]]);
    bench.write("m.mcap", [MAGIC, &filler, &zeros[MAGIC.len()..]].concat());
    bench.refuses("inspect m.mcap", "at most 33554432");
}

/// A short recording with one attachment changed or added.
fn with_attachment(whole: &[u8], name: &str, data: &[u8]) -> Vec<u8> {
    // before the scenario nothing is looked for, and behind the messages the decisions are
    let is_scenario = name == "scenario.toml";
    let mut bytes = MAGIC.to_vec();
    if is_scenario {
        bytes.extend(attachment(name, data));
    }
    let mut rest = &whole[MAGIC.len()..whole.len() - MAGIC.len()];
    while !rest.is_empty() {
        let length = 9 + u64::from_le_bytes(rest[1..9].try_into().unwrap()) as usize;
        let (one, after) = rest.split_at(length);
        let is_same = one[0] == 9 && one.windows(name.len()).any(|window| window == name.as_bytes());
        // without a summary
        if one[0] == 15 {
            if !is_scenario {
                bytes.extend(attachment(name, data));
            }
            bytes.extend(one);
            break;
        }
        if !is_same {
            bytes.extend(one);
        }
        rest = after;
    }
    bytes.extend(record(2, &[0; 20]));
    bytes.extend(MAGIC);
    bytes
}

fn short(plant: Plant) -> (Scenario, Vec<u8>) {
    let scenario = example(plant);
    let settings = EpisodeSettings { tick_limit: Some(2), ..scenario.settings };
    let scenario = Scenario { settings, ..scenario };
    (scenario.clone(), unpacked(&encoded(scenario, |_| {}).0))
}

pub(super) fn scenarios(bench: Bench) {
    for plant in [Plant::Point, rapier()] {
        let (scenario, whole) = short(plant);
        let text = bench.filled(&scenario.text().unwrap(), "\n# x");
        bench.write("m.mcap", with_attachment(&whole, "scenario.toml", text.as_bytes()));
        bench.reads("replay m.mcap");
        bench.write("m.mcap", with_attachment(&whole, "scenario.toml", (text + "\n").as_bytes()));
        bench.refuses("replay m.mcap", "scenario.toml is larger than 25165824 bytes");
    }
    let (_, whole) = short(Plant::Point);
    for piece in ["a=[[[],[],[],", "[[changes]]\n", "x.y.z=1\n", "[a.b.c.d.e]\n"] {
        let text = bench.filled("", piece);
        bench.write("m.mcap", with_attachment(&whole, "scenario.toml", text.as_bytes()));
        bench.refuses("replay m.mcap", "m.mcap");
    }
}

pub(super) fn decisions(bench: Bench) {
    let (_, whole) = short(Plant::Point);
    let human = "{\"option\":0,\"stance\":\"Follow\",\"stubbornness\":0,\"discomfort\":0}";
    for (begin, piece, end) in [
        ("{\"human\":[", human, "]}"),
        ("{\"hands\":{\"0\":[", "null", "]}}"),
        ("{\"hands\":{\"0\":[]", "\"1\":[]", "}}"),
    ] {
        let count = (bench.longest() - begin.len() - end.len()) / (piece.len() + 1);
        let mut pieces = vec![piece.to_owned(); count];
        if piece.starts_with("\"1\"") {
            pieces = (1..(bench.longest() - 100) / 14).map(|i| format!("\"{i}\":[]")).collect();
        }
        let separator = if begin.ends_with(']') { "," } else { "" };
        let text = format!("{begin}{separator}{}{end}", pieces.join(","));
        let text = bench.filled(&text, " ");
        bench.write("m.mcap", with_attachment(&whole, "decisions.json", text.as_bytes()));
        let output = bench.run("replay m.mcap");
        assert!(matches!(output.status.code(), Some(0 | 1)), "{begin}: {output:?}");
        bench.write("m.mcap", with_attachment(&whole, "decisions.json", (text + " ").as_bytes()));
        bench.refuses("replay m.mcap", "decisions.json is larger than");
    }
    for piece in ["[", "{\"a\":", "[],", "{\"human\":[", "\""] {
        let text = bench.filled("", piece);
        bench.write("m.mcap", with_attachment(&whole, "decisions.json", text.as_bytes()));
        bench.refuses("replay m.mcap", "decisions.json is not a log of decisions");
    }
}

/// Calls `act` with every list of a snapshot.
fn lists(value: &mut Value, act: &mut dyn FnMut(&mut Vec<Value>)) {
    match value {
        Value::Tag(_, inner) => lists(inner, act),
        Value::Map(items) => items.iter_mut().for_each(|(_, value)| lists(value, act)),
        Value::Array(items) => {
            items.iter_mut().for_each(|value| lists(value, act));
            act(items);
        }
        _ => {}
    }
}

/// The kinds of the values in an item.
fn kind(item: &Value) -> String {
    match item {
        Value::Array(items) => format!("[{}]", items.iter().map(kind).collect::<String>()),
        Value::Map(items) => format!("{{{:?}}}", items.iter().map(|(key, _)| key).collect::<Vec<_>>()),
        Value::Float(_) | Value::Integer(_) => "number ".to_owned(),
        other => format!("{other:?} "),
    }
}

pub(super) fn snapshots(bench: Bench) {
    let scenario = Scenario {
        settings: EpisodeSettings { tick_limit: Some(3), ..EpisodeSettings::default() },
        ..example(rapier())
    };
    let of = |scenario: &Scenario| {
        let prepared = scenario.clone().prepare().unwrap();
        let mut episode = prepared.episode().unwrap();
        episode.step();
        prepared.snapshot(&episode).bytes().unwrap()
    };
    // a world of comments
    let padded = |missing: usize| {
        let text = format!("{}#{}", scenario.world.text(), "x".repeat(missing));
        let world = WorldText { file: scenario.world.file().to_owned(), text }.into();
        of(&Scenario { world, ..scenario.clone() })
    };
    let plain = of(&scenario);
    let missing = bench.longest() - padded(1 << 20).len() + (1 << 20);
    let longest = padded(missing);
    assert_eq!(longest.len(), bench.longest());
    bench.write("s", longest);
    let output = bench.run("run --resume s");
    assert!(matches!(output.status.code(), Some(0 | 3)), "{output:?}");
    bench.write("s", padded(missing + 1));
    bench.refuses("run --resume s", "larger than 33554432 bytes");
    // every list with as many of its own items, and of small ones, as fit
    let (head, contents) = opened(&plain);
    let mut count = 0;
    lists(&mut contents.clone(), &mut |_| count += 1);
    let mut seen = std::collections::BTreeSet::new();
    for which in 0..count {
        for small in [None, Some(Value::Array(Vec::new()))] {
            let (mut contents, mut at) = (contents.clone(), 0);
            let mut is_new = false;
            lists(&mut contents, &mut |items| {
                at += 1;
                if at - 1 != which {
                    return;
                }
                let Some(item) = small.clone().or_else(|| items.first().cloned()) else { return };
                let length = cbor4ii::serde::to_vec(Vec::new(), &item).unwrap().len();
                // a long item takes no more memory than its length; of equal lists one is enough
                is_new = length <= 16 && seen.insert(format!("{} {small:?}", kind(&item)));
                if is_new {
                    *items = vec![item; (bench.longest() - plain.len()) / length.max(1)];
                }
            });
            if is_new {
                bench.write("s", closed(head, contents));
                let output = bench.run("run --resume s");
                assert!(matches!(output.status.code(), Some(0 | 2 | 3)), "{which}, {small:?}: {output:?}");
            }
        }
    }
    assert!(count > 10, "{count}");
}
