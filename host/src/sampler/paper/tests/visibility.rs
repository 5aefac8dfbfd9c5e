//! The ray that is not shaded against the one that is.

use glam::{Affine3A, Vec2, Vec3};

use crate::sampler::Eye;
use crate::sampler::noise::Random;
use crate::scene::builtin::builtin;
use crate::trace::camera::Camera;
use crate::trace::{Hit, World};

/// A world whose visibility is that of the trait: what a shaded ray finds.
struct Shaded<'a>(&'a World);

impl Eye for Shaded<'_> {
    fn camera(&self, time: f64) -> Camera {
        self.0.camera(time)
    }

    fn pose(&self, object: u8, time: f64) -> Affine3A {
        self.0.pose(object, time)
    }

    fn look(&self, time: f64, pixel: Vec2, seed: u32) -> Hit {
        Eye::look(self.0, time, pixel, seed)
    }

    fn look_along(&self, time: f64, direction: Vec3, seed: u32) -> Hit {
        Eye::look_along(self.0, time, direction, seed)
    }
}

#[test]
fn a_test_sees_what_a_sample_would() {
    for (scene, later) in [("walkthrough", 0.9), ("toycar", 0.9)] {
        let mut world = World::new(builtin(scene).expect("built in"), [96, 96]).expect("sound");
        let mut random = Random::new(11);
        world.prepare(0.3, 0.301);
        let hits: Vec<Hit> = (0..4000)
            .map(|_| Vec2::new(random.unit(), random.unit()) * 96.0)
            .map(|pixel| Eye::look(&world, 0.3, pixel, 1))
            .collect();
        let seen = hits.iter().filter(|h| world.sees(0.3, h.object, h.local));
        assert!(
            seen.count() > 3980,
            "{scene}: a hit is seen from where it was found"
        );
        world.prepare(later, later + 0.001);
        let (mut hidden, mut differ) = (0, 0);
        for hit in &hits {
            let test = world.sees(later, hit.object, hit.local);
            let sample = Shaded(&world).sees(later, hit.object, hit.local);
            hidden += u32::from(!sample);
            differ += u32::from(test != sample);
        }
        assert!(hidden > 20, "{scene}: {hidden} hidden");
        assert!(differ <= 8, "{scene}: {differ} of {hidden}");
    }
}
