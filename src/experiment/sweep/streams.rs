//! The ray streams of an experiment, kept in files named by hashes of their inputs.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use xxhash_rust::xxh3::xxh3_128;

use super::super::load::Experiment;
use super::super::progress;
use super::error::SweepError;
use crate::console;
use crate::culling::Policy;
use crate::json;
use crate::output::{Turn, unlink};
use crate::stream::{Header, StreamReader, StreamWriter, Totals};
use crate::tracer::Tracer;

/// Name of the lock for recording streams, in their folder.
const RECORDING: &str = "recording";
/// Pause between attempts to take the lock. Assumed.
const PAUSE: Duration = Duration::from_millis(100);

/// A hash of all inputs of the program's build.
pub(in super::super) const BUILD: &str = env!("UMBRASIM_BUILD");

/// A hash of the inputs of a stream: its header, which covers the specs and the scene's files, and the needs of all
/// policies that are traced together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) struct Identity(u128);

impl Identity {
    fn new(header: &Header, policies: &[Box<dyn Policy>]) -> Self {
        // The needs of one policy change how all streams are cut into chunks.
        let needs: Vec<String> = policies.iter().map(|policy| format!("{:?}", policy.needs())).collect();
        let mut needs: Vec<&String> = needs.iter().collect();
        needs.sort();
        needs.dedup();
        let all = json::line(&(needs, header));
        Self(xxh3_128(all.expect("plain data, which JSON can hold").as_bytes()))
    }

    /// The name of the stream's file. It depends on the build, which may make another stream of the same inputs.
    fn file(self) -> String {
        format!("{:032x}.rays", xxh3_128(format!("{self}{BUILD}").as_bytes()))
    }
}

impl fmt::Display for Identity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:032x}", self.0)
    }
}

/// The streams of an experiment's policies, before they are read or recorded.
pub(in super::super) struct Streams<'a> {
    experiment: &'a Experiment,
    tracer: Tracer<'a>,
    policies: Vec<Box<dyn Policy>>,
    headers: Vec<Header>,
    paths: Vec<PathBuf>,
    folder: PathBuf,
    pub(in super::super) identities: Vec<Identity>,
}

/// A recorded stream, and the tracer's counts in its measured frames.
pub(in super::super) struct Recorded {
    pub(crate) path: PathBuf,
    pub(crate) header: Header,
    pub(crate) totals: Totals,
    rays: u64,
}

impl Recorded {
    /// The rays of all its frames, warm-up frames included.
    pub(crate) fn rays(&self) -> u64 {
        self.rays
    }

    fn new(path: &Path, reader: &StreamReader) -> Self {
        let header = reader.header().clone();
        let measured = reader.frames().iter().filter(|frame| !header.warmup.contains(&frame.number));
        let totals = measured.map(|frame| frame.totals).sum();
        let all: Totals = reader.frames().iter().map(|frame| frame.totals).sum();
        let rays = all.primary_rays + all.secondary_rays + all.shadow_rays;
        Self { path: path.into(), header, totals, rays }
    }
}

impl<'a> Streams<'a> {
    /// The streams of an experiment; `folder` holds their files.
    pub(in super::super) fn new(experiment: &'a Experiment, folder: &Path) -> Self {
        let scene = &experiment.scene;
        let first = scene.animation.frame(experiment.frames[0]);
        let tracer = Tracer::new(scene, &first, experiment.spec.resolution, experiment.spec.tracer);
        let policies = experiment.policies();
        // Machines do not change a stream.
        let spec = &experiment.spec;
        let inputs =
            format!("{:?}", (&experiment.scene_spec, experiment.scene_hashes(), spec.resolution, &spec.tracer));
        let mut headers = Vec::new();
        for ((name, spec), policy) in experiment.spec.policies.iter().zip(&policies) {
            let inputs = format!("{inputs}{spec:?}");
            let warmup = experiment.first_frames().to_vec();
            headers.push(Header { warmup, ..tracer.header(name, policy.as_ref(), experiment.frames.clone(), &inputs) });
        }
        let identities: Vec<Identity> = headers.iter().map(|header| Identity::new(header, &policies)).collect();
        let paths = identities.iter().map(|identity| folder.join(identity.file())).collect();
        Self { experiment, tracer, policies, headers, paths, folder: folder.into(), identities }
    }

