//! A scene made ready for rays.
//!
//! Static geometry lies in one flat hierarchy in world coordinates. Nodes that move rigidly
//! together (everything down to the next animated node) are one *mover* with a hierarchy in the
//! coordinates of its animated node, its *frame*. Skinned geometry is one more hierarchy in
//! world coordinates whose triangles belong to joints, which are frames too.
//!
//! Objects on the wire: 0 is the static world; then the movers, largest first; then the joints.
//! There are at most [`MAX_OBJECTS`]: what is beyond is traced just the same, but a joint
//! reports its nearest ancestor that is an object, and all else reports 0, so that the display
//! takes it for static.

use glam::{Affine3A, Mat4, Vec2, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use unframed_wire::SKY;

use super::Rays;
use super::camera::Camera;
use super::casters::{self, Casters};
use super::check::{WorldError, check};
use super::epoch::{Epoch, Knot, Outlook, inverse_or_zero, sweep};
use super::geometry::{Attributes, Geometry, NO_COLOURS, Soup};
use super::light::{Lamp, Place, Source, lights_others};
use super::moment::Moment;
use super::skin::Skinned;
use super::texture::Sampler;
use crate::effects::vpl::{self, Vpls};
use crate::scene::animate::Animation;
use crate::scene::model::{Lens, MIRROR_ROUGHNESS, Primitive, Scene};

/// Most object ids, the static world included.
pub const MAX_OBJECTS: usize = 250;

/// Instants over the loop at which the extent of skinned geometry is measured.
const SKIN_PROBES: u32 = 48;

/// What moves in a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Motion {
    /// The camera.
    pub view: bool,
    /// Geometry.
    pub objects: bool,
    /// Lights.
    pub lights: bool,
}

/// A scene made ready for rays.
#[derive(Clone)]
pub struct World {
    pub(crate) scene: Scene,
    size: [u32; 2],
    animation: Animation,
    /// Poses of all nodes; those that stand still are right at every instant.
    poses: Vec<Affine3A>,
    pub(crate) sampler: Sampler,
    /// Per material: an area light, which casts no shadow.
    pub(crate) glowing: Vec<bool>,
    pub(crate) fixed: Geometry,
    /// Mover `i` has frame `i`.
    pub(crate) movers: Vec<Geometry>,
    /// Nodes of the movers, then of the joints.
    frames: Vec<usize>,
    skinned: Option<Skinned>,
    pub(crate) skin: Geometry,
    /// Frame of each object but the first.
    pub(crate) object_frames: Vec<usize>,
    object_bounds: Vec<Aabb>,
    pub(crate) lamps: Vec<Lamp>,
    /// From this one on lamps are area lights.
    pub(crate) first_area: usize,
    /// Shadows that are left to the display where it draws them.
    pub(crate) casters: Casters,
    /// Of the prepared stretch, when the scene calls for indirect light.
    pub(crate) vpls: Vpls,
    camera: Option<(usize, Lens)>,
    pub(crate) epoch: Epoch,
}

