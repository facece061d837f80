//! Plots of a run, each in a file of its own. To add one, write its file and name it in [`RUN_PLOTS`] or
//! [`MACHINE_PLOTS`].

mod bytes;
mod dram_rows;
mod hit_rates;
mod machine;
mod saving;
mod section;
mod split;
mod tradeoff;
mod utilization;
mod wrong;

use super::pictures::file_name;
use super::summary::Summary;
use crate::report::draw::{DrawError, Drawing, Plot, draw_all};
use machine::{Machine, MachinePlot};

pub(super) use section::Section;

/// Plots drawn once a run, in the page's order.
const RUN_PLOTS: &[Plot<Summary, Section>] = &[saving::PLOT, tradeoff::PLOT, wrong::PLOT];

/// Plots drawn once a machine, in the page's order.
const MACHINE_PLOTS: &[MachinePlot] = &[split::PLOT, bytes::PLOT, hit_rates::PLOT, utilization::PLOT, dram_rows::PLOT];

/// All plots of a run that there is data for.
pub(super) fn draw(summary: &Summary) -> Result<Vec<Drawing<Section>>, DrawError> {
    let mut drawings = draw_all(summary, RUN_PLOTS)?;
    for MachinePlot { name, draw } in MACHINE_PLOTS {
        for (machine, found) in summary.machines.iter() {
            let svg = draw(&Machine { name: machine, summary: found, baseline: summary.baseline.as_deref() })?;
            drawings.extend(svg.map(|svg| Drawing {
                name: format!("{name}-{}", file_name(machine)),
                section: Section::Machine(machine.into()),
                svg,
            }));
        }
    }
    Ok(drawings)
}
