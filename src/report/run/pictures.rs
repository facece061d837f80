//! Pictures of a report: from colours, wrong pixels and mode words; and PNG files.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::quantity::Resolution;
use crate::report::draw::palette::{Color, FALSE_DARK, FALSE_LIT, NUMERIC};
use crate::report::file_names::FileNamed;
use crate::validate::PixelVerdict;

/// Red, green and blue, 8 bits each, as shown on a screen.
pub(crate) type Rgb = [u8; 3];

/// A picture ready to be written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Image {
    /// Its size.
    pub resolution: Resolution,
    /// Row by row from the top left; their number follows from `resolution`.
    pub pixels: Vec<Rgb>,
}

/// A picture of the report: its content and its file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct PictureInfo {
    /// Path inside the report, with `/` between folders.
    pub file: String,
    /// Its content.
    pub kind: PictureKind,
    /// The policy that the picture belongs to; `None` for the reference renderer's.
    pub policy: Option<String>,
    /// The frame's number.
    pub frame: u32,
}

impl PictureInfo {
    /// A picture of this kind; the file's name follows from kind, policy and frame.
    pub(crate) fn new(kind: PictureKind, policy: Option<&FileNamed<'_>>, frame: u32) -> Self {
        let whose = policy.map(|policy| format!("-{}", policy.file)).unwrap_or_default();
        let what = match kind {
            PictureKind::Render => "render".into(),
            PictureKind::Reference => "reference".into(),
            PictureKind::Difference { light: None } => "difference".into(),
            PictureKind::Difference { light: Some(light) } => format!("difference-light{light}"),
            PictureKind::Words { light } => format!("words-light{light}"),
        };
        Self {
            file: format!("pictures/frame{frame:04}{whose}-{what}.png"),
            kind,
            policy: policy.map(|policy| policy.name.into()),
            frame,
        }
    }
}

/// The content of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum PictureKind {
    /// The tracer's picture.
    Render,
    /// The reference renderer's picture.
    Reference,
    /// Wrong pixels on a dimmed render.
    Difference {
        /// The light's number; `None` for all lights together.
        light: Option<u32>,
    },
    /// The mode words of the visible primitives, towards a light, as latched at the start of the frame.
    Words {
        /// The light's number.
        light: u32,
    },
}

/// Verdicts that a picture highlights, each with its name in legends and its colour in plots. Later ones are drawn
/// over earlier ones.
pub(crate) const SHOWN_VERDICTS: [(PixelVerdict, &str, Rgb); 3] = [
    (PixelVerdict::Numeric, "numeric difference", rgb(NUMERIC)),
    (PixelVerdict::FalseLit, "false lit", rgb(FALSE_LIT)),
    (PixelVerdict::FalseDark, "false dark", rgb(FALSE_DARK)),
];

const fn rgb(color: Color) -> Rgb {
    [color.0, color.1, color.2]
}

/// Converts colours of 0..1 to 8 bits. The scenes' colours are made for the screen, so no tone curve is applied.
pub(crate) fn render(resolution: Resolution, colors: &[Vec3]) -> Image {
    let shown = |level: f32| (level.clamp(0.0, 1.0) * 255.0).round() as u8;
    Image { resolution, pixels: colors.iter().map(|color| color.to_array().map(shown)).collect() }
}

/// Pixels by verdict on a dimmed grey `render`. Wrong pixels are enlarged so that a single one is visible: by one
/// pixel to each side for every 256 pixels of the picture's width. Numeric differences are not enlarged.
pub(crate) fn difference(render: &Image, verdicts: &[PixelVerdict]) -> Image {
    let Resolution { width, height } = render.resolution;
    let mut pixels: Vec<Rgb> = render.pixels.iter().map(|&rgb| dimmed(rgb)).collect();
    let margin = width.div_ceil(256);
    for (shown, _, color) in SHOWN_VERDICTS {
        let margin = if shown == PixelVerdict::Numeric { 0 } else { margin };
        for (index, _) in verdicts.iter().enumerate().filter(|&(_, &verdict)| verdict == shown) {
            let (x, y) = (index as u32 % width, index as u32 / width);
            for row in y.saturating_sub(margin)..=(y + margin).min(height - 1) {
                for column in x.saturating_sub(margin)..=(x + margin).min(width - 1) {
                    pixels[render.resolution.pixel(column, row).0 as usize] = color;
                }
            }
        }
    }
    Image { resolution: render.resolution, pixels }
}

/// A third of the luminance (ITU-R BT.709 weights).
fn dimmed([red, green, blue]: Rgb) -> Rgb {
    let luminance = 0.2126 * f32::from(red) + 0.7152 * f32::from(green) + 0.0722 * f32::from(blue);
    [(luminance / 3.0).round() as u8; 3]
}

/// Names of the occlusion modes, by their two bits.
pub(crate) const OCCLUSION_MODES: [&str; 4] = ["INIT", "PARTIALLY_OCCLUDED", "FULLY_RENDERED", "DYNAMIC"];

/// Names of the shadow modes, by their two bits.
pub(crate) const SHADOW_MODES: [&str; 4] = ["INIT", "FULL_SHADOW", "NON_SHADOW", "PARTIAL_SHADOW"];

