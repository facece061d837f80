//! Files that were cut off or changed, or are no ray streams.

use super::*;

#[test]
fn every_truncation_is_refused() {
    let (header, items) = small_stream();
    let bytes = written(&header, &items);
    for length in 0..bytes.len() {
        let error = read(&bytes[..length]).unwrap_err();
        match length {
            0 => assert!(matches!(error, StreamError::Foreign { .. }), "{length}: {error}"),
            _ => assert!(matches!(error, StreamError::CutOff { .. }), "{length}: {error}"),
        }
    }
    assert!(read(&[&bytes[..], b"\n"].concat()).is_err());
}

#[test]
fn every_flipped_bit_is_refused() {
    let (header, items) = small_stream();
    let mut bytes = written(&header, &items);
    for bit in 0..8 * bytes.len() {
        bytes[bit / 8] ^= 1 << (bit % 8);
        assert!(read(&bytes).is_err(), "bit {} of byte {}", bit % 8, bit / 8);
        bytes[bit / 8] ^= 1 << (bit % 8);
    }
    assert!(read(&bytes).is_ok());
}

#[test]
fn foreign_files_are_named() {
    let foreign = |bytes: &[u8]| match read(bytes) {
        Err(error @ StreamError::Foreign { .. }) => error.to_string(),
        other => panic!("{other:?}"),
    };
    assert_eq!(foreign(b""), "test.rays is no ray stream: it is empty");
    assert_eq!(foreign(b"# RON\n"), r"test.rays is no ray stream: it begins with `# RON\n`");
    assert!(foreign(b"\x89PNG\r\n\x1a\n 1234567890").contains(r"`\x89PNG\r\n\x1a\n`"));

    let (header, items) = small_stream();
    let mut bytes = written(&header, &items);
    bytes[8] = 7;
    let error = read(&bytes).unwrap_err();
    assert_eq!(
        error.to_string(),
        "test.rays is a ray stream of version 7; this program reads versions 2 and 3: record it again"
    );

    let folder = tempfile::tempdir().unwrap();
    match StreamReader::open(folder.path()) {
        Err(StreamError::Io { doing: "read", source, .. }) => {
            assert!(source.to_string().contains("a folder"), "{source}")
        }
        other => panic!("{:?}", other.err()),
    }
    let missing = folder.path().join("missing.rays");
    assert!(matches!(StreamReader::open(&missing), Err(StreamError::Io { doing: "read", .. })));
}

/// Two streams that differ only in their scene's name have the same items and lengths. Still, no block of one is
/// accepted in the other.
#[test]
fn blocks_of_another_file_are_refused() {
    let (one, items) = small_stream();
    let other = Header { scene: "hall".to_owned(), ..one.clone() };
    let (mine, theirs) = (written(&one, &items), written(&other, &items));
    assert_eq!(mine.len(), theirs.len());
    let begin = PREAMBLE_BYTES + u32::from_le_bytes(field(&mine, 12)) as usize;
    let mut at = begin;
    while at < mine.len() - FOOTER_BYTES {
        let end = at + BLOCK_BYTES + u32::from_le_bytes(field(&mine, at + 16)) as usize;
        let mut spliced = mine.clone();
        spliced[at..end].copy_from_slice(&theirs[at..end]);
        assert!(matches!(read(&spliced), Err(StreamError::Corrupt { fault: Fault::Checksum, .. })));
        at = end;
    }
    let footer = mine.len() - FOOTER_BYTES;
    assert!(read(&[&mine[..footer], &theirs[footer..]].concat()).is_err());
}
