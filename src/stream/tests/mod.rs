//! Tests of the ray stream file: writer, reader and rules together.

mod damage;
mod files;
mod forged;
mod rules;
mod versions;

use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

use proptest::collection::vec;
use proptest::prelude::*;

use super::format::{BLOCK_BYTES, FOOTER_BYTES, PREAMBLE_BYTES, field};
use super::*;
use crate::quantity::{LightId, ListId, NodeId, PixelId, PrimitiveId, Resolution, TriangleSlot};

const PATH: &str = "test.rays";

fn header(frames: &[u32]) -> Header {
    Header {
        scene: "room".to_owned(),
        frames: frames.to_vec(),
        warmup: Vec::new(),
        resolution: Resolution { width: 4, height: 3 },
        policy: "published".to_owned(),
        structure: Structure::Bvh2,
        lights: 3,
        static_primitives: 7,
        primitives: 10,
        static_nodes: 5,
        static_slots: 8,
        static_list_entries: 4,
        stores: StoreEntries {
            mode_words: 10,
            word_owners: 10,
            words_per_primitive: 1,
            pixel_counters: 10,
            occluder_ids: 30,
        },
        unjudged_updates: false,
        input_hash: u64::MAX - 1,
        records: [3, 1, 4, 0, 5, u32::MAX, 6].map(TriangleSlot).into(),
    }
}

fn info(number: u32) -> FrameInfo {
    FrameInfo { number, dynamic_nodes: 2, dynamic_slots: 3, dynamic_list_entries: 1 }
}

fn head(kind: RayKind, outcome: Outcome, parent: u32) -> RayHead {
    RayHead { kind, light: LightId(0), decision: Decision::Trace, outcome, pixel: PixelId(5), parent }
}

fn totals(chunks: &[Chunk], end: &[u32]) -> Totals {
    let mut totals = Totals::default();
    chunks.iter().flat_map(Chunk::rays).for_each(|ray| totals.count(&ray));
    totals.count_policy(end.iter().filter_map(|&word| Step::unpack(word)));
    totals
}

fn frame(number: u32, chunks: Vec<Chunk>, end: Vec<u32>) -> Vec<Item> {
    let totals = totals(&chunks, &end);
    let rays = chunks.into_iter().map(|chunk| Item::Rays(Arc::new(chunk)));
    let last = Item::End { policy: Arc::new(end), totals };
    [Item::Frame(info(number))].into_iter().chain(rays).chain([last]).collect()
}

fn packed(steps: &[Step]) -> Vec<u32> {
    steps.iter().map(|step| step.pack()).collect()
}

/// A chunk of a primary ray that hits, a shadow ray that is skipped, and a shadow ray that is traced.
fn small_chunk() -> Chunk {
    let mut chunk = Chunk::default();
    let hit = Step::Triangle { slot: TriangleSlot(10), stop: Stop::Hit };
    chunk.push(
        head(RayKind::Primary, Outcome::Hit(PrimitiveId(9)), 0),
        &packed(&[Step::Node(NodeId(0)), Step::Node(NodeId(6)), Step::List(ListId(4)), hit]),
        &packed(&[Step::Read { store: Store::ModeWord, index: 9 }]),
    );
    let skipped = RayHead { decision: Decision::Skip, ..head(RayKind::Shadow, Outcome::Lit, 1) };
    chunk.push(skipped, &[], &[]);
    chunk.push(
        RayHead { light: LightId(2), ..head(RayKind::Shadow, Outcome::Dark, 2) },
        &packed(&[Step::Node(NodeId(0)), hit]),
        &[Step::pack_word_update(9, Effect::Silent)],
    );
    chunk
}

fn small_stream() -> (Header, Vec<Item>) {
    let end = packed(&[Step::Write { store: Store::PixelCounter, index: 3 }]);
    let items = [frame(16, vec![small_chunk()], end), frame(32, vec![], vec![])].concat();
    (header(&[16, 32]), items)
}

fn written(header: &Header, items: &[Item]) -> Vec<u8> {
    let mut writer = StreamWriter::new(Vec::new(), Path::new(PATH), header).unwrap();
    items.iter().for_each(|item| writer.write(item).unwrap());
    writer.complete().unwrap()
}

fn read(bytes: &[u8]) -> Result<(Header, Vec<Item>), StreamError> {
    let mut reader = StreamReader::new(Cursor::new(bytes), Path::new(PATH))?;
    let items = reader.by_ref().collect::<Result<Vec<_>, _>>()?;
    Ok((reader.header().clone(), items))
}

/// The violation with which the writer refuses the last of `items`.
fn refusal(header: &Header, items: &[Item]) -> (Place, Violation) {
    let mut writer = StreamWriter::new(Vec::new(), Path::new(PATH), header).unwrap();
    let (last, before) = items.split_last().unwrap();
    before.iter().for_each(|item| writer.write(item).unwrap());
    match writer.write(last) {
        Err(StreamError::Invalid { place, violation, .. }) => (place, violation),
        other => panic!("{other:?}"),
    }
}

// Valid streams: random numbers are reduced to the ranges that the header and earlier rays allow.

