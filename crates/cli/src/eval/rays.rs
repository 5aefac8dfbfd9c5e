//! Rates at which methods take the same number of rays.

use anyhow::Result;
use unframed_host::drive::Host;
use unframed_host::stream::sender::Promise;
use unframed_host::trace::World;

use super::cell::Job;
use super::methods::{EvalMethod, Setting, Way};
use crate::measure::REFRESH_HZ;

/// Refreshes over which rays a sample are counted beforehand: half a second.
const PILOT: u32 = REFRESH_HZ / 2;

/// The rate of a job's stream: its own or, of methods that are compared at equal rays, the one
/// at which it takes as many rays as `adaptive` does at the job's rate.
///
/// # Errors
/// A stream fails.
pub fn rate(job: &Job, world: &World, setting: Setting) -> Result<u32> {
    let Setting::Rays(..) = setting else {
        return Ok(job.rate);
    };
    let refreshes = job.settings.refreshes.min(PILOT);
    let guided = rays_a_sample(
        EvalMethod::Adaptive.way(world, job.rate, job.seed, Setting::Only),
        job.rate,
        world,
        refreshes,
    )?;
    // Rays a sample hardly depend on the rate, but the rate may be far off.
    let mut rate = job.rate;
    for _ in 0..2 {
        let own = job.method.way(world, rate, job.seed, setting);
        let own = rays_a_sample(own, rate, world, refreshes)?;
        rate = (f64::from(job.rate) * guided / own).round().max(1.0) as u32;
    }
    Ok(rate)
}

fn rays_a_sample(way: Way, rate: u32, world: &World, refreshes: u32) -> Result<f64> {
    let Way::Stream {
        sampler,
        layout,
        tile_fields,
        ..
    } = way
    else {
        return Ok(1.0);
    };
    let promise = Promise {
        layout,
        lamps: true,
        tile_fields,
        rate,
        refresh_millihertz: REFRESH_HZ * 1000,
    };
    let mut host = Host::new(world.clone(), sampler, promise);
    let (mut rays, mut samples, mut bytes) = (0u64, 0u64, Vec::new());
    for _ in 0..refreshes {
        bytes.clear();
        let step = host.advance(&mut bytes)?;
        rays += u64::from(step.rays.total());
        samples += step.samples as u64;
    }
    Ok(rays as f64 / samples.max(1) as f64)
}
