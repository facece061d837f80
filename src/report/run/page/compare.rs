//! Reference and policy side by side, with wrong pixels outlined.
//!
//! A policy's picture consists of the reference and, on top, the pixels that differ: this keeps the page small.

use std::io::Cursor;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use minijinja::{Value, context};

use super::tables::psnr;
use crate::report::draw::palette::{Color, FALSE_DARK, FALSE_LIT, NUMERIC, css};
use crate::report::format::{counted, exact};
use crate::report::run::files::PngPicture;
use crate::report::run::pictures::{PictureKind, Rgb};
use crate::report::run::summary::Summary;

/// The outlined kinds of wrong pixels, with their colours.
const OUTLINED: [(&str, Color); 3] =
    [("numeric difference", NUMERIC), ("false lit", FALSE_LIT), ("false dark", FALSE_DARK)];

/// The key of outlines.
pub(super) fn key() -> Vec<(String, Color)> {
    OUTLINED.map(|(name, color)| (name.to_owned(), color)).into()
}

struct Pixels {
    width: usize,
    height: usize,
    rgb: Vec<Rgb>,
}

/// A PNG file's pixels; `None` if the file has another format than the program's: red, green and blue of 8 bits each.
fn pixels(png: &[u8]) -> Option<Pixels> {
    let mut reader = png::Decoder::new(Cursor::new(png)).read_info().ok()?;
    let mut bytes = vec![0; reader.output_buffer_size()?];
    let info = reader.next_frame(&mut bytes).ok()?;
    let is_ours = (info.color_type, info.bit_depth) == (png::ColorType::Rgb, png::BitDepth::Eight);
    let rgb = bytes.as_chunks::<3>().0.to_vec();
    is_ours.then_some(Pixels { width: info.width as usize, height: info.height as usize, rgb })
}

/// `image` where it differs from `base`, and transparent elsewhere, as a PNG file.
fn overlay(base: &Pixels, image: &Pixels) -> Option<Vec<u8>> {
    let pixel = |(a, b): (&Rgb, &Rgb)| if a == b { [0; 4] } else { [b[0], b[1], b[2], 255] };
    let rgba: Vec<[u8; 4]> = base.rgb.iter().zip(&image.rgb).map(pixel).collect();
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, base.width as u32, base.height as u32);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    let mut writer = encoder.write_header().ok()?;
    writer.write_image_data(rgba.as_flattened()).ok()?;
    writer.finish().ok()?;
    Some(file)
}

/// The outline of all pixels of a colour, as an SVG path; consecutive sides of pixels are joined.
fn outline(image: &Pixels, color: Color) -> String {
    let wanted = [color.0, color.1, color.2];
    let is = |x: usize, y: usize| x < image.width && y < image.height && image.rgb[y * image.width + x] == wanted;
    // Whether there is a side between a pixel and its predecessor; index 0 has no predecessor.
    let above = |x: usize, y: usize| is(x, y) != (y > 0 && is(x, y - 1));
    let before = |x: usize, y: usize| is(x, y) != (x > 0 && is(x - 1, y));
    let mut path = String::new();
    let mut sides = |outer: usize, inner: usize, side: &dyn Fn(usize, usize) -> bool, horizontal: bool| {
        for line in 0..=outer {
            let mut at = 0;
            while at <= inner {
                let length = (at..=inner).take_while(|&at| side(at, line)).count();
                if length > 0 {
                    path += &match horizontal {
                        true => format!("M{at} {line}h{length}"),
                        false => format!("M{line} {at}v{length}"),
                    };
                }
                at += length.max(1);
            }
        }
    };
    sides(image.height, image.width, &above, true);
    sides(image.width, image.height, &|y, x| before(x, y), false);
    path
}

fn data(png: &[u8]) -> String {
    STANDARD.encode(png)
}

fn find<'a>(
    pictures: &'a [PngPicture],
    frame: u32,
    kind: PictureKind,
    policy: Option<&str>,
) -> Option<&'a (crate::report::run::pictures::PictureInfo, Vec<u8>)> {
    pictures.iter().find(|(it, _)| it.frame == frame && it.kind == kind && it.policy.as_deref() == policy)
}

