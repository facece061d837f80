//! Traces a frame band by band, for all policies at the same time.

use std::sync::Arc;

use rayon::prelude::*;
use xxhash_rust::xxh3::Xxh3Default;

use super::band::Band;
use super::lane::LaneFrame;
use super::learned::Learned;
use super::shade::Shader;
use super::spec::{BAND_ROWS, TracerSpec};
use crate::accel::{Accel, Trail};
use crate::culling::{Needs, Policy};
use crate::quantity::Resolution;
use crate::scene::{Frame, Scene};
use crate::stream::{Header, Item};

/// Traces the frames of a scene.
pub struct Tracer<'a> {
    pub(super) scene: &'a Scene,
    pub(super) spec: TracerSpec,
    pub(super) resolution: Resolution,
    pub(super) accel: Accel,
    /// Distance from their surface at which rays start, in world units.
    pub(super) offset: f64,
}

impl<'a> Tracer<'a> {
    /// A tracer; `first` is the first frame of the experiment.
    pub fn new(scene: &'a Scene, first: &Frame, resolution: Resolution, spec: TracerSpec) -> Self {
        let accel = Accel::new(scene, spec.accel);
        let offset = spec.render.offset.resolve(scene, first);
        Self { scene, spec, resolution, accel, offset }
    }

    /// The static part of the acceleration structure.
    pub fn accel(&self) -> &Accel {
        &self.accel
    }

    /// Distance from their surface at which rays start, in world units.
    pub fn offset(&self) -> f64 {
        self.offset
    }

    /// The header of the stream of `policy`; `input` describes, as text, everything else that the stream depends on.
    pub fn header(&self, name: &str, policy: &dyn Policy, frames: Vec<u32>, input: &str) -> Header {
        let mut hash = Xxh3Default::new();
        hash.update(input.as_bytes());
        for corner in self.scene.statics.triangles.iter().flat_map(|triangle| triangle.v) {
            corner.to_array().iter().for_each(|coordinate| hash.update(&coordinate.to_le_bytes()));
        }
        Header {
            scene: self.scene.name.clone(),
            frames,
            warmup: Vec::new(),
            resolution: self.resolution,
            policy: name.to_owned(),
            structure: self.accel.structure(),
            lights: self.scene.light_count as u32,
            static_primitives: self.scene.statics.len() as u32,
            primitives: self.scene.primitive_count() as u32,
            static_nodes: self.accel.static_nodes(),
            static_slots: self.accel.static_slots(),
            static_list_entries: self.accel.static_list_entries(),
            stores: policy.stores(),
            unjudged_updates: false,
            input_hash: hash.digest(),
            records: self.accel.static_records().into(),
        }
    }

    /// Traces a frame for `policies`; frames must come in the order of the animation. Hands each policy's stream to
    /// `sink` with the policy's index. The streams are interleaved, each in its own order.
    ///
    /// # Errors
    /// The errors of `sink`.
    pub fn frame<E: Send>(
        &self,
        frame: &Frame,
        policies: &mut [Box<dyn Policy>],
        mut sink: impl FnMut(usize, Item) -> Result<(), E>,
    ) -> Result<Vec<LaneFrame>, E> {
        let world = self.accel.frame(self.scene, frame);
        let shader = Shader::new(self.scene, frame, self.spec.render, self.offset as f32);
        let needs = policies.iter().fold(Needs::default(), |all, policy| {
            let needs = policy.needs();
            Needs {
                references: all.references || needs.references,
                live: all.live || needs.live,
                census: all.census || needs.census,
            }
        });
        let band =
            Band { world: &world, shader: &shader, frame, resolution: self.resolution, needs, order: self.spec.order };
        let census = needs.census.then(|| self.census(&band));
        for policy in policies.iter_mut() {
            let census = if policy.needs().census { census.clone() } else { None };
            policy.begin_frame(&frame.lights, census);
        }
        for lane in 0..policies.len() {
            sink(lane, Item::Frame(world.info()))?;
        }

        let mut lanes: Vec<_> = policies.iter().map(|_| LaneFrame::new(self.scene, self.resolution)).collect();
        let mut changes = vec![Vec::new(); policies.len()];
        let mut learned = vec![Learned::default(); policies.len()];
        let band_rows = if needs.live { self.resolution.height } else { BAND_ROWS };
        let rows: Vec<_> = (0..self.resolution.height)
            .step_by(band_rows as usize)
            .map(|start| start..(start + band_rows).min(self.resolution.height))
            .collect();
        // A few bands per thread at a time: memory stays bounded, and the sink receives the bands in order.
        for batch in rows.chunks(4 * rayon::current_num_threads()) {
            let traced: Vec<_> = batch.par_iter().map(|rows| band.trace(rows.clone(), policies)).collect();
            for bands in traced {
                for (lane, mut band) in bands.into_iter().enumerate() {
                    learned[lane].settle(&mut band.chunk, &mut band.record);
                    changes[lane].extend(lanes[lane].take(band.record));
                    sink(lane, Item::Rays(Arc::new(band.chunk)))?;
                }
            }
        }
        for (lane, policy) in policies.iter_mut().enumerate() {
            let mut trail = Trail::default();
            policy.end_frame(&changes[lane], &mut trail);
            let totals = lanes[lane].end(&trail);
            sink(lane, Item::End { policy: Arc::new(trail.steps.into_vec()), totals })?;
        }
        Ok(lanes)
    }

    /// The number of pixels that show each primitive.
    fn census(&self, band: &Band<'_>) -> Vec<u32> {
        let mut pixels = vec![0; self.scene.primitive_count()];
        let rows: Vec<_> = (0..self.resolution.height).into_par_iter().map(|y| band.row(y)).collect();
        for hit in rows.into_iter().flatten().flatten() {
            pixels[hit.0 as usize] += 1;
        }
        pixels
    }
}
