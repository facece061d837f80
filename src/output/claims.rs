//! Claims of the files that this process's command writes. No two outputs may be the same file, and no output may be a
//! file that the command reads.
//!
//! Outputs are claimed before anything is read. All files are read through [`crate::input`], which refuses claimed
//! files. So the rule holds for every command, and for files named in other files.

use std::fs::{File, Metadata};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::carry;
use super::file::is_standard;
use super::identity::FileId;
use super::links::{folder_of, follow};

/// All outputs of this process's command.
static CLAIMS: Mutex<Vec<Claim>> = Mutex::new(Vec::new());

/// An output: the option that names it, its path, and its identity.
#[derive(Clone, Debug)]
struct Claim {
    option: &'static str,
    path: PathBuf,
    identity: Identity,
}

/// The identity of an output.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Identity {
    /// Standard output.
    Standard,
    /// An existing file or folder.
    There(FileId),
    /// Anything else, such as a file that does not exist yet: its folder and name.
    Named(PathBuf),
}

/// Two outputs are the same file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{first} {}` and `{second} {}` are the same file: each output needs its own",
    first_path.display(),
    second_path.display()
)]
pub(crate) struct ClaimError {
    first: &'static str,
    first_path: PathBuf,
    second: &'static str,
    second_path: PathBuf,
}

fn claims() -> MutexGuard<'static, Vec<Claim>> {
    CLAIMS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Claims a file that the command writes, named by `option`. Any number of options may claim a device.
///
/// # Errors
/// The file is another output.
pub(crate) fn claim_file(option: &'static str, path: &Path) -> Result<(), ClaimError> {
    claim(&mut claims(), option, path)
}

/// Claims a folder of results that the command writes, and all files in it that it replaces.
///
/// # Errors
/// The folder is another output.
pub(crate) fn claim_folder(option: &'static str, path: &Path) -> Result<(), ClaimError> {
    let mut claims = claims();
    claim(&mut claims, option, path)?;
    // A folder without a readable list is refused later, before it is written.
    let own = carry::read_list(path).ok().flatten().unwrap_or_default();
    own.iter().try_for_each(|own| claim(&mut claims, option, &path.join(own)))
}

fn claim(claims: &mut Vec<Claim>, option: &'static str, path: &Path) -> Result<(), ClaimError> {
    let Some(identity) = Identity::of(path) else { return Ok(()) };
    if let Some(other) = claims.iter().find(|other| other.identity == identity) {
        let (first, first_path) = (other.option, other.path.clone());
        return Err(ClaimError { first, first_path, second: option, second_path: path.into() });
    }
    claims.push(Claim { option, path: path.into(), identity });
    Ok(())
}

/// Whether one of the command's output files is standard output, under any name.
pub(crate) fn is_standard_output_claimed() -> bool {
    let id = FileId::of_standard_output();
    claims().iter().any(|claim| match claim.identity {
        Identity::Standard => true,
        Identity::There(other) => id == Some(other),
        Identity::Named(_) => false,
    })
}

/// Refuses to read a file that is an output.
///
/// # Errors
/// The file is claimed; the error names the option.
pub(crate) fn refuse_output(file: &File) -> io::Result<()> {
    check_input(&claims(), &file.metadata()?)
}

fn check_input(claims: &[Claim], metadata: &Metadata) -> io::Result<()> {
    let Some(id) = FileId::of(metadata) else { return Ok(()) };
    let same = |claim: &&Claim| match claim.identity {
        Identity::Standard => FileId::of_standard_output() == Some(id),
        Identity::There(other) => other == id,
        Identity::Named(_) => false,
    };
    claims.iter().find(same).map_or(Ok(()), |Claim { option, path, .. }| {
        let what = format!("`{option} {}` would overwrite it", path.display());
        Err(io::Error::new(io::ErrorKind::InvalidInput, what))
    })
}

impl Identity {
    /// `None` for devices, which any number of outputs may use.
    fn of(path: &Path) -> Option<Self> {
        if is_standard(path) {
            return Some(Self::Standard);
        }
        match path.metadata() {
            Ok(there) if is_device(&there) => None,
            Ok(there) => Some(FileId::of(&there).map_or_else(|| Self::named(path), Self::There)),
            Err(_) => Some(Self::named(path)),
        }
    }

    fn named(path: &Path) -> Self {
        let path = follow(path).unwrap_or_else(|_| path.into());
        let folder = folder_of(&path).canonicalize().unwrap_or_else(|_| folder_of(&path).into());
        Self::Named(folder.join(path.file_name().unwrap_or_default()))
    }
}

fn is_device(there: &Metadata) -> bool {
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
    use std::fs;
    use std::os::unix::fs::symlink;

    use super::*;

    #[test]
    fn one_file_is_one_output_and_no_input_whatever_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("in"), "x").unwrap();
        fs::hard_link(at("in"), at("hard")).unwrap();
        symlink("in", at("soft")).unwrap();
        symlink("new", at("dangling")).unwrap();
        fs::write(at("other"), "x").unwrap();
        let mut claims = Vec::new();
        claim(&mut claims, "--json", &at("in")).unwrap();
        for name in ["in", "hard", "soft", "./in"] {
            let error = check_input(&claims, &at(name).metadata().unwrap()).unwrap_err().to_string();
            assert!(error.starts_with("`--json ") && error.ends_with("/in` would overwrite it"), "{error}");
            let error = claim(&mut claims, "-o", &at(name)).unwrap_err().to_string();
            assert!(error.contains("are the same file"), "{error}");
        }
        check_input(&claims, &at("other").metadata().unwrap()).unwrap();
        claim(&mut claims, "-o", &at("new")).unwrap();
        for name in ["new", "./new", "dangling"] {
            claim(&mut claims, "--line-trace", &at(name)).unwrap_err();
        }
        claim(&mut claims, "--line-trace", &at("other")).unwrap();
        claim(&mut claims, "--dram-trace", Path::new("-")).unwrap();
        claim(&mut claims, "--dram-commands", Path::new("-")).unwrap_err();
        // Any number of outputs may go to `/dev/null`.
        (0..2).for_each(|_| claim(&mut claims, "--dram-commands", Path::new("/dev/null")).unwrap());
    }
}