impl World {
    /// Makes a scene ready; `size` is the image's width and height in pixels.
    ///
    /// A scene without a camera is seen from its origin, down −z, with 60° from top to bottom.
    ///
    /// # Errors
    /// When the size is not 1..=4096 or the scene contradicts itself.
    pub fn new(mut scene: Scene, size: [u32; 2]) -> Result<Self, WorldError> {
        check(&scene, size)?;
        scene.medium = scene.medium.filter(|m| m.extinction() > 0.0);
        let animation = Animation::new(&scene);
        let mut poses = Vec::new();
        animation.world_all(&scene, 0.0, &mut poses);

        let (fixed, mut movers) = rigid_parts(&scene, &animation, &poses);
        movers.sort_by_key(|(node, soup)| (std::cmp::Reverse(soup.corners.len()), *node));
        let mut frames: Vec<usize> = movers.iter().map(|m| m.0).collect();
        let mut movers: Vec<Soup> = movers.into_iter().map(|m| m.1).collect();
        let mut object_frames = Vec::new();
        for (frame, soup) in movers.iter_mut().enumerate() {
            let object = next_object(&mut object_frames, frame);
            soup.attributes.iter_mut().for_each(|a| a.object = object);
        }

        let skinned = Skinned::new(&scene);
        let mut skin = Soup::default();
        if let Some(skinned) = &skinned {
            let owners: Vec<_> = skinned.owners(&scene).collect();
            let object_of = joint_objects(
                &scene,
                owners.iter().flat_map(|o| &o.1),
                &mut frames,
                |frame| next_object(&mut object_frames, frame),
            );
            for (primitive, owner) in owners {
                add(&scene, primitive, &Affine3A::IDENTITY, &mut skin);
                let first = skin.attributes.len() - owner.len();
                for (a, node) in skin.attributes[first..].iter_mut().zip(owner) {
                    a.object = object_of[node];
                }
            }
            skinned.pose(&scene, &poses, &mut skin.corners, &mut Vec::new());
        }

        let camera = scene
            .nodes
            .iter()
            .enumerate()
            .find_map(|(i, n)| Some((i, n.camera?)));
        let epoch = Epoch {
            outlook: Outlook::Present,
            knots: Vec::new(),
            swept: Vec::new(),
            tree: None,
        };
        let lamps = Lamp::all(&scene);
        let mut world = Self {
            size,
            sampler: Sampler::new(&scene.textures),
            glowing: (0..scene.materials.len())
                .map(|m| lights_others(&scene, m))
                .collect(),
            fixed: Geometry::new(fixed),
            movers: movers.into_iter().map(Geometry::new).collect(),
            frames,
            skinned,
            skin: Geometry::new(skin),
            object_bounds: Vec::new(),
            object_frames,
            first_area: lamps.partition_point(|lamp| !lamp.is_area()),
            lamps,
            vpls: Vpls::default(),
            casters: Casters::default(),
            camera,
            epoch,
            scene,
            animation,
            poses,
        };
        world.measure_objects();
        world.choose_casters();
        world.prepare(0.0, 0.0);
        Ok(world)
    }

    /// The scene that it was made from.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Width and height of the image, pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Number of objects, the static world (0) included; hits report ids below it or
    /// [`SKY`]. At most [`MAX_OBJECTS`].
    #[must_use]
    pub fn object_count(&self) -> usize {
        self.object_bounds.len()
    }

    /// Bounds of an object in its own coordinates, metres: all its hits lie inside, skinned ones
    /// up to what its loop did at 48 probed instants plus a tenth. The sky's are its unit
    /// sphere. A point at the origin for objects that do not exist or are empty.
    #[must_use]
    pub fn bounds(&self, object: u8) -> Aabb {
        if object == SKY {
            return Aabb::new(Vec3A::NEG_ONE, Vec3A::ONE);
        }
        let empty = Aabb::new(Vec3A::ZERO, Vec3A::ZERO);
        self.object_bounds
            .get(usize::from(object))
            .copied()
            .unwrap_or(empty)
    }

    /// The camera at any instant, seconds.
    #[must_use]
    pub fn camera(&self, t: f64) -> Camera {
        match self.camera {
            Some((node, lens)) => {
                self.camera_at(&self.animation.world(&self.scene, node, t), &lens)
            }
            None => self.camera_at(&Affine3A::IDENTITY, &DEFAULT_LENS),
        }
    }

    /// The transform of an object's coordinates to the world at any instant, seconds: identity
    /// for the static world, a translation to the eye for the sky.
    #[must_use]
    pub fn pose(&self, object: u8, t: f64) -> Affine3A {
        if object == SKY {
            return Affine3A::from_translation(self.camera(t).eye);
        }
        usize::from(object)
            .checked_sub(1)
            .and_then(|i| self.object_frames.get(i))
            .map_or(Affine3A::IDENTITY, |&f| {
                self.animation.world(&self.scene, self.frames[f], t)
            })
    }

    /// What ever moves.
    #[must_use]
    pub fn moves(&self) -> Motion {
        let joints = self.movers.len()..self.frames.len();
        Motion {
            view: self
                .camera
                .is_some_and(|(node, _)| self.animation.moves(node)),
            objects: !self.movers.is_empty()
                || self.frames[joints]
                    .iter()
                    .any(|&node| self.animation.moves(node)),
            lights: self.lamps.iter().any(|l| l.moves(&self.animation)),
        }
    }

