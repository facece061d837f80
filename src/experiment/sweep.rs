//! Sweeps: the same ray streams on many machines, which differ in named fields of their specs.
//!
//! Frames are traced once; every point is a replay, kept in a file named by a hash of all that it depends on. So a
//! sweep that was stopped goes on where it was, and ends with the same bytes.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;
use ron::value::RawValue;
use serde::Deserialize;
use serde_json::Value;
use xxhash_rust::xxh3::xxh3_64;

use super::files::beside;
use super::frames::FrameRange;
use super::load::{Experiment, ExperimentError, Overrides};
use super::progress;
use super::split::{with_free_words, without_unit};
use crate::machine::MachineSpec;
use crate::named::Named;
use crate::output::write_whole;
use crate::quantity::Resolution;
use crate::replay::{self, Fidelity, Items, RunError, Source, StreamFile};
use crate::report::sweep::{Change, SweepPoint, SweepSummary};
use crate::ron_file::{self, ConfigError};
use crate::stats::MachineStats;
use crate::stream::{Header, StreamError, StreamReader, StreamWriter, Totals};
use crate::tracer::Tracer;

/// A sweep as its RON file says it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SweepSpec {
    /// The experiment whose streams and machines are used, relative to this file.
    experiment: PathBuf,
    /// Other frames than the experiment's.
    #[serde(default)]
    frames: Option<FrameRange>,
    /// Another size of the pictures.
    #[serde(default)]
    resolution: Option<Resolution>,
    /// Paths of fields in a machine's file, each with the values to try.
    vary: Named<Vec<Box<RawValue>>>,
    /// Which combinations.
    #[serde(default)]
    points: Points,
}

/// Which combinations of values are tried.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
enum Points {
    /// The machine as it is, and each value alone.
    #[default]
    Single,
    /// All combinations.
    All,
}

