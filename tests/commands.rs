//! Commands about configs and reports, as a user calls them: `describe`, `schema`, `new`, `check`, `diff`,
//! `completions` and `man`.

mod common;
#[path = "commands/configs.rs"]
mod configs;
#[path = "commands/extrapolate.rs"]
mod extrapolate;
#[path = "commands/options.rs"]
mod options;
#[path = "commands/reports.rs"]
mod reports;

use common::{Desk, error_text};

impl Desk {
    /// Runs the program, which must succeed; gives what it prints.
    fn prints(&self, args: &[&str]) -> String {
        let output = self.program(args).output().unwrap();
        assert!(output.status.success(), "{args:?}: {}", error_text(&output));
        String::from_utf8(output.stdout).unwrap()
    }

    /// Runs the program, which must refuse with exit status 2; gives its message.
    fn refuses(&self, args: &[&str]) -> String {
        let output = self.program(args).output().unwrap();
        let message = error_text(&output);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {message}");
        message[message.find("error: ").unwrap_or_else(|| panic!("{message}"))..].to_owned()
    }
}

/// Whether all lines have room in a terminal of so many columns.
fn fits(text: &str, columns: usize) -> bool {
    text.lines().all(|line| line.chars().count() <= columns)
}
