// Where do samples that just arrived fall now? There they stay: without reprojection. Twin of the
// second half of Display::world_sample and of Display::screen.

@group(0) @binding(2) var<uniform> items: vec4<u32>;
@group(0) @binding(3) var<storage, read_write> pending: array<Stored>;
@group(0) @binding(4) var<storage, read> transforms: array<Transform, 256>;
// 1 for each sample that could be placed.
@group(0) @binding(5) var<storage, read_write> placed: array<u32>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = linear(group, groups, local);
    if i >= items.x { return; }
    placed[i] = 0u;
    let sample = pending[i];
    var at = vec2<i32>(i32(low16(sample.y)), i32(sample.y >> 16u));
    if placing(sample) == PLACING_LATTICE {
        if transforms[slot(sample)].known == 0u { return; }
        let seen = project(transforms[slot(sample)], place(sample));
        if !seen.visible { return; }
        at = vec2<i32>(to_sixteenths(seen.x), to_sixteenths(seen.y));
    }
    if any(at < vec2<i32>(0i)) { return; }
    let x = low16(u32(at.x));
    let y = low16(u32(at.y));
    if (x >> 4u) >= u32(params.width) || (y >> 4u) >= u32(params.height) { return; }
    placed[i] = 1u;
    pending[i] = Stored(
        sample.x,
        pack16(x, y),
        sample.z & 0xffff0000u,
        (sample.w & 0xffu) | (PLACING_SCREEN << 16u),
    );
}