/// Why a sweep ended without a result.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// The experiment cannot be had.
    #[error(transparent)]
    Experiment(#[from] ExperimentError),
    /// A config is wrong.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// A stream cannot be written or read.
    #[error(transparent)]
    Stream(#[from] StreamError),
    /// A replay failed.
    #[error("machine `{machine}` on the stream of `{policy}`")]
    Machine {
        /// The machine's name.
        machine: String,
        /// The policy.
        policy: String,
        /// What happened.
        source: Box<RunError>,
    },
    /// A file of the sweep cannot be read or written.
    #[error("cannot read or write {}", path.display())]
    File {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// Something that is no sweep is in the way.
    #[error("{} is not an umbrasim sweep (it has no folder `points`) and will not be used", path.display())]
    Foreign {
        /// What is in the way.
        path: PathBuf,
    },
    /// Stopped: what was done is kept.
    #[error("stopped; the points done are kept, and the same command goes on with the others")]
    Stopped,
}

/// A machine of the sweep.
struct Machine {
    name: String,
    changes: Vec<Change>,
    spec: MachineSpec,
}

/// A replay, and where its result is kept.
struct Replay {
    policy: usize,
    spec: MachineSpec,
    file: PathBuf,
}

/// A recorded stream and what the tracer counted in it.
pub(super) struct Recorded {
    pub path: PathBuf,
    pub header: Header,
    totals: Totals,
}

impl Recorded {
    /// Its rays, skipped ones included.
    pub(super) fn rays(&self) -> u64 {
        self.totals.primary_rays + self.totals.secondary_rays + self.totals.shadow_rays
    }
}

/// Runs or continues the sweep of the file `path`; its streams and points are kept in `folder`.
pub(crate) fn sweep(path: &Path, folder: &Path, stop: &AtomicBool) -> Result<SweepSummary, SweepError> {
    let (experiment, machines) = load(path)?;
    let there = fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some());
    if folder.is_file() || there && !folder.join("points").is_dir() {
        return Err(SweepError::Foreign { path: folder.into() });
    }
    for part in ["points", "streams"] {
        let part = folder.join(part);
        fs::create_dir_all(&part).map_err(|source| SweepError::File { path: part, source })?;
    }
    let streams = record(&experiment, &folder.join("streams"), stop)?;
    let fidelity = experiment.spec.fidelity;
    let file = |policy: usize, spec: &MachineSpec| folder.join("points").join(key(&streams[policy], fidelity, spec));
    let replay = |policy: usize, spec: MachineSpec| Replay { policy, file: file(policy, &spec), spec };

    let off = experiment.off();
    let culling = || (0..streams.len()).filter(|&policy| policy != off);
    let mut replays: BTreeMap<PathBuf, Replay> = BTreeMap::new();
    for machine in &machines {
        let of_machine =
            std::iter::once(replay(off, without_unit(&machine.spec))).chain(culling().flat_map(|policy| {
                [replay(policy, machine.spec.clone()), replay(policy, with_free_words(&machine.spec))]
            }));
        replays.extend(of_machine.map(|replay| (replay.file.clone(), replay)));
    }
    run_all(&streams, fidelity, replays.into_values().collect(), stop)?;

    let mut points = Vec::new();
    for machine in &machines {
        let stats = |policy: usize, spec: &MachineSpec| read_point(&file(policy, spec));
        let baseline = stats(off, &without_unit(&machine.spec))?;
        for policy in culling() {
            points.push(SweepPoint::new(
                &machine.name,
                &streams[policy].header.policy,
                machine.changes.clone(),
                [&baseline, &stats(policy, &with_free_words(&machine.spec))?, &stats(policy, &machine.spec)?],
                &streams[policy].totals,
            ));
        }
    }
    Ok(SweepSummary {
        experiment: experiment.spec.name.clone(),
        scene: experiment.scene.name.clone(),
        frames: experiment.frames.clone(),
        resolution: experiment.spec.resolution,
        points,
    })
}

/// Reads the sweep of the file `path` and all files that it names. Returns how many machines the sweep has.
///
/// # Errors
/// A file cannot be read or is wrong, or a value does not fit its field.
pub fn machine_count(path: &Path) -> Result<usize, SweepError> {
    Ok(load(path)?.1.len())
}

fn load(path: &Path) -> Result<(Experiment, Vec<Machine>), SweepError> {
    let spec: SweepSpec = ron_file::read(path)?;
    let overrides = Overrides { frames: spec.frames, resolution: spec.resolution };
    let experiment = Experiment::load(&beside(path, &spec.experiment), overrides)?;
    let machines = machines(path, &spec, &experiment)?;
    Ok((experiment, machines))
}

/// All machines, in the order of the files.
fn machines(path: &Path, spec: &SweepSpec, experiment: &Experiment) -> Result<Vec<Machine>, ConfigError> {
    let wrong = |what: String| ConfigError::Content { path: path.into(), what };
    let mut all: Vec<Machine> = Vec::new();
    for (name, base) in experiment.machines.iter() {
        let machine = |changes: Vec<(&str, &str)>| {
            let mut spec = base.clone();
            for &(field, value) in &changes {
                spec = with_field(&spec, field, value).map_err(&wrong)?;
            }
            spec.check().map_err(|error| wrong(format!("machine `{name}` with {}: {error}", listed(&changes))))?;
            let changes = changes.into_iter().map(|(field, value)| Change { field: field.into(), value: value.into() });
            Ok::<_, ConfigError>(Machine { name: name.into(), changes: changes.collect(), spec })
        };
        let mut combinations: Vec<Vec<(&str, &str)>> = vec![Vec::new()];
        for (field, values) in spec.vary.iter() {
            if values.is_empty() {
                return Err(wrong(format!("`vary` has no value for `{field}`: at least one is needed")));
            }
            let values = values.iter().map(|value| (field, value.get_ron().trim()));
            match spec.points {
                Points::Single => combinations.extend(values.map(|change| vec![change])),
                Points::All => {
                    let with = |change| combinations.iter().map(move |others| [&others[..], &[change]].concat());
                    combinations = values.flat_map(with).collect();
                }
            }
        }
        for combination in combinations {
            let next = machine(combination)?;
            // A value that the machine has already is no point of its own.
            if all.iter().all(|other| other.name != next.name || other.spec != next.spec) {
                all.push(next);
            }
        }
    }
    if all.is_empty() {
        return Err(wrong(format!("the experiment `{}` has no machines", experiment.spec.name)));
    }
    Ok(all)
}

fn listed(changes: &[(&str, &str)]) -> String {
    changes.iter().map(|(field, value)| format!("`{field}: {value}`")).collect::<Vec<_>>().join(", ")
}

/// The machine with another value of the field at `path`, such as `shadow_cache.cache.bytes`.
fn with_field(spec: &MachineSpec, path: &str, value: &str) -> Result<MachineSpec, String> {
    let mut all = serde_json::to_value(spec).expect("a spec is plain data, which JSON can hold");
    let mut place = &mut all;
    for (index, name) in path.split('.').enumerate() {
        let Value::Object(fields) = place else {
            let parent = path.split('.').take(index).collect::<Vec<_>>().join(".");
            return Err(format!("`vary` names `{path}`, but `{parent}` has no fields of its own"));
        };
        let known = fields.keys().map(|field| format!("`{field}`")).collect::<Vec<_>>().join(", ");
        place = fields.get_mut(name).ok_or_else(|| {
            format!("`vary` names `{path}`, but a machine has no `{name}` there: {known} are allowed")
        })?;
    }
    *place = plain(value).map_err(|error| format!("`vary` has the value `{value}` for `{path}`: {error}"))?;
    serde_json::from_value(all).map_err(|error| format!("`vary` has the value `{value}` for `{path}`: {error}"))
}

/// A value of a RON file as data. A bare name is a variant's.
fn plain(text: &str) -> Result<Value, String> {
    let is_name = text.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
        && text.starts_with(|letter: char| letter.is_ascii_uppercase());
    if is_name {
        return Ok(Value::String(text.into()));
    }
    ron::from_str(text).map_err(|error| error.code.to_string())
}

/// Records the streams of all policies, or takes those that are there and of the same inputs.
pub(super) fn record(experiment: &Experiment, folder: &Path, stop: &AtomicBool) -> Result<Vec<Recorded>, SweepError> {
    let scene = &experiment.scene;
    let first = scene.animation.frame(experiment.frames[0]);
    let tracer = Tracer::new(scene, &first, experiment.spec.resolution, experiment.spec.tracer);
    let mut policies = experiment.policies();
    // Machines do not change a stream.
    let inputs = format!("{:?}", (&experiment.scene_spec, experiment.spec.resolution, &experiment.spec.tracer));
    let headers: Vec<Header> = experiment
        .spec
        .policies
        .iter()
        .zip(&policies)
        .map(|((name, spec), policy)| {
            tracer.header(name, policy.as_ref(), experiment.frames.clone(), &format!("{inputs}{spec:?}"))
        })
        .collect();
    let paths: Vec<PathBuf> = (0..headers.len()).map(|policy| folder.join(format!("policy{policy}.rays"))).collect();
    let there = || paths.iter().zip(&headers).map(|(path, header)| read_recorded(path, header)).collect();
    if let Some(streams) = there() {
        return Ok(streams);
    }
    let mut writers = Vec::new();
    for (path, header) in paths.iter().zip(&headers) {
        writers.push(StreamWriter::create(path, header)?);
    }
    let bar = progress::bar(experiment.frames.len(), "frames").with_message("tracing");
    for &number in &experiment.frames {
        if stop.load(Ordering::Relaxed) {
            return Err(SweepError::Stopped);
        }
        tracer.frame(&scene.animation.frame(number), &mut policies, |policy, item| writers[policy].write(&item))?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    for writer in writers {
        writer.finish()?;
    }
    let read = |(path, header): (&PathBuf, &Header)| {
        read_recorded(path, header).map_or_else(|| StreamReader::open(path).map(|it| recorded(path, &it)), Ok)
    };
    Ok(paths.iter().zip(&headers).map(read).collect::<Result<_, _>>()?)
}

/// A stream that was recorded with these inputs.
fn read_recorded(path: &Path, header: &Header) -> Option<Recorded> {
    let reader = StreamReader::open(path).ok()?;
    (reader.header() == header).then(|| recorded(path, &reader))
}

fn recorded(path: &Path, reader: &StreamReader) -> Recorded {
    let mut totals = Totals::default();
    reader.frames().iter().for_each(|frame| totals += frame.totals);
    Recorded { path: path.into(), header: reader.header().clone(), totals }
}

/// The name of a replay's file.
fn key(stream: &Recorded, fidelity: Fidelity, spec: &MachineSpec) -> String {
    let spec = MachineSpec { name: String::new(), ..spec.clone() };
    let all = serde_json::to_vec(&(env!("CARGO_PKG_VERSION"), fidelity, &stream.header, spec));
    format!("{:016x}.json", xxh3_64(&all.expect("plain data, which JSON can hold")))
}

/// What a replay measured.
fn read_point(file: &Path) -> Result<MachineStats, SweepError> {
    let text = fs::read(file).and_then(|text| Ok(serde_json::from_slice(&text)?));
    text.map_err(|source| SweepError::File { path: file.into(), source })
}

/// Makes all replays that are not there yet.
fn run_all(
    streams: &[Recorded],
    fidelity: Fidelity,
    replays: Vec<Replay>,
    stop: &AtomicBool,
) -> Result<(), SweepError> {
    let bar = progress::bar(replays.len(), "replays").with_message("replaying");
    replays.into_par_iter().try_for_each(|Replay { policy, spec, file }| {
        if read_point(&file).is_err() {
            let stats = replay(&spec, fidelity, &streams[policy], stop)?;
            let text = serde_json::to_vec_pretty(&stats).expect("plain data, which JSON can hold");
            write_whole(&file, &text).map_err(|source| SweepError::File { path: file.clone(), source })?;
        }
        bar.inc(1);
        Ok::<_, SweepError>(())
    })?;
    bar.finish_and_clear();
    Ok(())
}

/// A recorded stream that ends as one that is cut off does when it is stopped: the replay is thrown away.
struct Stoppable<'a> {
    file: StreamFile<'a>,
    stop: &'a AtomicBool,
}

impl Source for Stoppable<'_> {
    fn open(&self, frame: usize) -> Result<Items<'_>, StreamError> {
        Ok(Box::new(self.file.open(frame)?.take_while(|_| !self.stop.load(Ordering::Relaxed))))
    }
}

