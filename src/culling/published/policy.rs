//! The published algorithm (GI09): it learns shadow modes ray by ray, and trusts them once a primitive was seen whole.

use rustc_hash::{FxHashMap, FxHashSet};

use super::super::facts::SceneFacts;
use super::super::mode_word::{ModeWord, Occlusion, SEEN_DARK, SEEN_LIT, Shadow, WordLayout};
use super::super::policy::{Change, Evidence, Needs, Policy, Primary, SurfaceHit, Verdict, Worker};
use super::super::probe::Probe;
use super::rules::{
    Border, Directions, DynamicTests, EvidenceRule, Highest, LightMoves, OccludedFull, Partial, PublishedRules,
    References, ResetCheck, ResetModes, Secondary, Words,
};
use crate::accel::{Ray, Trail};
use crate::quantity::{LightId, PrimitiveId};
use crate::scene::Light;
use crate::stream::{Effect, Store, StoreEntries};

/// Modes and counters of all primitives, as of the frame's start.
pub struct Published {
    rules: PublishedRules,
    facts: SceneFacts,
    layout: WordLayout,
    words: Vec<u32>,
    /// The highest number of rendered pixels of each primitive.
    highest: Vec<u32>,
    /// The lights of the previous frame.
    lights: Vec<Light>,
    /// Number of pixels of each primitive in this frame, if the rules need it in advance.
    census: Option<Vec<u32>>,
}

/// Kinds of [`Change`]: shadow bits to OR into a word; pixels to add to a primitive's count; a primitive seen
/// occluded.
const MODES: u32 = 0;
const RENDERED: u32 = 1;
const OCCLUDED: u32 = 2;

/// The bits of a first word that an update sets when its primitive is seen occluded: the low bit of the occlusion
/// mode.
const SEEN_OCCLUDED: u32 = 0b01;

impl Published {
    /// The policy without any knowledge.
    pub fn new(rules: PublishedRules, facts: SceneFacts) -> Self {
        let layout = WordLayout::new(facts.lights as usize);
        let primitives = facts.primitives as usize;
        let mut words = vec![0; primitives * layout.words_per_primitive() as usize];
        for primitive in (facts.statics..facts.primitives).map(PrimitiveId) {
            words[layout.first(primitive) as usize] = ModeWord(0).with_occlusion(Occlusion::Dynamic).0;
        }
        Self { rules, facts, layout, words, highest: vec![0; primitives], lights: Vec::new(), census: None }
    }

    fn first_word(&self, primitive: PrimitiveId) -> ModeWord {
        ModeWord(self.words[self.layout.first(primitive) as usize])
    }

    fn set_occlusion(&mut self, primitive: PrimitiveId, mode: Occlusion) {
        let word = &mut self.words[self.layout.first(primitive) as usize];
        *word = ModeWord(*word).with_occlusion(mode).0;
    }

    fn too_many(&self, pixels: u32, primitive: PrimitiveId) -> bool {
        f64::from(pixels) > self.rules.reset_ratio.0 * f64::from(self.highest[primitive.0 as usize])
    }

    fn clear_modes(&mut self, primitive: PrimitiveId) {
        let first = self.layout.first(primitive) as usize;
        self.words[first] = ModeWord(self.words[first]).without_shadows().0;
        self.words[first + 1..first + self.layout.words_per_primitive() as usize].fill(0);
    }

    /// Whether a primitive that is seen occluded in the frame becomes PARTIALLY_OCCLUDED.
    fn becomes_partial(&self, primitive: PrimitiveId) -> bool {
        match self.first_word(primitive).occlusion() {
            Occlusion::Init => true,
            Occlusion::FullyRendered => self.rules.occluded_full == OccludedFull::BecomesPartial,
            Occlusion::PartiallyOccluded | Occlusion::Dynamic => false,
        }
    }

    /// The occlusion mode setting stage, for one primitive that was rendered, or seen occluded.
    fn set_mode(&mut self, primitive: PrimitiveId, pixels: u32, occluded: bool) {
        if occluded && self.becomes_partial(primitive) {
            self.set_occlusion(primitive, Occlusion::PartiallyOccluded);
        }
        if pixels > 0 {
            // A census counts pixels before the shadows. It is compared with the census of earlier frames, not with
            // all hits.
            let pixels = self.census.as_ref().map_or(pixels, |census| census[primitive.0 as usize]);
            match self.first_word(primitive).occlusion() {
                Occlusion::Init => {
                    self.set_occlusion(primitive, Occlusion::FullyRendered);
                    if self.rules.highest == Highest::AtFull {
                        self.highest[primitive.0 as usize] = pixels;
                    }
                }
                Occlusion::FullyRendered if self.too_many(pixels, primitive) => {
                    self.set_occlusion(primitive, Occlusion::Init);
                    self.highest[primitive.0 as usize] = pixels;
                    if self.rules.reset_modes == ResetModes::Clear {
                        self.clear_modes(primitive);
                    }
                }
                _ => {}
            }
            if self.rules.highest == Highest::RunningMaximum {
                let highest = &mut self.highest[primitive.0 as usize];
                *highest = pixels.max(*highest);
            }
        }
        let returns = self.rules.partial == Partial::Returns
            && self.first_word(primitive).occlusion() == Occlusion::PartiallyOccluded;
        if returns {
            self.set_occlusion(primitive, Occlusion::Init);
        }
    }
}