type Words = Vec<(u8, u32)>;

#[derive(Clone, Debug)]
struct RayPlan {
    kind: u8,
    light: u8,
    decision: u8,
    outcome: u32,
    parent: u32,
    path: Words,
    policy: Words,
}

fn ray_plan() -> impl Strategy<Value = RayPlan> {
    let words = || vec((any::<u8>(), any::<u32>()), 0..12);
    let free = (any::<u8>(), any::<u8>(), any::<u8>(), any::<u32>(), any::<u32>(), words(), words());
    free.prop_map(|(kind, light, decision, outcome, parent, path, policy)| RayPlan {
        kind,
        light,
        decision,
        outcome,
        parent,
        path,
        policy,
    })
}

fn steps(words: &Words, tags: u8) -> Vec<u32> {
    // Number of valid ids for each tag, from `header` and `info`.
    let counts = [7, 5, 11, 11, 11, 10, 10, 30, 10, 10, 30, 10, 10, 30, 10, 10];
    let word = |&(tag, index): &(u8, u32)| {
        let tag = tag % tags;
        (u32::from(tag) << 27) | (index % counts[usize::from(tag)])
    };
    words.iter().map(word).collect()
}

fn plan_chunk(groups: &[Vec<RayPlan>]) -> Chunk {
    let mut chunk = Chunk::default();
    for (pixel, group) in groups.iter().enumerate() {
        let mut hits = Vec::new();
        for (index, plan) in group.iter().enumerate() {
            let kind = match (hits.is_empty(), index) {
                (_, 0) => RayKind::Primary,
                (true, _) => break,
                _ => RayKind::ALL[1 + usize::from(plan.kind) % 3],
            };
            let shadow = kind == RayKind::Shadow;
            let outcome = match (shadow, plan.outcome % 3) {
                (true, 0) => Outcome::Lit,
                (true, _) => Outcome::Dark,
                (false, 0) => Outcome::Miss,
                (false, _) => Outcome::Hit(PrimitiveId(plan.outcome % 10)),
            };
            let decision = if shadow { Decision::ALL[usize::from(plan.decision) % 3] } else { Decision::Trace };
            let parent = if index == 0 { 0 } else { index - hits[plan.parent as usize % hits.len()] };
            let head = RayHead {
                kind,
                light: LightId(if shadow { plan.light % 3 } else { 0 }),
                decision,
                outcome,
                pixel: PixelId(pixel as u32 % 12),
                parent: parent as u32,
            };
            let path = if decision == Decision::Skip { vec![] } else { steps(&plan.path, 5) };
            chunk.push(head, &path, &steps(&plan.policy, 16));
            if matches!(outcome, Outcome::Hit(_)) {
                hits.push(index);
            }
        }
    }
    chunk
}

fn streams() -> impl Strategy<Value = (Header, Vec<Item>)> {
    let chunk = vec(vec(ray_plan(), 1..6), 0..8);
    let end = vec((any::<u8>(), any::<u32>()), 0..20);
    vec((any::<u32>(), vec(chunk, 0..4), end), 0..4).prop_map(|frames| {
        let numbers: Vec<_> = frames.iter().map(|frame| frame.0).collect();
        let items = frames.iter().flat_map(|(number, chunks, end)| {
            frame(*number, chunks.iter().map(|groups| plan_chunk(groups)).collect(), steps(end, 14))
        });
        (header(&numbers), items.collect())
    })
}

proptest! {
    #[test]
    fn what_is_written_is_read((header, items) in streams()) {
        let bytes = written(&header, &items);
        prop_assert_eq!(read(&bytes).unwrap(), (header.clone(), items.clone()));

        // Reading can start at each frame, also after another frame was read in part.
        let starts: Vec<_> = (0..items.len()).filter(|&at| matches!(items[at], Item::Frame(_))).collect();
        let mut reader = StreamReader::new(Cursor::new(&bytes), Path::new(PATH)).unwrap();
        for (index, &start) in starts.iter().enumerate().rev() {
            reader.next();
            reader.seek_frame(index).unwrap();
            let rest: Vec<_> = reader.by_ref().map(Result::unwrap).collect();
            prop_assert_eq!(&rest, &items[start..]);
        }
        reader.seek_frame(starts.len()).unwrap();
        prop_assert!(reader.next().is_none());
    }

    #[test]
    fn the_index_is_that_of_the_items((header, items) in streams()) {
        let bytes = written(&header, &items);
        let mut reader = StreamReader::new(Cursor::new(&bytes), Path::new(PATH)).unwrap();
        let inspection = inspect::inspect(&mut reader).unwrap();
        let mut frames = reader.frames().iter();
        let mut rays = 0;
        for item in &items {
            match item {
                Item::Frame(_) => rays = 0,
                Item::Rays(chunk) => rays += chunk.len() as u64,
                Item::End { totals, .. } => {
                    let entry = frames.next().unwrap();
                    prop_assert_eq!((entry.rays, entry.totals), (rays, *totals));
                }
            }
        }
        for (entry, summary) in reader.frames().iter().zip(&inspection.frames) {
            prop_assert_eq!(entry, &summary.entry);
            let kinds = &summary.kinds;
            prop_assert_eq!(kinds.iter().map(|kind| kind.rays).sum::<u64>(), entry.rays);
            prop_assert_eq!(kinds[RayKind::Shadow as usize].rays, entry.totals.shadow_rays);
            prop_assert_eq!(summary.decisions.skip, entry.totals.shadow_rays_skipped);
            prop_assert_eq!(summary.decisions.dynamic_only, entry.totals.shadow_rays_dynamic_only);
            for kind in kinds {
                prop_assert_eq!(kind.histogram.iter().sum::<u64>(), kind.rays);
                prop_assert_eq!(kind.miss + kind.hit + kind.lit + kind.dark, kind.rays);
            }
        }
        let blocks: u64 = reader.frames().iter().map(|entry| entry.bytes.0).sum();
        prop_assert!(blocks < inspection.file_bytes.0);
    }

    /// Random bytes after a valid start; they can contain any length.
    #[test]
    fn noise_is_refused(noise in vec(any::<u8>(), 0..400), keep in 0usize..600) {
        let (header, items) = small_stream();
        let whole = written(&header, &items);
        let mut bytes = whole.clone();
        bytes.truncate(keep);
        bytes.extend(noise);
        prop_assume!(bytes != whole);
        prop_assert!(read(&bytes).is_err());
    }
}

