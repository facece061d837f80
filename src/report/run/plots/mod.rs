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

use super::summary::Summary;
use crate::report::draw::{DrawError, Drawing, Plot, draw_all};
use crate::report::file_names::file_names;
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
        let names = file_names(summary.machines.iter().map(|(name, _)| name));
        for (machine, (_, found)) in names.iter().zip(summary.machines.iter()) {
            let of = Machine { name: machine.name, summary: found, baseline: summary.baseline.as_deref() };
            drawings.extend(draw(&of)?.map(|svg| Drawing {
                name: format!("{name}-{}", machine.file),
                section: Section::Machine(machine.name.into()),
                svg,
            }));
        }
    }
    Ok(drawings)
}
