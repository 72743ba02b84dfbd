//! Arguments in; the command's output and exit code out.

use std::process::ExitCode;

fn main() -> ExitCode {
    cocarry::cli::main()
}