    /// Number of triangles.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.fixed.len() + self.skin.len() + self.movers.iter().map(Geometry::len).sum::<usize>()
    }

    /// Makes the instants `t0..=t1` (seconds) ready for [`World::moment`]. Meant for a
    /// millisecond or a few; a loop of the animation at most.
    pub fn prepare(&mut self, t0: f64, t1: f64) {
        self.prepare_for(t0, t1, Outlook::Present);
    }

    /// The same, but at each instant of `t0..t1` everything is where it will be at `t1`, as foreseen at `t0` from the
    /// motion before it; and foreseen anew where a motion has a corner or a jump.
    pub fn foresee(&mut self, t0: f64, t1: f64) {
        self.prepare_for(t0, t1, Outlook::End);
    }

    /// All poses at an instant.
    fn pose_all(&mut self, time: f64, t1: f64, outlook: Outlook) {
        let (scene, poses) = (&self.scene, &mut self.poses);
        match outlook {
            Outlook::Present => self.animation.world_all(scene, time, poses),
            Outlook::End => self.animation.foresee_all(scene, time, t1, poses),
        }
    }

    fn prepare_for(&mut self, t0: f64, t1: f64, outlook: Outlook) {
        let corners = self.animation.corners(&self.scene, t0, t1);
        let times = Epoch::times(t0, t1, &corners, outlook);
        let mut frame_poses = Vec::with_capacity(times.len());
        let mut knots = Vec::with_capacity(times.len());
        for &time in &times {
            self.pose_all(time, t1, outlook);
            let frames: Vec<Affine3A> = self.frames.iter().map(|&n| self.poses[n]).collect();
            let camera = match &self.camera {
                Some((node, lens)) => self.camera_at(&self.poses[*node], lens),
                None => self.camera_at(&Affine3A::IDENTITY, &DEFAULT_LENS),
            };
            knots.push(Knot {
                time,
                camera,
                inverses: frames.iter().map(inverse_or_zero).collect(),
                lamps: self
                    .lamps
                    .iter()
                    .map(|l| l.place(&self.poses))
                    .collect::<Vec<Place>>(),
                lamp_poses: self.lamp_poses(),
            });
            frame_poses.push(frames);
        }
        let swept = self.movers.iter().enumerate().filter_map(|(i, mover)| {
            let poses = frame_poses.iter().map(|frames| frames[i]);
            Some((i as u32, sweep(&mover.bounds()?, poses)?))
        });
        self.epoch = Epoch {
            outlook,
            knots,
            swept: swept.collect(),
            tree: None,
        };
        self.epoch.index();
        // What there is one of for the whole stretch: in the present as in its middle.
        let once = match outlook {
            Outlook::Present => 0.5 * (t0 + t1),
            Outlook::End => t0,
        };
        if self.skinned.is_some() {
            self.pose_all(once, t1, outlook);
        }
        if let Some(skinned) = &self.skinned {
            let (mut corners, mut normals) = (Vec::new(), Vec::new());
            skinned.pose(&self.scene, &self.poses, &mut corners, &mut normals);
            self.skin.refit(&corners, &normals);
        }
        let moment = self.moment(once);
        if moment.indirect() {
            self.vpls = vpl::scatter(&moment, vpl::PATHS, vpl::NEAR);
        }
    }

    /// Rays that preparing the stretch took.
    #[must_use]
    pub fn preparation(&self) -> Rays {
        Rays {
            indirect: self.vpls.rays,
            ..Rays::default()
        }
    }

    /// Everything at an instant of the prepared stretch; instants outside give its ends.
    #[must_use]
    pub fn moment(&self, t: f64) -> Moment<'_> {
        Moment::new(self, t)
    }

    /// Poses of the lamps' nodes, if any lamp has an area.
    fn lamp_poses(&self) -> Vec<Affine3A> {
        if !self.lamps.iter().any(Lamp::is_area) {
            return Vec::new();
        }
        self.lamps.iter().map(|l| self.poses[l.node()]).collect()
    }

    fn camera_at(&self, pose: &Affine3A, lens: &Lens) -> Camera {
        let [w, h] = self.size.map(|s| s as f32);
        let m = pose.matrix3;
        let forward = (-m.z_axis).normalize_or(Vec3A::NEG_Z);
        let right = forward.cross(m.y_axis).normalize_or(Vec3A::X);
        Camera {
            eye: pose.translation.into(),
            right: right.into(),
            down: forward.cross(right).into(),
            forward: forward.into(),
            focal: 0.5 * h / (0.5 * lens.yfov).tan(),
            centre: Vec2::new(0.5 * w, 0.5 * h),
            aperture: lens.aperture,
            focus: lens.focus,
        }
    }

    /// Fills `casters`. A medium glows in the light of lamps: what it hides no sample tells.
    fn choose_casters(&mut self) {
        if self.scene.medium.is_some() {
            return;
        }
        let middle = self
            .fixed
            .bounds()
            .map_or(Vec3::ZERO, |b| b.center().into());
        let is_object = |mover: usize| self.object_frames.contains(&mover);
        let strength = |lamp: &Lamp| {
            let nowhere = || ([0.5; 2], Affine3A::IDENTITY);
            let light = lamp.incoming(&lamp.place(&self.poses), middle, nowhere);
            light.map_or(0.0, |light| light.irradiance.max_element())
        };
        self.casters = Casters::choose(
            &self.movers,
            is_object,
            &self.scene.materials,
            &self.glowing,
            &self.lamps,
            strength,
        );
    }

    /// Number of lamps whose shadows a display may draw itself, 0..=[`unframed_wire::LAMPS`].
    #[must_use]
    pub fn lamps_left(&self) -> u8 {
        self.casters.lamps.len() as u8
    }

    /// Where such a lamp is at any instant, seconds, and its light, as against the light that has no
    /// lamp: in red, green and blue.
    pub(crate) fn lamp_left(&self, lamp: usize, t: f64) -> Option<(Source, Vec3)> {
        let lamp = self.lamps.get(*self.casters.lamps.get(lamp)?)?;
        let pose = self.animation.world(&self.scene, lamp.node(), t);
        let ambient = self.scene.sky.ambient.max(Vec3::splat(1e-3));
        let source = lamp.source(&pose)?;
        Some((source, lamp.light() / ambient))
    }

    /// Whether such a lamp ever moves.
    pub(crate) fn lamps_left_move(&self) -> bool {
        let lamps = self.casters.lamps.iter();
        lamps
            .filter_map(|&lamp| self.lamps.get(lamp))
            .any(|lamp| lamp.moves(&self.animation))
    }

    /// The objects whose shadows a display may draw itself, with their triangles in the objects' own
    /// coordinates, metres.
    pub(crate) fn shapes(&self) -> Vec<(u8, Vec<[Vec3A; 3]>)> {
        let objects = (1..).zip(&self.object_frames);
        objects
            .filter(|(_, mover)| self.casters.contains(**mover))
            .filter_map(|(object, &mover)| {
                let (materials, glowing) = (&self.scene.materials, &self.glowing);
                Some((
                    object,
                    casters::shape(&self.movers[mover], materials, glowing)?,
                ))
            })
            .collect()
    }

    /// Fills `object_bounds`.
    fn measure_objects(&mut self) {
        let origin = Aabb::new(Vec3A::ZERO, Vec3A::ZERO);
        let mut bounds = vec![self.fixed.bounds()];
        bounds.extend(
            self.object_frames
                .iter()
                .map(|&f| self.movers.get(f).and_then(Geometry::bounds)),
        );
        if let Some(skinned) = &self.skinned {
            let (mut corners, mut normals, mut poses) = (Vec::new(), Vec::new(), Vec::new());
            for probe in 0..SKIN_PROBES {
                let t = self.scene.duration * f64::from(probe) / f64::from(SKIN_PROBES);
                self.animation.world_all(&self.scene, t, &mut poses);
                skinned.pose(&self.scene, &poses, &mut corners, &mut normals);
                self.skin.refit(&corners, &normals);
                for (triangle, a) in self.skin.triangles() {
                    let inverse = match usize::from(a.object).checked_sub(1) {
                        Some(i) => inverse_or_zero(&poses[self.frames[self.object_frames[i]]]),
                        None => Affine3A::IDENTITY,
                    };
                    let own = triangle.map(|v| inverse.transform_point3a(v));
                    let slot = &mut bounds[usize::from(a.object)];
                    let now = Aabb::from_points(&own);
                    *slot = Some(slot.map_or(now, |b| b.union(&now)));
                }
            }
            for (object, slot) in bounds.iter_mut().enumerate() {
                if let Some(b) = slot
                    && (object == 0 || self.object_frames[object - 1] >= self.movers.len())
                {
                    let pad = b.diagonal() * 0.1;
                    *slot = Some(Aabb::new(b.min - pad, b.max + pad));
                }
            }
        }
        self.object_bounds = bounds.into_iter().map(|b| b.unwrap_or(origin)).collect();
    }
}

