//! Saved work of each policy against its wrong decisions.

use super::section::Section;
use crate::report::draw::bars::{Bar, BarChart, Group, Segment};
use crate::report::draw::palette::{GREEN, VERMILLION, pale};
use crate::report::draw::{Figure, Plot};
use crate::report::format::{percent, percent_tick, short};
use crate::report::run::summary::{PolicySummary, Summary};

pub(super) const PLOT: Plot<Summary, Section> = Plot { name: "tradeoff", section: Section::Policies, figure };

fn figure(summary: &Summary) -> Option<Figure<'_>> {
    let culling = || summary.policies.iter().filter(|&(name, _)| summary.baseline.as_deref() != Some(name));
    let groups: Vec<Group> = culling().filter_map(group).collect();
    // For a single policy, the plot over frames shows the saving already.
    if groups.len() < 2 {
        return None;
    }
    let right = culling().filter(|(_, policy)| policy.counts.wrong() == Some(0));
    let best = right.filter_map(|(name, policy)| Some((name, policy.traversal_saved.mean?)));
    let best = best.filter(|(_, saved)| *saved > 0.0).max_by(|a, b| a.1.total_cmp(&b.1));
    let chart = BarChart {
        title: match best {
            Some((name, saved)) => {
                format!("Without a wrong decision, {name} saves most: {} of the node visits", percent(saved))
            }
            None => "What is saved, against what is wrong".into(),
        },
        about: "Mean share of the work of shadow rays without culling; wrong decisions a million shadow rays.".into(),
        key: vec![
            ("no decision is wrong".into(), GREEN),
            ("some are".into(), VERMILLION),
            ("pale: triangle tests".into(), pale(GREEN)),
        ],
        axis: "work of shadow rays saved",
        unit: "share",
        max: 1.0,
        tick: percent_tick,
        groups,
    };
    Some(chart.figure())
}

fn group((name, policy): (&str, &PolicySummary)) -> Option<Group> {
    let counts = &policy.counts;
    let wrong = counts.wrong().filter(|_| counts.shadow_rays > 0)?;
    let color = if wrong == 0 { GREEN } else { VERMILLION };
    let errors = match wrong {
        0 => "no decision wrong".to_owned(),
        wrong => format!("{} wrong a million", short(wrong as f64 * 1e6 / counts.shadow_rays as f64)),
    };
    let bar = |what: &str, saved: f64, color, note: String| Bar {
        name: what.into(),
        // A policy that adds work has no bar; the note has the number.
        segments: vec![Segment { part: "saved".into(), value: saved, color }],
        note: format!("{}{note}", percent(saved)),
    };
    Some(Group {
        name: name.into(),
        whole: 1.0,
        bars: vec![
            bar("node visits", policy.traversal_saved.mean?, color, format!(", {errors}")),
            bar("triangle tests", policy.intersection_saved.mean?, pale(color), String::new()),
        ],
    })
}
