//! Truncated, damaged and hostile files: refused with the place, and nothing else.

use super::{MAGIC, chunk, chunks, messages, rapier, record, short, short_on, unpacked};
use crate::support::repository;
use cocarry::scenario::{Plant, Scenario};
use cocarry_recording::recording::{Contents, Reader, columns, recover, replay};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::path::Path;
use std::time::Duration;

/// The error that reading gives.
fn fault(bytes: &[u8]) -> String {
    match Reader::new(bytes, "bad.mcap").and_then(|mut reader| Contents::read(&mut reader)) {
        Ok(_) => panic!("it was read"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn bad_files_are_told_with_their_place() {
    let whole = short();
    assert_eq!(
        fault(b""),
        "bad.mcap: is not an MCAP file: it must begin with the bytes 89 4d 43 41 50 30 0d 0a"
    );
    assert!(fault(b"not an MCAP file").contains("is not an MCAP file"));
    assert!(fault(&whole[..5]).contains("is cut at byte 5"));
    assert!(fault(&whole[..whole.len() - 3]).contains("in the last bytes"));
    assert!(fault(&[&whole[..], b"x"].concat()).contains("nothing else"));
    let mut long = whole.clone();
    long[9..17].copy_from_slice(&u64::MAX.to_le_bytes());
    let said = fault(&long);
    assert!(said.contains("the header at byte 8 would be 18446744073709551615 bytes long"), "{said}");
    let mut flipped = whole.clone();
    let middle = flipped.len() / 2;
    flipped[middle] ^= 4;
    let said = fault(&flipped);
    assert!(said.contains("at byte") && said.starts_with("bad.mcap: "), "{said}");
    // a bomb, honest and not, and other hostile chunks
    let zeros = zstd::bulk::compress(&vec![0; 30 << 20], 3).unwrap();
    let honest = chunk(1 << 40, 0, "zstd", &zeros);
    assert!(fault(&honest).contains("the contents of a chunk at byte 8 would be 1099511627776 bytes long"));
    assert!(fault(&chunk(1000, 0, "zstd", &zeros)).contains("a chunk at byte 8: it cannot be unpacked"));
    assert!(
        fault(&chunk(10, 0, "zstd", &zstd::bulk::compress(&[0; 9], 3).unwrap())).contains("should be 10")
    );
    assert!(fault(&chunk(4, 7, "", b"abcd")).contains("checksum"));
    assert!(
        fault(&chunk(4, 0, "lz4", b"abcd")).contains("its compression is `lz4`; only zstd and none are read")
    );
    assert!(fault(&chunk(4, 0, "", b"abcd")).contains("a record is longer than the rest of it"));
    let lost = record(5, &[[7, 0].as_slice(), &[0; 20]].concat());
    assert!(
        fault(&chunk(lost.len() as u64, 0, "", &lost)).contains("is on channel 7, which was not defined")
    );
    let mut greedy = MAGIC.to_vec();
    for id in 1..=40u16 {
        let text =
            [&id.to_le_bytes()[..], &[0; 8], &(1u32 << 19).to_le_bytes(), &vec![b' '; 1 << 19]].concat();
        greedy.extend(record(3, &text));
    }
    assert!(fault(&greedy).contains("all schemas up to that"), "{}", fault(&greedy));
}

/// Any file is either read or refused with words; what is recovered is a recording.
fn survives(bytes: &[u8], folder: &Path) {
    let refused = |error: &cocarry_recording::recording::ReadError| {
        let said = error.to_string();
        assert!(said.starts_with("m: ") && said.len() < 10_000, "{said}");
    };
    let mut reader = match Reader::new(bytes, "m") {
        Ok(reader) => reader,
        Err(error) => return refused(&error),
    };
    if let Err(error) = Contents::read(&mut reader) {
        refused(&error);
    }
    for topic in ["/options", "/log"] {
        let columns = Reader::new(bytes, "m").and_then(|mut r| columns(&mut r, topic));
        if let Err(error) = columns {
            refused(&error);
        }
    }
    if let Ok(again) = Reader::new(bytes, "m").and_then(|first| replay(first, Reader::new(bytes, "m")?)) {
        assert!(again.same < 1000);
    }
    let to = folder.join("out.mcap");
    let saved = recover(&mut Reader::new(bytes, "m").unwrap(), &to, true).unwrap();
    let read = messages(&std::fs::read(&to).unwrap());
    assert_eq!(read.len() as u64, saved.messages);
}

/// The fuzz targets' seeds: what once fell.
#[test]
fn seeds_of_the_fuzz_targets_are_read_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let seeds = |target: &str| {
        let seeds = std::fs::read_dir(repository("tests/fixtures/fuzz").join(target)).unwrap();
        seeds.map(|seed| std::fs::read(seed.unwrap().path()).unwrap()).collect::<Vec<_>>()
    };
    seeds("recording").iter().for_each(|bytes| survives(bytes, folder.path()));
    for bytes in seeds("scenario") {
        let scenario = Scenario::parse(std::str::from_utf8(&bytes).unwrap()).unwrap();
        let said = scenario.prepare().map(drop).unwrap_err().to_string();
        assert!(said.contains("is not a URDF: its first element is <a>"), "{said}");
    }
}

/// A file with something wrong in it.
fn mutant(whole: &[u8], rng: &mut ChaCha8Rng) -> Vec<u8> {
    let mut bytes = whole.to_vec();
    for _ in 0..rng.random_range(1..4) {
        let at = rng.random_range(0..bytes.len().max(1)).min(bytes.len().saturating_sub(1));
        if bytes.len() < 16 {
            return bytes;
        }
        match rng.random_range(0..7) {
            0 => bytes[at] ^= 1 << rng.random_range(0..8),
            1 => bytes[at] = rng.random(),
            2 => bytes.truncate(at),
            3 => {
                let until = (at + rng.random_range(1..64)).min(bytes.len());
                bytes.drain(at..until);
            }
            4 => {
                let until = (at + rng.random_range(1..64)).min(bytes.len());
                let copy = bytes[at..until].to_vec();
                let to = rng.random_range(0..bytes.len());
                bytes.splice(to..to, copy);
            }
            5 => {
                let number = [0, 1, u64::MAX, 1 << 31, 1 << 40, 255][rng.random_range(0..6)];
                let end = (at + 8).min(bytes.len());
                bytes[at..end].copy_from_slice(&number.to_le_bytes()[..end - at]);
            }
            _ => {
                let end = (at + 4).min(bytes.len());
                bytes[at..end].copy_from_slice(&rng.random::<u32>().to_le_bytes()[..end - at]);
            }
        }
    }
    bytes
}

fn fuzz(seed: u64, mutants: usize, plant: Plant) {
    let folder = tempfile::tempdir().unwrap();
    let whole = short_on(plant);
    let plain = unpacked(&whole);
    assert_eq!(messages(&whole), messages(&plain));
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for i in 0..mutants {
        let bytes = mutant(if i % 3 == 0 { &whole } else { &plain }, &mut rng);
        survives(&bytes, folder.path());
    }
}

#[test]
fn property_no_file_makes_reading_or_recovering_panic() {
    fuzz(1, 400, Plant::Point);
    fuzz(2, 40, rapier());
}

/// For long: `COCARRY_FUZZ_SECONDS=600 cargo test --test suite fuzz_for_long -- --ignored`.
#[test]
#[ignore = "runs as long as it is told to"]
fn fuzz_for_long() {
    let seconds = std::env::var("COCARRY_FUZZ_SECONDS").ok().and_then(|s| s.parse().ok()).unwrap_or(10);
    let begun = std::time::Instant::now();
    let mut seed = 1000;
    while begun.elapsed() < Duration::from_secs(seconds) {
        fuzz(seed, 1000, if seed % 2 == 0 { Plant::Point } else { rapier() });
        seed += 1;
    }
    println!("{} mutants", (seed - 1000) * 1000);
}

#[test]
fn damage_in_the_middle_loses_that_second_only() {
    let whole = short();
    let folder = tempfile::tempdir().unwrap();
    let chunks = chunks(&whole);
    let [first, second, third] = [0, 1, 2].map(|i| chunks[i]);
    assert!(first < second && second < third);
    let mut damaged = whole.clone();
    damaged[(second + third) / 2] ^= 1;
    let to = folder.path().join("saved.mcap");
    let saved = recover(&mut Reader::new(&damaged[..], "m").unwrap(), &to, false).unwrap();
    let bytes = std::fs::read(&to).unwrap();
    let (all, read) = (messages(&whole), messages(&bytes));
    assert!(read.len() < all.len() && read.iter().all(|m| all.contains(m)));
    assert_eq!(read.last(), all.last());
    assert!(saved.lost[0].to_string().contains(&format!("a chunk at byte {second}")), "{:?}", saved.lost);
    let contents = Contents::read(&mut Reader::new(&bytes[..], "m").unwrap()).unwrap();
    assert!(contents.recovered.expect("said")["001"].contains("a chunk at byte"));
}
