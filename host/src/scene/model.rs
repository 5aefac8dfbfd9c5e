//! The scene's data model, close to glTF 2.0 so that loading and export are direct.

use glam::{Mat4, Quat, Vec2, Vec3, Vec4};

/// A complete animated scene.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Built-in name or file stem.
    pub name: String,
    /// The node hierarchy; a parent stands before its children.
    pub nodes: Vec<Node>,
    /// Triangle meshes, referred to by nodes.
    pub meshes: Vec<Mesh>,
    /// Surface materials, referred to by primitives.
    pub materials: Vec<Material>,
    /// Images, referred to by materials.
    pub textures: Vec<Texture>,
    /// Skins, referred to by nodes.
    pub skins: Vec<Skin>,
    /// The animation that plays from time 0 and loops after `duration`.
    pub channels: Vec<Channel>,
    /// Length of the loop, seconds; 0 when nothing is animated.
    pub duration: f64,
    /// Radiance of rays that hit nothing.
    pub sky: Sky,
    /// A homogeneous medium, if any.
    pub medium: Option<Medium>,
    /// Whether light goes on from matt surfaces to others; else the sky's ambient term stands
    /// for it.
    pub indirect: bool,
}

/// A node of the hierarchy: local transform and what hangs on it.
#[derive(Clone, Debug)]
pub struct Node {
    /// For messages.
    pub name: String,
    /// Index of the parent, smaller than the own index.
    pub parent: Option<usize>,
    /// Rest translation, metres.
    pub translation: Vec3,
    /// Rest rotation, a unit quaternion.
    pub rotation: Quat,
    /// Rest scale.
    pub scale: Vec3,
    /// Index of a mesh.
    pub mesh: Option<usize>,
    /// Index of a skin that deforms the mesh.
    pub skin: Option<usize>,
    /// A light at the node's origin, shining down −z where it has a direction.
    pub light: Option<Light>,
    /// A camera at the node's origin. The first camera of the scene is the one used.
    pub camera: Option<Lens>,
}

impl Default for Node {
    fn default() -> Self {
        Self {
            name: String::new(),
            parent: None,
            translation: Vec3::ZERO,
            rotation: Quat::IDENTITY,
            scale: Vec3::ONE,
            mesh: None,
            skin: None,
            light: None,
            camera: None,
        }
    }
}

/// A camera's lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Vertical field of view, radians, above 0 and below π.
    pub yfov: f32,
    /// Radius of the aperture, metres; 0 is a pinhole.
    pub aperture: f32,
    /// Distance in focus, metres.
    pub focus: f32,
}

/// Triangles in one place.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// For messages.
    pub name: String,
    /// Parts with one material each.
    pub primitives: Vec<Primitive>,
}

/// Triangles of one material.
#[derive(Clone, Debug, Default)]
pub struct Primitive {
    /// Vertex positions, metres, mesh-local.
    pub positions: Vec<Vec3>,
    /// Unit normals, one a vertex; empty means flat shading.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, one a vertex or empty.
    pub uvs: Vec<Vec2>,
    /// Linear vertex colours, one a vertex or empty.
    pub colours: Vec<Vec4>,
    /// Up to four joints a vertex (indices into the skin), or empty.
    pub joints: Vec<[u16; 4]>,
    /// Their weights, summing to 1.
    pub weights: Vec<[f32; 4]>,
    /// Three vertex indices a triangle, in range.
    pub indices: Vec<[u32; 3]>,
    /// Index of the material.
    pub material: usize,
}

/// Metallic-roughness material with the extensions that the tracer knows.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// For messages.
    pub name: String,
    /// Linear base colour and opacity.
    pub base_colour: Vec4,
    /// Multiplies `base_colour`.
    pub base_texture: Option<TextureRef>,
    /// A pattern computed at the hit instead of an image; multiplies `base_colour`.
    pub procedural: Option<Procedural>,
    /// Linear emitted radiance (emissive strength multiplied in).
    pub emissive: Vec3,
    /// Multiplies `emissive`.
    pub emissive_texture: Option<TextureRef>,
    /// 0 dielectric … 1 metal.
    pub metallic: f32,
    /// 0 mirror … 1 matt. Metals at or below [`MIRROR_ROUGHNESS`] reflect rays.
    pub roughness: f32,
    /// 0 opaque … 1 refracting glass.
    pub transmission: f32,
    /// Index of refraction, 1 or more.
    pub ior: f32,
    /// Whether back faces are shaded too (all are hit).
    pub double_sided: bool,
    /// Below this opacity a hit is passed through (alpha mask); `None` is opaque.
    pub alpha_cutoff: Option<f32>,
    /// Shows its base colour, unlit.
    pub unlit: bool,
}

