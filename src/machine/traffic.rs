//! The spec of the host's own traffic with the DRAM, and the lines of this traffic.
//!
//! Rays, hits, pixels and texels follow one another in regions of their own; the dynamic part of the scene lies where
//! the layout puts it. This module has no notion of time: engines decide when a line is read or written, and what waits
//! for it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::quantity::LineAddr;
use crate::ranged::{Size, Within};
use crate::stats::TrafficClass;
use crate::stream::{FrameInfo, RayKind, Step, Stop};

/// Where rays from the host, and hits back to it, are buffered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum RayBuffer {
    /// In the FIFOs only, at no extra cost.
    #[default]
    Free,
    /// In an on-chip buffer; its bytes are counted.
    OnChip,
    /// In the DRAM, through the host's port.
    Dram,
}

/// Whether the dynamic part of the scene is written to the DRAM in each frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Build {
    /// It is already in the DRAM, at no cost.
    #[default]
    Free,
    /// Its nodes, lists and triangle records are written to the DRAM when the frame begins.
    Written,
}

/// DRAM traffic of the host and of a builder, through the host's port past all caches. All of it is off by default.
///
/// Source: a ray of 32 bytes holds an origin, a direction and the ends of an interval; a hit of 16 bytes holds a
/// distance, two barycentric coordinates and a triangle. All numbers have 4 bytes (RayDesc of Direct3D 12, Hit of
/// Arches). PowerVR GR6500 (2014) builds 100 million dynamic triangles per second. The queue is assumed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TrafficSpec {
    /// Where rays from the host, and hits back to it, are buffered.
    pub rays: RayBuffer,
    /// Bytes that the accelerator reads per ray.
    pub ray_bytes: Size<1, 4096>,
    /// Bytes that the accelerator writes per finished ray.
    pub hit_bytes: Size<1, 4096>,
    /// Bytes of the frame buffer that the host writes per finished primary ray; 0 for none.
    pub pixel_bytes: Size<0, 4096>,
    /// Bytes of textures that the host reads per hit of a primary or secondary ray; 0 for none.
    pub texture_bytes: Size<0, 4096>,
    /// Whether the dynamic part of the scene is written to the DRAM in each frame.
    pub build: Build,
    /// Dynamic triangles that a builder builds per second, in millions. Rays of a frame wait for the build; with 0 the
    /// builder takes no time, since it works while the previous frame is traced.
    #[schemars(extend("unit" = "million triangles a second"))]
    pub build_rate: Within<0, 1_000_000>,
    /// Number of waiting lines in the host's port from which on no ray is handed over.
    pub queue: Within<1, 65_536>,
}

impl Default for TrafficSpec {
    fn default() -> Self {
        Self {
            rays: RayBuffer::Free,
            ray_bytes: const { Size::literal(32) },
            hit_bytes: const { Size::literal(16) },
            pixel_bytes: const { Size::literal(0) },
            texture_bytes: const { Size::literal(0) },
            build: Build::Free,
            build_rate: const { Within::literal(0) },
            queue: const { Within::literal(64) },
        }
    }
}

impl TrafficSpec {
    /// Whether any of this traffic reaches the DRAM or takes time.
    pub fn is_on(&self) -> bool {
        self.rays == RayBuffer::Dram
            || self.pixel_bytes.get() > 0
            || self.texture_bytes.get() > 0
            || self.build == Build::Written
            || self.build_rate.get() > 0
    }

    /// The same traffic without building: the scene of each frame exists when the frame begins.
    pub fn without_build(self) -> Self {
        let Self { build, build_rate, .. } = Self::default();
        Self { build, build_rate, ..self }
    }

    /// Cycles, at a clock of `clock_mhz`, in which the dynamic part of a frame is built while its rays wait.
    pub fn build_cycles(&self, frame: &FrameInfo, clock_mhz: u64) -> u64 {
        let triangles = u64::from(frame.dynamic_slots);
        if self.build_rate.get() == 0 { 0 } else { (triangles * clock_mhz).div_ceil(self.build_rate.get()) }
    }
}

/// Consecutive lines that are read or written in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Run {
    /// The traffic class.
    pub class: TrafficClass,
    /// Whether the lines are written.
    pub write: bool,
    /// The first line.
    pub first: LineAddr,
    /// Number of lines.
    pub lines: u64,
}

/// Consecutive elements in a region of memory. A line is read or written once, with the first element that has a byte
/// in it: later elements find the line in a register.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Region {
    class: TrafficClass,
    write: bool,
    /// Base address of the region, and its bytes so far.
    base: u64,
    used: u64,
}

