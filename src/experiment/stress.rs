//! Stress: every policy on every small scene that is known to break a policy, and the effect of choices that the
//! published text leaves open.

use std::convert::Infallible;
use std::path::Path;

use super::progress::{self, Progress};
use super::stress_models::{self, MODELS, Recorded};
use crate::alike::closest;
use crate::culling::published::rules::{
    Directions, EvidenceRule, Preset, PublishedSpec, References, ResetCheck, Secondary,
};
use crate::culling::symmetric::{Neighbours, SymmetricSpec};
use crate::culling::{Policy, PolicySpec, SceneFacts};
use crate::named::twice;
use crate::quantity::Resolution;
use crate::report::stress::{CaseSummary, Effect, FrameWrong, Shift, StressModel, StressPolicy, StressSummary};
use crate::ron_file;
use crate::scene::builtin::cases::{Case, Recipe};
use crate::scene::{RenderSpec, Scene};
use crate::stream::{Item, Totals};
use crate::tracer::{LaneFrame, Tracer, TracerSpec};

/// Frames for which a failure case holds its last view.
const HELD: u32 = 4;
/// Random scenes on which the open choices are tried.
const SCENES: u32 = 12;
/// Picture size of the random scenes.
const SIZE: Resolution = Resolution { width: 48, height: 48 };

/// Policies whose streams the timing models replay: no culling, mode words, and certificates with hints.
const REPLAYED: [&str; 3] = ["Off", "Published", "Hybrid"];

/// Answers to what the published text leaves open, other than the defaults: one set of fields at a time, in a config's
/// syntax. (The order of pixels is missing: with latched words no order changes a decision.)
const ANSWERS: [&str; 21] = [
    "preset: Literal",
    "partial: Sticky",
    "reset_modes: Clear",
    "highest: AtReset",
    "highest: RunningMaximum",
    "evidence: AnyBlocker",
    "secondary: CullAndCount",
    "secondary: Ignore",
    "light_moves: Flush",
    "occluded_full: BecomesPartial",
    "references: WithDiagonals",
    "directions: BothWays",
    "directions: BothWays, references: WithDiagonals",
    "dynamic_tests: Spared",
    "border: Ignored",
    "reset_ratio: 1.5",
    "reset_ratio: 2.0",
    "reset_ratio: 3.0",
    "reset_ratio: 8.0",
    "reset_check: BeforeShadows",
    "words: Live",
];

/// The policies of the failure map: each kind with its defaults, and further readings of the published text.
pub(crate) fn policies() -> Vec<(String, PolicySpec)> {
    let literal = PublishedSpec { preset: Preset::Literal, ..PublishedSpec::default() };
    let repaired = PublishedSpec {
        directions: Some(Directions::BothWays),
        references: Some(References::WithDiagonals),
        evidence: Some(EvidenceRule::StaticBlockers),
        reset_check: Some(ResetCheck::BeforeShadows),
        secondary: Some(Secondary::Ignore),
        ..literal
    };
    let eight = SymmetricSpec { neighbours: Neighbours::Eight, ..SymmetricSpec::default() };
    let readings = [
        ("Published literal", PolicySpec::Published(literal)),
        ("Symmetric eight", PolicySpec::Symmetric(eight)),
        ("all repairs", PolicySpec::Published(repaired)),
    ];
    PolicySpec::all().into_iter().chain(readings).map(|(name, spec)| (name.to_owned(), spec)).collect()
}

/// The cases with the given names; all cases if `names` is empty.
///
/// # Errors
/// A name belongs to no case; the error proposes one.
pub(crate) fn cases(names: &[String]) -> Result<Vec<Case>, String> {
    if names.is_empty() {
        return Ok(Case::all().collect());
    }
    let all: Vec<&str> = Case::all().map(Case::name).collect();
    let case = |name: &String| {
        Case::all().find(|case| case.name().eq_ignore_ascii_case(name)).ok_or_else(|| {
            let near = closest(name, &all).map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
            format!("there is no case `{name}`{near}\ncases: {}", all.join(", "))
        })
    };
    let cases: Vec<Case> = names.iter().map(case).collect::<Result<_, _>>()?;
    match twice(&cases) {
        Some(case) => Err(format!("the case `{}` is named twice", case.name())),
        None => Ok(cases),
    }
}

/// Runs the given cases; if `all` is set, also measures the effects of other answers to open questions.
pub(crate) fn run(cases: &[Case], all: bool) -> StressSummary {
    let policies = policies();
    let named = policies.iter().map(|(name, spec)| StressPolicy { name: name.clone(), exact: spec.is_exact() });
    let models = MODELS.map(|model| StressModel { name: model.to_string(), exact: model.is_exact() });
    let bar = progress::bar("stress", cases.len() + if all { SCENES as usize } else { 0 }, "cases");
    let found = cases.iter().map(|&case| run_case(case, &policies)).inspect(|_| bar.inc(1)).collect();
    let effects = if all { effects(&bar) } else { Vec::new() };
    let summary = StressSummary::new(named.collect(), models.to_vec(), found, effects, SCENES);
    drop(bar);
    summary
}

