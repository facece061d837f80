//! Strips over the time of the measured frames: the cycles of each kind of unit by cause, and the DRAM's share of peak
//! bandwidth.

use super::machine::{Machine, MachinePlot};
use crate::report::draw::Figure;
use crate::report::draw::canvas::{Canvas, DrawError, LEFT, LINE, Text, tick_step};
use crate::report::draw::palette::{Color, FAINT, GRID, INK, cause_look, faded, pale};
use crate::report::format::{number, percent, tick, words};
use crate::report::grid::Grid;
use crate::report::run::limits;
use crate::report::run::machine_run::MachineRun;
use crate::report::run::over_time::Span;
use crate::stats::Cause;

pub(super) const PLOT: MachinePlot = MachinePlot { name: "over_time", figure };

/// Heights: of a strip, of the space below it, and of a policy's heading.
const STRIP: i32 = 30;
const GAP: i32 = 5;
const HEAD: i32 = 26;
/// Gap between two frames.
const APART: i32 = 3;
/// The most spans to draw, all frames together: on a wide sheet; and on a narrow sheet or as data.
const SPANS: usize = 48;
const FEW_SPANS: usize = 24;
/// A cause is drawn if it has at least this share somewhere.
const LEAST: f64 = 0.02;
/// A unit with a smaller busy share stands still.
const STILL: f64 = 0.05;
/// A kind of unit has a strip if its busy share reaches this at some time.
const WORKS: f64 = 0.2;

/// A policy's run.
struct Run<'a> {
    policy: &'a str,
    spans: &'a [Span],
    clock_mhz: f64,
    /// Peak bytes of the DRAM per cycle.
    peak: Option<f64>,
}

impl Run<'_> {
    /// The spans by frame, joined in pairs until there are at most `most`, or one per frame.
    fn frames(&self, most: usize) -> Vec<Vec<Span>> {
        let mut frames: Vec<Vec<Span>> = self.spans.chunk_by(|a, b| a.frame == b.frame).map(<[_]>::to_vec).collect();
        while frames.iter().map(Vec::len).sum::<usize>() > most.max(frames.len()) {
            frames.iter_mut().for_each(|frame| *frame = frame.chunks(2).map(Span::joined).collect());
        }
        frames
    }

    fn cycles(&self) -> u64 {
        self.spans.iter().map(|span| span.cycles).sum()
    }

    /// Simulated time in ms.
    fn time(&self, cycles: u64) -> f64 {
        cycles as f64 / (self.clock_mhz * 1e3)
    }

    /// The share of the DRAM's bandwidth that a span uses.
    fn dram(&self, span: &Span) -> Option<f64> {
        Some(span.dram_bytes as f64 / (self.peak? * span.cycles.max(1) as f64))
    }
}

fn figure<'a>(machine: &'a Machine<'a>) -> Option<Figure<'a>> {
    let run = |(policy, run): (&'a str, &'a MachineRun)| {
        let spans = machine.spans(policy);
        let (clock_mhz, peak) = (run.stats.clock_mhz, run.stats.dram_peak_bytes_per_cycle);
        (!spans.is_empty()).then_some(Run { policy, spans, clock_mhz, peak })
    };
    let runs: Vec<Run<'_>> = machine.runs().filter_map(run).collect();
    let works = |unit: &&str| runs.iter().flat_map(|run| run.spans).any(|span| span.share(unit, Cause::Busy) >= WORKS);
    let units = machine.keys(|run| &run.stats.units).into_iter().filter(|unit| *unit != "dispatcher");
    let units: Vec<&str> = units.filter(works).collect();
    if runs.is_empty() || units.is_empty() {
        return None;
    }
    let height = runs.iter().map(|run| HEAD + strips(run, &units) * (STRIP + GAP)).sum::<i32>() + 2 * LINE + 6;
    let data = data(&runs, &units);
    let seen = |cause: &Cause| {
        let mut shares =
            runs.iter().flat_map(|run| run.spans).flat_map(|it| units.iter().map(|unit| it.share(unit, *cause)));
        shares.any(|share| share >= LEAST)
    };
    let causes = Cause::ALL.into_iter().filter(seen).collect::<Vec<_>>().into_iter();
    let used = (runs.iter().any(|run| run.peak.is_some())).then(|| ("used of the DRAM's peak".to_owned(), USED));
    Some(Figure {
        title: title(machine, &runs),
        about: "One strip for each kind of units: the share of each cause over the time of the measured frames. All \
                policies have the same scale of time. A box marks the frame that is chosen above."
            .into(),
        key: causes.map(|cause| (cause_look(cause).0.to_owned(), look(cause))).chain(used).collect(),
        data,
        narrow: true,
        height: Box::new(move |_| height),
        paint: Box::new(move |canvas| paint(canvas, &runs, &units)),
    })
}

