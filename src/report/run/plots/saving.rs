//! Savings of culling in each frame.

use super::machine::policy_color;
use super::section::Section;
use crate::report::draw::canvas::{LEFT, LINE};
use crate::report::draw::over_frames::{Axes, Label, Panel, name_frames, panel_height};
use crate::report::draw::palette::Color;
use crate::report::draw::{Figure, Plot};
use crate::report::format::{number, percent};
use crate::report::grid::Grid;
use crate::report::run::summary::{FrameSummary, PolicySummary, Saved, Summary};

pub(super) const PLOT: Plot<Summary, Section> = Plot { name: "saving", section: Section::Frames, figure };

/// A panel's heading, the share of a frame, and the shares over all frames.
type Share = (&'static str, fn(&FrameSummary) -> Option<f64>, fn(&PolicySummary) -> &Saved);

const SHARES: [Share; 2] = [
    ("Node visits saved", |frame| frame.traversal_saved, |policy| &policy.traversal_saved),
    ("Triangle tests saved", |frame| frame.intersection_saved, |policy| &policy.intersection_saved),
];

type Line<'a> = (&'a str, &'a PolicySummary, Color);

fn figure(summary: &Summary) -> Option<Figure<'_>> {
    let lines: Vec<Line<'_>> = summary
        .policies
        .iter()
        .filter(|&(name, policy)| {
            let any = policy.frames.iter().any(|frame| SHARES.iter().any(|(_, of, _)| of(frame).is_some()));
            any && summary.baseline.as_deref() != Some(name)
        })
        .map(|(name, policy)| (name, policy, policy_color(summary, name)))
        .collect();
    let mean = |(_, policy, _): &Line<'_>| policy.traversal_saved.mean.unwrap_or(0.0);
    let (name, best, _) = lines.iter().max_by(|a, b| mean(a).total_cmp(&mean(b)))?;
    let mut title = format!("{name} saves ");
    title +=
        &best.traversal_saved.mean.map_or("no work".into(), |mean| format!("{} of the node visits", percent(mean)));
    if let (Some(max), Some(frame)) = (best.traversal_saved.max, best.traversal_saved.max_frame) {
        title += &format!(", most in frame {frame} ({})", percent(max));
    }
    let count = lines.len();
    let height = move |width| SHARES.len() as i32 * panel_height(width, count) + LINE;
    Some(Figure {
        title,
        about:
            "Work of shadow rays saved, as a share of the work without culling in the same frame. What a policy does \
                itself is counted in. Dashed: mean of the frames."
                .into(),
        key: Vec::new(),
        data: data(&lines),
        narrow: true,
        height: Box::new(height),
        paint: Box::new(move |canvas| {
            for (index, (heading, of, sums)) in SHARES.into_iter().enumerate() {
                let shares = lines.iter().flat_map(|(_, policy, _)| policy.frames.iter().filter_map(of));
                let values = shares.fold((0.0, 0.0), |(low, high): (f64, f64), it| (low.min(it), high.max(it)));
                let axes = Axes {
                    heading,
                    frames: &summary.frames,
                    values,
                    labels: lines.len(),
                    least_tick: 0.001,
                    tick: |share| format!("{} %", (share * 1000.0).round() / 10.0),
                };
                let panel = Panel::new(canvas, index as i32 * panel_height(canvas.width(), lines.len()), &axes)?;
                let mut labels = Vec::new();
                for (name, policy, color) in &lines {
                    panel.curve(policy.frames.iter().map(|frame| (frame.frame, of(frame))), *color)?;
                    let Some(mean) = sums(policy).mean else { continue };
                    panel.level(mean, *color)?;
                    let mut note = format!("mean {}", percent(mean));
                    if let (Some(max), Some(frame)) = (sums(policy).max, sums(policy).max_frame) {
                        note += &format!(", most {} in frame {frame}", percent(max));
                    }
                    labels.push(Label { value: mean, color: *color, name: (*name).into(), note });
                }
                panel.labels(&labels)?;
            }
            name_frames(canvas, height(canvas.width()) - LINE - LEFT)
        }),
    })
}

fn data(lines: &[Line<'_>]) -> Grid {
    let row = |name: &str, frame: &FrameSummary| -> Vec<String> {
        let shares = SHARES.iter().map(|(_, of, _)| of(frame).map_or_else(String::new, number));
        [name.to_owned(), frame.frame.to_string()].into_iter().chain(shares).collect()
    };
    Grid {
        head: ["policy", "frame", "node visits saved", "triangle tests saved"].map(Into::into).to_vec(),
        names: 1,
        rows: lines.iter().flat_map(|(name, policy, _)| policy.frames.iter().map(move |it| row(name, it))).collect(),
    }
}
