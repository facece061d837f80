//! `frames.csv`, with every count of every frame.

use super::summary::{FrameSummary, PolicySummary, Psnr, Summary};
use crate::report::csv_table::{CsvTable, cell};

/// A column of `frames.csv`: its header, and the field of a frame (empty where absent).
type Column = (&'static str, fn(&FrameSummary) -> String);

const COLUMNS: [Column; 24] = [
    ("frame", |row| row.frame.to_string()),
    ("primary_rays", |row| row.counts.primary_rays.to_string()),
    ("secondary_rays", |row| row.counts.secondary_rays.to_string()),
    ("shadow_rays", |row| row.counts.shadow_rays.to_string()),
    ("shadow_rays_skipped", |row| row.counts.shadow_rays_skipped.to_string()),
    ("shadow_rays_dynamic_only", |row| row.counts.shadow_rays_dynamic_only.to_string()),
    ("occlusion_tests", |row| row.counts.occlusion_tests.to_string()),
    ("occlusion_tests_per_pixel", |row| cell(row.counts.occlusion_tests_per_pixel)),
    ("node_visits", |row| row.counts.node_visits.to_string()),
    ("triangle_tests", |row| row.counts.triangle_tests.to_string()),
    ("shadow_node_visits", |row| row.counts.shadow_node_visits.to_string()),
    ("shadow_triangle_tests", |row| row.counts.shadow_triangle_tests.to_string()),
    ("list_reads", |row| row.counts.list_reads.to_string()),
    ("policy_node_visits", |row| row.counts.policy_node_visits.to_string()),
    ("policy_triangle_tests", |row| row.counts.policy_triangle_tests.to_string()),
    ("policy_reads", |row| row.counts.policy_reads.to_string()),
    ("policy_writes", |row| row.counts.policy_writes.to_string()),
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

/// `frames.csv`: a row a policy and frame, policies in the experiment's order.
pub(super) fn frames_csv(summary: &Summary) -> CsvTable {
    let head = std::iter::once("policy").chain(COLUMNS.iter().map(|(header, _)| *header));
    let of_policy = |(name, policy): (&str, &PolicySummary)| -> Vec<Vec<String>> {
        let row = |frame: &FrameSummary| {
            std::iter::once(name.to_owned()).chain(COLUMNS.iter().map(|(_, text)| text(frame))).collect()
        };
        policy.frames.iter().map(row).collect()
    };
    CsvTable::new("frames.csv", head, summary.policies.iter().flat_map(of_policy).collect())
}