/// Roughness at or below which a metal is a mirror.
pub const MIRROR_ROUGHNESS: f32 = 0.1;

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            base_colour: Vec4::ONE,
            base_texture: None,
            procedural: None,
            emissive: Vec3::ZERO,
            emissive_texture: None,
            metallic: 0.0,
            roughness: 1.0,
            transmission: 0.0,
            ior: 1.5,
            double_sided: true,
            alpha_cutoff: None,
            unlit: false,
        }
    }
}

/// A use of a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureRef {
    /// Index of the texture.
    pub texture: usize,
    /// Applied to the coordinates: uv·scale + offset (KHR_texture_transform without rotation).
    pub scale: Vec2,
    /// See `scale`.
    pub offset: Vec2,
}

/// Patterns of the built-in scenes (procedural shaders); exported to glTF as baked textures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Procedural {
    /// Two colours in squares of `size` in texture coordinates.
    Checker {
        /// Side of a square, texture coordinates.
        size: f32,
        /// The other colour, linear.
        other: Vec3,
    },
    /// Brick wall: bricks of `size`, joints of `joint`.
    Brick {
        /// Brick width and height, texture coordinates.
        size: Vec2,
        /// Joint width, texture coordinates.
        joint: f32,
        /// Colour of the joint, linear.
        mortar: Vec3,
    },
    /// Stripes along v.
    Stripes {
        /// Period in u.
        period: f32,
        /// The other colour, linear.
        other: Vec3,
    },
}

/// An image, decoded; sampled bilinearly with repeat.
#[derive(Clone, Debug, Default)]
pub struct Texture {
    /// For messages.
    pub name: String,
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// RGBA, 8 bits, row by row from the top; sRGB-encoded colour, linear alpha.
    pub rgba: Vec<[u8; 4]>,
    /// Whether u repeats (else clamps).
    pub repeat_u: bool,
    /// Whether v repeats (else clamps).
    pub repeat_v: bool,
}

/// A skin: joints and their inverse bind matrices.
#[derive(Clone, Debug, Default)]
pub struct Skin {
    /// Node indices.
    pub joints: Vec<usize>,
    /// One a joint: mesh space to the joint's rest space.
    pub inverse_bind: Vec<Mat4>,
}

/// A light on a node (KHR_lights_punctual). Emissive meshes are area lights besides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Where it shines.
    pub kind: LightKind,
    /// Linear colour times intensity: candela-like W/sr for point and spot, W/m² for directional.
    pub intensity: Vec3,
    /// Distance beyond which it does nothing; infinite if none is given.
    pub range: f32,
}

/// The kinds of punctual light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// In all directions.
    Point,
    /// In a cone around −z.
    Spot {
        /// Full intensity within this angle from the axis, radians.
        inner: f32,
        /// None beyond this angle, radians.
        outer: f32,
    },
    /// Parallel, down −z.
    Directional,
}

/// One animated property of one node.
#[derive(Clone, Debug)]
pub struct Channel {
    /// The node.
    pub node: usize,
    /// The property and its keys.
    pub track: Track,
    /// Key times, seconds, ascending.
    pub times: Vec<f32>,
    /// How to go from key to key.
    pub interpolation: Interpolation,
    /// The clip repeats after this many seconds (each clip loops on its own).
    pub period: f32,
}

/// Key values; for CUBICSPLINE three a key (in-tangent, value, out-tangent).
#[derive(Clone, Debug)]
pub enum Track {
    /// Metres.
    Translation(Vec<Vec3>),
    /// Unit quaternions.
    Rotation(Vec<Quat>),
    /// Factors.
    Scale(Vec<Vec3>),
}

/// glTF's interpolations (Appendix C).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Holds the key before.
    Step,
    /// Straight line, slerp for rotations.
    Linear,
    /// Cubic Hermite spline.
    CubicSpline,
}

/// Radiance of rays that hit nothing, and its diffuse light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// Linear radiance straight up.
    pub zenith: Vec3,
    /// Linear radiance at the horizon and below.
    pub horizon: Vec3,
    /// Irradiance/π that an unshadowed surface gets besides the lights (the neutral ambient term).
    pub ambient: Vec3,
}

impl Default for Sky {
    fn default() -> Self {
        Self {
            zenith: Vec3::ZERO,
            horizon: Vec3::ZERO,
            ambient: Vec3::ZERO,
        }
    }
}

/// A homogeneous participating medium in a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    /// Lowest corner, metres.
    pub min: Vec3,
    /// Highest corner, metres.
    pub max: Vec3,
    /// Scattering coefficient, 1/m.
    pub sigma_s: f32,
    /// Absorption coefficient, 1/m.
    pub sigma_a: f32,
    /// Henyey–Greenstein asymmetry, −1..1.
    pub g: f32,
}
