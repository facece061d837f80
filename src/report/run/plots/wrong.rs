//! Wrong shadow decisions in each frame.

use super::section::Section;
use crate::report::draw::canvas::{Canvas, DrawError, LEFT, LINE, Text};
use crate::report::draw::over_frames::{Axes, Label, Panel, name_frames, panel_height};
use crate::report::draw::palette::{Color, FAINT, FALSE_DARK, FALSE_LIT};
use crate::report::draw::{Figure, Plot};
use crate::report::format::{counted, exact, percent, tick};
use crate::report::grid::Grid;
use crate::report::run::summary::{PolicySummary, Summary};

pub(super) const PLOT: Plot<Summary, Section> = Plot { name: "wrong", section: Section::Frames, figure };

const LOOKS: [(&str, Color); 2] = [("false dark", FALSE_DARK), ("false lit", FALSE_LIT)];

type Line<'a> = (&'a str, &'a PolicySummary, u64);

fn figure(summary: &Summary) -> Option<Figure<'_>> {
    let (right, policies): (Vec<Line<'_>>, Vec<Line<'_>>) = summary
        .policies
        .iter()
        .filter(|&(name, _)| summary.baseline.as_deref() != Some(name))
        .filter_map(|(name, policy)| Some((name, policy, policy.counts.wrong()?)))
        .partition(|&(_, _, wrong)| wrong == 0);
    if right.is_empty() && policies.is_empty() {
        return None;
    }
    // All policies share one scale, so that they can be compared.
    let frames = policies.iter().flat_map(|(_, policy, _)| &policy.frames);
    let most = frames.filter_map(|frame| frame.counts.wrong()).max().unwrap_or(0) as f64;
    let title = match policies.iter().max_by_key(|(_, _, wrong)| *wrong) {
        None => "No policy made a wrong shadow decision".into(),
        Some((name, policy, wrong)) => {
            let worst = policy.frames.iter().max_by_key(|frame| frame.counts.wrong());
            let worst =
                worst.map(|it| format!(", most in frame {} ({})", it.frame, exact(it.counts.wrong().unwrap_or(0))));
            format!("{name}: {} wrong shadow decisions{}", exact(*wrong), worst.unwrap_or_default())
        }
    };
    let data = data(&policies);
    let count = policies.len() as i32;
    let axis = if policies.is_empty() { 0 } else { LINE };
    let below = move |width| count * panel_height(width, 1) + axis;
    let rows = right.len() as i32;
    Some(Figure {
        title,
        about: "Shadow rays whose answer differs from that of the same ray traced without culling.".into(),
        key: if count > 0 { LOOKS.map(|(name, color)| (name.to_owned(), color)).into() } else { Vec::new() },
        data,
        narrow: true,
        height: Box::new(move |width| below(width) + rows * LINE + LEFT),
        paint: Box::new(move |canvas| {
            let height = panel_height(canvas.width(), 1);
            if count > 0 {
                name_frames(canvas, count * height - LEFT)?;
            }
            for (index, (name, policy, wrong)) in (0..).zip(&policies) {
                let axes = Axes {
                    heading: &format!("{name}: wrong decisions in a frame"),
                    frames: &summary.frames,
                    values: (0.0, most),
                    labels: 1,
                    least_tick: 1.0,
                    tick,
                };
                let panel = Panel::new(canvas, index * height, &axes)?;
                bars(canvas, &panel, summary, policy)?;
                let share = percent(*wrong as f64 / policy.counts.shadow_rays as f64);
                let (name, note) = (format!("{} in all", exact(*wrong)), format!("{share} of shadow rays"));
                panel.labels(&[Label { value: most / 2.0, color: FAINT, name, note }])?;
            }
            for (index, (name, policy, _)) in (0..).zip(&right) {
                let text = format!("{name}: no wrong decision in {}", counted(policy.frames.len(), "frame"));
                let y = below(canvas.width()) + index * LINE + LINE / 2;
                canvas.text(&text, (LEFT, y), Text::LABEL.bold())?;
            }
            Ok(())
        }),
    })
}

/// One bar per frame: false dark, and false lit on top.
fn bars(
    canvas: &Canvas<'_>,
    panel: &Panel<'_, '_>,
    summary: &Summary,
    policy: &PolicySummary,
) -> Result<(), DrawError> {
    let half = panel.half_bar(&summary.frames);
    for frame in &policy.frames {
        let x = panel.x(frame.frame.into());
        let mut under = 0;
        for (count, (_, color)) in [frame.counts.false_dark, frame.counts.false_lit].into_iter().zip(LOOKS) {
            let count = count.unwrap_or(0);
            if count > 0 {
                let (from, to) = (panel.y(under as f64), panel.y((under + count) as f64));
                // A count above zero is at least one pixel high, so that it is visible.
                canvas.rect((x - half, to.min(from - 1)), (x + half, from), color)?;
            }
            under += count;
        }
    }
    Ok(())
}

fn data(policies: &[Line<'_>]) -> Grid {
    let rows = policies.iter().flat_map(|(name, policy, _)| {
        policy.frames.iter().map(|frame| {
            let count = |count: Option<u64>| count.map_or_else(String::new, |count| count.to_string());
            let counts = [frame.counts.false_dark, frame.counts.false_lit].map(count);
            [(*name).to_owned(), frame.frame.to_string()].into_iter().chain(counts).collect()
        })
    });
    Grid {
        head: ["policy", "frame", "false dark", "false lit"].map(Into::into).to_vec(),
        names: 1,
        rows: rows.collect(),
    }
}
