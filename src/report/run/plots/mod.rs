//! Plots of a run, each in a file of its own. To add a plot, write its file and add it to [`RUN_PLOTS`],
//! [`FRAME_PLOTS`] or [`MACHINE_PLOTS`].

mod bytes;
mod diagram;
mod dram_rows;
mod hit_rates;
mod machine;
mod over_time;
mod reuse;
mod saving;
mod section;
mod split;
mod times;
mod tradeoff;
mod utilization;
mod wrong;

use super::over_time::OverTime;
use super::summary::Summary;
use crate::report::draw::{DrawError, Drawing, Plot, draw_all};
use crate::report::file_names::file_names;
use machine::{Machine, MachinePlot};

pub(super) use section::Section;

/// Plots drawn once per run, in the page's order.
const RUN_PLOTS: &[Plot<Summary, Section>] = &[saving::PLOT, wrong::PLOT, tradeoff::PLOT];

/// Plots over frames drawn once per machine, in the page's order.
const FRAME_PLOTS: &[MachinePlot] = &[times::PLOT];

/// Plots drawn once per machine, in the page's order.
const MACHINE_PLOTS: &[MachinePlot] = &[
    diagram::PLOT,
    utilization::PLOT,
    over_time::PLOT,
    split::PLOT,
    bytes::PLOT,
    hit_rates::PLOT,
    reuse::PLOT,
    dram_rows::PLOT,
];

/// Draws all plots of a run that have data.
pub(super) fn draw(summary: &Summary, over_time: &OverTime) -> Result<Vec<Drawing<Section>>, DrawError> {
    let mut drawings = draw_all(summary, RUN_PLOTS)?;
    let names = file_names(summary.machines.iter().map(|(name, _)| name));
    let frames = FRAME_PLOTS.iter().map(|plot| (plot, true));
    for (MachinePlot { name, figure }, over_frames) in frames.chain(MACHINE_PLOTS.iter().map(|plot| (plot, false))) {
        for (machine, (_, found)) in names.iter().zip(summary.machines.iter()) {
            let of = Machine { name: machine.name, found, run: summary, over_time };
            let section = if over_frames { Section::Frames } else { Section::Machine(machine.name.into()) };
            if let Some(figure) = figure(&of) {
                drawings.push(Drawing::new(format!("{name}-{}", machine.file), section, figure)?);
            }
        }
    }
    Ok(drawings)
}
