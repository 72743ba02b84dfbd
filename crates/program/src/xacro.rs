//! Xacros: expanded by the program `xacro`, and only where the user asks for it, since it runs code that is
//! in the file.

use super::output;
use clap::Args;
use cocarry::Error;
use cocarry::bounds;
use cocarry::error::Place;
use cocarry::robot::Expand;
use cocarry::suggestion::shell_word;
use std::io::{self, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::time::{Duration, Instant};

/// The longest time that xacro may take, s. Descriptions of robots take less than one.
pub const MAX_SECONDS: u64 = bounds::XACRO.seconds;
/// The longest URDF that it may print, bytes: as long as a URDF that is read from a file.
pub const MAX_OUTPUT: u64 = bounds::XACRO.bytes();
/// The largest address space that it may have, bytes; where the system can limit it.
pub const MAX_MEMORY: u64 = bounds::XACRO.memory << 20;
/// The longest message of it that is kept, bytes.
const MAX_MESSAGE: u64 = 64 << 10;

/// Whether xacros are expanded.
#[derive(Args, Clone, Copy, Debug, Default)]
pub(super) struct XacroArguments {
    /// Expand a xacro with the program `xacro`, which runs code that is in the file: for files that you trust.
    /// It may take 30 s, 2 GiB of memory and print 16 MiB
    #[arg(long)]
    xacro: bool,
}

impl XacroArguments {
    /// The function that expands a xacro, if the user asks for it.
    pub fn expand(self) -> Option<&'static Expand> {
        self.xacro.then_some(&expand_and_tell)
    }
}

/// As [`expand`], after a line that says what runs.
fn expand_and_tell(file: &Path) -> Result<String, Error> {
    output::note(&format_args!("running `xacro -- {}`", shell_word(&file.display().to_string())));
    expand(file)
}

/// Expands a xacro with the program `xacro`, within limits of time, output and memory.
///
/// # Errors
/// The program is missing, fails, prints no text, or exceeds a limit.
pub fn expand(file: &Path) -> Result<String, Error> {
    let refused = |sentence: String| Error::at(Place::file(file.display().to_string()), sentence);
    let mut child = start(file).map_err(|error| refused(not_started(&error)))?;
    let printed = read_within(child.stdout.take(), MAX_OUTPUT);
    let said = read_within(child.stderr.take(), MAX_MESSAGE);
    let until = Instant::now() + Duration::from_secs(MAX_SECONDS);
    let left = || until.saturating_duration_since(Instant::now());
    let Ok(printed) = printed.recv_timeout(left()) else {
        end(&mut child);
        return Err(refused(format!("`xacro` takes longer than {MAX_SECONDS} s")));
    };
    if printed.len() as u64 > MAX_OUTPUT {
        end(&mut child);
        return Err(refused(format!("`xacro` prints more than {MAX_OUTPUT} bytes")));
    }
    let status = loop {
        match child.try_wait() {
            Ok(Some(status)) => break status,
            Ok(None) if left().is_zero() => {
                end(&mut child);
                return Err(refused(format!("`xacro` takes longer than {MAX_SECONDS} s")));
            }
            Ok(None) => std::thread::sleep(Duration::from_millis(5)),
            Err(error) => return Err(refused(not_started(&error))),
        }
    };
    if status.code() == Some(NOT_FOUND) {
        return Err(refused(not_started(&io::Error::from(io::ErrorKind::NotFound))));
    }
    if !status.success() {
        let said = said.recv_timeout(left()).unwrap_or_default();
        let said = reason(&String::from_utf8_lossy(&said));
        return Err(refused(format!("`xacro` cannot expand it: {said}")));
    }
    String::from_utf8(printed).map_err(|_| refused("`xacro` prints no text".to_owned()))
}

/// The reason that xacro gives, in one line: it comes first, and the files and macros that lead there follow it.
/// Of a Python error, the last line says which it is.
fn reason(said: &str) -> String {
    const MAX_LINES: usize = 4;
    const MAX_LENGTH: usize = 600;
    let traceback = said.find("Traceback (most recent call last)").map_or("", |at| &said[at..]);
    let is_said = |line: &&str| !line.is_empty() && !line.to_lowercase().starts_with("warning");
    let lines = said.lines().map(str::trim).filter(is_said);
    let lines: Vec<&str> = match traceback.trim().lines().last() {
        Some(last) => vec![last],
        None => lines.take(MAX_LINES).collect(),
    };
    let joined = lines.join("; ");
    let reason: String =
        joined.trim_start_matches("error: ").chars().filter(|c| !c.is_control()).take(MAX_LENGTH).collect();
    let hint = match ["ament_index_python", "rospkg"].iter().any(|module| said.contains(module)) {
        true => "; $(find PACKAGE) in it needs ROS: source its setup first, or write the package's path",
        false => "",
    };
    if reason.is_empty() { "no message".to_owned() } else { reason + hint }
}

/// The exit code of a shell that does not find a program.
const NOT_FOUND: i32 = 127;

fn not_started(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => {
            "needs the program `xacro` on the path; `pip install xacro` has it".to_owned()
        }
        _ => format!("`xacro` cannot be started: {error}"),
    }
}

/// Starts xacro in a group of processes of its own. The name of the file is an argument of the shell, never a
/// part of its text.
#[cfg(unix)]
fn start(file: &Path) -> io::Result<Child> {
    use std::os::unix::process::CommandExt;
    let limited = format!("ulimit -v {} 2>/dev/null; exec xacro -- \"$1\"", MAX_MEMORY >> 10);
    let mut command = Command::new("sh");
    command.args(["-c", &limited, "sh"]).arg(file).process_group(0);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()
}

#[cfg(not(unix))]
fn start(file: &Path) -> io::Result<Child> {
    let mut command = Command::new("xacro");
    command.arg("--").arg(file);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()
}

/// Ends xacro and what it started.
fn end(child: &mut Child) {
    if cfg!(unix) {
        // its group has its number
        let group = format!("-{}", child.id());
        let _ = Command::new("kill").args(["-KILL", "--", &group]).stderr(Stdio::null()).status();
    }
    let _ = child.kill();
    let _ = child.wait();
}

/// What a pipe has, at most `limit` bytes and one, read on a thread of its own.
fn read_within(pipe: Option<impl Read + Send + 'static>, limit: u64) -> mpsc::Receiver<Vec<u8>> {
    let (done, is_done) = mpsc::channel();
    std::thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(pipe) = pipe {
            // what was read before an error is what there is
            let _ = pipe.take(limit + 1).read_to_end(&mut bytes);
        }
        let _ = done.send(bytes);
    });
    is_done
}
