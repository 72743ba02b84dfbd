//! The tutorial, as it is written: its files in a blank folder, its commands in their order.

use crate::support::{repository, stderr};
use std::process::Command;

#[test]
fn the_tutorial_can_be_followed() {
    let text = std::fs::read_to_string(repository("docs/tutorial.md")).expect("the tutorial");
    let folder = tempfile::tempdir().unwrap();
    // what the reader is told to copy
    for (from, to) in [("carrier.toml", "porter.toml"), ("carrier.urdf", "carrier.urdf")] {
        std::fs::copy(repository("assets/robots").join(from), folder.path().join(to)).expect("a copy");
    }
    let (mut files, mut commands) = (0, 0);
    // blocks are every second part
    for block in text.split("```").skip(1).step_by(2) {
        let (head, body) = block.split_once('\n').expect("a block");
        if let Some((_, file)) = head.split_once(' ') {
            std::fs::write(folder.path().join(file), body).expect("a file");
            files += 1;
        }
        for line in body.lines().filter(|_| head == "sh") {
            let command = line.split('#').next().unwrap_or_default();
            let mut program = Command::new(env!("CARGO_BIN_EXE_cocarry"));
            let output = program
                .args(command.split_whitespace().skip(1))
                .current_dir(folder.path())
                .output()
                .expect("the program starts");
            assert!(output.status.success(), "{line}: {}", stderr(&output));
            commands += 1;
        }
    }
    assert_eq!((files, commands), (5, 14));
}