/// The colour of the used DRAM bandwidth.
const USED: Color = FAINT;

/// The colour of a cause. Starved units are paler than in other plots, so that the other causes stand out.
fn look(cause: Cause) -> Color {
    let (_, color) = cause_look(cause);
    if cause == Cause::Starved { pale(color) } else { color }
}

/// A title about the last run: how long the busiest kind of unit stands still, or how steadily it is busy, and the
/// largest DRAM utilization.
fn title(machine: &Machine<'_>, runs: &[Run<'_>]) -> String {
    let steady = runs.last().and_then(|run| {
        let found = machine.found.policies.get(run.policy)?;
        let (unit, _) = limits::busiest(found)?;
        let shares = || run.spans.iter().map(|span| (span.cycles, span.share(unit, Cause::Busy)));
        let works = || shares().map(|(_, share)| share).filter(|&share| share >= STILL);
        let (least, most) = (works().fold(1.0, f64::min), works().fold(0.0, f64::max));
        let still = shares().filter(|(_, share)| *share < STILL).map(|(cycles, _)| cycles).sum::<u64>();
        let still = still as f64 / run.cycles().max(1) as f64;
        let busy = match still {
            still if still >= LEAST => format!("stand still for {} of the time", percent(still)),
            _ => format!("are {} to {} busy", percent(least), percent(most)),
        };
        let dram = run.spans.iter().filter_map(|span| run.dram(span)).reduce(f64::max);
        let dram = dram.map(|most| format!("; up to {} of the DRAM's peak is used", percent(most)));
        Some(format!("with {}, {} units {busy}{}", run.policy, words(unit), dram.unwrap_or_default()))
    });
    format!("{}: {}", machine.name, steady.unwrap_or_else(|| "units over time".into()))
}

fn data(runs: &[Run<'_>], units: &[&str]) -> Grid {
    let busy = units.iter().map(|unit| format!("{} busy", words(unit)));
    let head = ["policy", "frame", "from, ms"].into_iter().map(String::from).chain(busy);
    let head = head.chain(["DRAM used".to_owned()]).collect();
    let row = |run: &Run<'_>, span: &Span| {
        let names = [run.policy.to_owned(), span.frame.to_string(), number(run.time(span.begin))];
        let share = |value: f64| number((value * 1e3).round() / 1e3);
        let busy = units.iter().map(|unit| share(span.share(unit, Cause::Busy)));
        names.into_iter().chain(busy).chain([run.dram(span).map_or_else(String::new, share)]).collect()
    };
    let rows = runs
        .iter()
        .flat_map(|run| run.frames(FEW_SPANS).into_iter().flatten().map(|span| row(run, &span)).collect::<Vec<_>>())
        .collect();
    Grid { head, names: 1, rows }
}

fn paint(canvas: &Canvas<'_>, runs: &[Run<'_>], units: &[&str]) -> Result<(), DrawError> {
    let names = units.iter().map(|unit| Text::NOTE.width(&words(unit))).max().unwrap_or(0);
    let (left, right) = (LEFT + names.max(Text::NOTE.width("DRAM")) + 10, canvas.width() - 2 * LEFT - 10);
    let spans = if canvas.is_narrow() { FEW_SPANS } else { SPANS };
    let runs: Vec<_> = runs.iter().map(|run| (run, run.frames(spans))).collect();
    let frames = runs.iter().map(|(_, frames)| frames.len() as i32).max().unwrap_or(1);
    let longest = runs.iter().map(|(run, _)| run.time(run.cycles())).fold(f64::MIN_POSITIVE, f64::max);
    let scale = f64::from(right - left - APART * (frames - 1)) / longest;
    let (mut y, mut places_of_frames) = (0, Vec::new());
    for (run, frames) in &runs {
        canvas.text(run.policy, (LEFT, y + HEAD / 2), Text::LABEL.bold())?;
        let columns = columns(run, frames, left, scale);
        // Names of frames, where there is room.
        let mut free = LEFT + Text::LABEL.bold().width(run.policy) + 10;
        for (frame, places) in frames.iter().zip(&columns) {
            let (Some(span), Some(&from)) = (frame.first(), places.first()) else { continue };
            let name = format!("frame {}", span.frame);
            let bottom = y + HEAD + strips(run, units) * (STRIP + GAP);
            let to = places[places.len() - 1];
            places_of_frames.push(format!("{} {from} {} {to} {bottom}", span.frame, y + HEAD));
            if from >= free {
                canvas.text(&name, (from, y + HEAD / 2), Text::NOTE)?;
                free = from + Text::NOTE.width(&name) + 8;
            }
        }
        y += HEAD;
        for unit in units {
            canvas.text(&words(unit), (left - 8, y + STRIP / 2), Text::NOTE.colored(INK).right())?;
            for (frame, places) in frames.iter().zip(&columns) {
                unit_strip(canvas, unit, frame, places, y)?;
            }
            y += STRIP + GAP;
        }
        if run.peak.is_some() {
            canvas.text("DRAM", (left - 8, y + STRIP / 2), Text::NOTE.colored(INK).right())?;
            for (frame, places) in frames.iter().zip(&columns) {
                let (from, to) = (places[0], places[places.len() - 1]);
                canvas.rect((from, y), (to, y + STRIP), faded(INK, 0.06))?;
                let used: Vec<f64> = frame.iter().map(|span| run.dram(span).unwrap_or(0.0).min(1.0)).collect();
                area(canvas, &used, places, y, USED)?;
            }
            y += STRIP + GAP;
        }
    }
    // The page's script uses these places to mark the chosen frame and to find a clicked one.
    canvas.attribute("data-strips", &places_of_frames.join(" "));
    let step = tick_step(longest, if canvas.is_narrow() { 4 } else { 10 });
    for at in (0..).map(|tick| f64::from(tick) * step).take_while(|&at| at <= longest * 1.000_001) {
        // Gaps between frames represent no time.
        let x = left + (at / longest * f64::from(right - left)).round() as i32;
        canvas.line(vec![(x, 0), (x, y)], GRID, 1)?;
        canvas.text(&tick(at), (x, y + 12), Text::NOTE.centered())?;
    }
    canvas.text("time of the measured frames, ms", ((left + right) / 2, y + 32), Text::NOTE.centered())
}

