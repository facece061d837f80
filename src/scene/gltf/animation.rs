//! Animations: tracks of translation, rotation and scale (section "Animations", appendix "Animation Sampler
//! Interpolation Modes").

use glam::{DQuat, DVec3, DVec4};
use gltf_json::Root;
use gltf_json::animation::{Channel, Interpolation, Property};
use gltf_json::validation::Checked;

use super::accessor::Elements;
use super::buffers::Buffers;
use super::document::name;
use crate::scene::limits::COORDINATE;

/// The tracks of a node; a property without a track does not change.
#[derive(Debug, Default)]
pub(super) struct Motion {
    /// Where it is.
    pub translation: Option<Vectors>,
    /// How it is turned.
    pub rotation: Option<Rotations>,
    /// How large it is.
    pub scale: Option<Vectors>,
}

impl Motion {
    /// Whether there is a track.
    pub(super) fn is_there(&self) -> bool {
        self.translation.is_some() || self.rotation.is_some() || self.scale.is_some()
    }

    /// Whether a track changes its value: a track with the same value at every key holds the node in one pose.
    pub(super) fn moves(&self) -> bool {
        let vectors = [&self.translation, &self.scale].into_iter().flatten().any(|track| track.0.moves());
        vectors || self.rotation.as_ref().is_some_and(|track| track.0.moves())
    }
}

/// Keys; the value is constant before the first one and after the last.
#[derive(Debug)]
struct Track<V> {
    /// Times in seconds, ascending, at least one.
    times: Vec<f64>,
    interpolation: Interpolation,
    /// One value per key; three for a cubic spline: incoming tangent, value, outgoing tangent.
    values: Vec<V>,
}

/// A time's place among keys.
enum Place<V> {
    /// At a key's value.
    On(V),
    /// Between two values, with the share of the way.
    Between(V, V, f64),
    /// Between two keys of a cubic spline: value, tangent, tangent, value, each already weighted.
    Cubic([(V, f64); 4]),
}

impl<V: Copy + PartialEq + Default> Track<V> {
    /// Whether the value changes with time.
    fn moves(&self) -> bool {
        match self.interpolation {
            // The value is constant if all values are equal and all inner tangents zero; the first incoming and the
            // last outgoing tangent have no effect.
            Interpolation::CubicSpline => {
                let values = self.values.chunks_exact(3);
                let tangents = self.values.iter().enumerate().filter(|(at, _)| at % 3 != 1);
                let inner = tangents.skip(1).take(self.values.len() / 3 * 2 - 2);
                let straight = inner.map(|(_, tangent)| *tangent).all(|tangent| tangent == V::default());
                !straight || values.map(|key| key[1]).any(|value| value != self.values[1])
            }
            _ => self.values.iter().any(|value| *value != self.values[0]),
        }
    }

    fn place(&self, time: f64) -> Place<V> {
        let (step, middle) = if self.interpolation == Interpolation::CubicSpline { (3, 1) } else { (1, 0) };
        let value = |key: usize| self.values[step * key + middle];
        let next = self.times.partition_point(|key| *key <= time);
        let Some(from) = next.checked_sub(1) else { return Place::On(value(0)) };
        if next == self.times.len() {
            return Place::On(value(from));
        }
        let length = self.times[next] - self.times[from];
        let share = (time - self.times[from]) / length;
        match self.interpolation {
            Interpolation::Step => Place::On(value(from)),
            Interpolation::Linear => Place::Between(value(from), value(next), share),
            Interpolation::CubicSpline => {
                let (t, t2) = (share, share * share);
                let t3 = t2 * t;
                Place::Cubic([
                    (value(from), 2.0 * t3 - 3.0 * t2 + 1.0),
                    (self.values[3 * from + 2], length * (t3 - 2.0 * t2 + t)),
                    (value(next), -2.0 * t3 + 3.0 * t2),
                    (self.values[3 * next], length * (t3 - t2)),
                ])
            }
        }
    }
}

/// A track of positions or scales.
#[derive(Debug)]
pub(super) struct Vectors(Track<DVec3>);

impl Vectors {
    /// The value at a time in seconds.
    pub(super) fn at(&self, time: f64) -> DVec3 {
        match self.0.place(time) {
            Place::On(value) => value,
            Place::Between(from, to, share) => from + (to - from) * share,
            Place::Cubic(parts) => parts.into_iter().map(|(value, weight)| value * weight).sum(),
        }
    }
}

/// A track of rotations.
#[derive(Debug)]
pub(super) struct Rotations(Track<DVec4>);

impl Rotations {
    /// The value at a time in seconds.
    pub(super) fn at(&self, time: f64) -> DQuat {
        match self.0.place(time) {
            Place::On(value) => DQuat::from_vec4(value).normalize(),
            // The shorter way, as the specification requires.
            Place::Between(from, to, share) => {
                DQuat::from_vec4(from).normalize().slerp(DQuat::from_vec4(to).normalize(), share)
            }
            Place::Cubic(parts) => {
                let sum: DVec4 = parts.into_iter().map(|(value, weight)| value * weight).sum();
                // Tangents can cancel the values: then the rotation is undefined.
                if sum.length() > 1e-9 { DQuat::from_vec4(sum.normalize()) } else { DQuat::IDENTITY }
            }
        }
    }
}