/// References of all frames with pictures, and a comparison per frame and policy; frames with the most wrong
/// decisions come first.
pub(super) fn comparisons(summary: &Summary, pictures: &[PngPicture]) -> (Vec<Value>, Vec<Value>) {
    let mut frames: Vec<u32> = Vec::new();
    for (info, _) in pictures {
        if !frames.contains(&info.frame) {
            frames.push(info.frame);
        }
    }
    frames.sort_by_key(|&frame| std::cmp::Reverse(wrong_in(summary, frame)));
    let (mut references, mut all) = (Vec::new(), Vec::new());
    for frame in frames {
        let Some((_, png)) = find(pictures, frame, PictureKind::Reference, None) else { continue };
        let Some(base) = pixels(png) else { continue };
        references.push(context! { frame, width => base.width, height => base.height, data => data(png) });
        let mut policies: Vec<&str> = summary.policies.iter().map(|(name, _)| name).collect();
        policies.sort_by_key(|&name| summary.baseline.as_deref() == Some(name));
        all.extend(policies.iter().filter_map(|policy| comparison(summary, pictures, (frame, &base), policy)));
    }
    (references, all)
}

/// The frame to look at first: the one with the most wrong decisions among those with pictures, or among all.
pub(super) fn worst_frame(summary: &Summary) -> Option<u32> {
    let of_pictures = summary.pictures.iter().map(|picture| picture.frame);
    let worst = of_pictures.max_by_key(|&frame| wrong_in(summary, frame));
    worst.or_else(|| summary.frames.iter().copied().max_by_key(|&frame| wrong_in(summary, frame)))
}

fn wrong_in(summary: &Summary, number: u32) -> u64 {
    let frames = summary.policies.iter().flat_map(|(_, policy)| &policy.frames);
    frames.filter(|frame| frame.frame == number).filter_map(|frame| frame.counts.wrong()).sum()
}

fn comparison(
    summary: &Summary,
    pictures: &[PngPicture],
    (frame, base): (u32, &Pixels),
    policy: &str,
) -> Option<Value> {
    let (_, render) = find(pictures, frame, PictureKind::Render, Some(policy))?;
    let render = pixels(render).filter(|render| render.rgb.len() == base.rgb.len())?;
    let difference = find(pictures, frame, PictureKind::Difference { light: None }, Some(policy));
    let difference = difference.and_then(|(_, png)| pixels(png));
    let outlines: Vec<Value> = difference
        .iter()
        .flat_map(|image| OUTLINED.map(|(_, color)| context! { color => css(color), path => outline(image, color) }))
        .collect();
    let numbers = summary.policies.get(policy)?.frames.iter().find(|it| it.frame == frame);
    let mut text = Vec::new();
    if let Some(it) = numbers {
        match (it.counts.false_dark, it.counts.false_lit) {
            (Some(0), Some(0)) => text.push("no wrong shadow".to_owned()),
            (Some(dark), Some(lit)) => {
                text.push(format!("{} false dark and {} false lit shadow rays", exact(dark), exact(lit)));
            }
            _ => {}
        }
        text.extend(it.counts.numeric_differences.map(|it| counted(it as usize, "numeric difference")));
        text.extend(it.psnr.map(|ratio| format!("PSNR {}", psnr(ratio))));
    }
    Some(context! {
        frame, policy, outlines, width => base.width, height => base.height,
        overlay => data(&overlay(base, &render)?), text => text.join(", "),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_outlined_by_their_sides() {
        let [red, black] = [[FALSE_DARK.0, FALSE_DARK.1, FALSE_DARK.2], [0; 3]];
        let image = Pixels { width: 3, height: 2, rgb: vec![red, red, black, black, black, black] };
        assert_eq!(outline(&image, FALSE_DARK), "M0 0h2M0 1h2M0 0v1M2 0v1");
        assert_eq!(outline(&image, FALSE_LIT), "");
    }

    #[test]
    fn only_what_differs_lies_over_the_reference() {
        let of = |rgb: Vec<Rgb>| Pixels { width: 2, height: 1, rgb };
        let file = overlay(&of(vec![[9; 3], [8; 3]]), &of(vec![[9; 3], [7; 3]])).unwrap();
        let mut reader = png::Decoder::new(Cursor::new(&file)).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut bytes).unwrap();
        assert_eq!(bytes, [0, 0, 0, 0, 7, 7, 7, 255]);
    }
}
