//! Several machines sampled on the same passes over a stream: each gives the same result as alone.

use super::fidelity::Fidelity;
use crate::engine::Source;
use crate::machine::MachineSpec;
use crate::sampling::{self, Against, Cut, PerMachine, Verdict};
use crate::stream::Header;

/// A stream, its cut, and the fidelity of the replays. The machines were checked before.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Together<'a> {
    /// The stream's header.
    pub header: &'a Header,
    /// The fidelity of the replays.
    pub fidelity: Fidelity,
    /// How samples cut the stream.
    pub cut: Cut,
    /// The baseline of the other machines, and its known statistics.
    pub baseline: Option<Against<'a>>,
}

impl Together<'_> {
    /// Whether the stream is sampled; if not, machines have nothing to share.
    pub(crate) fn samples(&self) -> bool {
        match self.fidelity {
            Fidelity::Auto { error } => sampling::pays(self.cut, error, self.header, self.baseline.is_some()),
            Fidelity::Sampled { rate, .. } => rate.get() < 1.0,
            Fidelity::Bound | Fidelity::Profile | Fidelity::Event | Fidelity::Cycle => false,
        }
    }

    /// Samples the stream for all machines; returns the verdict for each.
    ///
    /// # Errors
    /// The stream cannot be read, or the sample is too small. Per machine: its run fails.
    pub(crate) fn sample(&self, machines: &[&MachineSpec], source: &dyn Source) -> PerMachine<Verdict> {
        let Self { header, fidelity, cut, baseline } = *self;
        match fidelity {
            Fidelity::Auto { error } => sampling::auto(machines, baseline, cut, error, header, source),
            Fidelity::Sampled { engine, rate, seed, target_error: Some(target) } => {
                let all = (machines, baseline);
                sampling::sample_until_within(target, engine, cut, (rate, seed), all, header, source)
            }
            Fidelity::Sampled { engine, rate, seed, target_error: None } => {
                let items = &mut source.open(0)?;
                let sampled = sampling::sample_together(engine, cut, (rate, seed), machines, header, items)?;
                Ok(sampled.into_iter().map(|stats| stats.map(|stats| Verdict::Sampled(Box::new(stats)))).collect())
            }
            Fidelity::Bound | Fidelity::Profile | Fidelity::Event | Fidelity::Cycle => {
                unreachable!("`samples` says that nothing is shared")
            }
        }
    }
}