impl Policy for Published {
    fn needs(&self) -> Needs {
        Needs {
            references: true,
            live: self.rules.words == Words::Live,
            census: self.rules.reset_check == ResetCheck::BeforeShadows,
        }
    }

    fn begin_frame(&mut self, lights: &[Light], census: Option<Vec<u32>>) {
        self.census = census;
        if self.rules.light_moves == LightMoves::Flush && !self.lights.is_empty() {
            for (light, (new, old)) in lights.iter().zip(&self.lights).enumerate() {
                if new.position != old.position {
                    for primitive in (0..self.facts.statics).map(PrimitiveId) {
                        let place = self.layout.shadow(primitive, LightId(light as u8));
                        self.words[place.word as usize] &= !(0b11 << place.shift);
                    }
                }
            }
        }
        self.lights = lights.to_vec();
    }

    fn worker(&self) -> Box<dyn Worker + '_> {
        Box::new(PublishedWorker {
            policy: self,
            modes: FxHashMap::default(),
            rendered: FxHashMap::default(),
            occluded: FxHashSet::default(),
        })
    }

    fn end_frame(&mut self, changes: &[Change], trail: &mut Trail) {
        // Sorted by primitive, so that neither the modes nor the accesses depend on the order of bands.
        let mut touched: Vec<(PrimitiveId, u32, bool)> = Vec::new();
        let mut sorted: Vec<_> = changes.iter().filter(|change| change.kind != MODES).collect();
        sorted.sort_by_key(|change| change.index);
        for change in sorted {
            let primitive = PrimitiveId(change.index);
            if touched.last().is_none_or(|last| last.0 != primitive) {
                touched.push((primitive, 0, false));
            }
            if let Some((_, pixels, occluded)) = touched.last_mut() {
                match change.kind {
                    RENDERED => *pixels += change.value,
                    _ => *occluded = true,
                }
            }
        }
        for change in changes.iter().filter(|change| change.kind == MODES) {
            self.words[change.index as usize] |= change.value;
        }
        for (primitive, pixels, occluded) in touched {
            self.set_mode(primitive, pixels, occluded);
            trail.update(Store::PixelCounter, primitive.0);
            trail.update(Store::ModeWord, self.layout.first(primitive));
        }
    }

    fn word(&self, primitive: PrimitiveId) -> Option<u32> {
        Some(self.first_word(primitive).0)
    }

    fn stores(&self) -> StoreEntries {
        StoreEntries {
            mode_words: self.words.len() as u32,
            word_owners: self.facts.primitives,
            words_per_primitive: self.layout.words_per_primitive(),
            pixel_counters: self.highest.len() as u32,
            ..StoreEntries::default()
        }
    }
}

struct PublishedWorker<'a> {
    policy: &'a Published,
    /// Learned shadow bits, by word.
    modes: FxHashMap<u32, u32>,
    /// Number of pixels rendered, by primitive.
    rendered: FxHashMap<PrimitiveId, u32>,
    occluded: FxHashSet<PrimitiveId>,
}

impl PublishedWorker<'_> {
    fn is_dynamic(&self, primitive: PrimitiveId) -> bool {
        self.policy.facts.is_dynamic(primitive)
    }

    fn see_occluded(&mut self, primitive: PrimitiveId, probe: &mut Probe<'_>) {
        if self.is_dynamic(primitive) {
            return;
        }
        let first = self.occluded.insert(primitive);
        let effect = match (self.policy.becomes_partial(primitive), first) {
            (false, _) => Effect::Silent,
            (true, false) => Effect::Repeats,
            (true, true) => Effect::Changes,
        };
        probe.set_bits(self.policy.layout.first(primitive), SEEN_OCCLUDED, effect);
    }

    /// Whether the primitive's shadow modes can be trusted.
    fn fully_rendered(&self, primitive: PrimitiveId) -> bool {
        let policy = self.policy;
        if policy.first_word(primitive).occlusion() != Occlusion::FullyRendered {
            return false;
        }
        let rules = &policy.rules;
        let seen_occluded_now = rules.words == Words::Live
            && rules.occluded_full == OccludedFull::BecomesPartial
            && self.occluded.contains(&primitive);
        let zoomed_in =
            policy.census.as_ref().is_some_and(|census| policy.too_many(census[primitive.0 as usize], primitive));
        !seen_occluded_now && !zoomed_in
    }
}