/// Number of strips of a run.
fn strips(run: &Run<'_>, units: &[&str]) -> i32 {
    units.len() as i32 + i32::from(run.peak.is_some())
}

/// For each frame, the columns where its spans begin, and the column where the last span ends.
fn columns(run: &Run<'_>, frames: &[Vec<Span>], left: i32, scale: f64) -> Vec<Vec<i32>> {
    let mut passed = 0;
    let column = |passed: u64, frame: i32| left + frame * APART + (run.time(passed) * scale).round() as i32;
    let of_frame = |(index, frame): (i32, &Vec<Span>)| {
        let mut places = vec![column(passed, index)];
        for span in frame {
            passed += span.cycles;
            places.push(column(passed, index));
        }
        places
    };
    (0..).zip(frames).map(of_frame).collect()
}

/// Draws the cycles of a kind of unit in a frame: stacked causes, busy at the bottom.
fn unit_strip(canvas: &Canvas<'_>, unit: &str, frame: &[Span], places: &[i32], top: i32) -> Result<(), DrawError> {
    let (from, to) = (places[0], places[places.len() - 1]);
    canvas.rect((from, top), (to, top + STRIP), look(Cause::Starved))?;
    let mut causes: Vec<Cause> = Cause::ALL.into_iter().filter(|&cause| cause != Cause::Starved).collect();
    // The sum of all causes is drawn first, and smaller sums over it.
    while let Some(&last) = causes.last() {
        if frame.iter().any(|span| span.share(unit, last) >= LEAST) {
            let sum = |span: &Span| causes.iter().map(|&cause| span.share(unit, cause)).sum::<f64>();
            area(canvas, &frame.iter().map(sum).collect::<Vec<_>>(), places, top, look(last))?;
        }
        causes.pop();
    }
    Ok(())
}

/// Fills the area below shares; each share lies in the middle of its span.
fn area(canvas: &Canvas<'_>, shares: &[f64], places: &[i32], top: i32, color: Color) -> Result<(), DrawError> {
    let (Some(&first), Some(&last)) = (shares.first(), shares.last()) else { return Ok(()) };
    let (from, to, bottom) = (places[0], places[places.len() - 1], top + STRIP);
    let y = |share: f64| bottom - (share * f64::from(STRIP)).round() as i32;
    let middles = places.windows(2).zip(shares).map(|(pair, &share)| (pair[0].midpoint(pair[1]), y(share)));
    let ends = [(to, y(last)), (to, bottom)];
    let points: Vec<(i32, i32)> = [(from, bottom), (from, y(first))].into_iter().chain(middles).chain(ends).collect();
    // Points between two others of the same height are not needed.
    let level =
        |at: usize| at > 0 && at + 1 < points.len() && points[at - 1..=at + 1].iter().all(|it| it.1 == points[at].1);
    canvas.polygon((0..points.len()).filter(|&at| !level(at)).map(|at| points[at]).collect(), color)
}
