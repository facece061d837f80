//! Certificates where they are possible; otherwise a test of the last blocker. Both are for cells of receivers and for
//! lamps: the points of an area light share a blocker as they share a proof.
//!
//! The two complement each other. A re-tested blocker answers dark rays for one triangle test, but cannot answer lit
//! rays. A certificate answers both, but is impossible where the answer changes within a cell, or where no single
//! triangle blocks the whole cell. (Two triangles that share an edge do not certainly block rays along it: the
//! triangle test is not watertight, and a ray may slip between them in the tracer.)

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::cells::Cell;
use super::certificates::{CertificateSpec, Certificates, Prover};
use super::facts::SceneFacts;
use super::hints::{HintWorker, Hints};
use super::mode_word::Shadow;
use super::policy::{Change, Evidence, Policy, Primary, SurfaceHit, Verdict, Worker};
use super::probe::Probe;
use crate::accel::{Ray, Trail};
use crate::quantity::{LightId, PrimitiveId};
use crate::ranged::PowerOfTwo;
use crate::scene::Light;
use crate::stream::StoreEntries;

/// Settings of certificates and hints. They suit every scene: no setting is a length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct HybridSpec {
    /// When proofs are attempted, and how many are stored.
    pub certificates: CertificateSpec,
    /// Entries of the table of hints, which holds the last blockers.
    pub hints: PowerOfTwo<2, 16_777_216>,
}

impl Default for HybridSpec {
    /// 64 KB of hints: sixteen times this size saves only 2 % more of the triangle tests in the BART kitchen.
    fn default() -> Self {
        Self { certificates: CertificateSpec::default(), hints: const { PowerOfTwo::literal(16_384) } }
    }
}

/// The policy's state.
pub(crate) struct Hybrid {
    certificates: Certificates,
    hints: Hints,
    facts: SceneFacts,
}

impl Hybrid {
    /// The policy without any knowledge.
    pub(crate) fn new(spec: HybridSpec, facts: SceneFacts) -> Self {
        let hints = Hints::new(spec.hints, facts.lights);
        Self { certificates: Certificates::new(spec.certificates, facts), hints, facts }
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
            facts: self.facts,
            open: vec![None; self.facts.lights as usize],
        })
    }

    fn end_frame(&mut self, changes: &[Change], trail: &mut Trail) {
        self.certificates.end_frame(changes, trail);
        self.hints.end_frame(changes, trail);
    }

    fn stores(&self) -> StoreEntries {
        StoreEntries { occluder_ids: self.hints.entries(), ..self.certificates.stores() }
    }
}

/// A ray without a certificate for its answer.
#[derive(Clone, Copy, Debug)]
struct Open {
    cell: Cell,
    /// The hinted triangle that blocks the ray.
    blocker: Option<PrimitiveId>,
}

struct HybridWorker<'a> {
    prover: Prover<'a>,
    hints: HintWorker<'a>,
    facts: SceneFacts,
    /// The rays of the current hit without a certificate, by light.
    open: Vec<Option<Open>>,
}

impl Worker for HybridWorker<'_> {
    fn hit(&mut self, _: SurfaceHit, _: Option<&Primary<'_>>, _: &mut Probe<'_>) {
        self.prover.hit();
        self.open.fill(None);
    }

    fn decide(&mut self, hit: SurfaceHit, light: LightId, ray: &Ray, probe: &mut Probe<'_>) -> Verdict {
        let leaf = self.prover.leaf(hit, light, probe);
        match leaf.map(|leaf| leaf.mode) {
            Some(Shadow::Full) => return Verdict::Dark,
            Some(Shadow::Non) => return Verdict::DynamicOnly,
            _ => {}
        }
        let cell = leaf.map_or(Cell::whole(hit.primitive), |leaf| leaf.cell);
        let blocker = self.hints.blocker(cell, self.facts.lamps.of(light), ray, probe);
        self.open[usize::from(light.0)] = Some(Open { cell, blocker });
        if blocker.is_some() { Verdict::Dark } else { Verdict::Trace }
    }

    fn learn(&mut self, _: SurfaceHit, light: LightId, evidence: Evidence, probe: &mut Probe<'_>) {
        let Some(Open { cell, blocker }) = self.open[usize::from(light.0)] else { return };
        let traced = evidence.blocker.filter(|&blocker| !self.facts.is_dynamic(blocker));
        let blocker = blocker.or(traced);
        self.hints.learn(cell, self.facts.lamps.of(light), blocker);
        self.prover.learn(light, blocker, probe);
    }

    fn finish(self: Box<Self>) -> Vec<Change> {
        self.prover.finish().chain(self.hints.finish()).collect()
    }
}
