//! `frames.csv`, with every count of every frame.

use super::machine_columns::MachineColumns;
use super::summary::{FrameSummary, PolicySummary, Psnr, Summary};
use crate::report::csv_table::{CsvTable, cell};
use crate::stream::Totals;

/// A column of `frames.csv`: its header, and the field of a frame (empty where absent).
type Column = (&'static str, fn(&FrameSummary) -> String);

/// The columns after the frame's number and the tracer's counters.
const COLUMNS: [Column; 9] = [
    ("occlusion_tests", |row| row.counts.occlusion_tests.to_string()),
    ("occlusion_tests_per_pixel", |row| cell(row.counts.occlusion_tests_per_pixel)),
    ("traversal_saved", |row| cell(row.traversal_saved)),
    ("intersection_saved", |row| cell(row.intersection_saved)),
    ("false_dark", |row| cell(row.counts.false_dark)),
    ("false_lit", |row| cell(row.counts.false_lit)),
    ("compared_rays", |row| cell(row.counts.compared_rays)),
    ("numeric_differences", |row| cell(row.counts.numeric_differences)),
    ("psnr_db", |row| match row.psnr {
        None => String::new(),
        Some(Psnr::Identical) => "inf".into(),
        Some(Psnr::Decibel(ratio)) => ratio.to_string(),
    }),
];

/// `frames.csv`: one row per policy and frame, policies in the experiment's order, columns of machines last.
pub(in crate::report) fn frames_csv(summary: &Summary) -> CsvTable {
    let machines = MachineColumns::of(summary);
    let counters = Totals::DECLARED.iter().map(|counter| counter.name);
    let head = ["policy", "frame"].into_iter().chain(counters).chain(COLUMNS.map(|(header, _)| header));
    let head: Vec<String> = head.map(str::to_owned).chain(machines.iter().flat_map(MachineColumns::head)).collect();
    let of_policy = |(name, policy): (&str, &PolicySummary)| -> Vec<Vec<String>> {
        let row = |frame: &FrameSummary| {
            let names = [name.to_owned(), frame.frame.to_string()];
            let counters = frame.counts.totals.values().map(|value| value.to_string());
            let of_machines = machines.iter().flat_map(|machine| machine.row(name, frame.frame));
            names.into_iter().chain(counters).chain(COLUMNS.map(|(_, text)| text(frame))).chain(of_machines).collect()
        };
        policy.frames.iter().map(row).collect()
    };
    let rows = summary.policies.iter().flat_map(of_policy).collect();
    CsvTable::new("frames.csv", head.iter().map(String::as_str), rows)
}
