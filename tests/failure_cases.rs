//! Wrong shadow decisions of the published algorithm, frame by frame, for nine readings of its text. The expected
//! numbers are those of an independent model in double precision; the scenes are the same.

use umbrasim::culling::PolicySpec;
use umbrasim::culling::published::rules::{
    Directions, EvidenceRule, Highest, Partial, Preset, PublishedSpec, References, ResetCheck, Secondary,
};
use umbrasim::culling::{Policy, SceneFacts};
use umbrasim::scene::builtin::cases::Case;
use umbrasim::tracer::{Tracer, TracerSpec};

/// The readings, in the order of the tables' columns.
fn readings() -> [(&'static str, PublishedSpec); 9] {
    let published = PublishedSpec { preset: Preset::Literal, ..PublishedSpec::default() };
    let both = PublishedSpec { directions: Some(Directions::BothWays), ..published };
    let eight = PublishedSpec { references: Some(References::WithDiagonals), ..both };
    let early = Some(ResetCheck::BeforeShadows);
    let statics = Some(EvidenceRule::StaticBlockers);
    let ignore = Some(Secondary::Ignore);
    [
        ("published", published),
        ("published, PARTIAL stays", PublishedSpec { partial: Some(Partial::Sticky), ..published }),
        ("both directions", both),
        ("eight neighbours, both directions", eight),
        ("static blockers only", PublishedSpec { evidence: statics, ..published }),
        ("reset checked before shadows", PublishedSpec { reset_check: early, ..published }),
        ("nothing at secondary hits", PublishedSpec { secondary: ignore, ..published }),
        ("highest as running maximum", PublishedSpec { highest: Some(Highest::RunningMaximum), ..published }),
        ("all repairs", PublishedSpec { evidence: statics, reset_check: early, secondary: ignore, ..eight }),
    ]
}

/// Wrong decisions of each frame.
type Wrong = &'static [u64];
/// Readings, by their place in [`readings`].
type Columns = &'static [usize];

/// What the published reading gets wrong in each frame, and the readings (by column) that get something else wrong.
fn expected(case: Case) -> (Wrong, &'static [(Columns, Wrong)]) {
    match case {
        Case::C1 | Case::C1b => (&[0, 0, 6], &[]),
        Case::C2 => (&[0, 0, 5, 5], &[]),
        Case::C3 => (&[0, 0, 8, 0], &[(&[5, 8], &[0, 0, 0, 0])]),
        Case::C4 => (&[0, 0, 8], &[(&[2, 3, 8], &[0, 0, 0])]),
        Case::C4b => (&[0, 0, 5], &[(&[2, 3, 8], &[0, 0, 0])]),
        Case::C5 => (&[0, 0, 2], &[]),
        Case::C6 => (&[0, 0, 1], &[]),
        Case::C7 => (&[0, 0, 5], &[(&[2, 3, 8], &[0, 0, 0])]),
        Case::C7b => (&[0, 0, 4], &[]),
        Case::C8 => (&[0, 0, 78, 78], &[(&[4, 8], &[0, 0, 0, 0])]),
        Case::C9 | Case::C11 => (&[0, 0, 78], &[]),
        Case::C10 => (&[0, 0, 10], &[(&[5, 6, 8], &[0, 0, 0])]),
        Case::C12 => (&[0, 0, 35], &[]),
        Case::C13 => (&[0, 0, 20], &[(&[2, 3, 8], &[0, 0, 0])]),
        Case::C14 => (&[0, 0, 0, 8, 0], &[(&[1, 5, 8], &[0, 0, 0, 0, 0]), (&[7], &[0, 0, 0, 8, 8])]),
        _ => (&[0, 0, 0], &[]),
    }
}

/// Wrong decisions of all shadow rays, by policy and frame.
fn wrong(case: Case, mut policies: Vec<Box<dyn Policy>>) -> Vec<Vec<u64>> {
    let scene = case.scene();
    let spec = TracerSpec { render: case.render(), ..TracerSpec::default() };
    let tracer = Tracer::new(&scene, &scene.animation.frame(0), case.resolution(), spec);
    let mut counts = vec![Vec::new(); policies.len()];
    for number in 0..scene.frame_count {
        let frame = scene.animation.frame(number);
        let lanes = tracer.frame::<()>(&frame, &mut policies, |_, _| Ok(())).expect("the sink takes everything");
        for (counts, lane) in counts.iter_mut().zip(lanes) {
            counts.push(lane.wrong.iter().map(|wrong| wrong.false_dark + wrong.false_lit).sum());
        }
    }
    counts
}

#[test]
fn each_reading_fails_exactly_where_it_must() {
    let mut differences = Vec::new();
    for &case in Case::FAILURES {
        let facts = SceneFacts::of(&case.scene());
        let policies = readings().map(|(_, spec)| PolicySpec::Published(spec).build(facts));
        let found = wrong(case, policies.into());
        let (published, others) = expected(case);
        for (column, ((reading, _), found)) in readings().iter().zip(found).enumerate() {
            let other = others.iter().find(|(columns, _)| columns.contains(&column));
            let expected = other.map_or(published, |(_, counts)| counts);
            if found != expected {
                differences.push(format!("{} {reading}: {found:?} instead of {expected:?}", case.name()));
            }
        }
    }
    assert!(differences.is_empty(), "{}", differences.join("\n"));
}
