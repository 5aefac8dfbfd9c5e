// Light of the instant: takes from a sample what lamps do not bring it now, as something stands
// before them. Twin of unframed_recon::light, but for the drawing of the maps. Stages bind a Light as
// `light`.

// The most lamps, faces of a lamp, windows of all, codes of a share.
const LAMPS: u32 = 2u;
const FACES: u32 = 6u;
const WINDOWS: u32 = 64u;
const CODES: u32 = 16u;
// Everything of a light, 15 fractional bits.
const WHOLE: u32 = 32768u;
// log2 of half the side of a face of a point lamp; half the side of a directional one's.
const FACE_BITS: u32 = 14u;
const PLANE: i32 = 131072i;
// Fractional bits of matrices.
const TOWARD_BITS: u32 = 14u;
// log2 of the unit in which maps keep depths, in those of places; no depth.
const DEPTH_BITS: u32 = 2u;
const NOTHING: u32 = 65535u;
// How much deeper than what stands before it something must be.
const BEHIND: u32 = 1u;

// Where one object is drawn on one face.
struct Window {
    slot: u32,
    corner_x: i32,
    corner_y: i32,
    // Texels.
    width: u32,
    height: u32,
    // log2 of a texel's side.
    shift: u32,
    first: u32,
    padding: u32,
}

// From an object's lattice to a lamp's coordinates.
struct Toward {
    matrix: array<i32, 9>,
    offset: array<i32, 3>,
}

// Twin of Lamps in light.rs.
struct Lamps {
    windows_len: u32,
    // A bit a lamp.
    directional: u32,
    // Where the windows of each face of each lamp begin, and the last end.
    faces: array<u32, 13>,
    windows: array<Window, WINDOWS>,
    // Of each lamp and code: red, green, blue.
    parts: array<u32, 96>,
    // Of each slot and lamp.
    towards: array<Toward, 512>,
}

struct Light {
    lamps: Lamps,
    // Two to a word, the first in the low half.
    texels: array<u32>,
}

// Where on which face a lamp sees something.
struct Aim {
    // Not at the lamp itself, nor beyond its face.
    seen: bool,
    face: u32,
    x: i32,
    y: i32,
    depth: u32,
}

// Where a lamp sees a lattice point.
fn toward_place(index: u32, q: vec3<i32>) -> vec3<i32> {
    var seen: vec3<i32>;
    for (var k = 0u; k < 3u; k++) {
        let sum = light.lamps.towards[index].matrix[3u * k] * q.x
            + light.lamps.towards[index].matrix[3u * k + 1u] * q.y
            + light.lamps.towards[index].matrix[3u * k + 2u] * q.z;
        seen[k] = light.lamps.towards[index].offset[k]
            + ((sum + (1i << (TOWARD_BITS - 1u))) >> TOWARD_BITS);
    }
    return seen;
}

fn depth_of(directional: bool, ahead: i32) -> u32 {
    let first = select(0i, 1i << 15u, directional);
    return u32(clamp((ahead >> DEPTH_BITS) + first, 0i, i32(NOTHING) - 1i));
}

fn aim_of(directional: bool, place: vec3<i32>) -> Aim {
    if directional {
        let inside = abs(place.x) < PLANE && abs(place.y) < PLANE;
        return Aim(inside, 0u, place.x, place.y, depth_of(true, place.z));
    }
    let size = abs(place);
    var axis = 2u;
    if size.x >= size.y && size.x >= size.z {
        axis = 0u;
    } else if size.y >= size.z {
        axis = 1u;
    }
    let ahead = size[axis];
    if ahead == 0i { return Aim(false, 0u, 0i, 0i, 0u); }
    let face = 2u * axis + select(0u, 1u, place[axis] < 0i);
    // To 16 bits, so that with 14 more they are 30.
    let down = u32(max(16i - i32(countLeadingZeros(u32(ahead))), 0i));
    let by = ahead >> down;
    let x = ((place[(axis + 1u) % 3u] >> down) << FACE_BITS) / by;
    let y = ((place[(axis + 2u) % 3u] >> down) << FACE_BITS) / by;
    return Aim(true, face, x, y, depth_of(false, ahead));
}

fn texel_at(index: u32) -> u32 {
    return (light.texels[index >> 1u] >> (16u * (index & 1u))) & 0xffffu;
}

// Whether something other than the object of a slot stands before what a lamp sees.
fn blocked(lamp: u32, aim: Aim, slot: u32) -> bool {
    let entry = lamp * FACES + aim.face;
    for (var i = light.lamps.faces[entry]; i < light.lamps.faces[entry + 1u]; i++) {
        let window = light.lamps.windows[i];
        // What lies before the corner becomes very large.
        let x = bitcast<u32>((aim.x - window.corner_x) >> window.shift);
        let y = bitcast<u32>((aim.y - window.corner_y) >> window.shift);
        if x >= window.width || y >= window.height || window.slot == slot { continue; }
        let nearest = texel_at(window.first + y * window.width + x);
        if aim.depth > min(nearest + BEHIND, NOTHING) { return true; }
    }
    return false;
}

// A code of which `left` (of WHOLE) is left.
fn dimmed(code: u32, left: u32) -> u32 {
    if left >= WHOLE { return code; }
    return linear_to_srgb((tables.linear[code] * left + (WHOLE >> 1u)) >> 15u);
}

// A sample's colour in the light of the instant.
fn relight(sample: Stored) -> vec3<u32> {
    let code = rgb(sample);
    let shares = sample.w >> 24u;
    if shares == 0u || light.lamps.windows_len == 0u { return code; }
    var left = vec3<u32>(WHOLE);
    for (var lamp = 0u; lamp < LAMPS; lamp++) {
        let share = (shares >> (4u * lamp)) & 15u;
        if share == 0u { continue; }
        let directional = ((light.lamps.directional >> lamp) & 1u) != 0u;
        let seen = toward_place(slot(sample) * LAMPS + lamp, place(sample));
        let aim = aim_of(directional, seen);
        if !aim.seen || !blocked(lamp, aim, slot(sample)) { continue; }
        let part = 3u * (lamp * CODES + share);
        for (var c = 0u; c < 3u; c++) {
            left[c] -= min(left[c], light.lamps.parts[part + c]);
        }
    }
    return vec3<u32>(
        dimmed(code.x, left.x),
        dimmed(code.y, left.y),
        dimmed(code.z, left.z),
    );
}