fn run_case(case: Case, policies: &[(String, PolicySpec)]) -> CaseSummary {
    let scene = case.scene();
    let frames = scene.frame_count + if case.is_failure() { HELD } else { 0 };
    let specs: Vec<_> = policies.iter().map(|(_, spec)| spec.clone()).collect();
    let stage = Stage::new(&scene, case.resolution(), case.render());
    let mut streams: Vec<_> = policies
        .iter()
        .map(|(name, spec)| {
            let policy = spec.build(SceneFacts::of(&scene));
            let header = stage.tracer.header(name, policy.as_ref(), (0..frames).collect(), "");
            REPLAYED.contains(&name.as_str()).then(|| Recorded { header, items: Vec::new() })
        })
        .collect();
    let mut wrongs = vec![Vec::new(); specs.len()];
    let keep = |lane: usize, item: &Item| streams[lane].iter_mut().for_each(|stream| stream.items.push(item.clone()));
    stage.trace(frames, &specs, keep, |lane, done| {
        let mut frame = FrameWrong { shadow_rays: done.totals.shadow_rays, ..FrameWrong::default() };
        for wrong in &done.wrong {
            frame.false_dark += wrong.false_dark;
            frame.false_lit += wrong.false_lit;
        }
        wrongs[lane].push(frame);
    });
    let streams: Vec<_> = streams.into_iter().flatten().collect();
    let models = stress_models::verdicts(&streams);
    CaseSummary { name: case.name().into(), title: case.title().into(), policies: wrongs, models }
}

/// The change from each answer on random scenes, against the default answers on the same scenes.
fn effects(bar: &Progress) -> Vec<Effect> {
    let published = |text: &str| {
        let spec = ron_file::parse(&format!("({text})"), Path::new("answers"));
        PolicySpec::Published(spec.expect("the list holds what a config can"))
    };
    let specs: Vec<_> = [PolicySpec::Off, published("")].into_iter().chain(ANSWERS.map(published)).collect();
    // By answer, its change in each scene.
    let mut changes = vec![(Vec::new(), Vec::new()); ANSWERS.len()];
    for seed in 0..SCENES {
        let scene = Recipe { seed: seed.into(), ..Recipe::default() }.scene("random");
        let render = RenderSpec { depth: 3, ..RenderSpec::default() };
        let mut sums = vec![(Totals::default(), 0); specs.len()];
        let stage = Stage::new(&scene, SIZE, render);
        stage.trace(
            scene.frame_count,
            &specs,
            |_, _| {},
            |lane, done| {
                sums[lane].0 += done.totals;
                sums[lane].1 += done.wrong.iter().map(|wrong| wrong.false_dark + wrong.false_lit).sum::<u64>();
            },
        );
        let visits = |totals: &Totals| (totals.shadow_node_visits + totals.policy_node_visits) as f64;
        let off = visits(&sums[0].0);
        let figures = |(totals, wrong): &(Totals, u64)| {
            (1.0 - visits(totals) / off, *wrong as f64 * 1e6 / totals.shadow_rays as f64)
        };
        let base = figures(&sums[1]);
        for (changes, sum) in changes.iter_mut().zip(&sums[2..]) {
            let (saving, wrong) = figures(sum);
            changes.0.push(saving - base.0);
            changes.1.push(wrong - base.1);
        }
        bar.inc(1);
    }
    let effect = |(option, (saving, wrong)): (&str, (Vec<f64>, Vec<f64>))| Effect {
        option: option.into(),
        saving: Shift::of(&saving),
        wrong_per_million: Shift::of(&wrong),
    };
    ANSWERS.into_iter().zip(changes).map(effect).collect()
}

/// A scene, ready to be traced.
struct Stage<'a> {
    scene: &'a Scene,
    tracer: Tracer<'a>,
}

impl<'a> Stage<'a> {
    fn new(scene: &'a Scene, resolution: Resolution, render: RenderSpec) -> Self {
        let spec = TracerSpec { render, ..TracerSpec::default() };
        Self { scene, tracer: Tracer::new(scene, &scene.animation.frame(0), resolution, spec) }
    }

    /// Traces frames 0 to `frames` (exclusive) for all policies. `item` receives the items of each policy's stream,
    /// `done` its finished frames.
    fn trace(
        &self,
        frames: u32,
        specs: &[PolicySpec],
        mut item: impl FnMut(usize, &Item),
        mut done: impl FnMut(usize, LaneFrame),
    ) {
        let facts = SceneFacts::of(self.scene);
        let mut policies: Vec<Box<dyn Policy>> = specs.iter().map(|spec| spec.build(facts)).collect();
        for number in 0..frames {
            let sink = |lane: usize, made: Item| {
                item(lane, &made);
                Ok::<_, Infallible>(())
            };
            let Ok(lanes) = self.tracer.frame(&self.scene.animation.frame(number), &mut policies, sink);
            lanes.into_iter().enumerate().for_each(|(lane, frame)| done(lane, frame));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::stress::Outcome;

    #[test]
    fn the_map_shows_what_is_known() {
        let summary = run(&Case::all().collect::<Vec<_>>(), true);
        assert_eq!(summary.broken(), Vec::<String>::new());
        let outcome = |case: &str, policy: &str| {
            let column = summary.policies.iter().position(|it| it.name == policy).expect("a policy");
            let case = summary.cases.iter().find(|it| it.name == case).expect("a case");
            Outcome::of(&case.policies[column])
        };
        assert_eq!(outcome("C3", "Published literal"), Outcome::Healed { frames: 1, worst: 8 });
        assert_eq!(outcome("C8", "Published literal"), Outcome::Wrong { frames: 6, worst: 78 });
        assert_eq!(outcome("C8", "Published"), Outcome::Right);
        assert_eq!(outcome("C4", "Symmetric"), Outcome::Right);
        assert_eq!(outcome("C4m", "Published literal"), Outcome::Right);
        let of = |option: &str| summary.effects.iter().find(|it| it.option == option).expect("an answer");
        assert!(of("secondary: Ignore").saving.mean < 0.0);
        // Lights that do not move flush nothing.
        assert_eq!(of("light_moves: Flush").saving, Shift { mean: 0.0, error: 0.0 });
    }
}
