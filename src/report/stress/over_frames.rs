//! Wrong decisions of each case over its frames.

use super::columns::{COLUMNS, HEAD, ROW, head};
use super::data::{CaseSummary, FrameWrong, Outcome, StressSummary};
use super::section::Section;
use crate::report::draw::canvas::{LEFT, LINE, TITLES, Text, palette, svg};
use crate::report::draw::{DrawError, Plot};
use crate::report::format::exact;

pub(super) const PLOT: Plot<StressSummary, Section> =
    Plot { name: "wrong-over-frames", section: Section::OverFrames, draw: |summary| draw(summary).map(Some) };

/// Bars of wrong decisions, frame by frame, for the cases and policies that have any.
fn draw(summary: &StressSummary) -> Result<String, DrawError> {
    let fails = |frames: &[FrameWrong]| Outcome::of(frames) != Outcome::Right;
    let columns: Vec<_> = (0..summary.policies.len())
        .filter(|&column| summary.cases.iter().any(|case| fails(&case.policies[column])))
        .collect();
    let cases: Vec<&CaseSummary> =
        summary.cases.iter().filter(|case| case.policies.iter().any(|frames| fails(frames))).collect();
    let names: Vec<_> = columns.iter().map(|&column| summary.policies[column].name.as_str()).collect();
    let top = TITLES + HEAD;
    let row_height = 2 * ROW;
    svg(top + cases.len() as i32 * row_height + LINE, |canvas| {
        canvas.titles(
            "Wrong shadow decisions over the frames",
            "a bar a frame, those of a case on one scale; the number is the most in a frame",
        )?;
        let width = head(canvas, top, &names)?;
        for (row, case) in (0..).zip(&cases) {
            let bottom = top + (row + 1) * row_height - 6;
            canvas.text(&case.name, (LEFT, bottom - 14), Text::LABEL)?;
            let all = case.policies.iter().flatten().map(FrameWrong::wrong);
            let most = all.max().unwrap_or(0).max(1);
            for (place, &column) in (0..).zip(&columns) {
                let (left, frames) = (COLUMNS + place * width, &case.policies[column]);
                canvas.line(vec![(left, bottom), (left + width - 8, bottom)], palette::GRID, 1)?;
                let bar = (width - 8) / frames.len().max(1) as i32;
                for (frame, wrong) in (0..).zip(frames) {
                    if wrong.wrong() > 0 {
                        let height = (wrong.wrong() * 26).div_ceil(most) as i32;
                        let x = left + frame * bar;
                        canvas.rect((x, bottom - height), (x + bar - 1, bottom), palette::VERMILLION)?;
                    }
                }
                if let Outcome::Healed { worst, .. } | Outcome::Wrong { worst, .. } = Outcome::of(frames) {
                    canvas.text(&exact(worst), (left, bottom - 34), Text::NOTE)?;
                }
            }
        }
        Ok(())
    })
}
