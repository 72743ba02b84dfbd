//! Small files that ask for much: refused in bounded memory, output and time, and at once where a file never
//! ends.

use crate::recording::{MAGIC, chunk, example, rapier, record};
use crate::support::{repository, stderr};
use cocarry::scenario::Plant;
use std::path::Path;
use std::process::{Command, Output};

/// Runs the program with an address space of so many MiB.
pub fn within(mebibytes: u64, folder: &Path, line: &str) -> Output {
    let program = env!("CARGO_BIN_EXE_cocarry");
    let command = format!("ulimit -v {}; exec '{program}' {line}", mebibytes << 10);
    Command::new("sh").args(["-c", &command]).current_dir(folder).output().unwrap()
}

/// The error of the program, which must refuse the input.
fn refused(mebibytes: u64, folder: &Path, line: &str) -> String {
    let output = within(mebibytes, folder, line);
    let said = stderr(&output);
    let end: String = said.chars().take(2000).collect();
    assert_eq!(output.status.code(), Some(2), "{line}: {end}");
    assert!(said.starts_with("error: ") && said.len() < 10_000, "{line}: {end}");
    said
}

fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat()
}

/// A record with a message on channel 1.
pub fn message(data: &[u8]) -> Vec<u8> {
    record(5, &[&[1, 0][..], &[0; 20], data].concat())
}

/// A record that defines channel 1, of JSON without a schema.
pub fn channel(topic: &str) -> Vec<u8> {
    record(4, &[&[1, 0, 0, 0][..], &text(topic), &text("json"), &[0; 4]].concat())
}

pub fn attachment(name: &str, data: &[u8]) -> Vec<u8> {
    let length = (data.len() as u64).to_le_bytes();
    record(9, &[&[0; 16][..], &text(name), &text("text/plain"), &length, data, &[0; 4]].concat())
}

/// A file with these chunks, packed.
pub fn packed(chunks: &[Vec<u8>]) -> Vec<u8> {
    let chunks = chunks.iter().flat_map(|records| {
        let packed = zstd::bulk::compress(records, 3).unwrap();
        chunk(records.len() as u64, 0, "zstd", &packed)[MAGIC.len()..].to_vec()
    });
    MAGIC.iter().copied().chain(chunks).collect()
}