/// Seen through when the scene has no camera.
const DEFAULT_LENS: Lens = Lens {
    yfov: std::f32::consts::FRAC_PI_3,
    aperture: 0.0,
    focus: f32::INFINITY,
};

/// The id for a frame, or 0 when ids are used up.
fn next_object(object_frames: &mut Vec<usize>, frame: usize) -> u8 {
    if object_frames.len() + 1 >= MAX_OBJECTS {
        return 0;
    }
    object_frames.push(frame);
    object_frames.len() as u8
}

/// Static triangles in world coordinates, and those of each carrier in its coordinates.
fn rigid_parts(
    scene: &Scene,
    animation: &Animation,
    poses: &[Affine3A],
) -> (Soup, Vec<(usize, Soup)>) {
    let mut fixed = Soup::default();
    let mut movers: Vec<(usize, Soup)> = Vec::new();
    for (i, node) in scene.nodes.iter().enumerate() {
        let (Some(mesh), None) = (node.mesh, node.skin) else {
            continue;
        };
        let (soup, pose) = match animation.carrier(i) {
            None => (&mut fixed, poses[i]),
            Some(carrier) => {
                let known = movers.iter().position(|m| m.0 == carrier);
                let at = known.unwrap_or_else(|| {
                    movers.push((carrier, Soup::default()));
                    movers.len() - 1
                });
                (&mut movers[at].1, relative(scene, animation, i, carrier))
            }
        };
        for primitive in &scene.meshes[mesh].primitives {
            add(scene, primitive, &pose, soup);
        }
    }
    movers.retain(|m| !m.1.corners.is_empty());
    (fixed, movers)
}