/// The motions of all nodes by number, from the animation called `wanted` or from the only one.
///
/// # Errors
/// No animation of that name, several and no name, weights of morph targets, two channels of one node and property,
/// keys that do not rise or are out of range.
pub(super) fn read(root: &Root, buffers: &Buffers, wanted: Option<&str>) -> Result<Vec<Motion>, String> {
    let mut motions: Vec<Motion> = root.nodes.iter().map(|_| Motion::default()).collect();
    let names =
        || root.animations.iter().map(|animation| format!("{:?}", animation.name.as_deref().unwrap_or_default()));
    let list = || names().collect::<Vec<_>>().join(", ");
    let animation = match (wanted, &root.animations[..]) {
        (Some(name), all) => {
            let found = all.iter().find(|animation| animation.name.as_deref() == Some(name));
            found.ok_or_else(|| format!("no animation is named {name:?}: there are [{}]", list()))?
        }
        (None, []) => return Ok(motions),
        (None, [only]) => only,
        (None, _) => return Err(format!("it has several animations: `animation` must name one of {}", list())),
    };
    for channel in &animation.channels {
        let index = channel.target.node.value();
        let place = || format!("the animation of node {}", name(root, index));
        let motion = motions.get_mut(index).ok_or_else(|| format!("{}: it is not there", place()))?;
        read_channel(root, buffers, animation, channel, motion).map_err(|what| format!("{}: {what}", place()))?;
    }
    Ok(motions)
}

fn read_channel(
    root: &Root,
    buffers: &Buffers,
    animation: &gltf_json::Animation,
    channel: &Channel,
    motion: &mut Motion,
) -> Result<(), String> {
    let Checked::Valid(property) = channel.target.path else { return Err("its property is not known".into()) };
    let sampler = animation.samplers.get(channel.sampler.value()).ok_or("its sampler is not there")?;
    let Checked::Valid(interpolation) = sampler.interpolation else {
        return Err("its interpolation is not known".into());
    };
    let times = Elements::<1>::new(root, buffers, sampler.input.value(), "times")?;
    let times: Vec<f64> = times.iter().map(|[time]| time).collect();
    let good =
        times.iter().all(|time| COORDINATE.check("", *time).is_ok()) && times.is_sorted_by(|one, next| one < next);
    if times.is_empty() || !good {
        return Err("its times must rise, from one key on".into());
    }
    let output = sampler.output.value();
    let vectors = |times: Vec<f64>| -> Result<Vectors, String> {
        let values = Elements::<3>::new(root, buffers, output, "values")?;
        let values = values.iter().map(|value| COORDINATE.check_vector("a value", DVec3::from_array(value)));
        track(times, interpolation, values.collect::<Result<_, _>>()?).map(Vectors)
    };
    let twice = |there: bool| if there { Err("two channels move one property".to_owned()) } else { Ok(()) };
    match property {
        Property::Translation => {
            twice(motion.translation.is_some())?;
            motion.translation = Some(vectors(times)?);
        }
        Property::Scale => {
            twice(motion.scale.is_some())?;
            motion.scale = Some(vectors(times)?);
        }
        Property::Rotation => {
            twice(motion.rotation.is_some())?;
            let values = Elements::<4>::new(root, buffers, output, "values")?;
            let tangents = interpolation == Interpolation::CubicSpline;
            let values = values.iter().enumerate().map(|(at, value)| {
                // Tangents need not be of unit length.
                if tangents && at % 3 != 1 {
                    value.into_iter().try_for_each(|number| COORDINATE.check("a tangent", number).map(|_| ()))?;
                } else {
                    unit(value)?;
                }
                Ok(DVec4::from_array(value))
            });
            motion.rotation = Some(Rotations(track(times, interpolation, values.collect::<Result<_, String>>()?)?));
        }
        Property::MorphTargetWeights => return Err("morph targets are not read".into()),
    }
    Ok(())
}

fn track<V>(times: Vec<f64>, interpolation: Interpolation, values: Vec<V>) -> Result<Track<V>, String> {
    let each = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    if values.len() == each * times.len() {
        Ok(Track { times, interpolation, values })
    } else {
        Err(format!("{} keys and {} values: {each} for each key are needed", times.len(), values.len()))
    }
}

/// A rotation of four numbers, whose length is about 1: files hold rounded numbers.
pub(super) fn unit(numbers: [f64; 4]) -> Result<DQuat, String> {
    let rotation = DQuat::from_array(numbers);
    if (rotation.length() - 1.0).abs() < 0.01 {
        Ok(rotation.normalize())
    } else {
        Err(format!("a rotation of {numbers:?} is not allowed: a quaternion of length 1 is"))
    }
}