#[test]
#[cfg(unix)]
fn only_regular_files_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let fifo = folder.path().join("fifo");
    assert!(Command::new("mkfifo").arg(&fifo).status().unwrap().success());
    std::fs::write(folder.path().join("world.toml"), "worlds = [\"fifo\"]\nplants = \"point\"\nseeds = 1\n")
        .unwrap();
    let mut said = vec![refused(1000, folder.path(), "sweep world.toml")];
    for file in ["/dev/zero", "fifo"] {
        for line in [
            "run",
            "run --belief-samples",
            "run --resume",
            "run --robot",
            "world",
            "sweep",
            "sweep --summary",
            "sweep --merge out.csv",
            "inspect",
            "replay",
            "recover -o out.mcap",
            "fit eta",
            "fit risk-weight",
            "regress check",
            "regress record",
        ] {
            // the name of a robot file must end so
            if line != "run --robot" {
                said.push(refused(1000, folder.path(), &format!("{line} {file}")));
            }
        }
    }
    for said in said {
        assert!(said.contains("cannot be read: is a special file; expected a regular file"), "{said}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn a_recording_has_a_robot_of_bounded_depth() {
    let folder = tempfile::tempdir().unwrap();
    let mut scenario = example(rapier());
    let Plant::Rapier { setup, .. } = &mut scenario.plant else { panic!("the physical plant") };
    let deep = "<a b=\"/>\">".repeat(20_000) + &"</a>".repeat(20_000);
    let mut texts = setup.robot.texts().clone();
    texts.urdf = format!("<robot name=\"r\"><link name=\"l\"><visual>{deep}</visual></link></robot>");
    setup.robot = texts.into();
    let file = [MAGIC, &attachment("scenario.toml", scenario.text().unwrap().as_bytes())].concat();
    std::fs::write(folder.path().join("deep.mcap"), file).unwrap();
    let said = refused(1000, folder.path(), "replay deep.mcap");
    assert!(said.contains("depth of its elements = 65"), "{said}");
}

/// One long key with many values: every path would have the key in it.
#[test]
fn a_table_of_a_small_recording_is_bounded() {
    let folder = tempfile::tempdir().unwrap();
    let key = "k".repeat(120_000);
    let hostile = [
        format!("{{\"{key}\":[{}0]}}", "0,".repeat(60_000)),
        format!("{{\"{key}\":[{}[]]}}", "[],".repeat(40_000)),
        format!("{{{}\"z\":0}}", (0..5000).map(|i| format!("\"{i}\":0,")).collect::<String>()),
    ];
    for json in hostile {
        // the first chunk may unpack to as much
        let file = packed(&[[channel("/t"), message(json.as_bytes())].concat()]);
        assert!(file.len() < 20_000);
        std::fs::write(folder.path().join("wide.mcap"), file).unwrap();
        let said = refused(400, folder.path(), "inspect wide.mcap --csv /t");
        assert!(said.contains("`/t` is too large for a table"), "{said}");
    }
    // few columns in many rows
    let wide = format!("{{{}\"z\":0}}", (0..4000).map(|i| format!("\"{i}\":0,")).collect::<String>());
    let records = [channel("/t"), message(wide.as_bytes()), message(b"{}").repeat(20_000)].concat();
    std::fs::write(folder.path().join("long.mcap"), packed(&[records])).unwrap();
    let said = refused(400, folder.path(), "inspect long.mcap --csv /t --output out.csv");
    assert!(said.contains("more than 20000000 cells"), "{said}");
    assert!(!folder.path().join("out.csv").exists());
}

#[test]
fn a_recording_unpacks_to_a_bounded_length() {
    let folder = tempfile::tempdir().unwrap();
    let written = || std::fs::metadata(folder.path().join("out.mcap")).unwrap().len();
    // messages without contents, of which each has an entry in an index
    let bomb = message(b"").repeat(900_000);
    let bombs: Vec<_> = std::iter::once(channel("/t")).chain(std::iter::repeat_n(bomb, 12)).collect();
    let bombs = packed(&bombs);
    assert!(bombs.len() < 60_000, "{}", bombs.len());
    std::fs::write(folder.path().join("bombs.mcap"), &bombs).unwrap();
    let output = within(400, folder.path(), "recover bombs.mcap -o out.mcap");
    assert!(output.status.success(), "{}", stderr(&output));
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(
        said.contains("the contents of a chunk, with all chunks before it in so short a file,"),
        "{said}"
    );
    assert!(written() < 1_000_000, "{}", written());
    let said = refused(400, folder.path(), "inspect bombs.mcap");
    assert!(said.contains("in so short a file"), "{said}");
    // what is copied unpacked may not be in a chunk
    let zeros = packed(&vec![attachment("zeros", &vec![0; 1_000_000]); 30]);
    std::fs::write(folder.path().join("zeros.mcap"), &zeros).unwrap();
    let output = within(400, folder.path(), "recover zeros.mcap -o out.mcap --overwrite");
    assert!(output.status.success(), "{}", stderr(&output));
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(said.contains("an attachment at byte 8: it is in a chunk, where only schemas"), "{said}");
    assert!(written() < 10_000, "{}", written());
    // texts and maps that claim to be longer than their records
    let claim = u32::MAX.to_le_bytes();
    let map = [&text("a")[..], &8_u32.to_le_bytes(), &claim, &claim].concat();
    for (opcode, body, what) in [
        (12, [&claim[..], b"abc"].concat(), "a metadata record"),
        (12, [&text("a")[..], &claim].concat(), "a metadata record"),
        (12, map.clone(), "a metadata record"),
        (3, [&[1, 0][..], &text("a"), &text("b"), &claim].concat(), "a schema"),
        (4, [&[1, 0, 0, 0][..], &claim].concat(), "a channel"),
        (4, [&[1, 0, 0, 0][..], &text("/t"), &text("json"), &map[5..]].concat(), "a channel"),
        (6, [&[0; 28][..], &claim].concat(), "a chunk"),
        (6, [&[0; 28][..], &text(""), &[0xff; 8]].concat(), "a chunk"),
    ] {
        std::fs::write(folder.path().join("claims.mcap"), [MAGIC, &record(opcode, &body)].concat()).unwrap();
        let said = refused(400, folder.path(), "inspect claims.mcap");
        assert!(said.contains(&format!("{what} at byte 8: its fields exceed its length")), "{said}");
    }
    // an attachment that is too short for its fields
    std::fs::write(folder.path().join("short.mcap"), [MAGIC, &record(9, &[0; 34])].concat()).unwrap();
    let said = refused(400, folder.path(), "inspect short.mcap");
    assert!(said.contains("an attachment at byte 8: its fields exceed its length"), "{said}");
}

/// As much text as is read, of every kind that parsers are known to need memory for.
#[test]
fn large_texts_are_read_in_bounded_memory() {
    let folder = tempfile::tempdir().unwrap();
    let most = 16 << 20;
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("more.toml"), vec![b'#'; most + 1]).unwrap();
    for (line, limit) in
        [("fit eta", 16 << 20), ("world", 4 << 20), ("run --robot", 1 << 20), ("sweep", 1 << 20)]
    {
        let said = refused(1000, folder.path(), &format!("{line} more.toml"));
        assert!(said.contains(&format!("more.toml: cannot be read: larger than {limit} bytes")), "{said}");
    }
    for name in ["carrier.toml", "carrier.urdf"] {
        std::fs::copy(repository("assets/robots").join(name), path(name)).unwrap();
    }
    // the parsers' worst: much structure in few bytes
    for (line, most, pieces) in [
        ("world large.toml", 4 << 20, &["a=[[[],[],[],", "[[obstacle]]\n", "x.y.z=1\n", "[a.b.c.d.e]\n"][..]),
        ("sweep large.toml", 1 << 20, &["a=[[[],[],[],", "[[run]]\n", "x.y.z=1\n"]),
        ("regress check large.toml", 1 << 20, &["a=[[[],[],[],", "[[run]]\n", "x.y.z=1\n"]),
        ("run --robot large.toml", 1 << 20, &["a=[[[],[],[],", "[[posture]]\n", "x.y.z=1\n"]),
        ("run --robot carrier.toml", most, &["<a/>", "<a>", "<a b='' c=''/>", "&amp;", "<!-- -->"]),
        ("fit eta large.toml", most, &["participant,", "a\n", "\"\n"]),
        ("run --belief-samples large.toml", most, &["alpha,", "alpha,gamma\n", "\"\n"]),
    ] {
        for piece in pieces {
            let text = piece.repeat(most / piece.len() - 10);
            std::fs::write(path("large.toml"), &text).unwrap();
            std::fs::write(path("carrier.urdf"), format!("<robot name=\"r\">{text}")).unwrap();
            refused(1500, folder.path(), line);
        }
    }
}

