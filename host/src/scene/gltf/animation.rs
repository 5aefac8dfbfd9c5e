//! Animation clips (glTF 2.0 §3.11): which of them play, and their channels.
//!
//! Without a name all clips play together from time 0, each looping at its own length. Two rules
//! keep that sensible for files whose clips are alternatives (walk, idle, jump):
//! - a channel whose keys are all equal animates nothing: it sets the rest pose;
//! - a clip that would animate a property that an earlier clip animates is left out whole, with a
//!   warning (half of a walk mixed into an idle pose would be neither).

use super::error::{Fault, Warnings, place};
use super::extras;
use super::nodes::{Nodes, unit};
use super::source::Source;
use crate::scene::{Channel, Interpolation, Track};
use glam::{Quat, Vec3};
use gltf::animation::Property;
use gltf::json::{self, validation::Checked};

/// The names of a file's clips; those without one are called by their number.
pub(super) fn names(source: &Source) -> Vec<String> {
    let clips = source.document.as_json().animations.iter().enumerate();
    clips
        .map(|(i, clip)| clip.name.clone().unwrap_or_else(|| i.to_string()))
        .collect()
}

/// Loads the clip `only`, or all that can play together.
pub(super) fn load(
    source: &Source,
    nodes: &mut Nodes,
    only: Option<usize>,
    warnings: &mut Warnings,
) -> Result<Vec<Channel>, Fault> {
    let mut playing: Vec<Channel> = Vec::new();
    let mut owners: Vec<String> = Vec::new();
    let mut posed: Vec<(usize, Kind)> = Vec::new();
    for (index, clip) in source.document.as_json().animations.iter().enumerate() {
        if only.is_some_and(|only| only != index) {
            continue;
        }
        let at = place("animation", index, clip.name.as_deref());
        let channels = load_clip(source, clip, nodes, &at, warnings)?;
        let (moving, still): (Vec<_>, Vec<_>) = channels.into_iter().partition(moves);
        let collision = moving.iter().find_map(|c| {
            playing
                .iter()
                .position(|p| target(p) == target(c))
                .map(|p| (c, p))
        });
        if let Some((channel, with)) = collision {
            warnings.add(
                at,
                format!(
                    "is left out: {} also animates the {:?} of node {:?}; name one clip to play it",
                    owners[with],
                    kind(&channel.track),
                    nodes.nodes[channel.node].name
                ),
            );
            continue;
        }
        for channel in still {
            // As for moving channels, the first clip has its way.
            if !posed.contains(&target(&channel)) {
                posed.push(target(&channel));
                pose(&channel, nodes);
            }
        }
        owners.extend(moving.iter().map(|_| at.clone()));
        playing.extend(moving);
    }
    Ok(playing)
}

/// What a channel animates.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Translation,
    Rotation,
    Scale,
}

fn kind(track: &Track) -> Kind {
    match track {
        Track::Translation(_) => Kind::Translation,
        Track::Rotation(_) => Kind::Rotation,
        Track::Scale(_) => Kind::Scale,
    }
}

fn target(channel: &Channel) -> (usize, Kind) {
    (channel.node, kind(&channel.track))
}

/// Whether a channel's value changes with time.
fn moves(channel: &Channel) -> bool {
    // Keys of a spline come in threes: in-tangent, value, out-tangent.
    let spline = channel.interpolation == Interpolation::CubicSpline;
    fn varies<T: Copy>(
        keys: &[T],
        spline: bool,
        size: impl Fn(T) -> f32,
        diff: impl Fn(T, T) -> f32,
    ) -> bool {
        let first = keys[usize::from(spline)];
        // Exporters leave rounding noise on channels that rest.
        let noise = 1e-6 * (1.0 + size(first));
        keys.iter()
            .enumerate()
            .any(|(i, &key)| match spline && i % 3 != 1 {
                true => size(key) > noise,
                false => diff(key, first) > noise,
            })
    }
    if channel.times.len() < 2 || channel.period <= 0.0 {
        return false;
    }
    match &channel.track {
        Track::Translation(keys) | Track::Scale(keys) => {
            varies(keys, spline, Vec3::length, |a, b| (a - b).length())
        }
        Track::Rotation(keys) => varies(keys, spline, Quat::length, |a, b| (a - b).length()),
    }
}

