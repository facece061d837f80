//! `index.html`: one file that contains the whole report, with pictures and plots.

mod compare;
mod config;
mod left_out;
mod tables;
mod verdict;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use minijinja::{Value, context};

use super::choice::choice;
use super::files::PngPicture;
use super::pictures::{NO_WORD, OCCLUSION_MODES, PictureKind, Rgb, SHADOW_MODES, word_color};
use super::plots::Section;
use super::summary::{MachineSummary, Summary};
use super::{findings, notices};
use crate::report::draw::Drawing;
use crate::report::template::{self, defined, grid, key};
use tables::MEANINGS;

/// The page as HTML. `config` is the experiment's text as run.
pub(super) fn page(
    summary: &Summary,
    config: &str,
    drawings: &[Drawing<Section>],
    pictures: &[PngPicture],
) -> Result<String, minijinja::Error> {
    let plots = |section: &Section| template::plots(drawings, section);
    let (references, comparisons) = compare::comparisons(summary, pictures);
    let pairs = |named: &crate::named::Named<String>| -> Vec<Vec<String>> {
        named.iter().map(|(name, value)| vec![name.to_owned(), value.clone()]).collect()
    };
    let culling = summary.policies.iter().filter(|&(name, _)| summary.baseline.as_deref() != Some(name));
    let context = context! {
        experiment => summary.experiment.as_str(),
        finding => verdict::finding(summary),
        setting => findings::setting(summary),
        notices => notices::notices(summary),
        tiles => verdict::tiles(summary),
        findings => findings::of_policies(summary).into_iter().collect::<Vec<_>>(),
        policies => defined(tables::policies(summary), MEANINGS),
        machine_figures => defined(tables::machines(summary), MEANINGS),
        policy_plots => plots(&Section::Policies),
        frame_plots => plots(&Section::Frames),
        shadow_rays => summary.policies.iter().any(|(_, policy)| policy.counts.shadow_rays > 0),
        lights => defined(tables::lights(summary), MEANINGS),
        frames => grid(tables::frames(summary)),
        worst => compare::worst_frame(summary),
        culling => culling.map(|(name, _)| name.to_owned()).collect::<Vec<_>>(),
        references, comparisons,
        outlines => key(&compare::key()),
        word_pictures => word_pictures(pictures),
        occlusion_modes => OCCLUSION_MODES.to_vec(),
        word_colors => word_colors(),
        no_word => css(NO_WORD),
        machines => summary.machines.iter().map(|it| machine(it, drawings)).collect::<Vec<_>>(),
        config => config::lines(config, &summary.changed),
        changed => summary.changed.len(),
        schema => summary.schema,
        provenance => pairs(&summary.provenance),
        made => pairs(&summary.made),
        left_out => grid(left_out::left_out(summary)),
        wall => grid(tables::wall(summary)),
    };
    template::render("page.html", include_str!("page.html"), context)
}

fn machine((name, machine): (&str, &MachineSummary), drawings: &[Drawing<Section>]) -> Value {
    let plots = template::plots(drawings, &Section::Machine(name.into()));
    let dram = machine.policies.iter().next().map(|(_, run)| run.stats.dram_organization.as_str());
    let choice = choice(machine.policies.iter().map(|(_, run)| &run.stats));
    let split = defined(super::tables::split(machine), MEANINGS);
    let reuse = machine.reuse.is_some();
    context! { name, fidelity => machine.fidelity.as_str(), dram, plots, choice, split, reuse }
}

/// The legend of mode words: one row per shadow mode, one colour per occlusion mode.
fn word_colors() -> Vec<Value> {
    let row = |(shadow, name): (usize, &'static str)| {
        let colors: Vec<String> =
            (0..OCCLUSION_MODES.len()).map(|occlusion| css(word_color(occlusion, shadow))).collect();
        context! { name, colors }
    };
    SHADOW_MODES.into_iter().enumerate().map(row).collect()
}

fn css([red, green, blue]: Rgb) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// Pictures of mode words.
fn word_pictures(pictures: &[PngPicture]) -> Vec<Value> {
    let picture = |(info, png): &PngPicture| {
        let PictureKind::Words { light } = info.kind else { return None };
        let policy = info.policy.as_deref().unwrap_or_default();
        let caption = format!("frame {}, towards light {light}, {policy}", info.frame);
        Some(context! { caption, data => STANDARD.encode(png) })
    };
    pictures.iter().filter_map(picture).collect()
}
