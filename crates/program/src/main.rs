//! The `cocarry` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    cocarry_program::main()
}