    /// Records missing streams. First reads the streams that `wanted` selects (by policy) completely, so that a
    /// damaged one is found before a replay. Only one process records in a folder; others wait for its streams.
    pub(in super::super) fn have(
        mut self,
        wanted: impl Fn(usize) -> bool,
        stop: &AtomicBool,
    ) -> Result<Vec<Recorded>, SweepError> {
        let missing = |it: &Self| (0..it.paths.len()).map(|policy| !it.is_there(policy, wanted(policy))).collect();
        let is_missing: Vec<bool> = missing(&self);
        if is_missing.contains(&true) {
            let _turn = match Turn::take(&self.folder.join(RECORDING)) {
                Some(turn) => turn,
                None => self.wait_for_turn(stop)?,
            };
            let is_missing: Vec<bool> = missing(&self);
            self.record(&is_missing, stop)?;
            self.tell_unread();
        }
        let read = |path: &PathBuf| StreamReader::open(path).map(|reader| Recorded::new(path, &reader));
        Ok(self.paths.iter().map(read).collect::<Result<_, _>>()?)
    }

    /// Reports streams in the folder that do not belong to this experiment. They may be large, and only the user knows
    /// whether another sweep needs them.
    fn tell_unread(&self) {
        let entries = std::fs::read_dir(&self.folder).into_iter().flatten().flatten();
        let unread = entries.filter(|entry| {
            let path = entry.path();
            path.extension().is_some_and(|ending| ending == "rays") && !self.paths.contains(&path)
        });
        let sizes: Vec<u64> = unread.filter_map(|entry| Some(entry.metadata().ok()?.len())).collect();
        if !sizes.is_empty() {
            let (folder, count) = (self.folder.display(), sizes.len());
            let size = indicatif::HumanBytes(sizes.iter().sum());
            console::tell(format_args!(
                "{folder}: streams of other inputs or builds stay there, unread: {count} of {size} in all"
            ));
        }
    }

    /// Waits until no other process records in the folder.
    fn wait_for_turn(&self, stop: &AtomicBool) -> Result<Turn, SweepError> {
        console::tell(format_args!(
            "another process records the streams in {}: this one waits for them",
            self.folder.display()
        ));
        loop {
            if stop.load(Ordering::Relaxed) {
                return Err(SweepError::Stopped);
            }
            match Turn::take(&self.folder.join(RECORDING)) {
                Some(turn) => return Ok(turn),
                None => std::thread::sleep(PAUSE),
            }
        }
    }

    /// Whether a policy's stream is in the folder and has the right header; `whole` checks all of its content.
    fn is_there(&self, policy: usize, whole: bool) -> bool {
        let (path, header) = (&self.paths[policy], &self.headers[policy]);
        if path.symlink_metadata().is_err() {
            return false;
        }
        let why = match StreamReader::open(path) {
            Ok(reader) if reader.header() != header => "it is the stream of other inputs".into(),
            Ok(mut reader) => match whole.then(|| reader.find_map(Result::err)).flatten() {
                None => return true,
                Some(error) => error.to_string(),
            },
            Err(error) => error.to_string(),
        };
        console::tell(format_args!("{}: {why}; the stream is recorded again", path.display()));
        false
    }

    /// Traces all frames, and writes the streams of policies whose `is_missing` is true.
    fn record(&mut self, is_missing: &[bool], stop: &AtomicBool) -> Result<(), SweepError> {
        if !is_missing.contains(&true) {
            return Ok(());
        }
        let mut writers = Vec::new();
        for ((path, header), &is_missing) in self.paths.iter().zip(&self.headers).zip(is_missing) {
            if is_missing {
                unlink(path).map_err(|source| SweepError::File { path: path.clone(), source })?;
            }
            writers.push(if is_missing { Some(StreamWriter::create(path, header)?) } else { None });
        }
        let frames = &self.experiment.frames;
        let bar = progress::bar("tracing", frames.len(), "frames");
        for &number in frames {
            if stop.load(Ordering::Relaxed) {
                return Err(SweepError::Stopped);
            }
            let frame = self.experiment.scene.animation.frame(number);
            self.tracer.frame(&frame, &mut self.policies, |policy, item| {
                writers[policy].as_mut().map_or(Ok(()), |writer| writer.write(&item))
            })?;
            bar.inc(1);
        }
        drop(bar);
        Ok(writers.into_iter().flatten().try_for_each(StreamWriter::finish)?)
    }
}
