//! Simulated time of each frame that a machine replayed.

use super::machine::{Machine, MachinePlot};
use crate::report::draw::Figure;
use crate::report::draw::canvas::{LEFT, LINE};
use crate::report::draw::over_frames::{Axes, Label, Panel, name_frames, panel_height};
use crate::report::format::{milliseconds, number, tick};
use crate::report::grid::Grid;
use crate::stats::{FrameStats, MachineStats};

pub(super) const PLOT: MachinePlot = MachinePlot { name: "times", figure };

fn time(stats: &MachineStats, frame: &FrameStats) -> f64 {
    frame.cycles.0 as f64 / (stats.clock_mhz * 1e3)
}

fn figure<'a>(machine: &'a Machine<'a>) -> Option<Figure<'a>> {
    let name = machine.name;
    let runs: Vec<_> = machine.runs().filter(|(_, run)| !run.stats.frames.is_empty()).collect();
    if runs.iter().all(|(_, run)| run.stats.frames.len() < 2) {
        return None;
    }
    let changes = machine.changes(|run| run.milliseconds_per_frame);
    let row = |policy: &str, stats: &MachineStats, frame: &FrameStats| -> Vec<String> {
        let warmup = if frame.warmup { "warm-up" } else { "measured" };
        vec![policy.to_owned(), frame.frame.to_string(), warmup.into(), number(time(stats, frame))]
    };
    let rows = runs.iter().flat_map(|(policy, run)| run.stats.frames.iter().map(|it| row(policy, &run.stats, it)));
    let data = Grid { head: ["policy", "frame", "", "ms"].map(Into::into).to_vec(), names: 1, rows: rows.collect() };
    let count = runs.len();
    Some(Figure {
        title: changes.map_or_else(|| format!("{name}: time a frame"), |it| format!("{name}: time a frame {it}")),
        about: "Simulated time of each frame that the machine replayed. Rings: warm-up frames, which are in no mean. \
                Dashed: mean of the measured frames."
            .into(),
        key: Vec::new(),
        data,
        narrow: true,
        height: Box::new(move |width| panel_height(width, count) + LINE),
        paint: Box::new(move |canvas| {
            let all = runs.iter().flat_map(|(_, run)| run.stats.frames.iter().map(|it| time(&run.stats, it)));
            let axes = Axes {
                heading: "ms a frame",
                frames: &machine.run.frames,
                values: (0.0, all.fold(0.0, f64::max)),
                labels: count,
                least_tick: 1e-6,
                tick,
            };
            let panel = Panel::new(canvas, 0, &axes)?;
            let mut labels = Vec::new();
            for (policy, run) in &runs {
                let color = machine.color(policy);
                panel.curve(run.stats.frames.iter().map(|it| (it.frame, Some(time(&run.stats, it)))), color)?;
                for frame in run.stats.frames.iter().filter(|frame| frame.warmup) {
                    let at = (panel.x(frame.frame.into()), panel.y(time(&run.stats, frame)));
                    canvas.ring(at, 6, color, 1)?;
                }
                let Some(mean) = run.milliseconds_per_frame else { continue };
                panel.level(mean, color)?;
                let note = format!("mean {} ms", milliseconds(mean));
                labels.push(Label { value: mean, color, name: (*policy).into(), note });
            }
            panel.labels(&labels)?;
            name_frames(canvas, panel_height(canvas.width(), count) - LEFT)
        }),
    })
}
