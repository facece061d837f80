//! Reading pictures that colour surfaces: PNG and binary PPM.

mod png;
mod ppm;

use super::material::Texture;

/// The picture in the bytes of a file, its first row at v = 1. Its first bytes tell the format.
///
/// # Errors
/// Bytes of another format, sides above 32,768, a picture that ends too early. The error says what is wrong and what is
/// allowed.
pub fn decode(bytes: &[u8]) -> Result<Texture, String> {
    match bytes {
        [b'P', b'6', ..] => ppm::decode(bytes),
        [0x89, b'P', b'N', b'G', ..] => png::decode(bytes),
        _ => Err("the picture is neither a PNG nor a binary PPM (`P6`): only these are read".into()),
    }
}
