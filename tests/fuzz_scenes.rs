//! Mutants of scenes in every format: none may panic, take long or take much memory.
//!
//! The mutants are the same on every run; `UMBRASIM_FUZZ_CASES` sets another number of them for each format.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use umbrasim::scene::spec::SceneSpec;

/// Mutants of each format.
const CASES: u64 = 400;
/// The most time for one mutant.
const TIME: Duration = Duration::from_secs(20);
/// The most memory for all of them, in kB: the corpus is small, so that what a mutant asks for must be little.
const MEMORY_KB: u64 = 512 << 10;

/// Pieces that readers stumble over.
const PIECES: &[&str] = &[
    "0",
    "-1",
    "1",
    "4294967295",
    "4294967296",
    "-9223372036854775808",
    "18446744073709551615",
    "1e9",
    "1e10",
    "1e39",
    "-1e-30",
    "1e999",
    "nan",
    "inf",
    "-1.#IND",
    "1.#INF",
    "#",
    "\\\n",
    "\r",
    "\0",
    "\u{feff}",
    "é",
    "{",
    "}",
    "(",
    ")",
    "[",
    "]",
    "\"",
    ",",
    ":",
    "/",
    "//",
    " ",
    "\t",
    "\n",
    "..",
    "/dev/zero",
    "f 1 2 3\n",
    "mtllib box.mtl\n",
    "usemtl red\n",
    "i 0 room.aff ",
    "element face 4000000000\n",
    "property list uint int x\n",
    "null",
    "{}",
    "[0]",
    "\"KHR_draco_mesh_compression\"",
];

/// SplitMix64 (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ (mixed >> 31)
    }

    /// A number below `end`, which is above 0.
    fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }
}

/// Changes one to four places.
fn mutate(bytes: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..=random.below(4) {
        let at = random.below(bytes.len() + 1);
        let end = (at + random.below(12)).min(bytes.len());
        match random.below(7) {
            0 => drop(bytes.splice(at..at, PIECES[random.below(PIECES.len())].bytes())),
            1 => drop(bytes.drain(at..end)),
            2 => {
                let copy = bytes[at..end].to_vec();
                drop(bytes.splice(at..at, copy));
            }
            3 => bytes.truncate(bytes.len() - random.below(bytes.len() / 4 + 1)),
            4 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
            // A word, most often a number, becomes another one.
            _ => {
                let inside = |byte: &u8| byte.is_ascii_alphanumeric() || b"+-._".contains(byte);
                let start = bytes[..at].iter().rposition(|byte| !inside(byte)).map_or(0, |place| place + 1);
                let length = bytes[start..].iter().take_while(|byte| inside(byte)).count();
                drop(bytes.splice(start..start + length, PIECES[random.below(PIECES.len())].bytes()));
            }
        }
    }
}

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures")
}

/// A folder with the whole corpus.
fn corpus() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for name in ["fuzz", "gltf"] {
        for entry in fs::read_dir(fixtures().join(name)).unwrap() {
            let path = entry.unwrap().path();
            fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
        }
    }
    folder
}

/// Reads a scene's RON, loads the scene, and looks at some frames.
fn load(text: &str, folder: &Path) -> bool {
    let extensions = ron::extensions::Extensions::IMPLICIT_SOME | ron::extensions::Extensions::UNWRAP_VARIANT_NEWTYPES;
    let options = ron::Options::default().with_default_extension(extensions);
    let Ok(spec) = options.from_str::<SceneSpec>(text) else { return false };
    // A built-in scene is as large as its parameters say, whatever the corpus.
    if !matches!(spec, SceneSpec::Files(_) | SceneSpec::Aff(_)) {
        return false;
    }
    let Ok(scene) = spec.load(folder) else { return false };
    assert!(scene.statics.triangles.iter().all(|triangle| triangle.v.iter().all(|corner| corner.is_finite())));
    for number in [0, 1, scene.frame_count - 1] {
        let frame = scene.animation.frame(number);
        assert_eq!((frame.dynamic.len(), frame.lights.len()), (scene.dynamic_count, scene.light_count));
        assert!(frame.dynamic.triangles.iter().all(|triangle| triangle.v.iter().all(|corner| corner.is_finite())));
        assert!(frame.lights.iter().all(|light| light.position.is_finite() && light.color.is_finite()));
    }
    true
}

/// The most memory that this process has had, in kB; 0 where the system does not tell.
fn peak_memory() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.trim().trim_end_matches(" kB").parse().ok()).unwrap_or(0)
}

/// Loads mutants of the file `name` by the scene `text`; the corpus as it is must load.
fn fuzz(name: &str, text: &str) {
    let folder = corpus();
    let original = fs::read(folder.path().join(name)).unwrap();
    assert!(load(text, folder.path()), "{name} itself");
    let cases = std::env::var("UMBRASIM_FUZZ_CASES").map_or(CASES, |cases| cases.parse().unwrap());
    let mut loaded = 0;
    for case in 0..cases {
        let mut random = Random(case);
        let mut bytes = original.clone();
        mutate(&mut bytes, &mut random);
        fs::write(folder.path().join(name), &bytes).unwrap();
        let begin = Instant::now();
        let found = if name.ends_with(".ron") {
            load(&String::from_utf8_lossy(&bytes), folder.path())
        } else {
            load(text, folder.path())
        };
        loaded += u64::from(found);
        assert!(begin.elapsed() < TIME, "case {case} of {name} takes {:?}", begin.elapsed());
        assert!(peak_memory() < MEMORY_KB, "case {case} of {name}: {} kB", peak_memory());
    }
    // Some mutants must be refused and some must load, else the sequence says nothing.
    assert!((cases / 100..cases - cases / 100).contains(&loaded), "{loaded} of {cases} mutants of {name} load");
}

/// A scene of one file.
fn of(file: &str) -> String {
    let camera = "camera: (fov: Vertical(40), path: Still(eye: (0, 0, 5), look: At(0, 0, 0)))";
    format!("Files(files: \"{file}\", frame_count: 3, {camera})")
}

#[test]
fn aff() {
    fuzz("room.aff", "Aff(\"room.aff\")");
}

#[test]
fn obj() {
    fuzz("box.obj", &of("box.obj"));
}

#[test]
fn material_libraries() {
    fuzz("box.mtl", &of("box.obj"));
}

#[test]
fn pictures() {
    fuzz("wood.ppm", &of("box.obj"));
}

#[test]
fn ply() {
    fuzz("mesh.ply", &of("mesh.ply"));
}

#[test]
fn gltf_documents() {
    fuzz("yard.gltf", &of("yard.gltf"));
}

#[test]
fn gltf_containers() {
    fuzz("yard.glb", &of("yard.glb"));
}

#[test]
fn gltf_buffers() {
    fuzz("yard.bin", &of("yard.gltf"));
}

#[test]
fn configs() {
    let text = fs::read_to_string(fixtures().join("fuzz/scene.ron")).unwrap();
    fuzz("scene.ron", &text);
}
