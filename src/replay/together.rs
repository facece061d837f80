//! Several machines for which a stream is sampled on the same passes: each gives what it would by itself.

use super::fidelity::Fidelity;
use crate::engine::Source;
use crate::machine::MachineSpec;
use crate::sampling::{self, Against, Cut, Each, Verdict};
use crate::stream::Header;

/// A stream, how it is cut, and how machines are replayed on it. The machines were checked.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Together<'a> {
    /// The stream's header.
    pub header: &'a Header,
    /// How machines are replayed.
    pub fidelity: Fidelity,
    /// How samples cut the stream.
    pub cut: Cut,
    /// The machine that the others are measured against, and what is known of it.
    pub baseline: Option<Against<'a>>,
}

impl Together<'_> {
    /// Whether the stream is sampled at all: if not, machines have nothing to share.
    pub(crate) fn samples(&self) -> bool {
        match self.fidelity {
            Fidelity::Auto { error } => sampling::pays(self.cut, error, self.header, self.baseline.is_some()),
            Fidelity::Sampled { rate, .. } => rate.get() < 1.0,
            Fidelity::Bound | Fidelity::Profile | Fidelity::Event | Fidelity::Cycle => false,
        }
    }

    /// Samples the stream for all machines; what that ends with for each.
    ///
    /// # Errors
    /// The stream cannot be read, or so few windows tell nothing; of a machine, a run fails.
    pub(crate) fn sample(&self, machines: &[&MachineSpec], source: &dyn Source) -> Each<Verdict> {
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