/// Replays a recorded stream on a machine.
///
/// # Errors
/// The replay is stopped or fails.
pub(super) fn replay(
    machine: &MachineSpec,
    fidelity: Fidelity,
    stream: &Recorded,
    stop: &AtomicBool,
) -> Result<MachineStats, SweepError> {
    let source = Stoppable { file: StreamFile(&stream.path), stop };
    let replay = replay::Replay::new(machine, &stream.header).map_err(RunError::from);
    let stats = replay.and_then(|replay| replay.fidelity(fidelity).run(&source));
    if stop.load(Ordering::Relaxed) {
        return Err(SweepError::Stopped);
    }
    stats.map_err(|source| SweepError::Machine {
        machine: machine.name.clone(),
        policy: stream.header.policy.clone(),
        source: Box::new(source),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::shadow_cache::Place;

    #[test]
    fn any_field_can_be_set_and_errors_say_what_is_allowed() {
        let base = MachineSpec::default();
        let set = |path, value| with_field(&base, path, value);
        assert_eq!(set("shadow_cache.cache.bytes", "65536").unwrap().shadow_cache.cache.bytes.get(), 65536);
        assert_eq!(set("shadow_cache.place", "L2").unwrap().shadow_cache.place, Place::L2);
        let error = |path, value| set(path, value).unwrap_err();
        assert!(error("shadow_cache.size", "1").contains("a machine has no `size` there: `count`, `latency`,"));
        assert!(error("clock_mhz.x", "1").contains("`clock_mhz` has no fields of its own"));
        assert!(error("shadow_cache.place", "Onw").contains("expected one of `Own`, `Triangle`, `L2`, `Free`"));
        assert!(error("shadow_cache.count", "0").contains("0 is not allowed here: a whole number from 1 to 64 is"));
    }
}