impl Region {
    /// Region number `number`. Regions are 1 TiB apart, above everything that a stream can name.
    fn new(number: u64, class: TrafficClass, write: bool) -> Self {
        Self { class, write, base: number << 40, used: 0 }
    }

    /// The lines of the next element that hold no byte of an earlier element.
    fn next(&mut self, bytes: u64, line: u64) -> Run {
        let first = self.used.div_ceil(line);
        self.used += bytes;
        let lines = self.used.div_ceil(line) - first;
        Run { class: self.class, write: self.write, first: LineAddr(self.base / line + first), lines }
    }
}

/// The reads and writes of a machine's host.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct HostTraffic {
    spec: TrafficSpec,
    line: u64,
    rays: Region,
    hits: Region,
    pixels: Region,
    textures: Region,
}

impl HostTraffic {
    /// The traffic of a machine with lines of `line` bytes, before a stream begins; `None` if all of it is off.
    pub(crate) fn new(spec: &TrafficSpec, line: u64) -> Option<Self> {
        spec.is_on().then(|| Self {
            spec: *spec,
            line,
            rays: Region::new(1, TrafficClass::Ray, false),
            hits: Region::new(2, TrafficClass::Ray, true),
            pixels: Region::new(3, TrafficClass::FrameBuffer, true),
            textures: Region::new(4, TrafficClass::Texture, false),
        })
    }

    /// The lines that the accelerator reads for the next ray.
    pub(crate) fn ray(&mut self) -> Option<Run> {
        let bytes = if self.spec.rays == RayBuffer::Dram { self.spec.ray_bytes.get() } else { 0 };
        some(self.rays.next(bytes, self.line))
    }

    /// The lines for the result of a ray of `kind` with a packed path: writes of the hit and of the pixel, then reads
    /// of textures.
    pub(crate) fn result(&mut self, kind: RayKind, path: &[u32]) -> impl Iterator<Item = Run> + use<> {
        let Self { spec, line, hits, pixels, textures, .. } = self;
        let hit = if spec.rays == RayBuffer::Dram { spec.hit_bytes.get() } else { 0 };
        let pixel = if kind == RayKind::Primary { spec.pixel_bytes.get() } else { 0 };
        let is_textured = spec.texture_bytes.get() > 0 && kind != RayKind::Shadow && hits_something(path);
        let texels = if is_textured { spec.texture_bytes.get() } else { 0 };
        let runs = [hits.next(hit, *line), pixels.next(pixel, *line), textures.next(texels, *line)];
        runs.into_iter().filter_map(some)
    }

    /// The lines that the builder writes for a frame with these dynamic arrays.
    pub(crate) fn built(&self, arrays: [(LineAddr, u64); 3]) -> impl Iterator<Item = Run> + use<> {
        let written = self.spec.build == Build::Written;
        let run = |(first, lines)| Run { class: TrafficClass::Build, write: true, first, lines };
        arrays.into_iter().filter(move |_| written).filter_map(move |array| some(run(array)))
    }
}

/// The run, or `None` if it has no lines.
fn some(run: Run) -> Option<Run> {
    (run.lines > 0).then_some(run)
}

/// Whether a triangle test of a packed path hits.
fn hits_something(path: &[u32]) -> bool {
    path.iter().any(|&word| matches!(Step::unpack(word), Some(Step::Triangle { stop: Stop::Hit, .. })))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_moved_with_the_first_element_in_it() {
        let mut region = Region::new(1, TrafficClass::Ray, false);
        let mut lines = |bytes| {
            let Run { first, lines, .. } = region.next(bytes, 64);
            (first.0 - (1 << 34), lines)
        };
        // Elements of 48 bytes: the second one ends in the second line, the third and the fourth end in the third line.
        assert_eq!([lines(48), lines(48), lines(48), lines(48)], [(0, 1), (1, 1), (2, 1), (3, 0)]);
        assert_eq!([lines(0), lines(200)], [(3, 0), (3, 4)]);
    }

    #[test]
    fn building_takes_the_stated_rate() {
        let spec = TrafficSpec { build_rate: Within::literal(100), ..TrafficSpec::default() };
        let frame = FrameInfo { dynamic_slots: 62_490, ..FrameInfo::default() };
        // 62,490 triangles at 100 million a second are 625 microseconds.
        assert_eq!(spec.build_cycles(&frame, 500), 312_450);
        assert_eq!(spec.without_build().build_cycles(&frame, 500), 0);
    }
}
