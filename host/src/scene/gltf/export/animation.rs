//! Keyframes.

use super::Writer;
use crate::scene::{Channel, Interpolation, Track};
use glam::{Quat, Vec3};
use serde_json::{Value, json};

impl Writer {
    /// One clip for each period.
    pub(super) fn animations(&mut self, channels: &[Channel]) -> Vec<Value> {
        let mut periods: Vec<f32> = Vec::new();
        for channel in channels {
            if !periods.contains(&channel.period) {
                periods.push(channel.period);
            }
        }
        periods
            .into_iter()
            .enumerate()
            .map(|(i, period)| {
                let mut samplers = Vec::new();
                let mut targets = Vec::new();
                for channel in channels.iter().filter(|c| c.period == period) {
                    let (path, interpolation, sampler) = self.sampler(channel);
                    targets.push(json!({
                        "sampler": samplers.len(),
                        "target": { "node": channel.node, "path": path },
                    }));
                    samplers.push(json!({
                        "input": sampler[0], "output": sampler[1], "interpolation": interpolation,
                    }));
                }
                json!({
                    "name": format!("loop {i}"), "channels": targets, "samplers": samplers,
                    "extras": { "period": period },
                })
            })
            .collect()
    }

    fn sampler(&mut self, channel: &Channel) -> (&'static str, &'static str, [Value; 2]) {
        let spline = channel.interpolation == Interpolation::CubicSpline;
        let mut times = channel.times.clone();
        // Other programs loop a clip at its last key: hold the last value until the period ends.
        let pad = times.last().is_some_and(|&last| last < channel.period);
        if pad {
            times.push(channel.period);
        }
        let input = self.buffer.floats(&times, "SCALAR", true);
        let (path, kind, values) = match &channel.track {
            Track::Translation(keys) => {
                ("translation", "VEC3", held(keys, pad, spline, Vec3::ZERO))
            }
            Track::Scale(keys) => ("scale", "VEC3", held(keys, pad, spline, Vec3::ZERO)),
            Track::Rotation(keys) => {
                let zero = Quat::from_array([0.0; 4]);
                let keys = held(keys, pad, spline, zero);
                let flat: Vec<f32> = keys.iter().flat_map(|q| q.to_array()).collect();
                let output = self.buffer.floats(&flat, "VEC4", false);
                return ("rotation", interpolation(channel), [input, output]);
            }
        };
        let flat: Vec<f32> = values.iter().flat_map(|v| v.to_array()).collect();
        let output = self.buffer.floats(&flat, kind, false);
        (path, interpolation(channel), [input, output])
    }
}

fn interpolation(channel: &Channel) -> &'static str {
    match channel.interpolation {
        Interpolation::Step => "STEP",
        Interpolation::Linear => "LINEAR",
        Interpolation::CubicSpline => "CUBICSPLINE",
    }
}

/// The keys, with the last value once more if `pad`. A spline's tangents between the last two
/// keys become zero, so that it rests there.
fn held<T: Copy>(keys: &[T], pad: bool, spline: bool, zero: T) -> Vec<T> {
    let mut keys = keys.to_vec();
    if !pad || keys.is_empty() {
        return keys;
    }
    if spline {
        let last = keys.len() - 1;
        let value = keys[last - 1];
        keys[last] = zero;
        keys.extend([zero, value, zero]);
    } else {
        keys.push(keys[keys.len() - 1]);
    }
    keys
}
