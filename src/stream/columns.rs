//! The payload of a RAYS block: a chunk of rays, column by column.
//!
//! ```text
//!   0   4  rays (n)
//!   4   4  steps of all rays (s)
//!   8   n  class: bits 1:0 kind, bits 3:2 decision, bits 5:4 outcome, bits 7:6 zero
//!       n  light
//!      4n  primitive of a hit; 0 for other outcomes
//!      4n  pixel
//!      4n  parent
//!      4n  steps of the path
//!      4n  steps of the policy
//!      4s  packed steps: of each ray the path's, then the policy's
//! ```
//!
//! A column of 4-byte numbers is stored as four planes: the lowest byte of every number, then the next bytes. Planes of
//! high bytes hardly change from ray to ray. LZ4, whose shortest match is 4 bytes, compresses them to almost nothing.
//! Steps are stored as they are: whole runs of them repeat from ray to ray.

use super::chunk::{Chunk, Decision, Outcome, RayHead, RayKind};
use super::fault::Fault;
use super::format::{field, put_words, words};
use super::version::Version;
use crate::quantity::{LightId, PixelId, PrimitiveId};

/// Bytes before the columns.
const COUNTS_BYTES: usize = 8;
/// Bytes of a ray without its steps: two columns of a byte, five of 4 bytes.
const RAY_BYTES: usize = 2 + 5 * 4;

fn payload_len(rays: usize, steps: usize) -> usize {
    COUNTS_BYTES + RAY_BYTES * rays + 4 * steps
}

/// Length of the payload of `chunk` in bytes.
pub(super) fn chunk_len(chunk: &Chunk) -> usize {
    payload_len(chunk.len(), chunk.steps())
}

/// Appends the payload of `chunk`.
pub(super) fn put_chunk(chunk: &Chunk, out: &mut Vec<u8>) {
    put_words(&[chunk.len() as u32, chunk.steps() as u32], out);
    out.extend(chunk.heads().map(|head| class(&head)));
    out.extend(chunk.heads().map(|head| head.light.0));
    let primitive = |head: RayHead| match head.outcome {
        Outcome::Hit(primitive) => primitive.0,
        Outcome::Miss | Outcome::Lit | Outcome::Dark => 0,
    };
    put_planes(chunk.heads().map(primitive), out);
    put_planes(chunk.heads().map(|head| head.pixel.0), out);
    put_planes(chunk.heads().map(|head| head.parent), out);
    put_planes(chunk.rays().map(|ray| ray.packed_path().len() as u32), out);
    put_planes(chunk.rays().map(|ray| ray.packed_policy().len() as u32), out);
    put_words(chunk.packed_steps(), out);
}

fn put_planes(numbers: impl Iterator<Item = u32>, out: &mut Vec<u8>) {
    let numbers: Vec<u32> = numbers.collect();
    for plane in 0..4 {
        out.extend(numbers.iter().map(|number| (number >> (8 * plane)) as u8));
    }
}

fn class(head: &RayHead) -> u8 {
    let outcome = match head.outcome {
        Outcome::Miss => 0,
        Outcome::Hit(_) => 1,
        Outcome::Lit => 2,
        Outcome::Dark => 3,
    };
    head.kind as u8 | (head.decision as u8) << 2 | outcome << 4
}

/// Reads a payload. Checks lengths and class bytes, but neither ids nor whether every word is a step: the chunk must
/// not leave the module before a [`super::Checker`] has seen it.
pub(super) fn chunk(payload: &[u8], version: Version) -> Result<Chunk, Fault> {
    if payload.len() < COUNTS_BYTES {
        return Err(Fault::Length { found: payload.len(), expected: COUNTS_BYTES });
    }
    let [rays, steps] = [0, 4].map(|at| u32::from_le_bytes(field(payload, at)) as usize);
    if payload.len() != payload_len(rays, steps) {
        return Err(Fault::Length { found: payload.len(), expected: payload_len(rays, steps) });
    }
    let (columns, packed) = payload[COUNTS_BYTES..].split_at(RAY_BYTES * rays);
    let (classes, columns) = columns.split_at(rays);
    let (lights, columns) = columns.split_at(rays);
    let [primitives, pixels, parents, paths, policies] =
        [0, 1, 2, 3, 4].map(|column| from_planes(columns, column, rays));
    let rays = (0..rays).map(|ray| {
        let (class, primitive) = (classes[ray], primitives[ray]);
        let (kind, decision, outcome) = unclass(class, primitive).ok_or(Fault::Class { ray, class, primitive })?;
        let (light, pixel, parent) = (LightId(lights[ray]), PixelId(pixels[ray]), parents[ray]);
        let head = RayHead { kind, light, decision, outcome, pixel, parent };
        Ok((head, [paths[ray], policies[ray]]))
    });
    Chunk::from_columns(rays, version.steps(words(packed))?)?.ok_or(Fault::Steps { steps })
}

/// Decodes a column of 4-byte numbers from its four planes.
fn from_planes(columns: &[u8], column: usize, rays: usize) -> Vec<u32> {
    let plane = |at: usize| &columns[(4 * column + at) * rays..][..rays];
    let bytes = plane(0).iter().zip(plane(1)).zip(plane(2)).zip(plane(3));
    bytes.map(|(((&a, &b), &c), &d)| u32::from_le_bytes([a, b, c, d])).collect()
}

fn unclass(class: u8, primitive: u32) -> Option<(RayKind, Decision, Outcome)> {
    let kind = RayKind::ALL[usize::from(class & 3)];
    let decision = *Decision::ALL.get(usize::from(class >> 2 & 3))?;
    let outcome = match (class >> 4, primitive) {
        (0, 0) => Outcome::Miss,
        (1, _) => Outcome::Hit(PrimitiveId(primitive)),
        (2, 0) => Outcome::Lit,
        (3, 0) => Outcome::Dark,
        _ => return None,
    };
    Some((kind, decision, outcome))
}
