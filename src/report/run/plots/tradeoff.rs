//! What each policy saves against what it gets wrong.

use super::section::Section;
use crate::report::draw::Plot;
use crate::report::draw::bars::{Bar, BarChart, Group, Segment};
use crate::report::draw::canvas::{DrawError, pale, palette};
use crate::report::format::{percent, percent_tick, short};
use crate::report::run::summary::{PolicySummary, Summary};

pub(super) const PLOT: Plot<Summary, Section> = Plot { name: "tradeoff", section: Section::Saving, draw };

fn draw(summary: &Summary) -> Result<Option<String>, DrawError> {
    let culling = summary.policies.iter().filter(|&(name, _)| summary.baseline.as_deref() != Some(name));
    let groups: Vec<Group> = culling.filter_map(group).collect();
    // One policy's saving stands in the plot over frames already.
    if groups.len() < 2 {
        return Ok(None);
    }
    let chart = BarChart {
        title: "What is saved, against what is wrong".into(),
        subtitle: "mean share of the work without culling; wrong decisions a million shadow rays".into(),
        legend: vec![
            ("no decision is wrong".into(), palette::GREEN),
            ("some are".into(), palette::VERMILLION),
            ("pale: triangle tests".into(), pale(palette::GREEN)),
        ],
        axis: "work of shadow rays saved",
        max: 1.0,
        tick: percent_tick,
        groups,
    };
    chart.draw().map(Some)
}

fn group((name, policy): (&str, &PolicySummary)) -> Option<Group> {
    let counts = &policy.counts;
    let wrong = counts.wrong().filter(|_| counts.shadow_rays > 0)?;
    let color = if wrong == 0 { palette::GREEN } else { palette::VERMILLION };
    let errors = match wrong {
        0 => "no decision wrong".to_owned(),
        wrong => format!("{} wrong a million", short(wrong as f64 * 1e6 / counts.shadow_rays as f64)),
    };
    let bar = |what: &str, saved: f64, color, note: String| Bar {
        name: what.into(),
        // Work that a policy adds has no bar; the note has its number.
        segments: vec![Segment { length: saved.max(0.0), color }],
        note: format!("{}{note}", percent(saved)),
    };
    Some(Group {
        name: name.into(),
        bars: vec![
            bar("node visits", policy.traversal_saved.mean?, color, format!(", {errors}")),
            bar("triangle tests", policy.intersection_saved.mean?, pale(color), String::new()),
        ],
    })
}