/// The bytes of `small_stream`, payloads unpacked: a change of the layout shows here, and needs another version number.
/// Sizes and offsets in the index depend on the LZ4 encoder: if nothing else changes, only the encoder has changed.
#[test]
fn the_layout_is_as_ever() {
    let (header, items) = small_stream();
    let bytes = written(&header, &items);
    let text_len = u32::from_le_bytes(field(&bytes, 12)) as usize;
    assert_eq!(bytes[..12], *b"\x89RAYS\r\n\x1a\x03\0\0\0");
    let seed = u32::from_le_bytes(field(&bytes, 16));
    let text = &bytes[PREAMBLE_BYTES..PREAMBLE_BYTES + text_len];
    assert_eq!(
        std::str::from_utf8(text).unwrap(),
        r#"{"scene":"room","frames":[16,32],"resolution":{"width":4,"height":3},"policy":"published","#.to_owned()
            + r#""structure":"Bvh2","lights":3,"static_primitives":7,"primitives":10,"static_nodes":5,"#
            + r#""static_slots":8,"static_list_entries":4,"stores":{"mode_words":10,"word_owners":10,"words_per_primitive":1,"#
            + r#""pixel_counters":10,"occluder_ids":30},"input_hash":18446744073709551614}"#
    );

    let mut at = PREAMBLE_BYTES + text_len;
    let mut lines = vec![format!("seed {seed:08x}")];
    let footer = bytes.len() - FOOTER_BYTES;
    while at < footer {
        let raw = u32::from_le_bytes(field(&bytes, at + 12)) as usize;
        let stored = u32::from_le_bytes(field(&bytes, at + 16)) as usize;
        let payload = lz4_flex::block::decompress(&bytes[at + BLOCK_BYTES..at + BLOCK_BYTES + stored], raw).unwrap();
        let hex: String = payload.iter().map(|byte| format!("{byte:02x}")).collect();
        lines.push(format!("{} {}: {hex}", bytes[at..at + 4].escape_ascii(), bytes[at + 4]));
        at += BLOCK_BYTES + stored;
    }
    lines.push(bytes[footer + 12..].escape_ascii().to_string());
    insta::assert_snapshot!(lines.join("\n"), @"
seed ce7d4b36
FRAM 0: 10000000020000000300000001000000
RAYS 1: 03000000080000001029310000020900000000000000000000000505050000000000000000000001020000000000000000000400020000000000000000000100010000000000000000000000000006000000040000080a00002009000028000000000a00002009000078
FEND 2: 010000000000000000000000000000000200000000000000010000000000000000000000000000000200000000000000010000000000000001000000000000000100000000000000010000000000000000000000000000000000000000000000010000000000000002000000000000000000000000000000010000000000000003000048
FRAM 3: 20000000020000000300000001000000
FEND 4: 0000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000
INDX 5: 100000007801000000000000ca00000000000000fe000000000000000300000000000000030000000000000001000000000000000000000000000000020000000000000001000000000000000000000000000000020000000000000001000000000000000100000000000000010000000000000001000000000000000000000000000000000000000000000001000000000000000200000000000000000000000000000001000000000000002000000042020000000000004e0000000000000090000000000000000000000000000000020000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000300000001000000040000000000000005000000ffffffff06000000
RAYS-END
");
}

#[test]
fn an_inspection_is_data() {
    let (header, items) = small_stream();
    let bytes = written(&header, &items);
    let mut reader = StreamReader::new(Cursor::new(bytes), Path::new(PATH)).unwrap();
    let inspection = inspect::inspect(&mut reader).unwrap();
    let json = serde_json::to_value(&inspection).unwrap();
    assert_eq!(json["frames"][0]["kinds"][1]["histogram"], serde_json::json!([1, 0, 1]));
    assert_eq!(json["frames"][0]["number"], 16);
}
