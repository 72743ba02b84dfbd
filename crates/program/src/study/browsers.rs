//! Browsers without a window, in which simulated participants answer the page of a study.

use super::run::of_store;
use crate::interrupt::Interrupt;
use crate::output::{Failure, Progress, input};
use anyhow::{Context, anyhow};
use cocarry_people::{Browsers, Store};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// The programs that are looked for, in this order.
const PROGRAMS: [&str; 6] =
    ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "microsoft-edge", "chrome"];
/// No window, nothing asked of others, and no saving of time on pages that nobody looks at.
const FLAGS: [&str; 10] = [
    "--headless=new",
    "--no-first-run",
    "--no-default-browser-check",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-quic",
    "--disable-background-timer-throttling",
    "--disable-renderer-backgrounding",
    "--mute-audio",
];
/// The sizes of a desktop's window and of a phone's, and how many browsers there are for each of a phone.
const DESKTOP: &str = "--window-size=1024,760";
const PHONE: [&str; 2] = ["--window-size=500,900", "--touch-events=enabled"];
const BROWSERS_PER_PHONE: u64 = 4;
/// The interval between two looks at the answers, and the longest time without any.
const POLL_INTERVAL: Duration = Duration::from_millis(200);
const PATIENCE: Duration = Duration::from_secs(120);
/// How long a browser that was ended may take to leave its folder.
const FAREWELL: Duration = Duration::from_secs(5);

/// A browser, which ends with this, and the folder that it keeps its things in.
struct Browser {
    process: Child,
    profile: TempDir,
}

impl Drop for Browser {
    fn drop(&mut self) {
        // one that has ended already cannot be killed
        let _ = self.process.kill();
        let _ = self.process.wait();
        // its own processes end a moment later, and write until then
        let is_gone = |folder: &Path| std::fs::remove_dir_all(folder).is_ok() || !folder.exists();
        let ended = Instant::now();
        while !is_gone(self.profile.path()) && ended.elapsed() < FAREWELL {
            std::thread::sleep(POLL_INTERVAL);
        }
    }
}

impl Browser {
    fn start(program: &Path, index: u64, address: &str) -> Result<Self, Failure> {
        let profile = TempDir::with_prefix("cocarry-browser-")
            .context("a folder for a browser cannot be made")
            .map_err(Failure::Output)?;
        let mut command = Command::new(program);
        command.args(FLAGS).arg(format!("--user-data-dir={}", profile.path().display()));
        match index % BROWSERS_PER_PHONE == 1 {
            true => command.args(PHONE),
            false => command.arg(DESKTOP),
        };
        if is_root(profile.path()) {
            // which it refuses to be otherwise
            command.arg("--no-sandbox");
        }
        command.arg(address).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        let process =
            command.spawn().map_err(|error| input(anyhow!("--browser: {}: {error}", program.display())))?;
        Ok(Self { process, profile })
    }
}

/// Whether the user who has just made this folder is the system's administrator.
fn is_root(folder: &Path) -> bool {
    #[cfg(unix)]
    return std::fs::metadata(folder).is_ok_and(|data| std::os::unix::fs::MetadataExt::uid(&data) == 0);
    #[cfg(not(unix))]
    {
        let _ = folder;
        false
    }
}

/// The browser that was asked for, or the first one of those that are looked for.
pub(super) fn found(program: Option<&Path>) -> Result<PathBuf, Failure> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders: Vec<PathBuf> = std::env::split_paths(&path).collect();
    let on_path = |name: &Path| match name.components().count() {
        1 => folders.iter().map(|folder| folder.join(name)).find(|file| file.is_file()),
        _ => name.is_file().then(|| name.to_owned()),
    };
    if let Some(program) = program {
        return on_path(program)
            .ok_or_else(|| input(anyhow!("--browser: there is no program {}", program.display())));
    }
    let named = |name: &str| on_path(Path::new(&format!("{name}{}", std::env::consts::EXE_SUFFIX)));
    PROGRAMS.into_iter().find_map(named).ok_or_else(|| {
        input(anyhow!(
            "--browser: none of {} is on the path; give its program: --browser=/path/to/chromium",
            PROGRAMS.join(", ")
        ))
    })
}

/// Lets the participants answer the page at a port of this computer. `store` is where answers go.
pub(super) fn answered(
    program: &Path,
    port: u16,
    browsers: Browsers,
    store: &Store,
    interrupt: &Interrupt,
) -> Result<(), Failure> {
    let address = |participant| format!("http://127.0.0.1:{port}/{}", browsers.query(participant));
    let mut running = (0..browsers.at_once.min(browsers.participants))
        .map(|i| Browser::start(program, i, &address(i)))
        .collect::<Result<Vec<_>, _>>()?;
    let progress = Progress::new(browsers.participants as usize, "participants");
    let (mut done, mut chunks, mut since) = (0, 0, Instant::now());
    while done < browsers.participants {
        std::thread::sleep(POLL_INTERVAL);
        if interrupt.is_set() {
            let of = browsers.participants;
            return Err(Failure::Interrupted(anyhow!("{done} of {of} participants have finished")));
        }
        let [_, finished] = store.counts().map_err(of_store)?;
        (done..finished).for_each(|_| progress.step());
        done = finished;
        let arrived = store.chunk_count().map_err(of_store)?;
        if arrived > chunks {
            (chunks, since) = (arrived, Instant::now());
        }
        let ended = running.iter_mut().find_map(|browser| browser.process.try_wait().ok().flatten());
        let fault = match ended {
            Some(status) if done < browsers.participants => format!("ended ({status})"),
            _ if since.elapsed() > PATIENCE => {
                format!("has sent nothing for {} s", PATIENCE.as_secs())
            }
            _ => continue,
        };
        return Err(Failure::Output(anyhow!(
            "--browser: {} {fault}; {done} of {} participants have finished",
            program.display(),
            browsers.participants
        )));
    }
    progress.finish();
    Ok(())
}