#[test]
fn a_study_has_a_bounded_number_of_combinations() {
    let folder = tempfile::tempdir().unwrap();
    let list = |n: usize| (1..=n).map(|i| i.to_string()).collect::<Vec<_>>().join(", ");
    let head = "worlds = \"environment-1\"\nplants = \"point\"\nseeds = 1\n";
    let run = format!("[[run]]\neta = [{}]\nrisk_weight_m = [{}]\n", list(300), list(200));
    std::fs::write(folder.path().join("s.toml"), format!("{head}{}", run.repeat(2))).unwrap();
    let said = refused(2000, folder.path(), "sweep s.toml");
    assert!(said.contains("more than 100000 combinations"), "{said}");
    std::fs::write(folder.path().join("s.toml"), format!("{head}{}", "[[run]]\n".repeat(1001))).unwrap();
    let said = refused(2000, folder.path(), "sweep s.toml");
    assert!(said.contains("s.toml:4: run") && said.contains("at most 1000 tables [[run]]"), "{said}");
    std::fs::write(folder.path().join("s.toml"), format!("{head}risk_weight_m = [{}]\n", list(1001)))
        .unwrap();
    let said = refused(2000, folder.path(), "sweep s.toml");
    assert!(said.contains("more than 1000 combinations of a world, a risk weight and a robot"), "{said}");
    std::fs::write(folder.path().join("s.toml"), format!("{head}eta = [{}]\n", list(10_001))).unwrap();
    let said = refused(2000, folder.path(), "sweep s.toml");
    assert!(said.contains("s.toml:4: eta") && said.contains("at most 10000"), "{said}");
}

