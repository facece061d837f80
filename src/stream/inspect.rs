//! Summarises a ray stream file for people: counts and sizes of each frame.

use std::io::{Read, Seek};

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
    /// The stream's header.
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
    /// Rays of each kind, in the order of [`RayKind::ALL`], kinds without rays included.
    pub kinds: Vec<KindSummary>,
    /// The policy's decisions for the shadow rays.
    pub decisions: Decisions,
    /// Steps of the policy that are recorded for rays.
    pub policy_steps: u64,
    /// Steps of the policy at the frame's end.
    pub end_steps: u64,
}

/// Shadow rays by the policy's decision.
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
    /// Number of rays.
    pub rays: u64,
    /// Rays that hit nothing.
    pub miss: u64,
    /// Rays that hit a primitive.
    pub hit: u64,
    /// Rays that see their light.
    pub lit: u64,
    /// Rays that do not see their light.
    pub dark: u64,
    /// Steps of their paths.
    pub steps: u64,
    /// Steps a ray; `None` without a ray.
    pub mean_steps: Option<f64>,
    /// Rays by the length of their paths. Element 0 counts paths without a step, element `k` paths of 2^(k-1) to 2^k -
    /// 1 steps; the last element counts the longest path.
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

/// Reads the stream once, a block at a time, and counts its contents.
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
