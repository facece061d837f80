//! Binary PPM (`P6`) with one byte a colour, as the netpbm manual page `ppm(5)` defines it.

use crate::scene::limits::MAX_SIDE;
use crate::scene::material::Texture;

/// The texture in the bytes of a PPM file. The error says what is wrong and what is allowed.
pub(super) fn decode(bytes: &[u8]) -> Result<Texture, String> {
    let mut header = Header { bytes };
    if header.word() != b"P6" {
        return Err("not a binary PPM picture: it must begin with `P6`".into());
    }
    let width = header.number("width", MAX_SIDE)?;
    let height = header.number("height", MAX_SIDE)?;
    let maximum = header.number("largest colour value", 255)?;
    // One white-space byte, and only one, stands between the header and the pixels.
    let pixels = header.bytes.get(1..).unwrap_or_default();
    let count = width as usize * height as usize;
    let Some(pixels) = pixels.get(..3 * count) else {
        return Err(format!(
            "{width}x{height} pixels take {} bytes: only {} follow the header",
            3 * count,
            pixels.len()
        ));
    };
    let scale = |value: u8| ((u32::from(value).min(maximum) * 255 + maximum / 2) / maximum) as u8;
    let rgb = pixels.as_chunks().0.iter().map(|&pixel: &[u8; 3]| pixel.map(scale)).collect();
    Ok(Texture { width, height, rgb })
}

/// The part of the header that is still to be read.
struct Header<'a> {
    bytes: &'a [u8],
}

impl<'a> Header<'a> {
    /// The next word, empty at the end; `#` begins a comment that ends with its line.
    fn word(&mut self) -> &'a [u8] {
        loop {
            self.bytes = self.bytes.trim_ascii_start();
            if self.bytes.first() != Some(&b'#') {
                break;
            }
            self.split_at(|byte| byte == b'\n');
        }
        self.split_at(|byte| byte.is_ascii_whitespace() || byte == b'#')
    }

    /// Takes the bytes before the first byte for which `end` holds.
    fn split_at(&mut self, end: impl Fn(u8) -> bool) -> &'a [u8] {
        let length = self.bytes.iter().position(|&byte| end(byte)).unwrap_or(self.bytes.len());
        let (taken, rest) = self.bytes.split_at(length);
        self.bytes = rest;
        taken
    }

    fn number(&mut self, what: &str, most: u32) -> Result<u32, String> {
        let word = String::from_utf8_lossy(self.word());
        match word.parse() {
            Ok(number) if (1..=most).contains(&number) => Ok(number),
            _ => Err(format!("{what} is `{word}`: a whole number from 1 to {most} is allowed")),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn reads_rows_from_the_top() {
        let texture = decode(b"P6 # a comment\n#another\n2 1\n# and one\n255\n\x01\x02\x03\x20\x0A\x23").unwrap();
        assert_eq!(texture, Texture { width: 2, height: 1, rgb: vec![[1, 2, 3], [32, 10, 35]] });
    }

    #[test]
    fn scales_smaller_ranges() {
        assert_eq!(decode(b"P6 1 1 5\n\x00\x02\x05").unwrap().rgb, vec![[0, 102, 255]]);
    }

    #[test]
    fn says_what_is_wrong() {
        let what = |bytes: &[u8]| decode(bytes).unwrap_err();
        assert!(what(b"").contains("P6"));
        assert!(what(b"P5 1 1 255\n\0").contains("P6"));
        assert!(what(b"P6 0 1 255\n").contains("width is `0`"));
        assert!(what(b"P6 1 4294967295 255\n").contains("height is `4294967295`"));
        assert!(what(b"P6 32768 32768 255\n\0").contains("3221225472 bytes: only 1 follow"));
        assert!(what(b"P6 1 1 65535\n\0\0\0\0\0\0").contains("largest colour value is `65535`"));
        assert!(what(b"P6 1 1 255\n\0\0").contains("only 2 follow"));
        assert!(what(b"P6 1 1 255").contains("only 0 follow"));
    }

    proptest! {
        #[test]
        fn never_panics(bytes in prop::collection::vec(any::<u8>(), 0..64)) {
            let _ = decode(&bytes);
        }

        #[test]
        fn a_picture_is_whole_or_refused(
            width in 0u32..5, height in 0u32..5, maximum in 0u32..300, pixels in prop::collection::vec(any::<u8>(), 0..60)
        ) {
            let mut bytes = format!("P6\n{width} {height}\n#\n{maximum}\n").into_bytes();
            bytes.extend(&pixels);
            let fits = width * height > 0 && (1..=255).contains(&maximum) && (width * height * 3) as usize <= pixels.len();
            let texture = decode(&bytes);
            prop_assert_eq!(texture.is_ok(), fits);
            if let Ok(texture) = texture {
                prop_assert_eq!(texture.rgb.len(), (width * height) as usize);
            }
        }
    }
}