/// The constant transform of a node to its carrier.
fn relative(scene: &Scene, animation: &Animation, node: usize, carrier: usize) -> Affine3A {
    let mut pose = Affine3A::IDENTITY;
    let mut at = node;
    while at != carrier {
        pose = animation.local(scene, at, 0.0) * pose;
        match scene.nodes[at].parent {
            Some(parent) => at = parent,
            None => break,
        }
    }
    pose
}

/// Appends a primitive's triangles.
fn add(scene: &Scene, primitive: &Primitive, pose: &Affine3A, soup: &mut Soup) {
    let material = &scene.materials[primitive.material];
    let porous = material.alpha_cutoff.is_some()
        || material.transmission > 0.0
        || lights_others(scene, primitive.material);
    let textured = material.base_texture.is_some()
        || material.emissive_texture.is_some()
        || material.procedural.is_some();
    let polished = material.metallic > 0.0 && material.roughness <= MIRROR_ROUGHNESS
        || material.transmission > 0.0;
    let to_normals = Mat4::from(*pose).inverse().transpose();
    for triangle in &primitive.indices {
        let t = triangle.map(|i| i as usize);
        let normal = |v: usize| {
            let n = primitive.normals.get(v).copied().unwrap_or(Vec3::ZERO);
            to_normals.transform_vector3(n).normalize_or_zero()
        };
        let mut colours = NO_COLOURS;
        if !primitive.colours.is_empty() {
            colours = soup.colours.len() as u32;
            soup.colours.push(t.map(|v| primitive.colours[v]));
        }
        soup.corners
            .push(t.map(|v| pose.transform_point3(primitive.positions[v]).into()));
        soup.attributes.push(Attributes {
            normals: t.map(normal),
            uvs: t.map(|v| primitive.uvs.get(v).copied().unwrap_or(Vec2::ZERO)),
            material: primitive.material as u32,
            colours,
            object: 0,
            porous,
            textured,
            polished,
        });
    }
}

/// The object id of each node that is a dominant joint; adds their frames. Where ids run out,
/// the joints with fewest triangles take the id of an ancestor.
fn joint_objects<'a>(
    scene: &Scene,
    owners: impl Iterator<Item = &'a usize>,
    frames: &mut Vec<usize>,
    mut object: impl FnMut(usize) -> u8,
) -> Vec<u8> {
    let mut triangles = vec![0u32; scene.nodes.len()];
    owners.for_each(|&node| triangles[node] += 1);
    let mut joints: Vec<usize> = (0..triangles.len()).filter(|&n| triangles[n] > 0).collect();
    joints.sort_by_key(|&n| (std::cmp::Reverse(triangles[n]), n));
    let mut ids = vec![0; scene.nodes.len()];
    for &node in &joints {
        ids[node] = object(frames.len());
        frames.push(node);
    }
    for &node in &joints {
        let mut at = node;
        while ids[at] == 0 {
            let Some(parent) = scene.nodes[at].parent else {
                break;
            };
            at = parent;
        }
        ids[node] = ids[at];
    }
    ids
}
