//! `cocarry demo`: serves the page with the simulator in it on this computer, and opens it in a browser.

pub(super) mod files;
mod server;

use super::interrupt::Interrupt;
use super::output::{Failure, examples, input, print, print_message};
use anyhow::{Context, anyhow};
use clap::Args;
use cocarry_recording::rendering::DEMO_PORT;
use files::Pages;
use server::Server;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::path::PathBuf;
use std::process::{Command, ExitCode, Stdio};

/// Open a page in the browser in which episodes run, to watch, to change and to steer
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry demo", "the page, in your browser; Ctrl-C ends it"),
    ("cocarry demo --no-browser --port 9000", "its address alone, at a certain port"),
]))]
pub(super) struct DemoArguments {
    /// Serve at this port of this computer [default: 8790, or a free one]
    #[arg(long, value_name = "PORT")]
    port: Option<u16>,
    /// Print the address, and open no browser
    #[arg(long)]
    no_browser: bool,
    /// Serve the page in this folder, as `crates/web/build` makes it, in place of the one in this program
    #[arg(long, value_name = "FOLDER")]
    page: Option<PathBuf>,
}

pub(super) fn run_demo(arguments: &DemoArguments) -> Result<ExitCode, Failure> {
    let pages = Pages::find(arguments.page.as_deref()).map_err(input)?;
    let listener = listen(arguments.port).map_err(input)?;
    let interrupt = Interrupt::caught()?;
    let server =
        Server::start(listener, pages).context("the page cannot be served").map_err(Failure::Output)?;
    let address = format!("http://{}/", server.address());
    print(&format!("the page is at {address}\nCtrl-C ends it\n"))?;
    if !arguments.no_browser && !open(&address) {
        print_message("no browser was found: open the address in one");
    }
    interrupt.wait();
    drop(server);
    Ok(ExitCode::SUCCESS)
}

/// A listener on this computer alone.
fn listen(port: Option<u16>) -> anyhow::Result<TcpListener> {
    let bind = |port| TcpListener::bind(SocketAddr::from((Ipv4Addr::LOCALHOST, port)));
    match port {
        None => bind(DEMO_PORT).or_else(|_| bind(0)).map_err(|error| anyhow!("no port is free: {error}")),
        Some(port) => bind(port).map_err(|error| {
            anyhow!("--port {port}: {error}; use another port, or leave --port out to take a free one")
        }),
    }
}

/// Opens an address in the system's browser. Whether there is a program for it.
fn open(address: &str) -> bool {
    let (program, before): (&str, &[&str]) = if cfg!(target_os = "macos") {
        ("open", &[])
    } else if cfg!(windows) {
        ("rundll32", &["url.dll,FileProtocolHandler"])
    } else {
        ("xdg-open", &[])
    };
    let mut command = Command::new(program);
    command.args(before).arg(address).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().is_ok()
}
