//! `index.html`: one file that holds the whole report, pictures and plots included.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use minijinja::{Value, context};

use super::files::PngPicture;
use super::findings;
use super::pictures::{NO_WORD, OCCLUSION_MODES, PictureKind, Rgb, SHADOW_MODES, SHOWN_VERDICTS, word_color};
use super::plots::Section;
use super::summary::{MachineRun, MachineSummary, PolicySummary, Psnr, Summary};
use super::tables;
use crate::report::draw::Drawing;
use crate::report::format::{exact, or_absent, percent, short};
use crate::report::grid::Grid;
use crate::report::template::{self, grid};

/// The page as HTML. `config` is the experiment's text as run.
pub(super) fn page(
    summary: &Summary,
    config: &str,
    drawings: &[Drawing<Section>],
    pictures: &[PngPicture],
) -> Result<String, minijinja::Error> {
    let plots = |section: &Section| template::plots(drawings, section);
    let machine = |(name, machine): (&str, &MachineSummary)| {
        let plots = plots(&Section::Machine(name.into()));
        let dram = machine.policies.iter().next().map(|(_, run)| run.stats.dram_organization.as_str());
        let needs = |(policy, run): (&str, &MachineRun)| {
            let needs = run.stats.needs.as_ref()?;
            let [target, pilot] = [needs.target, needs.pilot_share].map(percent);
            Some(context! {
                policy, target, pilot,
                taken => needs.models.last().map(|taken| taken.model.as_str()),
                parts => grid(tables::parts(needs)),
                models => grid(tables::models(needs)),
            })
        };
        let needs: Vec<Value> = machine.policies.iter().filter_map(needs).collect();
        context! { name, fidelity => machine.fidelity.as_str(), dram, plots, needs, split => grid(tables::split(machine)) }
    };
    let context = context! {
        experiment => summary.experiment.as_str(),
        setting => findings::setting(summary),
        findings => findings::of_policies(summary).into_iter().map(|(name, text)| vec![name, text]).collect::<Vec<_>>(),
        policies => grid(tables::policies(summary)),
        machine_figures => grid(tables::machines(summary)),
        saving => plots(&Section::Saving),
        shadow_rays => summary.policies.iter().any(|(_, policy)| policy.counts.shadow_rays > 0),
        correctness => grid(correctness(summary)),
        lights => grid(lights(summary)),
        wrong => plots(&Section::Correctness),
        pictures => frames(pictures),
        pixel_classes => SHOWN_VERDICTS.map(|(_, name, color)| context! { name, color => css(color) }).to_vec(),
        has_words => pictures.iter().any(|(info, _)| matches!(info.kind, PictureKind::Words { .. })),
        occlusion_modes => OCCLUSION_MODES.to_vec(),
        word_colors => word_colors(),
        no_word => css(NO_WORD),
        machines => summary.machines.iter().map(machine).collect::<Vec<_>>(),
        config,
        schema => summary.schema,
        provenance => summary.provenance.iter().map(|(name, value)| vec![name.to_owned(), value.clone()]).collect::<Vec<_>>(),
        wall => grid(wall(summary)),
    };
    template::render("page.html", include_str!("page.html"), context)
}

/// Wall time and own speed a stage.
fn wall(summary: &Summary) -> Grid {
    let row = |(stage, seconds): (&str, &f64)| {
        let speed = summary.simulated_rays_per_wall_second.get(stage);
        vec![stage.into(), format!("{seconds:.2}"), or_absent(speed, |&speed| short(speed))]
    };
    Grid {
        head: ["stage", "seconds", "rays simulated a second"].map(Into::into).to_vec(),
        names: 1,
        rows: summary.wall_seconds.iter().map(row).collect(),
    }
}

/// The legend of mode words: a row a shadow mode, a colour an occlusion mode.
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

/// How right each policy's shadows are.
fn correctness(summary: &Summary) -> Grid {
    const HEAD: [&str; 7] =
        ["policy", "decisions", "false dark", "false lit", "wrong share", "numeric differences", "lowest PSNR"];
    let row = |(name, policy): (&str, &PolicySummary)| {
        let counts = &policy.counts;
        let wrong = counts.wrong().filter(|_| counts.shadow_rays > 0);
        vec![
            name.to_owned(),
            exact(counts.shadow_rays),
            or_absent(counts.false_dark, exact),
            or_absent(counts.false_lit, exact),
            or_absent(wrong, |wrong| percent(wrong as f64 / counts.shadow_rays as f64)),
            or_absent(counts.numeric_differences, exact),
            or_absent(lowest_psnr(policy), |psnr| match psnr {
                Psnr::Identical => "identical".into(),
                Psnr::Decibel(ratio) => format!("{ratio:.1} dB"),
            }),
        ]
    };
    Grid { head: HEAD.map(Into::into).to_vec(), names: 1, rows: summary.policies.iter().map(row).collect() }
}

fn lowest_psnr(policy: &PolicySummary) -> Option<Psnr> {
    policy.frames.iter().filter_map(|frame| frame.psnr).reduce(|low, next| match (low, next) {
        (Psnr::Decibel(a), Psnr::Decibel(b)) => Psnr::Decibel(a.min(b)),
        (Psnr::Identical, other) | (other, Psnr::Identical) => other,
    })
}

/// Wrong decisions towards each light.
fn lights(summary: &Summary) -> Grid {
    let rows = summary.policies.iter().flat_map(|(name, policy)| {
        policy.lights.iter().map(move |wrong| {
            vec![name.to_owned(), wrong.light.to_string(), exact(wrong.false_dark), exact(wrong.false_lit)]
        })
    });
    Grid {
        head: ["policy", "light", "false dark", "false lit"].map(Into::into).to_vec(),
        names: 1,
        rows: rows.collect(),
    }
}

/// Pictures by frame, frames as they first occur.
fn frames(pictures: &[PngPicture]) -> Vec<Value> {
    let mut frames: Vec<(u32, Vec<Value>)> = Vec::new();
    for (info, png) in pictures {
        let whose = info.policy.as_deref().map(|policy| format!(", {policy}")).unwrap_or_default();
        let caption = match info.kind {
            PictureKind::Render => format!("render{whose}"),
            PictureKind::Reference => "reference: f64, nothing culled".into(),
            PictureKind::Difference { light: None } => format!("wrong pixels{whose}"),
            PictureKind::Difference { light: Some(light) } => format!("wrong pixels towards light {light}{whose}"),
            PictureKind::Words { light } => format!("mode words towards light {light}{whose}"),
        };
        let picture = context! { caption, data => STANDARD.encode(png) };
        match frames.iter_mut().find(|(frame, _)| *frame == info.frame) {
            Some((_, pictures)) => pictures.push(picture),
            None => frames.push((info.frame, vec![picture])),
        }
    }
    frames.into_iter().map(|(frame, pictures)| context! { frame, pictures }).collect()
}
