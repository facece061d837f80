//! Gives the program a hash of everything that it is built from, by which results of other builds are known.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use xxhash_rust::xxh3::Xxh3Default;

/// Files and folders that make the program, beside the compiler and its settings.
const SOURCES: [&str; 4] = ["src", "build.rs", "Cargo.toml", "Cargo.lock"];
/// Settings of the compiler.
const SETTINGS: [&str; 5] = ["TARGET", "PROFILE", "OPT_LEVEL", "DEBUG", "CARGO_ENCODED_RUSTFLAGS"];

fn main() {
    let mut hash = Xxh3Default::new();
    for source in SOURCES {
        println!("cargo::rerun-if-changed={source}");
        add(Path::new(source), &mut hash);
    }
    for setting in SETTINGS {
        hash.update(env::var(setting).unwrap_or_default().as_bytes());
        hash.update(&[0]);
    }
    let compiler = env::var("RUSTC").ok().and_then(|rustc| Command::new(rustc).arg("-vV").output().ok());
    hash.update(&compiler.map(|output| output.stdout).unwrap_or_default());
    println!("cargo::rustc-env=UMBRASIM_BUILD={:016x}", hash.digest());
    // Reports name the commit; sources that lie in no repository have none.
    let git = Command::new("git").args(["describe", "--always", "--dirty", "--abbrev=12"]).output();
    let commit = git.ok().filter(|output| output.status.success());
    if let Some(commit) = commit.and_then(|output| String::from_utf8(output.stdout).ok()) {
        println!("cargo::rustc-env=UMBRASIM_COMMIT={}", commit.trim());
    }
}

/// Adds the name and bytes of a file, or of all files in a folder.
fn add(path: &Path, hash: &mut Xxh3Default) {
    if path.is_dir() {
        let entries = fs::read_dir(path).expect("the folder of sources is readable");
        let mut inside: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
        inside.sort();
        inside.iter().for_each(|path| add(path, hash));
    } else if let Ok(bytes) = fs::read(path) {
        hash.update(path.to_string_lossy().as_bytes());
        hash.update(&(bytes.len() as u64).to_le_bytes());
        hash.update(&bytes);
    }
}
