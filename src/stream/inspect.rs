//! What is in a ray stream file, for people: counts and sizes of each frame.

use std::io::{Read, Seek};

use comfy_table::{CellAlignment, Table, presets};
use serde::Serialize;

use super::chunk::{Chunk, Decision, Outcome, RayKind};
use super::error::StreamError;
use super::format::FrameEntry;
use super::header::Header;
use super::item::Item;
use super::reader::StreamReader;
use crate::quantity::Bytes;

/// A stream file's contents in numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Inspection {
    /// Version of the file's layout.
    pub version: u32,
    /// The file's length.
    pub file_bytes: Bytes,
    /// What the stream is of.
    pub header: Header,
    /// Its frames in order.
    pub frames: Vec<FrameSummary>,
}

/// A frame in numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct FrameSummary {
    /// The frame's entry of the index: number, sizes and totals.
    #[serde(flatten)]
    pub entry: FrameEntry,
    /// Bytes before compression over bytes in the file.
    pub compression: f64,
    /// Rays of each kind, in the order of [`RayKind::ALL`]; kinds without a ray are there too.
    pub kinds: Vec<KindSummary>,
    /// What the policy decided for the shadow rays.
    pub decisions: Decisions,
    /// Steps that the policy did on rays' account.
    pub policy_steps: u64,
    /// Steps that the policy did at the frame's end.
    pub end_steps: u64,
}

/// Shadow rays by what the policy decided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub(crate) struct Decisions {
    /// Traced among everything.
    pub trace: u64,
    /// Traced among dynamic objects only.
    pub dynamic_only: u64,
    /// Not traced.
    pub skip: u64,
}

/// Rays of one kind.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(crate) struct KindSummary {
    /// The kind's name.
    pub kind: &'static str,
    /// How many there are.
    pub rays: u64,
    /// Those that hit nothing.
    pub miss: u64,
    /// Those that hit a primitive.
    pub hit: u64,
    /// Those that see their light.
    pub lit: u64,
    /// Those that do not see their light.
    pub dark: u64,
    /// Steps of their paths.
    pub steps: u64,
    /// Steps a ray; `None` without a ray.
    pub mean_steps: Option<f64>,
    /// Rays by the length of their paths. The first number is of paths without a step, number `k` of paths of
    /// 2^(k-1) to 2^k - 1 steps; it ends with the longest path.
    pub histogram: Vec<u64>,
}

impl FrameSummary {
    fn new(entry: &FrameEntry) -> Self {
        Self {
            entry: *entry,
            compression: entry.raw_bytes.0 as f64 / entry.bytes.0 as f64,
            kinds: RayKind::ALL.map(|kind| KindSummary { kind: kind.name(), ..KindSummary::default() }).into(),
            decisions: Decisions::default(),
            policy_steps: 0,
            end_steps: 0,
        }
    }

    fn count(&mut self, chunk: &Chunk) {
        for ray in chunk.rays() {
            let of = &mut self.kinds[ray.head.kind as usize];
            of.rays += 1;
            match ray.head.outcome {
                Outcome::Miss => of.miss += 1,
                Outcome::Hit(_) => of.hit += 1,
                Outcome::Lit => of.lit += 1,
                Outcome::Dark => of.dark += 1,
            }
            let steps = ray.packed_path().len();
            of.steps += steps as u64;
            let bucket = (usize::BITS - steps.leading_zeros()) as usize;
            if of.histogram.len() <= bucket {
                of.histogram.resize(bucket + 1, 0);
            }
            of.histogram[bucket] += 1;
            if ray.head.kind == RayKind::Shadow {
                match ray.head.decision {
                    Decision::Trace => self.decisions.trace += 1,
                    Decision::DynamicOnly => self.decisions.dynamic_only += 1,
                    Decision::Skip => self.decisions.skip += 1,
                }
            }
            self.policy_steps += ray.packed_policy().len() as u64;
        }
        for of in &mut self.kinds {
            of.mean_steps = (of.rays > 0).then(|| of.steps as f64 / of.rays as f64);
        }
    }
}

