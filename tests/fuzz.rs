//! Inputs that were changed at random, the same ones in every run: nothing panics, and memory stays bounded.
//!
//! Each test runs again as a process of its own under a limit on its memory: what asks for more ends it.

#[path = "fuzz/configs.rs"]
mod configs;
#[path = "fuzz/mutation.rs"]
mod mutation;
#[path = "fuzz/streams.rs"]
mod streams;

use std::process::Command;

/// How many changed inputs there are where by default there are `usual` of them. The environment variable
/// `UMBRASIM_FUZZ_CASES` sets how many of each format there are where by default there are 400: with 1000 of them, this
/// test and `fuzz_scenes` try more than 20,000.
fn cases(usual: usize) -> usize {
    let wanted = std::env::var("UMBRASIM_FUZZ_CASES").ok();
    wanted.map_or(usual, |wanted| usual * wanted.parse::<usize>().unwrap() / 400)
}

/// Set in the process that is under the limit.
const LIMITED: &str = "UMBRASIM_UNDER_A_LIMIT";
/// The limit on a process's address space, in kB: the test's threads and libraries take some of it.
const LIMIT: u32 = 1_500_000;

/// Whether this process is under the limit. If not, the test of that name is run in one that is.
fn is_limited(test: &str) -> bool {
    if std::env::var_os(LIMITED).is_some() {
        return true;
    }
    let mut shell = Command::new("sh");
    shell.args(["-c", &format!("ulimit -v {LIMIT} && exec \"$@\""), "sh"]);
    shell.arg(std::env::current_exe().unwrap()).args([test, "--exact", "--nocapture"]).env(LIMITED, "1");
    let output = shell.output().unwrap();
    assert!(output.status.success(), "{test}: {}\n{}", output.status, String::from_utf8_lossy(&output.stderr));
    false
}