/// Makes the value of a channel that does not move the rest pose of its node.
fn pose(channel: &Channel, nodes: &mut Nodes) {
    let first = usize::from(channel.interpolation == Interpolation::CubicSpline);
    let node = &mut nodes.nodes[channel.node];
    match &channel.track {
        Track::Translation(keys) => node.translation = keys[first],
        Track::Rotation(keys) => node.rotation = keys[first],
        Track::Scale(keys) => node.scale = keys[first],
    }
}

fn load_clip(
    source: &Source,
    clip: &json::Animation,
    nodes: &Nodes,
    at: &str,
    warnings: &mut Warnings,
) -> Result<Vec<Channel>, Fault> {
    let mut channels: Vec<Channel> = Vec::new();
    for (index, channel) in clip.channels.iter().enumerate() {
        let at = format!("{at}, channel {index}");
        let Some(sampler) = clip.samplers.get(channel.sampler.value()) else {
            return Err(Fault::new(
                at,
                format!("sampler {} does not exist", channel.sampler),
            ));
        };
        let (Checked::Valid(path), Checked::Valid(interpolation)) =
            (channel.target.path, sampler.interpolation)
        else {
            return Err(Fault::new(at, "unknown path or interpolation"));
        };
        if path == Property::MorphTargetWeights {
            warnings.add(at, "morph targets are left at rest");
            continue;
        }
        let accessor = |index: json::Index<json::Accessor>| {
            let found = source.document.accessors().nth(index.value());
            found.ok_or_else(|| Fault::new(&at, format!("accessor {index} does not exist")))
        };
        let times: Vec<f32> = source
            .floats::<1>(&accessor(sampler.input)?, &format!("{at}, input"))?
            .into_iter()
            .map(|[t]| t)
            .collect();
        if times.is_empty() || times[0] < 0.0 || times.windows(2).any(|w| w[0] > w[1]) {
            return Err(Fault::new(at, "key times must be 0 or more and ascend"));
        }
        let interpolation = match interpolation {
            gltf::animation::Interpolation::Step => Interpolation::Step,
            gltf::animation::Interpolation::Linear => Interpolation::Linear,
            gltf::animation::Interpolation::CubicSpline => Interpolation::CubicSpline,
        };
        let spline = interpolation == Interpolation::CubicSpline;
        let expected = if spline { 3 * times.len() } else { times.len() };
        let output = accessor(sampler.output)?;
        if output.count() != expected {
            let reason = format!("{} values for {} keys", output.count(), times.len());
            return Err(Fault::new(
                at,
                format!("{reason}; {interpolation:?} needs {expected}"),
            ));
        }
        let out = format!("{at}, output");
        let vectors = || -> Result<Vec<Vec3>, Fault> {
            Ok(source
                .floats::<3>(&output, &out)?
                .into_iter()
                .map(Vec3::from)
                .collect())
        };
        let track = match path {
            Property::Translation => Track::Translation(vectors()?),
            Property::Scale => Track::Scale(vectors()?),
            _ => {
                let keys = source
                    .floats::<4>(&output, &out)?
                    .into_iter()
                    .map(Quat::from_array);
                // Tangents are not rotations and keep their length.
                let key = |(i, q)| if spline && i % 3 != 1 { q } else { unit(q) };
                Track::Rotation(keys.enumerate().map(key).collect())
            }
        };
        let Some(&node) = nodes.ours.get(channel.target.node.value()) else {
            return Err(Fault::new(
                at,
                format!("node {} does not exist", channel.target.node),
            ));
        };
        let channel = Channel {
            node,
            track,
            times,
            interpolation,
            period: 0.0,
        };
        if channels.iter().any(|c| target(c) == target(&channel)) {
            warnings.add(
                at,
                "animates the same property as a channel before it and is left out",
            );
            continue;
        }
        channels.push(channel);
    }
    let last = channels
        .iter()
        .filter_map(|c| c.times.last().copied())
        .fold(0.0, f32::max);
    let stated = extras::number(&extras::parse(&clip.extras), "period").filter(|p| *p > 0.0);
    for channel in &mut channels {
        channel.period = stated.unwrap_or(last);
    }
    Ok(channels)
}
