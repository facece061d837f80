//! Measures how wrong a picture is: shadow decisions with culling against the same rays without culling, and both
//! against the reference.
//!
//! Three pictures of one frame are compared. `reference` comes from the [reference renderer](crate::reference) in
//! `f64`, `plain` from the tracer in `f32` without culling, `culled` from the tracer with a policy. A decision is the
//! result of a primary hit for a light: not asked, lit or hidden. `plain` and `culled` come from the same rays, so a
//! decision that differs between them is the policy's error, without any rounding. A decision that differs between
//! `plain` and `reference` is due to rounding alone.

use std::ops::AddAssign;

use serde::{Deserialize, Serialize};

use crate::quantity::{LightId, PixelId, Resolution};
use crate::scene::{Picture, ShadowBits};

/// Why pictures cannot be compared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ValidateError {
    /// A picture's size differs from the reference picture's.
    #[error("a picture of {found} cannot be compared with one of {expected}")]
    Size {
        /// The reference picture's size.
        expected: Resolution,
        /// The other's.
        found: Resolution,
    },
    /// The tracer's two pictures do not agree on a primary hit or on the lights asked for, which no policy may change.
    #[error("pixel {pixel}: the picture with culling and the one without are not of the same rays")]
    OtherRays {
        /// The first such pixel.
        pixel: PixelId,
    },
}

/// The verdict on a pixel, for one light or for all, in ascending order of severity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum PixelVerdict {
    /// All three pictures agree.
    #[default]
    Same,
    /// Culling changed nothing, but the tracer and the reference renderer differ.
    Numeric,
    /// Culling lights what is in shadow.
    FalseLit,
    /// Culling darkens what is lit.
    FalseDark,
}

/// Where a frame's pictures differ, pixel by pixel from the top left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VerdictPicture {
    /// Its size.
    pub resolution: Resolution,
    /// For each light, the verdict on each pixel's decision.
    pub lights: Vec<Vec<PixelVerdict>>,
    /// For each pixel the worst verdict over the lights, at least [`PixelVerdict::Numeric`] where the tracer's primary
    /// hit is not the reference renderer's.
    pub all: Vec<PixelVerdict>,
}

/// Counts of decisions, of one light or of several.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DecisionCounts {
    /// Decisions that the tracer asked for.
    pub asked: u64,
    /// Hidden with culling, lit without.
    pub false_dark: u64,
    /// Lit with culling, hidden without.
    pub false_lit: u64,
    /// Decisions of the tracer without culling that differ from the reference renderer's, including those that only
    /// one of the two asked for.
    pub numeric_differences: u64,
}

/// The squared error of one picture against another.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SquaredError {
    /// The sum of squared differences of linear colour values, where 1 is white; brighter values are not clipped.
    pub sum: f64,
    /// The number of values: three per pixel.
    pub values: u64,
}

/// The comparison of a frame's pictures, or of several frames' when added up.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Comparison {
    /// Pixels compared.
    pub pixels: u64,
    /// Pixels where the tracer's primary hit is not the reference renderer's.
    pub hit_differences: u64,
    /// The counts of each light.
    pub lights: Vec<DecisionCounts>,
    /// The error of the picture with culling against the reference picture.
    pub against_reference: SquaredError,
    /// The error of the picture with culling against the one without.
    pub against_plain: SquaredError,
}

impl SquaredError {
    fn of(picture: &Picture, truth: &Picture) -> Self {
        let pairs = picture.rgb.iter().zip(&truth.rgb);
        let sum = pairs.map(|(ours, theirs)| (ours.as_dvec3() - theirs.as_dvec3()).length_squared()).sum();
        Self { sum, values: 3 * truth.rgb.len() as u64 }
    }

    /// The peak signal-to-noise ratio in decibels, 10 log10(1 / mean squared error); `None` where there is no error.
    pub fn psnr(&self) -> Option<f64> {
        (self.sum != 0.0).then(|| 10.0 * (self.values as f64 / self.sum).log10())
    }
}

impl Comparison {
    /// The counts over all lights.
    pub fn all_lights(&self) -> DecisionCounts {
        self.lights.iter().fold(DecisionCounts::default(), |mut all, light| {
            all += *light;
            all
        })
    }
}

impl AddAssign for DecisionCounts {
    fn add_assign(&mut self, other: Self) {
        self.asked += other.asked;
        self.false_dark += other.false_dark;
        self.false_lit += other.false_lit;
        self.numeric_differences += other.numeric_differences;
    }
}

impl AddAssign for SquaredError {
    fn add_assign(&mut self, other: Self) {
        self.sum += other.sum;
        self.values += other.values;
    }
}