/// Reads the stream once, a block at a time, and counts what is in it.
pub(crate) fn inspect<R: Read + Seek>(reader: &mut StreamReader<R>) -> Result<Inspection, StreamError> {
    reader.seek_frame(0)?;
    let mut frames: Vec<_> = reader.frames().iter().map(FrameSummary::new).collect();
    let mut current = 0;
    for item in &mut *reader {
        match item? {
            Item::Frame(_) => {}
            Item::Rays(chunk) => frames[current].count(&chunk),
            Item::End { policy, .. } => {
                frames[current].end_steps = policy.len() as u64;
                current += 1;
            }
        }
    }
    Ok(Inspection {
        version: reader.version(),
        file_bytes: reader.file_bytes(),
        header: reader.header().clone(),
        frames,
    })
}

/// The inspection as tables for a terminal.
pub(crate) fn render(inspection: &Inspection) -> String {
    let Inspection { version, file_bytes, header, frames } = inspection;
    let mut about = table::<&str>(&[]);
    about.add_row(["scene", &header.scene]);
    about.add_row(["policy", &header.policy]);
    about.add_row(["structure", &format!("{:?}", header.structure)]);
    about.add_row(["resolution", &header.resolution.to_string()]);
    about.add_row(["lights", &header.lights.to_string()]);
    let dynamic = header.primitives - header.static_primitives;
    about.add_row(["triangles", &format!("{} static, {dynamic} dynamic", header.static_primitives)]);
    about.add_row(["input hash", &format!("{:016x}", header.input_hash)]);
    about.add_row(["file", &format!("version {version}, {file_bytes} bytes, {} frames", frames.len())]);

    let mut sizes = table(&[
        "frame",
        "rays",
        "shadow",
        "skipped",
        "dyn. only",
        "dark",
        "policy steps",
        "bytes",
        "raw/stored",
        "bytes/ray",
    ]);
    for frame in frames {
        let shadow = &frame.kinds[RayKind::Shadow as usize];
        sizes.add_row([
            frame.entry.number.to_string(),
            frame.entry.rays.to_string(),
            shadow.rays.to_string(),
            frame.decisions.skip.to_string(),
            frame.decisions.dynamic_only.to_string(),
            shadow.dark.to_string(),
            (frame.policy_steps + frame.end_steps).to_string(),
            frame.entry.bytes.to_string(),
            format!("{:.2}", frame.compression),
            mean((frame.entry.rays > 0).then(|| frame.entry.bytes.0 as f64 / frame.entry.rays as f64)),
        ]);
    }
    align_right(&mut sizes, 0);

    let buckets = frames.iter().flat_map(|frame| &frame.kinds).map(|kind| kind.histogram.len()).max().unwrap_or(0);
    let columns = ["frame", "kind", "rays", "steps/ray"].map(str::to_owned);
    let columns: Vec<String> = columns.into_iter().chain((0..buckets).map(bucket_name)).collect();
    let mut steps = table(&columns);
    for frame in frames {
        for kind in frame.kinds.iter().filter(|kind| kind.rays > 0) {
            let mut row = vec![
                frame.entry.number.to_string(),
                kind.kind.to_owned(),
                kind.rays.to_string(),
                mean(kind.mean_steps),
            ];
            row.extend((0..buckets).map(|bucket| kind.histogram.get(bucket).unwrap_or(&0).to_string()));
            steps.add_row(row);
        }
    }
    align_right(&mut steps, 2);
    format!("{about}\n\n{sizes}\n\nRays by the steps of their paths:\n{steps}\n")
}

/// A mean, or a dash where there is none.
fn mean(value: Option<f64>) -> String {
    value.map_or("-".to_owned(), |value| format!("{value:.2}"))
}

/// The range of steps that a bucket of [`KindSummary::histogram`] stands for.
fn bucket_name(bucket: usize) -> String {
    match bucket {
        0 | 1 => bucket.to_string(),
        _ => format!("{}-{}", 1u64 << (bucket - 1), (1u64 << bucket) - 1),
    }
}

fn table<T: ToString>(columns: &[T]) -> Table {
    let mut table = Table::new();
    table.load_preset(presets::NOTHING);
    if !columns.is_empty() {
        table.set_header(columns.iter().map(ToString::to_string));
    }
    table
}

fn align_right(table: &mut Table, from: usize) {
    for column in table.column_iter_mut().skip(from) {
        column.set_cell_alignment(CellAlignment::Right);
    }
}
