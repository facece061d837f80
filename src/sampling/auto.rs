//! No more than a stream needs: a pilot tells which parts of the machine matter and which rung is close enough, another
//! part of the stream checks that, and only then is everything replayed, by the cheapest model that has passed.

use std::sync::Arc;

use rayon::prelude::*;

use super::findings::TELLING;
use super::plan::{Cut, Plan};
use super::sample::sample_until;
use crate::engine::whole::whole;
use crate::engine::{Items, Level, RunError, Sampled, Source};
use crate::machine::MachineSpec;
use crate::machine::shadow_cache::{Place, ShadowCacheSpec};
use crate::memory::dram::spec::Model;
use crate::memory::l2::L2Spec;
use crate::memory::tags::Contents;
use crate::ranged::{Share, Size, Within};
use crate::stats::{MachineStats, ModelCheck, Needs, PartNeed};
use crate::stream::{Chunk, Header, Item, RayKind, StreamError, Totals};

/// One in so many pixels is in the pilot, and as many are held back. A dozen replays of it cost less than a hundredth
/// of one replay of all.
const PILOT: u64 = 2000;
/// Pixels of the pilot at least.
const LEAST_PIXELS: u64 = 512;
/// Points with which sampling begins: some more than the windows that tell, since large windows have several.
const FIRST_WINDOWS: f64 = 1.25 * TELLING as f64;
/// The share of windows with which it begins at least: with fewer, reading the stream costs much more than what is
/// replayed. (Kitchen on `small`, 41,000 windows: with one in 100, intervals were 0.7 % and 16 of 57 s of processor
/// time were the windows'; with one in 250, 1.4 % and 6 of 40 s.)
const LEAST_RATE: f64 = 0.004;
/// The share of pixels that may be replayed, those beside the windows among them: as many as there are. With the tags
/// that takes a tenth longer than `Event` on one processor, and little more than half as long on two.
const MOST_REPLAYED: f64 = 1.0;

