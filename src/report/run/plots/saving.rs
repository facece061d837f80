//! What culling saved in each frame.

use plotters::style::RGBColor;

use super::section::Section;
use crate::report::draw::Plot;
use crate::report::draw::canvas::{DrawError, LEFT, LINE, TITLES, Text, policy_color, svg};
use crate::report::draw::over_frames::{Axes, DATA, LABEL, LABELS, Panel, name_frames, panel_height};
use crate::report::format::percent;
use crate::report::run::summary::{FrameSummary, PolicySummary, Saved, Summary};

pub(super) const PLOT: Plot<Summary, Section> = Plot { name: "saving", section: Section::Saving, draw };

/// A panel's heading, a frame's share and the sums of the frames' shares.
type Share = (&'static str, fn(&FrameSummary) -> Option<f64>, fn(&PolicySummary) -> &Saved);

const SHARES: [Share; 2] = [
    ("Node visits saved", |frame| frame.traversal_saved, |policy| &policy.traversal_saved),
    ("Triangle tests saved", |frame| frame.intersection_saved, |policy| &policy.intersection_saved),
];

fn draw(summary: &Summary) -> Result<Option<String>, DrawError> {
    let policies: Vec<(&str, &PolicySummary, RGBColor)> = summary
        .policies
        .iter()
        .filter(|&(name, policy)| {
            let any = policy.frames.iter().any(|frame| SHARES.iter().any(|(_, of, _)| of(frame).is_some()));
            any && summary.baseline.as_deref() != Some(name)
        })
        .enumerate()
        .map(|(index, (name, policy))| (name, policy, policy_color(index)))
        .collect();
    if policies.is_empty() {
        return Ok(None);
    }
    // Room for every policy's label.
    let data = DATA.max(policies.len() as i32 * LABEL);
    let panels = TITLES + SHARES.len() as i32 * panel_height(data);
    svg(panels + LINE, |canvas| {
        canvas.titles(
            "Work of shadow rays saved, frame by frame",
            "share of the work without culling in the same frame; dashed: mean of the frames",
        )?;
        for (index, (heading, of, sums)) in SHARES.into_iter().enumerate() {
            let shares = policies.iter().flat_map(|(_, policy, _)| policy.frames.iter().filter_map(of));
            let values = shares.fold((0.0, 0.0), |(low, high): (f64, f64), share| (low.min(share), high.max(share)));
            let top = TITLES + index as i32 * panel_height(data);
            let axes = Axes {
                heading,
                frames: &summary.frames,
                values,
                height: data,
                least_tick: 0.001,
                tick: |share| format!("{} %", (share * 1000.0).round() / 10.0),
            };
            let panel = Panel::new(canvas, top, &axes)?;
            let mut labels = Vec::new();
            for (name, policy, color) in &policies {
                let place = |frame: &FrameSummary| Some((panel.x(frame.frame.into()), panel.y(of(frame)?)));
                // A line ends where a frame has no share.
                for run in policy.frames.iter().map(place).collect::<Vec<_>>().split(Option::is_none) {
                    let points: Vec<(i32, i32)> = run.iter().flatten().copied().collect();
                    if points.len() > 1 {
                        canvas.line(points.clone(), *color, 2)?;
                    }
                    points.iter().try_for_each(|&point| canvas.dot(point, 3, *color))?;
                }
                if let Some(mean) = sums(policy).mean {
                    panel.level(mean, *color)?;
                    labels.push((*name, sums(policy), mean, *color));
                }
            }
            let heights = panel.labels(labels.iter().map(|&(_, _, mean, _)| mean));
            for ((name, sums, mean, color), y) in labels.into_iter().zip(heights) {
                canvas.text(name, (LABELS, y), Text::LABEL.bold().colored(color))?;
                let mut text = format!("mean {}", percent(mean));
                if let (Some(max), Some(frame)) = (sums.max, sums.max_frame) {
                    text += &format!(", most {} in {frame}", percent(max));
                }
                canvas.text(&text, (LABELS, y + 17), Text::NOTE)?;
            }
        }
        name_frames(canvas, panels - LEFT / 2)
    })
    .map(Some)
}
