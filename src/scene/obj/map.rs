//! Options of the statement `map_Kd`.
//!
//! Source: Wavefront Technologies, "MTL material format (Lightwave, OBJ)", section "Material texture map".

use glam::Vec2;

use crate::scene::limits::COORDINATE;
use crate::scene::text::{number, shortened};

/// Maps a face's texture coordinates to the picture's: `-s` scales, then `-o` moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct UvMap {
    scale: Vec2,
    offset: Vec2,
}

impl Default for UvMap {
    fn default() -> Self {
        Self { scale: Vec2::ONE, offset: Vec2::ZERO }
    }
}

impl UvMap {
    /// The picture's coordinates.
    pub(crate) fn apply(self, uv: Vec2) -> Vec2 {
        if self == Self::default() { uv } else { self.scale * uv + self.offset }
    }
}

/// Takes the options from the front of `text`; what is left is the name of the file.
///
/// # Errors
/// An unknown option, an option with an unsupported effect on the picture, options without a name.
pub(super) fn options(text: &str) -> Result<(UvMap, &str), String> {
    let (mut map, mut rest) = (UvMap::default(), text);
    while rest.starts_with('-') {
        let (option, after) = first_word(rest);
        rest = match option {
            "-s" | "-o" | "-t" => {
                let base = if option == "-s" { 1.0 } else { 0.0 };
                let (numbers, after) = up_to_three(after, base)?;
                match option {
                    "-s" => map.scale = numbers,
                    "-o" => map.offset = numbers,
                    _ if numbers != Vec2::ZERO => {
                        return Err("`-t` of other than 0 is not allowed: it is not read".into());
                    }
                    _ => {}
                }
                after
            }
            // Filtering and colour correction do not change the texel of a point.
            "-blendu" | "-blendv" | "-cc" => switch(option, after, true)?,
            "-clamp" => switch(option, after, false)?,
            "-texres" => {
                let (value, after) = first_word(after);
                number(value)?;
                after
            }
            "-mm" => {
                let (base, after) = first_word(after);
                let (gain, after) = first_word(after);
                if number(base)? != 0.0 || number(gain)? != 1.0 {
                    return Err(format!("`-mm {base} {gain}` is not allowed: 0 1 is"));
                }
                after
            }
            _ => {
                return Err(format!(
                    "`{}` is no option of map_Kd: -s, -o, -t, -mm, -blendu, -blendv, -cc, -clamp and -texres are",
                    shortened(option)
                ));
            }
        };
    }
    if rest.is_empty() { Err("`map_Kd` needs the name of a picture".into()) } else { Ok((map, rest)) }
}

fn first_word(text: &str) -> (&str, &str) {
    let (word, rest) = text.split_once(|letter: char| letter.is_ascii_whitespace()).unwrap_or((text, ""));
    (word, rest.trim_ascii_start())
}

/// The rest after `on` or `off`. An option that would change the picture can be `off` only.
fn switch<'a>(option: &str, text: &'a str, on_allowed: bool) -> Result<&'a str, String> {
    match first_word(text) {
        ("off", rest) => Ok(rest),
        ("on", rest) if on_allowed => Ok(rest),
        (word, _) => {
            let allowed = if on_allowed { "on or off" } else { "off" };
            Err(format!("`{option} {}` is not allowed: {allowed} is", shortened(word)))
        }
    }
}

/// The first two of one to three numbers; missing numbers are `base`.
fn up_to_three(text: &str, base: f32) -> Result<(Vec2, &str), String> {
    let (mut numbers, mut rest) = ([base; 3], text);
    for (index, place) in numbers.iter_mut().enumerate() {
        let (word, after) = first_word(rest);
        match number(word) {
            Ok(number) => {
                COORDINATE.check("a number of an option", number.into())?;
                *place = number;
                rest = after;
            }
            Err(error) if index == 0 => return Err(error),
            Err(_) => break,
        }
    }
    Ok((Vec2::new(numbers[0], numbers[1]), rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_stand_before_the_name() {
        let plain = UvMap::default();
        assert_eq!(options("a b.png"), Ok((plain, "a b.png")));
        assert_eq!(options("-s 1 1 1 -o 0 -blendu off -mm 0 1 -texres 256 a.png"), Ok((plain, "a.png")));
        let (map, name) = options("-s 2 3\t-o 0.5 a.png").unwrap();
        assert_eq!((map.apply(Vec2::ONE), name), (Vec2::new(2.5, 3.0), "a.png"));
        assert_eq!(options("-s 2 a.png").unwrap().0.apply(Vec2::ONE), Vec2::new(2.0, 1.0));
    }

    #[test]
    fn what_is_not_read_is_refused() {
        let error = |text| options(text).unwrap_err();
        assert!(error("-q 1 a.png").starts_with("`-q` is no option of map_Kd"));
        assert!(error("-clamp on a.png").contains("off is"));
        assert!(error("-mm 0 2 a.png").contains("0 1 is"));
        assert!(error("-t 1 a.png").contains("not read"));
        assert!(error("-s a.png").contains("not a finite number"));
        assert!(error("-s 1 1 1").contains("needs the name"));
        assert!(error("").contains("needs the name"));
    }
}