impl AddAssign<&Comparison> for Comparison {
    /// Adds another frame's comparison; the empty one is neutral.
    fn add_assign(&mut self, other: &Self) {
        self.pixels += other.pixels;
        self.hit_differences += other.hit_differences;
        self.lights.resize(self.lights.len().max(other.lights.len()), DecisionCounts::default());
        for (light, other) in self.lights.iter_mut().zip(&other.lights) {
            *light += *other;
        }
        self.against_reference += other.against_reference;
        self.against_plain += other.against_plain;
    }
}

/// What a primary hit finds for a light.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Decision {
    NotAsked,
    Lit,
    Dark,
}

impl Decision {
    fn of(bits: ShadowBits, light: LightId) -> Self {
        let has = |bits: u64| bits >> light.0 & 1 == 1;
        match (has(bits.asked), has(bits.dark)) {
            (false, _) => Self::NotAsked,
            (true, false) => Self::Lit,
            (true, true) => Self::Dark,
        }
    }
}

/// Compares the three pictures of a frame of a scene with `lights` lights.
///
/// # Errors
/// The pictures differ in size, or culling changed which rays were traced or which lights were asked for.
pub fn compare(
    reference: &Picture,
    plain: &Picture,
    culled: &Picture,
    lights: usize,
) -> Result<(Comparison, VerdictPicture), ValidateError> {
    let resolution = reference.resolution;
    if let Some(other) = [plain, culled].iter().find(|other| other.resolution != resolution) {
        return Err(ValidateError::Size { expected: resolution, found: other.resolution });
    }
    let same_rays = |pixel: usize| {
        plain.hits[pixel] == culled.hits[pixel] && plain.shadows[pixel].asked == culled.shadows[pixel].asked
    };
    if let Some(pixel) = (0..resolution.pixels()).find(|pixel| !same_rays(*pixel)) {
        return Err(ValidateError::OtherRays { pixel: PixelId(pixel as u32) });
    }

    let hit_differs: Vec<bool> = reference.hits.iter().zip(&plain.hits).map(|(ours, theirs)| ours != theirs).collect();
    let mut all: Vec<_> =
        hit_differs.iter().map(|differs| if *differs { PixelVerdict::Numeric } else { PixelVerdict::Same }).collect();
    let mut comparison = Comparison {
        pixels: resolution.pixels() as u64,
        hit_differences: hit_differs.iter().filter(|differs| **differs).count() as u64,
        lights: Vec::new(),
        against_reference: SquaredError::of(culled, reference),
        against_plain: SquaredError::of(culled, plain),
    };
    let mut pictures = Vec::new();
    for light in (0..lights).map(|light| LightId(light as u8)) {
        let mut counts = DecisionCounts::default();
        let mut verdicts = Vec::with_capacity(resolution.pixels());
        for (pixel, worst) in all.iter_mut().enumerate() {
            let [truth, without, with] =
                [reference, plain, culled].map(|picture| Decision::of(picture.shadows[pixel], light));
            counts.asked += u64::from(without != Decision::NotAsked);
            counts.numeric_differences += u64::from(without != truth);
            let verdict = match (without, with) {
                (Decision::Lit, Decision::Dark) => PixelVerdict::FalseDark,
                (Decision::Dark, Decision::Lit) => PixelVerdict::FalseLit,
                _ if without != truth => PixelVerdict::Numeric,
                _ => PixelVerdict::Same,
            };
            counts.false_dark += u64::from(verdict == PixelVerdict::FalseDark);
            counts.false_lit += u64::from(verdict == PixelVerdict::FalseLit);
            *worst = verdict.max(*worst);
            verdicts.push(verdict);
        }
        comparison.lights.push(counts);
        pictures.push(verdicts);
    }
    Ok((comparison, VerdictPicture { resolution, lights: pictures, all }))
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::quantity::PrimitiveId;

    /// A row of pixels that all hit primitive 0, from their (asked, dark) bits.
    fn picture(bits: &[(u64, u64)]) -> Picture {
        Picture {
            resolution: Resolution { width: bits.len() as u32, height: 1 },
            rgb: vec![Vec3::splat(0.5); bits.len()],
            hits: vec![Some(PrimitiveId(0)); bits.len()],
            shadows: bits.iter().map(|&(asked, dark)| ShadowBits { asked, dark }).collect(),
        }
    }

    #[test]
    fn counts_by_hand() {
        use PixelVerdict::*;
        // Pixels: agreement; light 0 false dark; light 1 false lit; both; at light 0 `plain` has an error that culling
        // undoes, which still counts as false; light 1 asked by the tracer alone; another hit.
        let mut reference = picture(&[(3, 1), (3, 0), (3, 2), (3, 2), (3, 0), (1, 0), (0, 0)]);
        let plain = picture(&[(3, 1), (3, 0), (3, 2), (3, 2), (3, 1), (3, 0), (0, 0)]);
        let culled = picture(&[(3, 1), (3, 1), (3, 0), (3, 1), (3, 0), (3, 0), (0, 0)]);
        reference.hits[6] = None;
        let (comparison, verdicts) = compare(&reference, &plain, &culled, 2).expect("comparable");
        let light = |false_dark, false_lit, numeric_differences| DecisionCounts {
            asked: 6,
            false_dark,
            false_lit,
            numeric_differences,
        };
        assert_eq!(comparison.lights, [light(2, 1, 1), light(0, 2, 1)]);
        assert_eq!(comparison.all_lights(), DecisionCounts { asked: 12, ..light(2, 3, 2) });
        assert_eq!((comparison.pixels, comparison.hit_differences), (7, 1));
        assert_eq!(verdicts.lights[0], [Same, FalseDark, Same, FalseDark, FalseLit, Same, Same]);
        assert_eq!(verdicts.lights[1], [Same, Same, FalseLit, FalseLit, Same, Numeric, Same]);
        assert_eq!(verdicts.all, [Same, FalseDark, FalseLit, FalseDark, FalseLit, Numeric, Numeric]);
    }

    #[test]
    fn the_64th_light_counts() {
        let bit = 1 << 63;
        let (lit, dark) = (picture(&[(bit, 0)]), picture(&[(bit, bit)]));
        let (comparison, _) = compare(&lit, &lit, &dark, 64).expect("comparable");
        assert_eq!(comparison.lights[63].false_dark, 1);
        assert_eq!(comparison.all_lights().asked, 1);
    }

    #[test]
    fn psnr_of_a_uniform_difference() {
        let reference = picture(&[(0, 0); 10]);
        for difference in [0.5f32, 0.125, 2.0] {
            let mut culled = reference.clone();
            culled.rgb.iter_mut().for_each(|color| *color += Vec3::splat(difference));
            let (comparison, _) = compare(&reference, &reference, &culled, 0).expect("comparable");
            let expected = -20.0 * f64::from(difference).log10();
            for error in [comparison.against_reference, comparison.against_plain] {
                let psnr = error.psnr().expect("they differ");
                assert!((psnr - expected).abs() < 1e-12, "{psnr} {expected}");
            }
        }
        let (same, verdicts) = compare(&reference, &reference, &reference, 0).expect("comparable");
        assert_eq!((same.against_reference.psnr(), same.against_plain.psnr()), (None, None));
        assert!(verdicts.all.iter().all(|verdict| *verdict == PixelVerdict::Same));
    }

    #[test]
    fn psnr_tells_reference_from_plain() {
        let reference = picture(&[(0, 0); 4]);
        let mut plain = reference.clone();
        plain.rgb[0].x += 0.25;
        let (comparison, _) = compare(&reference, &plain, &plain, 0).expect("comparable");
        assert_eq!(comparison.against_reference, SquaredError { sum: 0.0625, values: 12 });
        assert_eq!(comparison.against_plain.psnr(), None);
    }

    #[test]
    fn frames_add_up() {
        let reference = picture(&[(1, 0), (1, 1)]);
        let culled = picture(&[(1, 1), (1, 1)]);
        let (frame, _) = compare(&reference, &reference, &culled, 1).expect("comparable");
        let mut sum = Comparison::default();
        sum += &frame;
        assert_eq!(sum, frame);
        sum += &frame;
        assert_eq!((sum.pixels, sum.all_lights().asked, sum.all_lights().false_dark), (4, 4, 2));
        assert_eq!(sum.against_plain.values, 12);
        let text = serde_json::to_string(&sum).expect("a plain structure");
        assert_eq!(serde_json::from_str::<Comparison>(&text).expect("as written"), sum);
    }

    #[test]
    fn refuses_what_cannot_be_compared() {
        let one = picture(&[(1, 0)]);
        let two = picture(&[(1, 0), (1, 0)]);
        let found = two.resolution;
        assert_eq!(compare(&one, &one, &two, 1), Err(ValidateError::Size { expected: one.resolution, found }));
        let mut other_hit = two.clone();
        other_hit.hits[1] = None;
        let other_lights = picture(&[(1, 0), (0, 0)]);
        for culled in [other_hit, other_lights] {
            assert_eq!(compare(&two, &two, &culled, 1), Err(ValidateError::OtherRays { pixel: PixelId(1) }));
        }
    }
}
