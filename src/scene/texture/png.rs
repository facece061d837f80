//! PNG pictures of any colour type; transparency is dropped.

use std::io::Cursor;

use crate::scene::limits::MAX_SIDE;
use crate::scene::material::Texture;

/// The largest number of pixels of a picture: a small file can ask for gigabytes.
const MAX_PIXELS: usize = 1 << 26;

/// The picture in the bytes of a PNG file. The error says what is wrong and what is allowed.
pub(super) fn decode(bytes: &[u8]) -> Result<Texture, String> {
    let wrong = |error: png::DecodingError| format!("not a PNG picture: {error}");
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    let header = decoder.read_header_info().map_err(wrong)?;
    let (width, height, interlaced) = (header.width, header.height, header.interlaced);
    if width > MAX_SIDE || height > MAX_SIDE || width as usize * height as usize > MAX_PIXELS {
        return Err(format!(
            "{width}x{height} pixels: sides of at most {MAX_SIDE} and at most {MAX_PIXELS} pixels are allowed"
        ));
    }
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(wrong)?;
    let samples = reader.output_color_type().0.samples();
    let mut rgb = Vec::new();
    if interlaced {
        let size = reader.output_buffer_size().ok_or("the picture does not fit in memory")?;
        let mut whole = vec![0; size];
        let info = reader.next_frame(&mut whole).map_err(wrong)?;
        whole.truncate(info.buffer_size());
        append(&mut rgb, &whole, samples);
    } else {
        // Reading by rows holds the picture in memory only once.
        while let Some(row) = reader.next_row().map_err(wrong)? {
            append(&mut rgb, row.data(), samples);
        }
    }
    if rgb.len() != width as usize * height as usize {
        return Err(format!("{width}x{height} pixels are told, and {} are there", rgb.len()));
    }
    Ok(Texture { width, height, rgb })
}

/// Adds pixels of one or two samples, which are grey (and alpha), or of three or four, colour (and alpha).
fn append(rgb: &mut Vec<[u8; 3]>, bytes: &[u8], samples: usize) {
    let pixels = bytes.chunks_exact(samples);
    rgb.extend(pixels.map(|pixel| if samples < 3 { [pixel[0]; 3] } else { [pixel[0], pixel[1], pixel[2]] }));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn encoded(width: u32, height: u32, color: png::ColorType, data: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(color);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        bytes
    }

    #[test]
    fn all_colour_types_become_colours() {
        let grey = encoded(2, 1, png::ColorType::GrayscaleAlpha, &[7, 255, 200, 0]);
        assert_eq!(decode(&grey).unwrap(), Texture { width: 2, height: 1, rgb: vec![[7; 3], [200; 3]] });
        let color = encoded(1, 2, png::ColorType::Rgba, &[1, 2, 3, 0, 4, 5, 6, 255]);
        assert_eq!(decode(&color).unwrap(), Texture { width: 1, height: 2, rgb: vec![[1, 2, 3], [4, 5, 6]] });
    }

    #[test]
    fn sides_are_checked_before_memory_is_taken() {
        let mut bytes = encoded(1, 1, png::ColorType::Rgb, &[1, 2, 3]);
        for (width, height) in [(1_000_000, 0x7fff_ffff), (32_769, 1), (32_768, 32_768)] {
            bytes[16..20].copy_from_slice(&u32::to_be_bytes(width));
            bytes[20..24].copy_from_slice(&u32::to_be_bytes(height));
            let sum = crc32fast::hash(&bytes[12..29]);
            bytes[29..33].copy_from_slice(&sum.to_be_bytes());
            assert!(decode(&bytes).unwrap_err().contains("sides of at most 32768"), "{width} {height}");
        }
        assert!(decode(&bytes[..20]).unwrap_err().starts_with("not a PNG picture"));
    }
}
