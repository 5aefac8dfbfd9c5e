//! The baseline: the same samples scattered plainly in `f32` on one thread: moved to the view,
//! weighed by age, widths from the density in 3 × 3 pixels, weighted means; no hidden-point test,
//! nothing filled.

use super::scene;

struct Sample {
    place: [f32; 3],
    time: f32,
    rgb: [f32; 3],
    object: usize,
}

struct Seen {
    x: f32,
    y: f32,
    weight: f32,
}

/// The baseline's state.
pub(crate) struct Plain {
    size: usize,
    samples: Vec<Sample>,
    lifetimes: Vec<f32>,
    seen: Vec<Seen>,
    sums: Vec<[f32; 4]>,
    /// The picture, linear.
    pub(crate) picture: Vec<[f32; 3]>,
}

impl Plain {
    /// A second of samples.
    pub(crate) fn new(size: u16, samples: usize) -> Self {
        let mut rng = scene::Rng(1);
        let tiles = scene::tiles(size, true, &mut rng);
        let lifetimes = tiles
            .iter()
            .map(|t| (t.lifetime.log2_q8() as f32 / 256.0).exp2());
        let lifetimes = lifetimes.collect();
        let samples = (0..samples).map(|i| {
            let sample = scene::sample(&mut rng);
            Sample {
                place: sample.place.map(f32::from),
                time: i as f32 / samples as f32,
                rgb: sample.rgb.map(|c| (f32::from(c) / 255.0).powf(2.2)),
                object: usize::from(sample.object.wrapping_add(1)),
            }
        });
        let pixels = usize::from(size) * usize::from(size);
        Self {
            size: size.into(),
            samples: samples.collect(),
            lifetimes,
            seen: Vec::new(),
            sums: vec![[0.0; 4]; pixels],
            picture: vec![[0.0; 3]; pixels],
        }
    }

    /// Makes the picture at `index` 60ths of a second after the last sample, everything moving.
    pub(crate) fn refresh(&mut self, index: u32) {
        let phase = f64::from(index) * 0.02;
        let view = scene::view(self.size as u16, (phase * 0.3).sin() * 0.3);
        // Row k of view times pose, with its offset.
        let mut transforms = [[[0f32; 4]; 3]; 256];
        for pose in scene::poses(phase) {
            let transform = &mut transforms[usize::from(pose.object.wrapping_add(1))];
            for (k, row) in transform.iter_mut().enumerate() {
                for j in 0..3 {
                    let r = view.rows[k][j] as f32;
                    for (entry, m) in row.iter_mut().zip(pose.matrix[j]) {
                        *entry += r * m as f32 / (1u64 << pose.frac_bits) as f32;
                    }
                    row[3] += r * (pose.translation[j] - view.eye[j]) as f32;
                }
            }
        }
        let (size, now) = (self.size, 1.0 + index as f32 / 60.0);
        let limit = size as f32;
        self.seen.clear();
        let mut mass = vec![0f32; size * size];
        for s in &self.samples {
            let [x, y, w] = transforms[s.object]
                .map(|r| r[0] * s.place[0] + r[1] * s.place[1] + r[2] * s.place[2] + r[3]);
            let (x, y) = (x / w, y / w);
            let inside = w > 0.0 && x >= 0.0 && y >= 0.0 && x < limit && y < limit;
            let weight = if inside {
                let (px, py) = (x as usize, y as usize);
                let u = (now - s.time) / self.lifetimes[py / 8 * size.div_ceil(8) + px / 8];
                let weight = 1.0 / (1.0 + u * u + u * u * u * u);
                mass[py * size + px] += weight;
                weight
            } else {
                0.0
            };
            self.seen.push(Seen { x, y, weight });
        }
        let mut sigma = vec![0f32; size * size];
        for y in 0..size {
            for x in 0..size {
                let mut sum = 0.0;
                for v in y.saturating_sub(1)..(y + 2).min(size) {
                    for u in x.saturating_sub(1)..(x + 2).min(size) {
                        sum += mass[v * size + u];
                    }
                }
                sigma[y * size + x] = (1.5 / sum.sqrt()).clamp(0.35, 1.2);
            }
        }
        self.sums.fill([0.0; 4]);
        for (s, at) in self.samples.iter().zip(&self.seen) {
            if at.weight == 0.0 {
                continue;
            }
            let sigma = sigma[at.y as usize * size + at.x as usize];
            let (reach, steep) = (3.0 * sigma, -0.5 / (sigma * sigma));
            let range = |v: f32| {
                let first = (v - reach - 0.5).ceil().max(0.0) as usize;
                first..((v + reach + 0.5).floor().max(0.0) as usize).min(size)
            };
            for row in range(at.y) {
                let dy = at.y - row as f32 - 0.5;
                for column in range(at.x) {
                    let dx = at.x - column as f32 - 0.5;
                    let weight = at.weight * ((dx * dx + dy * dy) * steep).exp();
                    let sums = &mut self.sums[row * size + column];
                    sums[0] += weight;
                    for (sum, c) in sums[1..].iter_mut().zip(s.rgb) {
                        *sum += weight * c;
                    }
                }
            }
        }
        for (pixel, sums) in self.picture.iter_mut().zip(&self.sums) {
            *pixel = [1, 2, 3].map(|c| sums[c] / sums[0].max(1e-9));
        }
    }
}
