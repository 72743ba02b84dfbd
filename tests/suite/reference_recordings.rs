//! The recordings that ship: written anew by the commands next to them, byte for byte.

use crate::support::{cocarry, repository, stderr};

#[test]
fn the_commands_of_the_reference_recordings_write_them_anew() {
    let text = std::fs::read_to_string(repository("recordings/README.md")).expect("a README");
    let folder = tempfile::tempdir().unwrap();
    let mut written = 0;
    for line in text.lines().filter(|line| line.starts_with("cocarry run ")) {
        let (command, shipped) = line.split_once(" --record ").expect("a recording");
        let shipped = repository(shipped);
        let anew = folder.path().join(shipped.file_name().expect("a name"));
        let words = command.split_whitespace().skip(1);
        let arguments: Vec<&str> = words.chain(["--record", anew.to_str().unwrap()]).collect();
        let output = cocarry(&arguments);
        assert!(output.status.success(), "{line}: {}", stderr(&output));
        let [shipped, anew] = [&shipped, &anew].map(|file| std::fs::read(file).expect("a recording"));
        assert!(shipped.len() < 2 << 20, "{line}: {} bytes", shipped.len());
        assert!(shipped == anew, "{line}: other bytes than those that ship");
        written += 1;
    }
    assert_eq!(written, 4);
}
