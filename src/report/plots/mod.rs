//! Plots, each a file of its own that takes a run's summary and gives an SVG drawing. To add one, write its file and
//! name it in [`PLOTS`].

mod bars;
mod bytes;
mod canvas;
pub mod chart;
mod dram_rows;
mod hit_rates;
pub mod ladder_map;
mod over_frames;
pub mod pareto;
pub mod reuse;
mod saving;
mod split;
pub mod stress;
pub mod sweep;
mod tradeoff;
mod utilization;
mod wrong;

use std::collections::{BTreeMap, BTreeSet};

pub use canvas::DrawError;

use super::file_names::file_names;
use super::summary::{MachineRun, MachineSummary, Summary};

/// All plots, in the page's order.
pub const PLOTS: [Plot; 8] = [
    saving::PLOT,
    tradeoff::PLOT,
    wrong::PLOT,
    split::PLOT,
    bytes::PLOT,
    hit_rates::PLOT,
    utilization::PLOT,
    dram_rows::PLOT,
];

/// A plot.
pub struct Plot {
    /// Its name in files.
    pub name: &'static str,
    /// How it is drawn.
    draw: Draw,
}

enum Draw {
    /// Once a run.
    Run(Section, fn(&Summary) -> Result<Option<String>, DrawError>),
    /// Once a machine.
    Machine(fn(&Machine) -> Result<Option<String>, DrawError>),
}

/// A machine's part of a summary.
struct Machine<'a> {
    name: &'a str,
    summary: &'a MachineSummary,
    baseline: Option<&'a str>,
}

impl<'a> Machine<'a> {
    /// Its runs, by policy.
    fn runs(&self) -> impl Iterator<Item = (&'a str, &'a MachineRun)> + use<'a> {
        self.summary.policies.iter()
    }

    /// The run without culling.
    fn baseline_run(&self) -> Option<&'a MachineRun> {
        self.summary.policies.get(self.baseline?)
    }

    /// All keys that the runs have, in order.
    fn keys<T>(&self, of: fn(&'a MachineRun) -> &'a BTreeMap<String, T>) -> Vec<&'a str> {
        let keys: BTreeSet<&str> = self.runs().flat_map(|(_, run)| of(run).keys().map(String::as_str)).collect();
        keys.into_iter().collect()
    }
}

/// The part of the page that a drawing belongs to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Section {
    /// What culling saved.
    Saving,
    /// What it got wrong.
    Correctness,
    /// What the machine of that name measured.
    Machine(String),
}

/// A plot, drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Drawing {
    /// The file's name, without its end.
    pub name: String,
    /// Where it belongs.
    pub section: Section,
    /// The SVG file.
    pub svg: String,
}

/// All plots of a run that there is data for.
pub fn draw(summary: &Summary) -> Result<Vec<Drawing>, DrawError> {
    let mut drawings = Vec::new();
    for Plot { name, draw } in PLOTS {
        match draw {
            Draw::Run(section, draw) => {
                drawings.extend(draw(summary)?.map(|svg| Drawing { name: name.into(), section, svg }));
            }
            Draw::Machine(draw) => {
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
        }
    }
    Ok(drawings)
}
