//! The `umbrasim` program: everything it does is in the library's command line.

use std::process::ExitCode;

fn main() -> ExitCode {
    umbrasim::cli::main()
}
