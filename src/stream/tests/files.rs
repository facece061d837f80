//! Files appear whole or not at all.

use std::fs;
use std::io::{self, Write};

use super::*;

fn names(folder: &Path) -> Vec<String> {
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

#[test]
fn a_file_appears_when_it_is_finished() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.rays");
    let (header, items) = small_stream();
    let mut writer = StreamWriter::create(&path, &header).unwrap();
    items.iter().for_each(|item| writer.write(item).unwrap());
    assert!(!path.exists());
    writer.finish().unwrap();
    assert_eq!(names(folder.path()), ["x.rays"]);
    let read: Vec<_> = StreamReader::open(&path).unwrap().map(Result::unwrap).collect();
    assert_eq!(read, items);

    // Dropped half way, failed, and finished too early: the old file stays, and nothing else.
    let old = fs::read(&path).unwrap();
    let mut writer = StreamWriter::create(&path, &header).unwrap();
    writer.write(&items[0]).unwrap();
    drop(writer);
    let mut writer = StreamWriter::create(&path, &header).unwrap();
    assert!(writer.write(&items[1]).is_err());
    assert!(matches!(writer.write(&items[0]), Err(StreamError::Failed { .. })));
    assert!(matches!(writer.finish(), Err(StreamError::Failed { .. })));
    let writer = StreamWriter::create(&path, &header).unwrap();
    assert!(writer.finish().is_err());
    assert_eq!(names(folder.path()), ["x.rays"]);
    assert_eq!(fs::read(&path).unwrap(), old);

    assert!(matches!(StreamWriter::create(folder.path(), &header), Err(StreamError::Io { doing: "create", .. })));
    let nowhere = folder.path().join("missing/x.rays");
    assert!(matches!(StreamWriter::create(&nowhere, &header), Err(StreamError::Io { doing: "create", .. })));
}

/// A file on a disk that is full after `left` bytes.
struct FullDisk {
    file: tempfile::NamedTempFile,
    left: usize,
}

impl Write for FullDisk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let taken = bytes.len().min(self.left);
        self.left -= taken;
        if taken == 0 { Err(io::ErrorKind::StorageFull.into()) } else { self.file.write(&bytes[..taken]) }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

#[test]
fn a_full_disk_is_an_error_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let (header, items) = small_stream();
    let all = written(&header, &items).len();
    let write = |left| {
        let file = tempfile::NamedTempFile::new_in(folder.path()).unwrap();
        let mut writer = StreamWriter::new(FullDisk { file, left }, Path::new(PATH), &header)?;
        items.iter().try_for_each(|item| writer.write(item))?;
        writer.complete()
    };
    for left in 0..all {
        match write(left) {
            Err(StreamError::Io { doing: "write", source, .. }) => {
                assert_eq!(source.kind(), io::ErrorKind::StorageFull);
            }
            Err(other) => panic!("{other:?}"),
            Ok(_) => panic!("{left} of {all} bytes were enough"),
        }
        assert!(names(folder.path()).is_empty());
    }
    assert!(write(all).is_ok());
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_device_is_told() {
    let full = Path::new("/dev/full");
    if !full.exists() {
        println!("skipped: there is no /dev/full");
        return;
    }
    let (header, _) = small_stream();
    match StreamWriter::create(full, &header) {
        Err(StreamError::Io { source, .. }) => assert_eq!(source.kind(), io::ErrorKind::StorageFull),
        other => panic!("{:?}", other.err()),
    }
}
