//! Certificates where they can be had, the last blocker tested again otherwise; both for cells of receivers.

use serde::{Deserialize, Serialize};

use super::cells::Cell;
use super::certificates::{CertificateSpec, Certificates, Prover};
use super::hints::{HintWorker, Hints};
use super::mode_word::Shadow;
use super::{Change, Evidence, Policy, Probe, SceneFacts, SurfaceHit, Verdict, Worker};
use crate::accel::{Ray, Trail, World};
use crate::quantity::{LightId, PrimitiveId};
use crate::scene::{Light, Triangle};
use crate::stream::StoreEntries;

/// The settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct HybridSpec {
    /// When proofs are asked for.
    pub certificates: CertificateSpec,
    /// bits
    pub hints: u32,
    /// d
    pub drop: bool,
    /// d
    pub verbose: bool,
}
impl Default for HybridSpec {
    fn default() -> Self {
        Self { certificates: CertificateSpec::default(), hints: 18, drop: false, verbose: false }
    }
}

/// Certificates and hints.
pub struct Hybrid {
    spec: HybridSpec,
    certificates: Certificates,
    hints: Hints,
    statics: u32,
}

impl Drop for Hybrid {
    fn drop(&mut self) {
        if self.spec.verbose {
            println!("{:?} nodes used {}", self.spec, self.certificates.used());
        }
    }
}

impl Hybrid {
    /// Nothing known yet.
    pub fn new(spec: HybridSpec, facts: SceneFacts, statics: &[Triangle]) -> Self {
        Self {
            spec,
            certificates: Certificates::new(spec.certificates, facts, statics),
            hints: Hints::new(1 << spec.hints, facts.lights as usize),
            statics: facts.statics,
        }
    }
}

impl Policy for Hybrid {
    fn begin_frame(&mut self, lights: &[Light], _: Option<Vec<u32>>) {
        self.certificates.begin_frame(lights);
    }

    fn worker(&self) -> Box<dyn Worker + '_> {
        Box::new(HybridWorker {
            prover: self.certificates.prover(),
            hints: self.hints.worker(),
            statics: self.statics,
            drop: self.spec.drop,
            rays: vec![(Cell::whole(PrimitiveId(0)), None); self.hints_lights()],
        })
    }

    fn end_frame(&mut self, changes: &[Change], _: &World<'_>, trail: &mut Trail) {
        self.certificates.end_frame(changes, trail);
        self.hints.end_frame(changes, trail);
    }

    fn stores(&self) -> StoreEntries {
        StoreEntries {
            mode_words: self.certificates.entries(),
            occluder_ids: self.hints.len(),
            ..StoreEntries::default()
        }
    }
}
impl Hybrid {
    fn hints_lights(&self) -> usize {
        64
    }
}

struct HybridWorker<'a> {
    prover: Prover<'a>,
    hints: HintWorker<'a>,
    statics: u32,
    drop: bool,
    /// cell and blocker found
    rays: Vec<(Cell, Option<PrimitiveId>)>,
}

impl Worker for HybridWorker<'_> {
    fn decide(&mut self, hit: SurfaceHit, light: LightId, ray: &Ray, probe: &mut Probe<'_>) -> Verdict {
        let leaf = self.prover.leaf(hit, light, probe);
        let cell = match leaf {
            Some(leaf) if leaf.mode == Shadow::Full => return Verdict::Dark,
            Some(leaf) if leaf.mode == Shadow::Non => return Verdict::DynamicOnly,
            Some(leaf) => leaf.cell,
            None => Cell::whole(hit.primitive),
        };
        let blocker = self.hints.blocker(cell, light, ray, probe);
        self.rays[light.0 as usize] = (cell, blocker);
        if blocker.is_some() { Verdict::Dark } else { Verdict::Trace }
    }

    fn learn(&mut self, hit: SurfaceHit, light: LightId, evidence: Evidence, probe: &mut Probe<'_>) {
        let _ = hit;
        let (cell, tested) = self.rays[light.0 as usize];
        let blocker = match evidence.verdict {
            Verdict::DynamicOnly => return,
            Verdict::Dark if tested.is_none() => return,
            Verdict::Dark => tested,
            Verdict::Trace => evidence.blocker.filter(|b| b.0 < self.statics),
        };
        self.rays[light.0 as usize].1 = None;
        self.hints.learn(cell, light, blocker, self.drop);
        self.prover.learn(light, blocker, probe);
    }

    fn finish(self: Box<Self>) -> Vec<Change> {
        self.prover.finish().chain(self.hints.finish()).collect()
    }
}
