//! Wrong decisions of each case over its frames.

use super::columns::{HEAD, ROW, first_column, head};
use super::data::{CaseSummary, FrameWrong, Outcome, StressSummary};
use super::section::Section;
use crate::report::draw::canvas::{Canvas, DrawError, LEFT, LINE, Text};
use crate::report::draw::palette::{GRID, INK, VERMILLION};
use crate::report::draw::{Figure, Plot};
use crate::report::format::{counted, exact};
use crate::report::grid::Grid;

pub(super) const PLOT: Plot<StressSummary, Section> =
    Plot { name: "wrong-over-frames", section: Section::OverFrames, figure };

/// Bars of wrong decisions by frame, for the cases and policies that have any.
fn figure(summary: &StressSummary) -> Option<Figure<'_>> {
    let fails = |frames: &[FrameWrong]| Outcome::of(frames) != Outcome::Right;
    let columns: Vec<_> = (0..summary.policies.len())
        .filter(|&column| summary.cases.iter().any(|case| fails(&case.policies[column])))
        .collect();
    let cases: Vec<&CaseSummary> =
        summary.cases.iter().filter(|case| case.policies.iter().any(|frames| fails(frames))).collect();
    let name = |column: usize| summary.policies[column].name.as_str();
    let rows =
        cases.iter().flat_map(|case| columns.iter().map(move |&column| (*case, column))).flat_map(|(case, column)| {
            let frames = (0..).zip(&case.policies[column]);
            frames.map(move |(frame, wrong): (usize, _)| {
                let numbers = [frame as u64, wrong.false_dark, wrong.false_lit].map(|number| number.to_string());
                [case.name.clone(), name(column).to_owned()].into_iter().chain(numbers).collect()
            })
        });
    let data = Grid {
        head: ["case", "policy", "frame", "false dark", "false lit"].map(Into::into).to_vec(),
        names: 2,
        rows: rows.collect(),
    };
    if cases.is_empty() {
        return None;
    }
    let height = HEAD + cases.len() as i32 * 2 * ROW + LINE;
    Some(Figure {
        title: format!("{} of {} have frames with wrong decisions", cases.len(), counted(summary.cases.len(), "case")),
        about: "A bar a frame, those of a case on one scale; the number is the most in a frame.".into(),
        key: Vec::new(),
        data,
        narrow: true,
        height: Box::new(move |_| height),
        paint: Box::new(move |canvas| {
            let names: Vec<&str> = columns.iter().map(|&column| name(column)).collect();
            let width = head(canvas, HEAD, &names)?;
            (0..)
                .zip(&cases)
                .try_for_each(|(row, case)| draw_case(canvas, case, &columns, HEAD + (row + 1) * 2 * ROW - 6, width))
        }),
    })
}

fn draw_case(
    canvas: &Canvas<'_>,
    case: &CaseSummary,
    columns: &[usize],
    bottom: i32,
    width: i32,
) -> Result<(), DrawError> {
    canvas.text(&case.name, (LEFT, bottom - 14), Text::NOTE.colored(INK))?;
    let most = case.policies.iter().flatten().map(FrameWrong::wrong).max().unwrap_or(0).max(1);
    for (place, &column) in (0..).zip(columns) {
        let (left, frames) = (first_column(canvas) + place * width, &case.policies[column]);
        canvas.line(vec![(left, bottom), (left + width - 8, bottom)], GRID, 1)?;
        let bar = ((width - 8) / frames.len().max(1) as i32).max(1);
        for (frame, wrong) in (0..).zip(frames) {
            if wrong.wrong() > 0 {
                let height = (wrong.wrong() * 26).div_ceil(most) as i32;
                let x = left + frame * bar;
                canvas.rect((x, bottom - height), (x + bar - 1, bottom), VERMILLION)?;
            }
        }
        if let Outcome::Healed { worst, .. } | Outcome::Wrong { worst, .. } = Outcome::of(frames) {
            canvas.text(&exact(worst), (left, bottom - 34), Text::NOTE)?;
        }
    }
    Ok(())
}