/// Half a megabyte of integrals, and draws, for each of them would not fit.
#[test]
fn many_participants_are_inferred_in_little_memory() {
    let folder = tempfile::tempdir().unwrap();
    let mut answers = "participant,world,option,percent\n".to_owned();
    for person in 0..600 {
        for world in 1..=2 {
            for option in 1..=4 {
                let percent = if option == 1 + (person + world) % 4 { 100 } else { 0 };
                answers += &format!("p{person},environment-{world},{option},{percent}\n");
            }
        }
    }
    std::fs::write(folder.path().join("a.csv"), answers).unwrap();
    let output = within(300, folder.path(), "infer a.csv --csv people.csv --draws 100");
    assert!(output.status.success(), "{}", stderr(&output));
    let people = std::fs::read_to_string(folder.path().join("people.csv")).unwrap();
    assert_eq!(people.lines().count(), 601);
}

/// A link that leads to itself is no file.
#[test]
#[cfg(unix)]
fn circles_of_links_are_no_files() {
    let folder = tempfile::tempdir().unwrap();
    for (from, to) in [("a.toml", "b.toml"), ("b.toml", "a.toml"), (".", "deep")] {
        std::os::unix::fs::symlink(from, folder.path().join(to)).unwrap();
    }
    for line in ["run a.toml", "sweep a.toml", "run --robot a.toml", "inspect a.toml", "fit eta a.toml"] {
        let said = refused(1000, folder.path(), line);
        assert!(said.contains("a.toml"), "{line}: {said}");
    }
    // a mesh that is searched for in a package that contains itself
    let said = refused(1000, folder.path(), &format!("run {}w.toml", "deep/".repeat(60)));
    assert!(said.contains("w.toml"), "{said}");
}

/// A file that another process goes on writing is read up to an end.
#[test]
fn a_file_that_grows_while_it_is_read_has_an_end() {
    use std::io::Write;
    use std::sync::atomic::{AtomicBool, Ordering};
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.mcap");
    let begin = [MAGIC, &channel("/t")].concat();
    std::fs::write(&path, &begin).unwrap();
    std::fs::write(folder.path().join("a.csv"), "participant,world,option,percent\n").unwrap();
    let is_over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let grow = |name: &str, piece: Vec<u8>| {
            let mut file = std::fs::OpenOptions::new().append(true).open(folder.path().join(name)).unwrap();
            let is_over = &is_over;
            scope.spawn(move || {
                // 20 MB in all at most
                for _ in 0..2000 {
                    if is_over.load(Ordering::Relaxed) {
                        break;
                    }
                    file.write_all(&piece.repeat(10_000 / piece.len())).unwrap();
                    std::thread::sleep(std::time::Duration::from_millis(1));
                }
            });
        };
        grow("m.mcap", message(b"{}"));
        grow("a.csv", b"p,environment-1,1,100\n".to_vec());
        for line in
            ["inspect m.mcap", "inspect m.mcap --csv /t", "recover m.mcap -o out.mcap", "fit eta a.csv"]
        {
            let output = within(1000, folder.path(), line);
            assert!(matches!(output.status.code(), Some(0 | 2)), "{line}: {}", stderr(&output));
        }
        is_over.store(true, Ordering::Relaxed);
    });
}
