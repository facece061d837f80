//! Certificates only: a shadow ray is culled only by a proof. Exact, and independent of the view.

use super::certificates::{CertificateSpec, Certificates, Prover};
use super::facts::SceneFacts;
use super::mode_word::Shadow;
use super::policy::{Change, Evidence, Policy, Primary, SurfaceHit, Verdict, Worker};
use super::probe::Probe;
use crate::accel::{Ray, Trail};
use crate::quantity::LightId;
use crate::scene::Light;
use crate::stream::StoreEntries;

/// The policy's state.
pub(crate) struct Certified {
    certificates: Certificates,
    facts: SceneFacts,
}

impl Certified {
    /// The policy without any proof.
    pub(crate) fn new(spec: CertificateSpec, facts: SceneFacts) -> Self {
        Self { certificates: Certificates::new(spec, facts), facts }
    }
}

impl Policy for Certified {
    fn begin_frame(&mut self, lights: &[Light], _: Option<Vec<u32>>) {
        self.certificates.begin_frame(lights);
    }

    fn worker(&self) -> Box<dyn Worker + '_> {
        Box::new(CertifiedWorker { prover: self.certificates.prover(), facts: self.facts })
    }

    fn end_frame(&mut self, changes: &[Change], trail: &mut Trail) {
        self.certificates.end_frame(changes, trail);
    }

    fn stores(&self) -> StoreEntries {
        self.certificates.stores()
    }
}

struct CertifiedWorker<'a> {
    prover: Prover<'a>,
    facts: SceneFacts,
}

impl Worker for CertifiedWorker<'_> {
    fn hit(&mut self, _: SurfaceHit, _: Option<&Primary<'_>>, _: &mut Probe<'_>) {
        self.prover.hit();
    }

    fn decide(&mut self, hit: SurfaceHit, light: LightId, _: &Ray, probe: &mut Probe<'_>) -> Verdict {
        match self.prover.leaf(hit, light, probe).map(|leaf| leaf.mode) {
            Some(Shadow::Full) => Verdict::Dark,
            Some(Shadow::Non) => Verdict::DynamicOnly,
            _ => Verdict::Trace,
        }
    }

    fn learn(&mut self, _: SurfaceHit, light: LightId, evidence: Evidence, probe: &mut Probe<'_>) {
        if evidence.verdict == Verdict::Trace {
            let blocker = evidence.blocker.filter(|&blocker| !self.facts.is_dynamic(blocker));
            self.prover.learn(light, blocker, probe);
        }
    }

    fn finish(self: Box<Self>) -> Vec<Change> {
        self.prover.finish().collect()
    }
}