/// A part of the machine, and the machine without what it costs.
type Part = (&'static str, fn(&mut MachineSpec));

/// The parts that can be left out, a line each.
const PARTS: [Part; 8] = [
    ("L1s of traversal units", |machine| machine.traversal.cache.contents = Contents::Ideal),
    ("L1s of list units", |machine| machine.list.cache.contents = Contents::Ideal),
    ("L1s of intersection units", |machine| machine.intersection.cache.contents = Contents::Ideal),
    ("L1s of shadow-cache units", |machine| machine.shadow_cache.cache.contents = Contents::Ideal),
    ("bank conflicts of L1s", |machine| {
        let MachineSpec { traversal, list, intersection, shadow_cache, .. } = machine;
        let caches = [&mut traversal.cache, &mut list.cache, &mut intersection.cache, &mut shadow_cache.cache];
        caches.into_iter().for_each(|cache| cache.banks = None);
    }),
    ("L2", |machine| match &mut machine.l2 {
        L2Spec::Unified(cache) => cache.contents = Contents::Ideal,
        L2Spec::Split(homes) => homes.values_mut().for_each(|home| home.cache.contents = Contents::Ideal),
    }),
    ("banks, rows and refresh of the DRAM", |machine| {
        let bytes = machine.dram.peak_bytes_per_cycle(machine.clock_mhz.get());
        let a_channel = bytes.map(|bytes| (bytes / machine.dram.channels.get() as f64).round().max(1.0) as u64);
        let part = &machine.dram.part;
        let clocks = part.timing.rcd.get() + part.timing.cl.get();
        let latency = machine.dram.clocks(machine.clock_mhz.get()).cycle_after(clocks).max(1);
        let bytes_per_cycle = a_channel.and_then(|bytes| Size::new(bytes).ok());
        if let Ok(latency) = Within::new(latency) {
            machine.dram.model = Model::Flat { latency, bytes_per_cycle };
        }
    }),
    ("stores of the culling policy", |machine| {
        let ShadowCacheSpec { count, latency, contexts, cache, .. } = machine.shadow_cache;
        machine.shadow_cache =
            ShadowCacheSpec { count, latency, contexts, cache, place: Place::Free, ..ShadowCacheSpec::default() };
    }),
];

/// Replays a stream with an error of cycles and of L2 and DRAM bytes that is to be within `target`.
///
/// # Errors
/// The stream cannot be read, or a run fails.
pub(crate) fn auto(
    machine: &MachineSpec,
    target: Share,
    header: &Header,
    source: &dyn Source,
) -> Result<MachineStats, RunError> {
    let (frames, pixels) = (header.frames.len(), header.resolution.pixels() as u64);
    let wanted = (frames as u64 * pixels / PILOT).max(LEAST_PIXELS).min(pixels / 4) as usize;
    let third = pixels as usize / 3;
    let pilot = piece(source.open(frames / 3)?, third, wanted)?;
    let held_back = piece(source.open(2 * frames / 3)?, 2 * third, wanted)?;
    // A pilot is measured whole, wherever its frame lies.
    let pilot_header = Header { warmup: Vec::new(), ..header.clone() };
    let on = |machine: &MachineSpec, rung, piece: &[Item]| {
        let stats = whole(rung, machine, &pilot_header, &mut piece.iter().cloned().map(Ok), None);
        stats.map(|stats| Figures::of(&stats))
    };
    let without = |&(part, leave_out): &Part| {
        let mut without = machine.clone();
        leave_out(&mut without);
        (without != *machine).then_some((part, leave_out, without))
    };
    let parts: Vec<_> = PARTS.iter().filter_map(without).collect();
    let (exact, effects) = rayon::join(
        || rayon::join(|| on(machine, Level::Event, &pilot), || on(machine, Level::Event, &held_back)),
        || parts.par_iter().map(|(_, _, without)| on(without, Level::Event, &pilot)).collect::<Vec<_>>(),
    );
    let (truth, checked) = (exact.0?, exact.1?);
    let mut needs = Needs {
        target: target.get(),
        pilot_share: wanted as f64 / (frames as u64 * pixels) as f64,
        ..Needs::default()
    };
    let share = target.get() / PARTS.len() as f64;
    let mut reduced = machine.clone();
    for ((part, leave_out, _), figures) in parts.into_iter().zip(effects) {
        let effect = figures?.against(&truth);
        let matters = effect.iter().flatten().any(|effect| effect.abs() > share);
        if !matters {
            leave_out(&mut reduced);
        }
        let [cycles, l2_bytes, dram_bytes] = effect;
        needs.parts.push(PartNeed { part: part.into(), cycles, l2_bytes, dram_bytes, matters });
    }

    let off = |machine: &MachineSpec, rung, piece: &[Item], truth: &Figures| {
        Ok::<_, RunError>(on(machine, rung, piece)?.worst_against(truth))
    };
    if off(&reduced, Level::Event, &held_back, &checked)? > target.get() / 2.0 {
        needs.parts.iter_mut().for_each(|part| part.matters = true);
        reduced = machine.clone();
    }
    // The pilot is small: a model has to be well within the target there.
    let tried = |machine: &MachineSpec, rung: Level| {
        let error = off(machine, rung, &pilot, &truth)?;
        let is_near = error <= target.get() / 2.0;
        let again = if is_near { Some(off(machine, rung, &held_back, &checked)?) } else { None };
        let passes = again.is_some_and(|again| again <= target.get());
        Ok::<_, RunError>(ModelCheck { model: rung.to_string(), error: Some(error), held_back: again, passes })
    };
    let bound = tried(&reduced, Level::Bound)?;
    needs.models.push(bound.clone());
    if bound.passes {
        return Ok(MachineStats {
            needs: Some(needs),
            ..whole(Level::Bound, &reduced, header, &mut source.open(0)?, None)?
        });
    }
    // Next to it a sample costs the least, and tells its own error: on the whole machine, since what leaving parts out
    // adds is in no interval.
    let cut = Cut::new(machine);
    let windows = (frames as u64 * pixels) as f64 / cut.window() as f64;
    let (rate, most) = ((FIRST_WINDOWS / windows).max(LEAST_RATE), MOST_REPLAYED / cut.effort());
    if rate <= most {
        let plan = Plan::new(rate, machine, 0);
        let (sampled, passes) = sample_until(Sampled::Event, machine, header, plan, (target, most), source)?;
        let error = sampled.accuracy.widest();
        needs.models.push(ModelCheck { model: "Sampled(engine: Event)".into(), error, held_back: None, passes });
        if passes {
            return Ok(MachineStats { needs: Some(needs), ..sampled });
        }
    }
    let profile = tried(&reduced, Level::Profile)?;
    needs.models.push(profile.clone());
    if profile.passes {
        return Ok(MachineStats {
            needs: Some(needs),
            ..whole(Level::Profile, &reduced, header, &mut source.open(0)?, None)?
        });
    }
    let model = Level::Event.to_string();
    needs.models.push(ModelCheck { model, error: Some(0.0), held_back: Some(0.0), passes: true });
    Ok(MachineStats { needs: Some(needs), ..whole(Level::Event, machine, header, &mut source.open(0)?, None)? })
}

/// Cycles, bytes of the L2, bytes of the DRAM.
struct Figures([f64; 3]);

impl Figures {
    fn of(stats: &MachineStats) -> Self {
        Self([stats.cycles.0, stats.moved_l2().0, stats.moved("dram").0].map(|figure| figure as f64))
    }

    /// Changes as shares of `truth`, where there is one.
    fn against(&self, truth: &Self) -> [Option<f64>; 3] {
        std::array::from_fn(|at| (truth.0[at] > 0.0).then(|| self.0[at] / truth.0[at] - 1.0))
    }

    fn worst_against(&self, truth: &Self) -> f64 {
        self.against(truth).into_iter().flatten().fold(0.0, |worst, change| worst.max(change.abs()))
    }
}

/// A stream of `wanted` pixels of the frame that `items` begins with, from the `first` one on.
fn piece(items: Items<'_>, first: usize, wanted: usize) -> Result<Vec<Item>, StreamError> {
    let (mut piece, mut totals, mut passed) = (Vec::new(), Totals::default(), 0);
    for item in items {
        match item? {
            Item::Frame(info) => piece.push(Item::Frame(info)),
            Item::Rays(chunk) => {
                let mut part = Chunk::default();
                for ray in chunk.rays() {
                    passed += usize::from(ray.head.kind == RayKind::Primary);
                    if (first + 1..=first + wanted).contains(&passed) {
                        totals.count(&ray);
                        part.push(ray.head, ray.packed_path(), ray.packed_policy());
                    }
                }
                if !part.is_empty() {
                    piece.push(Item::Rays(Arc::new(part)));
                }
                if passed > first + wanted {
                    break;
                }
            }
            Item::End { .. } => break,
        }
    }
    piece.push(Item::End { policy: Arc::new(Vec::new()), totals });
    Ok(piece)
}
