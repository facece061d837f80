//! `inspect`: what a recorded ray stream holds.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use super::outcome::Outcome;
use super::print::print;
use crate::json;
use crate::report::format::{bytes, exact, or_absent};
use crate::report::{Grid, drawn};
use crate::stream::inspect::{FrameSummary, Inspection, KindSummary, inspect};
use crate::stream::{RayKind, StreamReader};

/// Say what a recorded ray stream holds
#[derive(Args)]
pub(super) struct Inspect {
    /// The stream's file
    stream: PathBuf,
    /// As JSON
    #[arg(long)]
    json: bool,
}

impl Inspect {
    pub(super) fn run(self) -> Result<Outcome> {
        let inspection = inspect(&mut StreamReader::open(&self.stream)?)?;
        let text = if self.json { json::pretty(&inspection)? } else { render(&inspection) };
        print(text)?;
        Ok(Outcome::Done)
    }
}

/// The inspection as text for a terminal.
fn render(inspection: &Inspection) -> String {
    let Inspection { version, file_bytes, header, frames } = inspection;
    let (fixed, moving) = (header.static_primitives, header.primitives - header.static_primitives);
    let about = [
        ("scene", header.scene.clone()),
        ("policy", header.policy.clone()),
        ("structure", format!("{:?}", header.structure)),
        ("resolution", header.resolution.to_string()),
        ("lights", header.lights.to_string()),
        ("triangles", format!("{} static, {} dynamic", exact(fixed.into()), exact(moving.into()))),
        ("input hash", format!("{:016x}", header.input_hash)),
        ("file", format!("version {version}, {}, {} frames", bytes(*file_bytes), frames.len())),
    ];
    let about = about.map(|(name, text)| format!("{name:<10}  {text}")).join("\n");
    let [sizes, steps] = [sizes(frames), steps(frames)].map(|grid| drawn(&grid));
    format!("{about}\n\n{sizes}\n\nRays by the steps of their paths:\n\n{steps}")
}

/// One row per frame: its rays, decisions and bytes.
fn sizes(frames: &[FrameSummary]) -> Grid {
    let head = ["frame", "rays", "shadow", "skipped", "dynamic only", "dark", "policy steps", "bytes", "bytes/ray"];
    let row = |frame: &FrameSummary| {
        let shadow = &frame.kinds[RayKind::Shadow as usize];
        let counts = [
            frame.entry.rays,
            shadow.rays,
            frame.decisions.skip,
            frame.decisions.dynamic_only,
            shadow.dark,
            frame.policy_steps + frame.end_steps,
            frame.entry.bytes.0,
        ];
        let a_ray = (frame.entry.rays > 0).then(|| frame.entry.bytes.0 as f64 / frame.entry.rays as f64);
        let number = std::iter::once(frame.entry.number.to_string());
        number.chain(counts.map(exact)).chain([or_absent(a_ray, two_places)]).collect()
    };
    Grid { head: head.map(Into::into).into(), names: 1, rows: frames.iter().map(row).collect() }
}

/// One row per frame and kind of rays: the numbers of rays by the steps of their paths.
fn steps(frames: &[FrameSummary]) -> Grid {
    let kinds = || frames.iter().flat_map(|frame| frame.kinds.iter().map(move |kind| (frame, kind)));
    let buckets = kinds().map(|(_, kind)| kind.histogram.len()).max().unwrap_or_default();
    let head = ["frame", "kind", "rays", "steps/ray"].map(str::to_owned);
    let row = |(frame, kind): (&FrameSummary, &KindSummary)| {
        let first = [frame.entry.number.to_string(), kind.kind.to_owned(), exact(kind.rays)];
        let counts = (0..buckets).map(|bucket| exact(kind.histogram.get(bucket).copied().unwrap_or_default()));
        first.into_iter().chain([or_absent(kind.mean_steps, two_places)]).chain(counts).collect()
    };
    Grid {
        head: head.into_iter().chain((0..buckets).map(bucket_name)).collect(),
        names: 2,
        rows: kinds().filter(|(_, kind)| kind.rays > 0).map(row).collect(),
    }
}

fn two_places(value: f64) -> String {
    format!("{value:.2}")
}

/// The range of steps of a bucket of [`KindSummary::histogram`].
fn bucket_name(bucket: usize) -> String {
    match bucket {
        0 | 1 => bucket.to_string(),
        _ => format!("{}-{}", 1u64 << (bucket - 1), (1u64 << bucket) - 1),
    }
}
