//! Timing models under stress: each must replay the streams of the failure cases, and is compared with the truth.

use crate::machine::MachineSpec;
use crate::replay::{Fidelity, Replay, RunError};
use crate::report::stress::ModelVerdict;
use crate::stream::{Header, Item};

/// The models; the first is the truth for the others.
pub(super) const MODELS: [Fidelity; 4] = [Fidelity::Cycle, Fidelity::Event, Fidelity::Profile, Fidelity::Bound];

/// The stream of a policy in a case.
pub(super) struct Recorded {
    pub header: Header,
    pub items: Vec<Item>,
}

/// The verdict on each of [`MODELS`] for a case's streams on the default machine.
pub(super) fn verdicts(streams: &[Recorded]) -> Vec<ModelVerdict> {
    let machine = MachineSpec::default();
    let replay = |model: Fidelity, Recorded { header, items }: &Recorded| {
        Replay::new(&machine, header).map_err(RunError::from)?.fidelity(model).run(items)
    };
    let truth: Vec<_> = streams.iter().map(|stream| replay(MODELS[0], stream)).collect();
    let verdict = |model: Fidelity| {
        let mut worst = ModelVerdict::Agrees;
        for (stream, truth) in streams.iter().zip(&truth) {
            let policy = &stream.header.policy;
            match (truth, replay(model, stream)) {
                (Ok(truth), Ok(found)) if *truth == found => {}
                (Ok(truth), Ok(found)) => worst.off_by(truth.cycles, found.cycles),
                (_, Err(error)) => return ModelVerdict::Failed(format!("{policy}: {error}")),
                (Err(error), Ok(_)) => return ModelVerdict::Failed(format!("{policy}: {}: {error}", MODELS[0])),
            }
        }
        worst
    };
    MODELS.into_iter().map(verdict).collect()
}
