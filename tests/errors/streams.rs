//! Streams that are cut off, changed, or something else.

use std::fs;

use super::common::Desk;

/// A folder with the stream `good.rays`.
fn desk() -> Desk {
    let desk = Desk::with_experiment();
    desk.succeed(&["trace", "tiny.ron", "-o", "good.rays", "--policy", "Published"]);
    desk
}

/// What `inspect` and `replay` say of `bad.rays`: the same.
fn refused(desk: &Desk, bytes: &[u8]) -> String {
    desk.put("bad.rays", bytes);
    let inspected = desk.refused(&["inspect", "bad.rays"]);
    let replayed = desk.refused(&["replay", "bad.rays", "--machine", "small.ron", "--json", "out.json"]);
    assert_eq!(inspected, replayed);
    inspected
}

#[test]
fn a_truncated_stream() {
    let desk = desk();
    let good = fs::read(desk.path("good.rays")).unwrap();
    insta::assert_snapshot!(refused(&desk, &good[..good.len() / 2]), @"error: bad.rays is cut off: its end is not that of a stream: a part was lost, or something was appended");
    insta::assert_snapshot!(refused(&desk, &good[..5]), @"error: bad.rays is cut off: its header is not whole");
    insta::assert_snapshot!(refused(&desk, &[]), @"error: bad.rays is no ray stream: it is empty");
    for part in 1..12 {
        let message = refused(&desk, &good[..good.len() * part / 12]);
        assert!(message.starts_with("error: bad.rays is cut off: "), "{message}");
    }
    let message = refused(&desk, &good[..good.len() - 1]);
    assert!(message.starts_with("error: bad.rays is cut off: "), "{message}");
}

#[test]
fn a_stream_with_a_flipped_bit() {
    let desk = desk();
    let good = fs::read(desk.path("good.rays")).unwrap();
    let flipped = |at: usize| {
        let mut bytes = good.clone();
        bytes[at] ^= 0x10;
        bytes
    };
    insta::assert_snapshot!(refused(&desk, &flipped(good.len() / 2)), @"error: bad.rays is corrupt: frame 1, block 6: the checksum does not fit the bytes");
    for part in 0..16 {
        refused(&desk, &flipped((good.len() - 1) * part / 15));
    }
}

#[test]
fn something_else_than_a_stream() {
    let desk = desk();
    insta::assert_snapshot!(refused(&desk, b"P6 640 480 255 and then the pixels"), @"error: bad.rays is no ray stream: it begins with `P6 640 4`");
    insta::assert_snapshot!(desk.refused(&["inspect", "/dev/null"]), @"error: cannot read /dev/null: a pipe or a device: a regular file is needed");
    insta::assert_snapshot!(desk.refused(&["inspect", "."]), @"error: cannot read .: a folder: a regular file is needed");
    insta::assert_snapshot!(desk.refused(&["inspect", "absent.rays"]), @"error: cannot read absent.rays: No such file or directory (os error 2)");
}

#[test]
fn a_machine_file_that_is_absent() {
    insta::assert_snapshot!(desk().refused(&["replay", "good.rays", "--machine", "absent.ron"]), @"error: cannot read absent.ron: No such file or directory (os error 2)");
}
