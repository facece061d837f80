//! What a user gets when something is wrong: a message that says what and where, exit status 2, and no file that looks
//! complete and is not.

mod common;
#[path = "errors/configs.rs"]
mod configs;
#[path = "errors/disk.rs"]
mod disk;
#[path = "errors/scenes.rs"]
mod scenes;
#[path = "errors/streams.rs"]
mod streams;

use common::{Desk, error_text};

impl Desk {
    /// Runs the program, which must refuse: exit status 2, no panic, and all files as they were. Gives its message.
    fn refused(&self, args: &[&str]) -> String {
        self.refuses(self.program(args))
    }

    /// The same for a program that is ready to be run.
    fn refuses(&self, mut program: assert_cmd::Command) -> String {
        let before = self.contents();
        let output = program.output().unwrap();
        let message = error_text(&output);
        assert_eq!(output.status.code(), Some(2), "{:?}: {message}", output.status);
        // What a run needs is told first.
        let error = message.find("error: ").unwrap_or_else(|| panic!("{message}"));
        assert!(!message.contains("panicked"), "{message}");
        assert!(self.contents() == before, "files were left or changed: {message}");
        message[error..].to_owned()
    }
}
