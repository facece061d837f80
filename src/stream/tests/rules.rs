//! The rules of streams, each broken once.

use super::super::format::RAW_LIMIT;
use super::super::violation::{RayFault, StepFault};
use super::*;

#[test]
fn items_come_in_order() {
    let header = header(&[4, 9]);
    let begin = Item::Frame(info(4));
    let rays = Item::Rays(Arc::new(Chunk::default()));
    let end = Item::End { policy: Arc::default(), totals: Totals::default() };
    let next = Item::Frame(info(9));
    let refused = |items: &[&Item]| {
        let items: Vec<_> = items.iter().map(|&item| item.clone()).collect();
        refusal(&header, &items).1
    };
    assert!(matches!(refused(&[&rays]), Violation::Order { .. }));
    assert!(matches!(refused(&[&end]), Violation::Order { .. }));
    assert!(matches!(refused(&[&begin, &next]), Violation::Order { .. }));
    assert!(matches!(refused(&[&begin, &end, &rays]), Violation::Order { .. }));
    assert_eq!(refused(&[&next]), Violation::Frame { found: 9, expected: 4 });
    assert_eq!(refused(&[&begin, &end, &begin]), Violation::Frame { found: 4, expected: 9 });
    assert_eq!(refused(&[&begin, &end, &next, &end, &next]), Violation::ExtraFrame { found: 9 });

    for (items, expected) in [
        (vec![begin.clone(), end.clone()], Violation::MissingFrame { expected: 9 }),
        (vec![begin], Violation::Order { found: "the stream's end", expected: "more of the frame" }),
    ] {
        let mut writer = StreamWriter::new(Vec::new(), Path::new(PATH), &header).unwrap();
        items.iter().for_each(|item| writer.write(item).unwrap());
        match writer.complete() {
            Err(StreamError::Invalid { violation, .. }) => assert_eq!(violation, expected),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn headers_are_checked() {
    for change in [
        |header: &mut Header| header.lights = 257,
        |header: &mut Header| header.static_primitives = 11,
        |header: &mut Header| header.resolution = Resolution { width: 1 << 17, height: 1 << 16 },
    ] {
        let mut header = header(&[]);
        change(&mut header);
        let error = StreamWriter::new(Vec::new(), Path::new(PATH), &header).err().unwrap();
        assert!(matches!(error, StreamError::Invalid { violation: Violation::Header { .. }, .. }), "{error}");
    }
}

#[test]
fn every_rule_of_rays_is_checked() {
    type Push = (RayHead, Vec<u32>, Vec<u32>);
    let hit = Outcome::Hit(PrimitiveId(1));
    let primary = || (head(RayKind::Primary, hit, 0), vec![], vec![]);
    let shadow = || (head(RayKind::Shadow, Outcome::Lit, 1), vec![], vec![]);
    let refused = |rays: &[Push]| {
        let mut chunk = Chunk::default();
        rays.iter().for_each(|(head, path, policy)| chunk.push(*head, path, policy));
        match refusal(&header(&[8]), &[Item::Frame(info(8)), Item::Rays(Arc::new(chunk))]) {
            (Place::Block { frame: Some(8), block: 1 }, Violation::Ray { ray, fault }) => {
                assert_eq!(ray, rays.len() - 1);
                fault
            }
            other => panic!("{other:?}"),
        }
    };
    let changed = |mut ray: Push, change: fn(&mut RayHead)| {
        change(&mut ray.0);
        ray
    };

    assert_eq!(refused(&[shadow()]), RayFault::FirstRay);
    assert_eq!(refused(&[changed(primary(), |head| head.parent = 1)]), RayFault::Parent(1));
    assert_eq!(refused(&[primary(), changed(shadow(), |head| head.parent = 0)]), RayFault::Parent(0));
    assert_eq!(refused(&[primary(), changed(shadow(), |head| head.parent = 2)]), RayFault::Parent(2));
    let other_group = changed(shadow(), |head| head.parent = 2);
    assert_eq!(refused(&[primary(), primary(), other_group]), RayFault::Parent(2));
    let miss = changed(primary(), |head| head.outcome = Outcome::Miss);
    assert_eq!(refused(&[miss, shadow()]), RayFault::ParentWithoutHit(1));
    assert_eq!(refused(&[primary(), shadow(), shadow()]), RayFault::ParentWithoutHit(1));
    let outside = changed(primary(), |head| head.pixel = PixelId(12));
    assert_eq!(refused(&[outside]), RayFault::Pixel { found: 12, pixels: 12 });
    let elsewhere = changed(shadow(), |head| head.pixel = PixelId(6));
    assert_eq!(refused(&[primary(), elsewhere]), RayFault::OtherPixel { found: 6, group: 5 });
    let light = changed(shadow(), |head| head.light = LightId(3));
    assert_eq!(refused(&[primary(), light]), RayFault::Light { found: 3, lights: 3 });
    let light = changed(primary(), |head| head.light = LightId(1));
    assert_eq!(refused(&[light]), RayFault::Light { found: 1, lights: 1 });
    assert_eq!(refused(&[changed(primary(), |head| head.decision = Decision::DynamicOnly)]), RayFault::Decision);
    assert!(matches!(
        refused(&[changed(primary(), |head| head.outcome = Outcome::Lit)]),
        RayFault::Outcome { kind: RayKind::Primary, outcome: Outcome::Lit }
    ));
    let hits = changed(shadow(), |head| head.outcome = Outcome::Miss);
    assert!(matches!(refused(&[primary(), hits]), RayFault::Outcome { .. }));
    let unknown = changed(primary(), |head| head.outcome = Outcome::Hit(PrimitiveId(10)));
    assert_eq!(refused(&[unknown]), RayFault::Primitive { found: 10, primitives: 10 });
    let mut skipped = changed(shadow(), |head| head.decision = Decision::Skip);
    skipped.1 = packed(&[Step::Node(NodeId(0))]);
    assert_eq!(refused(&[primary(), skipped]), RayFault::SkippedPath(1));

    // The first id that is too large, for each kind of step; other tests write the largest valid id.
    let slot = |index| Step::Triangle { slot: TriangleSlot(index), stop: Stop::Edges };
    let too_large = [(Step::Node(NodeId(7)), 7), (Step::List(ListId(5)), 5), (slot(11), 11)];
    for (step, limit) in too_large {
        let fault = StepFault::Id { at: 1, step, limit };
        let words = packed(&[Step::Node(NodeId(6)), step]);
        let head = head(RayKind::Primary, hit, 0);
        assert_eq!(refused(&[(head, words.clone(), vec![])]), RayFault::Path(fault.clone()));
        assert_eq!(refused(&[(head, vec![], words)]), RayFault::Policy(fault));
    }
    for (store, limit) in [(Store::ModeWord, 10), (Store::PixelCounter, 10), (Store::OccluderId, 30)] {
        for step in [
            Step::Read { store, index: limit },
            Step::Write { store, index: limit },
            Step::Update { store, index: limit },
        ] {
            let head = head(RayKind::Primary, hit, 0);
            let fault = StepFault::Id { at: 0, step, limit };
            assert_eq!(refused(&[(head, vec![], vec![step.pack()])]), RayFault::Policy(fault));
        }
    }
}

#[test]
fn totals_must_be_those_of_the_records() {
    let good = totals(&[small_chunk()], &[]);
    for at in 0..Totals::DECLARED.len() {
        let mut payload = Vec::new();
        format::put_end(&[], &good, &mut payload);
        payload[8 * at] ^= 1;
        let (_, changed) = format::end(&payload, super::super::version::Version::CURRENT).unwrap();
        let items = [
            Item::Frame(info(8)),
            Item::Rays(Arc::new(small_chunk())),
            Item::End { policy: Arc::default(), totals: changed },
        ];
        match refusal(&header(&[8]), &items).1 {
            Violation::Totals { what, recorded, counted } => {
                assert_eq!((what, recorded), (Totals::DECLARED[at].name, counted ^ 1));
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn the_writer_refuses_what_is_too_large() {
    let mut chunk = Chunk::default();
    let node = Step::Node(NodeId(1)).pack();
    chunk.push(head(RayKind::Primary, Outcome::Miss, 0), &vec![node; RAW_LIMIT / 4], &[]);
    let (_, violation) = refusal(&header(&[0]), &[Item::Frame(info(0)), Item::Rays(Arc::new(chunk))]);
    assert!(matches!(violation, Violation::TooLarge { what: "a chunk", .. }), "{violation}");

    let frames = vec![0; 1 << 20];
    let error = StreamWriter::new(Vec::new(), Path::new(PATH), &header(&frames)).err().unwrap();
    assert!(matches!(error, StreamError::Invalid { violation: Violation::TooLarge { what: "a header", .. }, .. }));
}
