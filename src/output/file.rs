//! Output files that the user names.

use std::fs::{File, Metadata};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::identity::FileId;
use super::links::{folder_of, follow, unlink};
use super::temporary::TemporaryFile;

/// The path that stands for standard output.
const STANDARD: &str = "-";

/// An output file. A regular file appears only when complete: bytes go to a temporary file beside it, which
/// [`OutputFile::finish`] renames. If it is dropped earlier, the temporary file is removed and an existing file stays.
/// Devices, pipes and standard output (`-`) are written to directly.
#[derive(Debug)]
pub struct OutputFile(Inner);

#[derive(Debug)]
enum Inner {
    Placed { file: TemporaryFile, path: PathBuf },
    Open(File),
    Standard(io::Stdout),
}

impl OutputFile {
    /// Begins the file `path`. Symbolic links are followed.
    ///
    /// # Errors
    /// The folder does not exist or takes no new files, or `path` is a folder.
    pub fn create(path: &Path) -> io::Result<Self> {
        if is_standard(path) {
            return Ok(Self(Inner::Standard(io::stdout())));
        }
        let refuse = |kind, what: String| Err(io::Error::new(kind, what));
        match path.metadata() {
            Ok(there) if there.is_dir() => return refuse(io::ErrorKind::IsADirectory, "it is a folder".into()),
            Ok(there) if !there.is_file() || is_of_system(path) => {
                return Ok(Self(Inner::Open(File::options().write(true).open(path)?)));
            }
            _ => {}
        }
        let path = follow(path)?;
        let folder = folder_of(&path);
        if !folder.is_dir() {
            return refuse(io::ErrorKind::NotFound, format!("there is no folder {}", folder.display()));
        }
        Ok(Self(Inner::Placed { file: TemporaryFile::create_in(folder)?, path }))
    }

    /// Puts the file into its place, replacing an existing one. Its bytes are then on the disk.
    ///
    /// # Errors
    /// The disk is full, which may show only here, or the existing file cannot be replaced.
    pub fn finish(self) -> io::Result<()> {
        match self.0 {
            Inner::Placed { file, path } => {
                if let Ok(earlier) = path.metadata() {
                    file.file().set_permissions(earlier.permissions())?;
                }
                file.file().sync_all()?;
                file.place(&path)
            }
            Inner::Open(mut file) => file.flush(),
            Inner::Standard(mut output) => output.flush(),
        }
    }
}

/// Whether `path` is standard output: its name is `-`, or it leads to the same file.
pub(super) fn is_standard(path: &Path) -> bool {
    let id = || path.metadata().ok().filter(Metadata::is_file).as_ref().and_then(FileId::of);
    path == Path::new(STANDARD) || id().is_some_and(|id| FileId::of_standard_output() == Some(id))
}

/// Whether a path is one of the system's names for an open file: such a file is written to, not replaced. Other files
/// below `/dev`, such as in `/dev/shm`, are replaced like any file.
fn is_of_system(path: &Path) -> bool {
    ["/dev/fd", "/dev/stdin", "/dev/stdout", "/dev/stderr", "/proc"].iter().any(|name| path.starts_with(name))
}

/// Writes a file of this program's own whole. A symbolic link of its name is replaced, not followed: what the link
/// leads to is not this program's.
///
/// # Errors
/// As [`OutputFile::create`] and [`OutputFile::finish`].
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    unlink(path)?;
    let mut file = OutputFile::create(path)?;
    file.write_all(bytes)?;
    file.finish()
}

impl Write for OutputFile {
    // Bypasses the temporary file's `Write`, whose errors would show the temporary name.
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.0 {
            Inner::Placed { file, .. } => file.file().write(bytes),
            Inner::Open(file) => file.write(bytes),
            // A closed pipe is no error: its reader wants no more.
            Inner::Standard(output) => match output.write(bytes) {
                Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(bytes.len()),
                written => written,
            },
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.0 {
            Inner::Placed { file, .. } => file.file().flush(),
            Inner::Open(file) => file.flush(),
            Inner::Standard(output) => output.flush(),
        }
    }
}

#[cfg(all(test, unix))]
mod tests {
    use std::fs;
    use std::os::unix::fs::{PermissionsExt, symlink};

    use super::*;

    #[test]
    fn a_file_comes_whole_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        write_whole(&path, b"one").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o600)).unwrap();
        let mut file = OutputFile::create(&path).unwrap();
        file.write_all(b"tw").unwrap();
        drop(file);
        assert_eq!(
            (fs::read(&path).unwrap().as_slice(), fs::read_dir(folder.path()).unwrap().count()),
            (&b"one"[..], 1)
        );
        write_whole(&path, b"two").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert_eq!(path.metadata().unwrap().permissions().mode() & 0o777, 0o600);
    }

    #[test]
    fn links_are_followed_and_pipes_written_to() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        symlink("real", at("link")).unwrap();
        let mut file = OutputFile::create(&at("link")).unwrap();
        file.write_all(b"one").unwrap();
        file.finish().unwrap();
        assert!(at("link").is_symlink() && fs::read(at("real")).unwrap() == b"one");
        write_whole(&at("link"), b"own").unwrap();
        assert!(!at("link").is_symlink() && fs::read(at("link")).unwrap() == b"own");
        assert_eq!(fs::read(at("real")).unwrap(), b"one");
        rustix::fs::mknodat(
            rustix::fs::CWD,
            at("pipe"),
            rustix::fs::FileType::Fifo,
            rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR,
            0,
        )
        .unwrap();
        let reader = std::thread::spawn({
            let pipe = at("pipe");
            move || fs::read(pipe).unwrap()
        });
        write_whole(&at("pipe"), b"through").unwrap();
        assert_eq!(reader.join().unwrap(), b"through");
        assert!(!at("pipe").is_file());
        assert!(write_whole(&at(""), b"").unwrap_err().to_string().contains("it is a folder"));
        assert!(write_whole(&at("no/a"), b"").unwrap_err().to_string().starts_with("there is no folder"));
        write_whole(Path::new("/dev/null"), b"nothing").unwrap();
    }

    /// A shorter file leaves nothing of a longer one.
    #[test]
    fn files_below_dev_are_files() {
        assert!(["/dev/stdout", "/dev/fd/3", "/proc/self/fd/1"].iter().all(|name| is_of_system(Path::new(name))));
        let Ok(folder) = tempfile::tempdir_in("/dev/shm") else { return println!("skipped: no /dev/shm") };
        let path = folder.path().join("a");
        write_whole(&path, b"longer").unwrap();
        write_whole(&path, b"short").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"short");
    }
}
