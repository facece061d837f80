//! What a command reads and what it writes: no file may be both, and no two outputs the same file.

use std::fs;
use std::path::{Path, PathBuf};

use super::carry;
use super::file::is_standard;
use super::links::{folder_of, follow};

/// An output that cannot be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ClaimError {
    /// The output is read by the same command.
    #[error("`{option}` would overwrite {}, which the command reads as {}", output.display(), input.display())]
    Input {
        /// The option that names the output.
        option: &'static str,
        /// The output as the option names it.
        output: PathBuf,
        /// The input as the command names it.
        input: PathBuf,
    },
    /// Two outputs are the same file.
    #[error("`{first}` ({}) and `{second}` ({}) are the same file: each output needs its own", first_path.display(), second_path.display())]
    Output {
        /// An option.
        first: &'static str,
        /// What it names.
        first_path: PathBuf,
        /// Another option.
        second: &'static str,
        /// What that names.
        second_path: PathBuf,
    },
}

/// The files of a command. Inputs are told first, then outputs.
#[derive(Debug, Default)]
pub struct Claims {
    inputs: Vec<(PathBuf, Identity)>,
    outputs: Vec<(&'static str, PathBuf, Identity)>,
}

impl Claims {
    /// The claims of a command that reads these files.
    pub fn reading(inputs: impl IntoIterator<Item = PathBuf>) -> Self {
        let inputs = inputs.into_iter().map(|path| {
            let identity = Identity::of(&path);
            (path, identity)
        });
        Self { inputs: inputs.collect(), outputs: Vec::new() }
    }

    /// Adds a file that the command writes, as `option` names it.
    ///
    /// # Errors
    /// It is an input, or another output.
    pub fn file(&mut self, option: &'static str, path: &Path) -> Result<(), ClaimError> {
        let identity = Identity::of(path);
        if let Some((input, _)) = self.inputs.iter().find(|(_, input)| input.is(&identity)) {
            return Err(ClaimError::Input { option, output: path.into(), input: input.clone() });
        }
        if let Some((first, first_path, _)) = self.outputs.iter().find(|(.., other)| other.is(&identity)) {
            let (first_path, second_path) = (first_path.clone(), path.into());
            return Err(ClaimError::Output { first, first_path, second: option, second_path });
        }
        self.outputs.push((option, path.into(), identity));
        Ok(())
    }

    /// Adds a folder of results that the command writes: it may hold inputs, but not among the files that it replaces.
    ///
    /// # Errors
    /// A file that is replaced is an input.
    pub fn folder(&mut self, option: &'static str, path: &Path) -> Result<(), ClaimError> {
        for own in carry::read_list(path).ok().flatten().unwrap_or_default() {
            let own = path.join(own);
            let identity = Identity::of(&own);
            if let Some((input, _)) = self.inputs.iter().find(|(_, input)| input.is(&identity)) {
                return Err(ClaimError::Input { option, output: own, input: input.clone() });
            }
        }
        self.file(option, path)
    }
}

/// What makes two paths the same file.
#[derive(Debug)]
enum Identity {
    /// Standard output.
    Standard,
    /// A device: any number of outputs can be written to it.
    Device,
    /// A file or folder that is there.
    There(same_file::Handle),
    /// Nothing yet: the folder and the name.
    New(PathBuf),
}

impl Identity {
    fn of(path: &Path) -> Self {
        if is_standard(path) {
            return Self::Standard;
        }
        match path.metadata() {
            Ok(there) if is_device(&there) => Self::Device,
            // A pipe cannot be opened without waiting for its other end.
            Ok(there) if there.is_file() || there.is_dir() => {
                same_file::Handle::from_path(path).map_or_else(|_| Self::new(path), Self::There)
            }
            _ => Self::new(path),
        }
    }

    fn new(path: &Path) -> Self {
        let path = follow(path).unwrap_or_else(|_| path.into());
        let folder = folder_of(&path).canonicalize().unwrap_or_else(|_| folder_of(&path).into());
        Self::New(folder.join(path.file_name().unwrap_or_default()))
    }

    fn is(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Standard, Self::Standard) => true,
            (Self::There(one), Self::There(other)) => one == other,
            (Self::New(one), Self::New(other)) => one == other,
            _ => false,
        }
    }
}

fn is_device(there: &fs::Metadata) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        there.file_type().is_char_device() || there.file_type().is_block_device()
    }
    #[cfg(not(unix))]
    {
        let _ = there;
        false
    }
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    #[test]
    fn an_output_that_is_an_input_or_another_output_is_refused_by_whatever_name() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("in"), "x").unwrap();
        fs::hard_link(at("in"), at("hard")).unwrap();
        symlink("in", at("soft")).unwrap();
        symlink("new", at("dangling")).unwrap();
        let mut claims = Claims::reading([at("in")]);
        for name in ["in", "hard", "soft", "./in"] {
            let error = claims.file("--json", &at(name)).unwrap_err();
            assert!(error.to_string().starts_with("`--json` would overwrite "), "{error}");
        }
        claims.file("--json", &at("new")).unwrap();
        for name in ["new", "./new", "dangling"] {
            let error = claims.file("--line-trace", &at(name)).unwrap_err();
            assert!(error.to_string().contains("are the same file"), "{error}");
        }
        claims.file("--line-trace", &at("other")).unwrap();
        claims.file("-o", Path::new("-")).unwrap();
        assert!(claims.file("--json", Path::new("-")).is_err());
        // Any number of outputs can be thrown away.
        claims.file("--dram-trace", Path::new("/dev/null")).unwrap();
        claims.file("--dram-commands", Path::new("/dev/null")).unwrap();
    }

    #[test]
    fn a_folder_may_hold_inputs_that_it_does_not_replace() {
        let folder = tempfile::tempdir().unwrap();
        let report = folder.path().join("rep");
        fs::create_dir(&report).unwrap();
        fs::write(report.join("summary.json"), "{}").unwrap();
        carry::write_list(&report).unwrap();
        fs::write(report.join("mine.ron"), "()").unwrap();
        assert_eq!(Claims::reading([report.join("mine.ron")]).folder("--out", &report), Ok(()));
        let error = Claims::reading([report.join("summary.json")]).folder("--out", &report).unwrap_err();
        assert!(error.to_string().contains("summary.json, which the command reads"), "{error}");
    }
}
