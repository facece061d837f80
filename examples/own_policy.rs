//! A user-defined culling policy: a primitive that no light reached when last traced counts as dark.
//!
//! For every primitive and light the policy keeps one bit: whether all traced shadow rays of a frame were blocked. If
//! so, shadow rays from that primitive are skipped. This saves much work and is wrong at the edges of moving shadows.
//! The tracer counts both: it also traces every ray without culling.
//!
//! Run with: `cargo run --release --example own_policy`

use std::convert::Infallible;

use umbrasim::accel::{Ray, Trail};
use umbrasim::culling::{Change, Evidence, Policy, PolicySpec, Probe, SceneFacts, SurfaceHit, Verdict, Worker};
use umbrasim::quantity::{LightId, Resolution};
use umbrasim::ranged::Within;
use umbrasim::scene::builtin::{self, BuiltInSpec};
use umbrasim::tracer::{Tracer, TracerSpec};

/// What a worker observed for a primitive and a light: codes of [`Change::kind`].
const LIT: u32 = 0;
const DARK: u32 = 1;

/// One bit for each primitive and light.
struct DarkLastFrame {
    lights: u32,
    dark: Vec<bool>,
}

impl DarkLastFrame {
    fn new(facts: SceneFacts) -> Self {
        Self { lights: facts.lights, dark: vec![false; (facts.primitives * facts.lights) as usize] }
    }

    fn entry(&self, hit: SurfaceHit, light: LightId) -> u32 {
        hit.primitive.0 * self.lights + u32::from(light.0)
    }
}

impl Policy for DarkLastFrame {
    fn worker(&self) -> Box<dyn Worker + '_> {
        Box::new(Band { policy: self, seen: Vec::new() })
    }

    fn end_frame(&mut self, changes: &[Change], _steps: &mut Trail) {
        // A primitive is dark if all its traced rays were blocked; one ray that reaches the light clears the bit.
        changes.iter().filter(|seen| seen.kind == DARK).for_each(|seen| self.dark[seen.index as usize] = true);
        changes.iter().filter(|seen| seen.kind == LIT).for_each(|seen| self.dark[seen.index as usize] = false);
    }
}

/// Decides for one band of rows: reads the policy, and returns its observations.
struct Band<'a> {
    policy: &'a DarkLastFrame,
    seen: Vec<Change>,
}

impl Worker for Band<'_> {
    fn decide(&mut self, hit: SurfaceHit, light: LightId, _: &Ray, _: &mut Probe<'_>) -> Verdict {
        let entry = self.policy.entry(hit, light);
        if self.policy.dark[entry as usize] { Verdict::Dark } else { Verdict::Trace }
    }

    fn learn(&mut self, hit: SurfaceHit, light: LightId, evidence: Evidence, _: &mut Probe<'_>) {
        if evidence.verdict == Verdict::Trace {
            let kind = if evidence.blocker.is_some() { DARK } else { LIT };
            self.seen.push(Change { kind, index: self.policy.entry(hit, light), value: 0 });
        }
    }

    fn finish(self: Box<Self>) -> Vec<Change> {
        self.seen
    }
}

fn main() {
    let scene = builtin::build(&BuiltInSpec::Room {
        lights: const { Within::literal(2) },
        frame_count: const { Within::literal(4) },
        detail: const { Within::literal(2) },
    });
    let facts = SceneFacts::of(&scene);
    let mut policies: Vec<Box<dyn Policy>> = vec![PolicySpec::Off.build(facts), Box::new(DarkLastFrame::new(facts))];
    let resolution = Resolution { width: 64, height: 64 };
    let tracer = Tracer::new(&scene, &scene.animation.frame(0), resolution, TracerSpec::default());
    for number in 0..scene.frame_count {
        // The sink would receive the ray streams; this example uses only the counts.
        let traced = tracer.frame(&scene.animation.frame(number), &mut policies, |_, _| Ok::<_, Infallible>(()));
        let Ok(lanes) = traced;
        let [off, own] = lanes.as_slice() else { unreachable!("two policies have two lanes") };
        let wrong: u64 = own.wrong.iter().map(|wrong| wrong.false_dark + wrong.false_lit).sum();
        println!(
            "frame {number}: {} of {} shadow rays skipped, {} node visits instead of {}, {wrong} wrong decisions",
            own.totals.shadow_rays_skipped,
            own.totals.shadow_rays,
            own.totals.shadow_node_visits,
            off.totals.shadow_node_visits,
        );
    }
}
