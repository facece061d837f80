//! Tests of the commands in the README and the book: each one parses, the files that it names exist, and its section
//! says how long it takes.

use std::path::Path;

use clap::Parser;

use super::Cli;
use crate::shipped::{self, Kind};

/// The README and all pages of the book.
fn pages() -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folders = ["guide", "model", "validation", "decisions"].map(|folder| root.join("docs").join(folder));
    let files = folders.iter().flat_map(|folder| std::fs::read_dir(folder).unwrap()).map(|file| file.unwrap().path());
    let pages = files.chain([root.join("README.md")]).filter(|path| path.extension().is_some_and(|it| it == "md"));
    pages.map(|path| (path.display().to_string(), std::fs::read_to_string(path).unwrap())).collect()
}

/// The commands in the indented blocks of a page, without comments and redirections. A line that ends with `\`
/// continues on the next line.
fn commands(page: &str) -> Vec<String> {
    let joined = page.replace("\\\n", " ");
    let indented = joined.lines().filter_map(|line| line.strip_prefix("    "));
    let starts = ["umbrasim ", "cargo run --release -- "];
    let commands = indented.filter_map(|line| starts.iter().find_map(|start| line.strip_prefix(start)));
    let alone = |line: &str| {
        let end = [" #", " >", " |"].iter().filter_map(|end| line.find(end)).min();
        line[..end.unwrap_or(line.len())].to_owned()
    };
    commands.map(alone).collect()
}

#[test]
fn commands_in_the_book_are_commands_and_their_configs_are_there() {
    let (mut count, mut wrong) = (0, Vec::new());
    for (page, text) in pages() {
        for command in commands(&text) {
            count += 1;
            let words = shlex::split(&command).expect(&command);
            let parsed = Cli::try_parse_from(std::iter::once("umbrasim".to_owned()).chain(words.iter().cloned()));
            if let Err(error) = parsed {
                wrong.push(format!("{page}: `umbrasim {command}`: {error}"));
            }
            for file in words.iter().filter(|word| word.starts_with("configs/") || word.starts_with("traces/")) {
                if !Path::new(env!("CARGO_MANIFEST_DIR")).join(file).exists() {
                    wrong.push(format!("{page}: `umbrasim {command}`: {file} is not there"));
                }
            }
            // A config without a folder or an ending is a shipped one.
            let first = words.get(1).filter(|word| shipped::is_name(word) && words[0] == "run");
            if let Some(name) = first.filter(|name| shipped::path(Kind::Experiment, name).is_none()) {
                wrong.push(format!("{page}: `umbrasim {command}`: no config is called {name}"));
            }
        }
    }
    assert!(count > 30, "{count} commands only");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Commands that end at once; tests of the command line run them all.
const AT_ONCE: [&str; 10] =
    ["new", "describe", "check", "schema", "completions", "man", "explain", "inspect", "diff", "plot"];

/// Whether a text says how long something takes.
fn tells_a_time(text: &str) -> bool {
    ["second", "minute", "hour"].iter().any(|unit| text.contains(unit))
}

#[test]
fn a_section_with_commands_says_how_long_they_take() {
    let mut silent = Vec::new();
    for (page, text) in pages() {
        let sections = text.split("\n#").filter(|section| !tells_a_time(section));
        let slow = sections.flat_map(commands).filter(|it| !AT_ONCE.iter().any(|name| it.starts_with(name)));
        silent.extend(slow.map(|command| format!("{page}: `umbrasim {command}`")));
    }
    assert!(silent.is_empty(), "nobody says how long these take:\n{}", silent.join("\n"));
}
