//! Files of version 2.

use super::super::version::Version;
use super::*;

/// The tags of version 2 and their steps; updates have no recorded effect.
fn steps(id: u32) -> [(u32, Step); 14] {
    let triangle = |stop| Step::Triangle { slot: TriangleSlot(id), stop };
    let stores = [Store::ModeWord, Store::PixelCounter, Store::OccluderId];
    let [a, b, c] = stores.map(|store| Step::Read { store, index: id });
    let [d, e, f] = stores.map(|store| Step::Write { store, index: id });
    let [g, h, i] = stores.map(|store| Step::Update { store, index: id });
    let [plane, edges, hit] = [Stop::Plane, Stop::Edges, Stop::Hit].map(triangle);
    let all = [Step::Node(NodeId(id)), Step::List(ListId(id)), plane, edges, hit, a, b, c, d, e, f, g, h, i];
    let mut tag = 0..;
    all.map(|step| (tag.next().unwrap(), step))
}

fn today(word: u32) -> Result<u32, Fault> {
    Version::Two.steps(vec![word]).map(|words| words[0])
}

#[test]
fn packed_steps_get_the_tags_of_today() {
    for id in [0, 1, 0x123_4567, Step::MAX_INDEX] {
        for (tag, step) in steps(id) {
            assert_eq!(today(tag << 28 | id), Ok(step.pack()), "{step:?}");
        }
    }
    for tag in [14, 15] {
        assert_eq!(today(tag << 28 | 7), Err(Fault::OldStep { word: tag << 28 | 7 }), "it judges no update today");
    }
    let (tag, id) = (3, Step::MAX_INDEX + 1);
    let fault = today(tag << 28 | id).unwrap_err();
    assert_eq!(fault, Fault::OldId { id });
    assert_eq!(fault.to_string(), "a step of version 2 names id 134217728: ids up to 134217727 can be replayed");
}

#[test]
fn other_versions_are_refused_by_their_number() {
    let (header, items) = small_stream();
    let mut bytes = written(&header, &items);
    for version in [0u32, 1, 4, u32::MAX] {
        bytes[8..12].copy_from_slice(&version.to_le_bytes());
        let error = read(&bytes).unwrap_err();
        assert!(matches!(error, StreamError::Version { found, .. } if found == version), "{error}");
        assert!(error.to_string().ends_with("this program reads versions 2 and 3: record it again"), "{error}");
    }
    // A file of version 3 that claims to be of version 2: the checksum does not match.
    bytes[8..12].copy_from_slice(&2u32.to_le_bytes());
    assert!(matches!(read(&bytes), Err(StreamError::Corrupt { place: Place::Header, fault: Fault::Checksum, .. })));
}

#[test]
fn a_stream_that_judges_no_update_says_so_in_every_copy() {
    let (header, items) = small_stream();
    let header = Header { unjudged_updates: true, ..header };
    assert_eq!(read(&written(&header, &items)).unwrap().0, header);
}
