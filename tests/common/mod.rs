//! What several tests need: the program, a folder to run it in, and small inputs.

#![allow(dead_code, reason = "each test uses its own part of this")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use tempfile::TempDir;

/// The crate's folder.
pub const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// A scene file of the real scenes, or none with a note where these are not at hand.
pub fn shared(file: &str) -> Option<PathBuf> {
    let path = Path::new(ROOT).join("../shared/scenes").join(file);
    if !path.exists() {
        println!("skipped: {} is absent", path.display());
    }
    path.exists().then_some(path)
}

/// A folder in which the program runs, so that messages and paths in it are the same everywhere.
pub struct Desk {
    dir: TempDir,
}

impl Desk {
    /// An empty folder.
    pub fn new() -> Self {
        Self { dir: tempfile::tempdir().unwrap() }
    }

    /// A folder with `small.ron`, a machine, its DRAM part, and `tiny.ron`, an experiment on a scene of three
    /// triangles, one of which moves: a frame is traced in a few milliseconds.
    pub fn with_experiment() -> Self {
        let desk = Self::new();
        desk.put("small.ron", &machine());
        desk.put("lpddr4_3200.ron", &dram_part());
        desk.put("tiny.ron", EXPERIMENT);
        desk.put("scene.ron", SCENE);
        desk.put("floor.obj", FLOOR);
        desk.put("kite.obj", KITE);
        desk
    }

    /// The path of a file in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    /// Writes a file.
    pub fn put(&self, name: &str, text: &(impl AsRef<[u8]> + ?Sized)) {
        fs::write(self.path(name), text).unwrap();
    }

    /// Writes a file with one place of it changed.
    pub fn put_changed(&self, name: &str, text: &str, from: &str, to: &str) {
        assert_eq!(text.matches(from).count(), 1, "`{from}` is to occur once");
        self.put(name, &text.replace(from, to));
    }

    /// All files and folders with their contents, in order.
    pub fn contents(&self) -> Vec<(PathBuf, Vec<u8>)> {
        let mut found = Vec::new();
        collect(self.dir.path(), &mut found);
        found.sort();
        found
    }

    /// The program with these arguments, to be run in the folder.
    pub fn program(&self, args: &[&str]) -> Command {
        let mut program = Command::cargo_bin("umbrasim").unwrap();
        program
            .current_dir(self.dir.path())
            .args(args)
            .env_remove("COLUMNS")
            .timeout(std::time::Duration::from_secs(300));
        program
    }

    /// Starts the program with these arguments in the folder; what it prints is thrown away.
    pub fn spawn(&self, args: &[&str]) -> std::process::Child {
        let mut program = std::process::Command::new(assert_cmd::cargo::cargo_bin("umbrasim"));
        program.current_dir(self.dir.path()).args(args);
        program.stdout(std::process::Stdio::null()).stderr(std::process::Stdio::null()).spawn().unwrap()
    }

    /// The program under a limit of `blocks` times 512 bytes on the length of any file that it writes, which stands for
    /// a full disk.
    pub fn limited(&self, blocks: u32, args: &[&str]) -> Command {
        let mut shell = Command::new("sh");
        shell.current_dir(self.dir.path()).timeout(std::time::Duration::from_secs(300));
        shell.args(["-c", "ulimit -f $0 && exec \"$@\"", &blocks.to_string()]);
        shell.arg(assert_cmd::cargo::cargo_bin("umbrasim")).args(args);
        shell
    }

    /// Runs the program, which must succeed; gives what it printed.
    pub fn succeed(&self, args: &[&str]) -> String {
        let output = self.program(args).output().unwrap();
        assert!(output.status.success(), "{args:?}: {}", error_text(&output));
        String::from_utf8(output.stdout).unwrap()
    }
}

/// What a run said on standard error.
pub fn error_text(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn collect(folder: &Path, found: &mut Vec<(PathBuf, Vec<u8>)>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(&path, found);
            found.push((path, Vec::new()));
        } else {
            let bytes = fs::read(&path).unwrap();
            found.push((path, bytes));
        }
    }
}

/// The text of `configs/machines/small.ron`, with the part of its DRAM beside it.
pub fn machine() -> String {
    fs::read_to_string(Path::new(ROOT).join("configs/machines/small.ron")).unwrap().replace("../dram/", "")
}

/// The text of `configs/dram/lpddr4_3200.ron`.
pub fn dram_part() -> String {
    fs::read_to_string(Path::new(ROOT).join("configs/dram/lpddr4_3200.ron")).unwrap()
}

/// The experiment of [`Desk::with_experiment`].
pub const EXPERIMENT: &str = r#"(
    name: "tiny",
    scene: "scene.ron",
    frames: "0..4",
    resolution: (width: 16, height: 16),
    policies: {
        "Off": Off,
        "Published": Published(),
    },
    machines: ["small.ron"],
)
"#;

/// Its scene: a floor, and a kite that sinks through the light's cone.
pub const SCENE: &str = r#"Obj(
    path: "floor.obj",
    lights: [(position: (0, 4, 0), color: (0.8, 0.8, 0.8))],
    camera: (
        fov: Vertical(40),
        path: Keys([(frame: 0, eye: (0, 2, 5), look: Along(0, -0.4, -1))]),
    ),
    moving: [
        (
            shape: Obj("kite.obj"),
            color: (0.8, 0.2, 0.2),
            path: [(frame: 0, position: (0, 2, 0)), (frame: 100, position: (0.5, 1, 0))],
        ),
    ],
    frame_count: 1000000,
    background: (0, 0, 0),
    ambient: (0.2, 0.2, 0.2),
)
"#;

/// Two triangles.
pub const FLOOR: &str = "v -3 0 -3\nv 3 0 -3\nv 3 0 3\nv -3 0 3\nf 1 4 3\nf 1 3 2\n";

/// One triangle.
pub const KITE: &str = "v -0.5 0 0\nv 0.5 0 0\nv 0 0 0.8\nf 1 3 2\n";