impl Worker for PublishedWorker<'_> {
    fn hit(&mut self, hit: SurfaceHit, primary: Option<&Primary<'_>>, probe: &mut Probe<'_>) {
        let rules = &self.policy.rules;
        if primary.is_none() && rules.secondary == Secondary::Ignore {
            return;
        }
        probe.read(Store::ModeWord, self.policy.layout.first(hit.primitive));
        let counts = primary.is_some() || rules.secondary == Secondary::CullAndCount;
        if counts && !self.is_dynamic(hit.primitive) {
            *self.rendered.entry(hit.primitive).or_default() += 1;
            probe.update(Store::PixelCounter, hit.primitive.0);
        }
        let Some(primary) = primary else { return };
        if primary.border && rules.border == Border::Occludes {
            self.see_occluded(hit.primitive, probe);
        }
        let compared = match rules.references {
            References::LeftAndUpper => 2,
            References::WithDiagonals => 4,
        };
        for reference in primary.references[..compared].iter().flatten() {
            if reference.primitive == hit.primitive {
                continue;
            }
            let facts = self.policy.facts;
            let tested = |primitive| rules.dynamic_tests == DynamicTests::Made || !facts.is_dynamic(primitive);
            if tested(reference.primitive) && probe.occlusion_test(primary.ray, reference.primitive) {
                self.see_occluded(reference.primitive, probe);
            }
            let backwards = rules.directions == Directions::BothWays && tested(hit.primitive);
            if backwards && probe.occlusion_test(&reference.ray, hit.primitive) {
                self.see_occluded(hit.primitive, probe);
            }
        }
    }

    fn decide(&mut self, hit: SurfaceHit, light: LightId, _: &Ray, _: &mut Probe<'_>) -> Verdict {
        let ignored = hit.depth > 1 && self.policy.rules.secondary == Secondary::Ignore;
        if ignored || !self.fully_rendered(hit.primitive) {
            return Verdict::Trace;
        }
        let place = self.policy.layout.shadow(hit.primitive, light);
        let mut word = self.policy.words[place.word as usize];
        if self.policy.rules.words == Words::Live {
            word |= self.modes.get(&place.word).copied().unwrap_or(0);
        }
        match place.mode(word) {
            Shadow::Full => Verdict::Dark,
            Shadow::Non => Verdict::DynamicOnly,
            Shadow::Init | Shadow::Partial => Verdict::Trace,
        }
    }

    fn learn(&mut self, hit: SurfaceHit, light: LightId, evidence: Evidence, probe: &mut Probe<'_>) {
        let rules = &self.policy.rules;
        if self.is_dynamic(hit.primitive) || hit.depth > 1 && rules.secondary == Secondary::Ignore {
            return;
        }
        let dark = match evidence.verdict {
            // The word itself gave this answer: there is nothing to learn.
            Verdict::Dark => return,
            Verdict::DynamicOnly if rules.evidence == EvidenceRule::StaticBlockers => return,
            Verdict::Trace | Verdict::DynamicOnly => match rules.evidence {
                EvidenceRule::AnyBlocker => evidence.blocker.is_some(),
                EvidenceRule::StaticBlockers => evidence.blocker.is_some_and(|blocker| !self.is_dynamic(blocker)),
            },
        };
        let place = self.policy.layout.shadow(hit.primitive, light);
        let bits = if dark { SEEN_DARK } else { SEEN_LIT } << place.shift;
        let learned = self.modes.entry(place.word).or_default();
        probe.set_bits(place.word, bits, Effect::of_bits(bits, self.policy.words[place.word as usize], *learned));
        *learned |= bits;
    }

    fn finish(self: Box<Self>) -> Vec<Change> {
        let modes = self.modes.into_iter().map(|(index, value)| Change { kind: MODES, index, value });
        let rendered =
            self.rendered.into_iter().map(|(PrimitiveId(index), value)| Change { kind: RENDERED, index, value });
        let occluded = self.occluded.into_iter().map(|PrimitiveId(index)| Change { kind: OCCLUDED, index, value: 1 });
        modes.chain(rendered).chain(occluded).collect()
    }
}
