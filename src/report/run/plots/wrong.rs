//! Wrong shadow decisions in each frame.

use plotters::style::RGBColor;

use super::section::Section;
use crate::report::draw::Plot;
use crate::report::draw::canvas::{Canvas, DrawError, LEFT, LINE, TITLES, Text, legend_height, palette, svg};
use crate::report::draw::over_frames::{Axes, DATA, LABELS, Panel, name_frames, panel_height};
use crate::report::format::{counted, exact, percent, tick};
use crate::report::run::summary::{PolicySummary, Summary};

pub(super) const PLOT: Plot<Summary, Section> = Plot { name: "wrong", section: Section::Correctness, draw };

const LOOKS: [(&str, RGBColor); 2] = [("false dark", palette::VERMILLION), ("false lit", palette::SKY)];

fn draw(summary: &Summary) -> Result<Option<String>, DrawError> {
    let (right, policies): (Vec<_>, Vec<_>) = summary
        .policies
        .iter()
        .filter(|&(name, _)| summary.baseline.as_deref() != Some(name))
        .filter_map(|(name, policy)| Some((name, policy, policy.counts.wrong()?)))
        .partition(|&(_, _, wrong)| wrong == 0);
    if right.is_empty() && policies.is_empty() {
        return Ok(None);
    }
    let legend = LOOKS.map(|(name, color)| (name.to_owned(), color));
    let top = TITLES + if policies.is_empty() { 0 } else { legend_height(&legend) };
    let below = top + policies.len() as i32 * panel_height(DATA) + if policies.is_empty() { 0 } else { LINE };
    // One scale, so that policies compare.
    let frames = policies.iter().flat_map(|(_, policy, _)| &policy.frames);
    let most = frames.filter_map(|frame| frame.counts.wrong()).max().unwrap_or(0) as f64;
    svg(below + right.len() as i32 * LINE + LINE, |canvas| {
        canvas.titles(
            "Wrong shadow decisions, frame by frame",
            "shadow rays whose answer differs from that of the same ray traced without culling",
        )?;
        if !policies.is_empty() {
            canvas.legend(TITLES, &legend)?;
            name_frames(canvas, below - LINE - LEFT / 2)?;
        }
        for (index, (name, policy, wrong)) in policies.iter().enumerate() {
            let axes = Axes {
                heading: &format!("{name}: wrong decisions in a frame"),
                frames: &summary.frames,
                values: (0.0, most),
                height: DATA,
                least_tick: 1.0,
                tick,
            };
            let panel = Panel::new(canvas, top + index as i32 * panel_height(DATA), &axes)?;
            bars(canvas, &panel, summary, policy)?;
            let y = panel.y(most / 2.0);
            canvas.text(&format!("{} in all", exact(*wrong)), (LABELS, y), Text::LABEL.bold())?;
            let share = percent(*wrong as f64 / policy.counts.shadow_rays as f64);
            canvas.text(&format!("{share} of shadow rays"), (LABELS, y + 17), Text::NOTE)?;
        }
        for (index, (name, policy, _)) in right.iter().enumerate() {
            let text = format!("{name}: no wrong decision in {}", counted(policy.frames.len(), "frame"));
            canvas.text(&text, (LEFT, below + index as i32 * LINE + LINE / 2), Text::LABEL.bold())?;
        }
        Ok(())
    })
    .map(Some)
}

/// A bar a frame: false dark, and false lit on top of it.
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
                // What is there is seen, however little it is.
                canvas.rect((x - half, to.min(from - 1)), (x + half, from), color)?;
            }
            under += count;
        }
    }
    Ok(())
}
