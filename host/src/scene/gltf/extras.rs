//! What a file tells us in `extras` (glTF 2.0 §3.4: application-specific data).

use super::error::Fault;
use crate::scene::{Medium, Sky};
use glam::Vec3;
use gltf::json::Extras;
use serde_json::Value;

/// Parses an `extras` property; absent and unreadable ones are `Null`.
pub(super) fn parse(extras: &Extras) -> Value {
    extras
        .as_ref()
        .and_then(|raw| serde_json::from_str(raw.get()).ok())
        .unwrap_or(Value::Null)
}

/// A finite number at a key.
pub(super) fn number(value: &Value, key: &str) -> Option<f32> {
    let number = value.get(key)?.as_f64()? as f32;
    number.is_finite().then_some(number)
}

/// Three finite numbers.
fn vec3(value: &Value) -> Option<Vec3> {
    let list = value.as_array().filter(|list| list.len() == 3)?;
    let mut components = [0.0; 3];
    for (component, value) in components.iter_mut().zip(list) {
        *component = value.as_f64()? as f32;
    }
    Some(Vec3::from(components)).filter(|v| v.is_finite())
}

/// `extras.medium = {aabb: [[x,y,z],[x,y,z]], sigma_s, sigma_a, g}` of the root.
pub(super) fn medium(root: &Value) -> Result<Option<Medium>, Fault> {
    let Some(value) = root.get("medium") else {
        return Ok(None);
    };
    let fault = |reason: &str| Fault::new("extras.medium", reason);
    let corner = |i: usize| value.get("aabb").and_then(|b| b.get(i)).and_then(vec3);
    let (Some(a), Some(b)) = (corner(0), corner(1)) else {
        return Err(fault("aabb is not [[x, y, z], [x, y, z]]"));
    };
    let medium = Medium {
        min: a.min(b),
        max: a.max(b),
        sigma_s: number(value, "sigma_s").unwrap_or(0.0),
        sigma_a: number(value, "sigma_a").unwrap_or(0.0),
        g: number(value, "g").unwrap_or(0.0),
    };
    if medium.sigma_s < 0.0 || medium.sigma_a < 0.0 {
        return Err(fault("sigma_s and sigma_a must be 0 or more per metre"));
    }
    if medium.g.abs() >= 1.0 {
        return Err(fault("g must lie between −1 and 1"));
    }
    // A medium that does nothing is none: it must not cost anything.
    Ok(Some(medium).filter(|m| m.sigma_s + m.sigma_a > 0.0))
}

/// `extras.indirect = true` of the root: the scene calls for indirect diffuse light.
pub(super) fn indirect(root: &Value) -> bool {
    root.get("indirect").and_then(Value::as_bool) == Some(true)
}

/// `extras.unframed.sky = {zenith, horizon, ambient}` of the root, written by the exporter.
pub(super) fn sky(root: &Value) -> Result<Option<Sky>, Fault> {
    let Some(value) = root.get("unframed").and_then(|u| u.get("sky")) else {
        return Ok(None);
    };
    let colour = |key: &str| {
        value
            .get(key)
            .and_then(vec3)
            .filter(|c| c.min_element() >= 0.0)
            .ok_or_else(|| {
                Fault::new(
                    format!("extras.unframed.sky.{key}"),
                    "is not three numbers of 0 or more",
                )
            })
    };
    Ok(Some(Sky {
        zenith: colour("zenith")?,
        horizon: colour("horizon")?,
        ambient: colour("ambient")?,
    }))
}
