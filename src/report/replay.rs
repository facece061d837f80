//! The report of a replay: the numbers of each machine, without plots and without a page.

use serde::{Deserialize, Serialize};

use super::csv_table::CsvTable;
use super::draw::{DrawError, Drawing};
use super::error::ReportError;
use super::results::{self, Results, Scope, Subject, Take};
use super::run::{MachineRun, MachineSummary, machine_rows};
use super::writer::{Report, ReportFile};
use crate::named::Named;
use crate::stats::MachineStats;

/// Measurements of machines on a recorded stream; `summary.json` holds them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ReplaySummary {
    scene: String,
    machines: Named<MachineSummary>,
}

impl ReplaySummary {
    /// The measurements of machines on the stream of `policy` in `scene` at a fidelity level.
    pub(crate) fn new(scene: &str, policy: &str, fidelity: &str, found: &Named<MachineStats>) -> Self {
        let machine = |(name, stats): (&str, &MachineStats)| {
            let frames =
                |warmup| stats.frames.iter().filter(move |it| it.warmup == warmup).map(|it| it.frame).collect();
            let summary = MachineSummary {
                fidelity: fidelity.to_owned(),
                frames: frames(false),
                warmup: frames(true),
                policies: [(policy, MachineRun::from(stats.clone()))].into_iter().collect(),
                split: Named::default(),
                reuse: None,
            };
            (name.to_owned(), summary)
        };
        Self { scene: scene.to_owned(), machines: found.iter().map(machine).collect() }
    }
}

impl Results for ReplaySummary {
    fn rows(&self, take: &mut Take<'_>) -> Result<(), ReportError> {
        self.machines.iter().try_for_each(|(name, machine)| {
            let of = Subject {
                run: "replay",
                scene: &self.scene,
                scope: Scope::Total,
                frame: None,
                policy: "",
                machine: Some((name, &machine.fidelity)),
                varied: &[],
            };
            machine_rows(of, machine, take)
        })
    }
}

impl Report for ReplaySummary {
    type Section = ();

    fn numbers(&self) -> &impl Serialize {
        self
    }

    fn tables(&self) -> Vec<CsvTable> {
        Vec::new()
    }

    fn attachments(&self) -> Result<Vec<ReportFile>, ReportError> {
        results::files(self)
    }

    fn plots(&self) -> Result<Vec<Drawing>, DrawError> {
        Ok(Vec::new())
    }

    fn page(&self, _: &[Drawing]) -> Result<Option<String>, minijinja::Error> {
        Ok(None)
    }
}
