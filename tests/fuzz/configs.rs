//! RON files of every kind.

use std::fs;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use umbrasim::experiment::identities::IdentitiesSpec;
use umbrasim::experiment::paper::PaperSpec;
use umbrasim::experiment::{Experiment, Overrides, pareto, read_machine, sweep};
use umbrasim::machine::MachineSpec;
use umbrasim::memory::dram::part::DramPart;
use umbrasim::ron_file;
use umbrasim::scene::spec::SceneSpec;

use super::mutation::Random;
use super::{cases, is_limited};

/// Changes of each file.
const CASES: usize = 60;

/// Files of a folder of `configs`.
fn files(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs").join(folder);
    let mut files: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

/// Reads changed texts of the files of a folder as `T`; gives how many could be read.
fn parsed<T: DeserializeOwned>(folder: &str, seed: u64, then: impl Fn(T)) -> usize {
    let mut random = Random(seed);
    let mut good = 0;
    for file in files(folder) {
        let text = fs::read_to_string(&file).unwrap();
        for _ in 0..cases(CASES) {
            match ron_file::parse::<T>(&random.change_text(&text), &file) {
                Ok(value) => {
                    good += 1;
                    then(value);
                }
                Err(error) => assert!(!error.to_string().is_empty()),
            }
        }
    }
    good
}

#[test]
fn single_files() {
    if !is_limited("configs::single_files") {
        return;
    }
    let machines = parsed::<MachineSpec>("machines", 1, |machine| {
        let _ = machine.check();
        let _ = machine.footprint();
    });
    assert!(machines > 20, "only {machines} machines could be read");
    assert!(parsed::<DramPart>("dram", 2, drop) > 10);
    assert!(parsed::<SceneSpec>("scenes", 3, drop) > 20);
    parsed::<PaperSpec>("experiments", 5, drop);
    parsed::<IdentitiesSpec>("experiments", 6, drop);
}

#[test]
fn files_that_name_others() {
    if !is_limited("configs::files_that_name_others") {
        return;
    }
    let desk = tempfile::tempdir().unwrap();
    let put = |name: &str, text: &str| fs::write(desk.path().join(name), text).unwrap();
    let at = |name: &str| desk.path().join(name);
    let machine = fs::read_to_string(&files("machines")[0]).unwrap().replace("../dram/", "");
    for part in files("dram") {
        fs::copy(&part, at(part.file_name().unwrap().to_str().unwrap())).unwrap();
    }
    let scene = "BuiltIn(Room(lights: 2, frame_count: 8, detail: 1))";
    let experiment = "(name: \"tiny\", scene: \"scene.ron\", frames: \"0..2\", resolution: (width: 8, height: 8), \
        policies: {\"Off\": Off, \"Published\": Published()}, machines: [\"machine.ron\"])";
    let swept =
        "(experiment: \"tiny.ron\", vary: {\"clock_mhz\": [400, 500], \"dispatcher.rays\": [8, 16]}, points: All)";
    let compared = "(experiments: [(file: \"tiny.ron\")], machines: [\"machine.ron\"], rungs: [Bound, Profile])";
    let good = [
        ("machine.ron", machine.as_str()),
        ("scene.ron", scene),
        ("tiny.ron", experiment),
        ("sweep.ron", swept),
        ("pareto.ron", compared),
    ];
    good.iter().for_each(|(name, text)| put(name, text));
    assert!(Experiment::load(&at("tiny.ron"), Overrides::default()).is_ok());
    assert_eq!(sweep::machine_count(&at("sweep.ron")).unwrap(), 4);
    assert!(pareto::Comparison::load(&at("pareto.ron"), None).is_ok());
    let mut random = Random(7);
    for (name, text) in good.iter().filter(|(name, _)| *name != "scene.ron") {
        for _ in 0..cases(CASES) {
            put(name, &random.change_text(text));
            let _ = read_machine(&at("machine.ron"));
            let _ = Experiment::load(&at("tiny.ron"), Overrides::default());
            let _ = sweep::machine_count(&at("sweep.ron"));
            let _ = pareto::Comparison::load(&at("pareto.ron"), None);
        }
        put(name, text);
    }
}