/// Number of lights that a 32-bit word has room for.
pub(crate) const LIGHTS_A_WORD: u32 = 15;

/// The colour of a word's two modes: the occlusion mode gives the hue, the shadow mode the lightness.
pub(crate) fn word_color(occlusion: usize, shadow: usize) -> Rgb {
    // Hues: grey, orange, blue, purple (Okabe and Ito 2008).
    const HUES: [[f32; 3]; 4] = [[150.0; 3], [230.0, 159.0, 0.0], [0.0, 114.0, 178.0], [204.0, 121.0, 167.0]];
    // Share of the hue, and of white, by shadow mode: dark for shadow, light for no shadow, the pure hue for partial
    // shadow.
    const LIGHTNESS: [(f32, f32); 4] = [(0.75, 0.0), (0.4, 0.0), (0.45, 0.55), (1.0, 0.0)];
    let (own, white) = LIGHTNESS[shadow & 3];
    HUES[occlusion & 3].map(|level| (own * level + white * 255.0).round() as u8)
}

/// Colour where a primary ray hits nothing.
pub(crate) const NO_WORD: Rgb = [0x18, 0x18, 0x18];

/// A picture of mode words: each pixel has the colour of the visible primitive's word (`None` where nothing is hit).
/// `place` is the light's place in the word, from 0 to [`LIGHTS_A_WORD`] - 1. A word's bits 1:0 are the occlusion
/// mode; bits 3:2 are the first light's shadow mode.
pub(crate) fn words(resolution: Resolution, words: &[Option<u32>], place: u32) -> Image {
    assert!(place < LIGHTS_A_WORD, "a word has room for {LIGHTS_A_WORD} lights");
    let color = |word: u32| word_color((word & 3) as usize, (word >> (2 + 2 * place) & 3) as usize);
    Image { resolution, pixels: words.iter().map(|word| word.map_or(NO_WORD, color)).collect() }
}

/// Encodes the picture as PNG. Fails if the number of pixels does not match the size.
pub(crate) fn png(image: &Image) -> Result<Vec<u8>, png::EncodingError> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, image.resolution.width, image.resolution.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(image.pixels.as_flattened())?;
    writer.finish()?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    const SIZE: Resolution = Resolution { width: 6, height: 4 };

    #[test]
    fn colours_are_clamped_not_bent() {
        let image = render(Resolution { width: 1, height: 1 }, &[Vec3::new(-1.0, 0.5, 7.0)]);
        assert_eq!(image.pixels, [[0, 128, 255]]);
    }

    #[test]
    fn a_wrong_pixel_is_enlarged_and_a_numeric_one_is_not() {
        let base = render(SIZE, &[Vec3::ONE; 24]);
        let mut verdicts = [PixelVerdict::Same; 24];
        verdicts[0] = PixelVerdict::FalseDark;
        verdicts[4 + 2 * 6] = PixelVerdict::Numeric;
        let image = difference(&base, &verdicts);
        let count = |verdict: PixelVerdict| {
            let color = SHOWN_VERDICTS.iter().find(|shown| shown.0 == verdict).map(|shown| shown.2);
            image.pixels.iter().filter(|&&rgb| Some(rgb) == color).count()
        };
        assert_eq!(count(PixelVerdict::FalseDark), 4);
        assert_eq!(count(PixelVerdict::Numeric), 1);
        assert_eq!(image.pixels.iter().filter(|&&rgb| rgb == [85; 3]).count(), 24 - 5);
    }

    #[test]
    fn every_pair_of_modes_has_a_colour_of_its_own() {
        let colors: BTreeSet<Rgb> = (0..16).map(|modes| word_color(modes / 4, modes % 4)).collect();
        assert_eq!(colors.len(), 16);
        assert!(!colors.contains(&NO_WORD));
        // FULLY_RENDERED; second light FULL_SHADOW.
        let image = words(Resolution { width: 2, height: 1 }, &[Some(0b01_00_10), None], 1);
        assert_eq!(image.pixels, [word_color(2, 1), NO_WORD]);
    }

    #[test]
    fn a_meaning_has_one_colour_in_plots_and_pictures() {
        let is = |color: Color, verdict: PixelVerdict| {
            let of = SHOWN_VERDICTS.iter().find(|(it, ..)| *it == verdict).map(|(.., rgb)| *rgb);
            assert_eq!(of, Some([color.0, color.1, color.2]), "{verdict:?}");
        };
        is(FALSE_DARK, PixelVerdict::FalseDark);
        is(FALSE_LIT, PixelVerdict::FalseLit);
        is(NUMERIC, PixelVerdict::Numeric);
    }

    #[test]
    fn png_files_hold_what_was_put_in() {
        let colors: Vec<Vec3> = (0..24).map(|index| Vec3::splat(index as f32 / 24.0)).collect();
        let image = render(SIZE, &colors);
        let file = png(&image).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&file)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((info.width, info.height), (6, 4));
        assert_eq!(pixels, image.pixels.as_flattened());
        assert!(png(&Image { resolution: SIZE, pixels: vec![[0; 3]; 23] }).is_err());
    }
}
