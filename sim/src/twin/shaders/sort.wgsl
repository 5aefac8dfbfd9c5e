// Brings the samples that count into the order of their pixels: the last step of a counting sort.
// Here they get their light of the instant, which the processor gives them when it weighs them: hidden
// ones need none. Within a pixel the order is any, and the sums do not depend on it. Counts go back to zero.

@group(0) @binding(2) var<storage, read> ring: Ring;
@group(0) @binding(3) var<storage, read> samples: array<Stored>;
@group(0) @binding(4) var<storage, read> projected: array<Projected>;
@group(0) @binding(5) var<storage, read> starts: array<u32>;
@group(0) @binding(6) var<storage, read_write> counts: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read_write> sorted: array<vec4<u32>>;
@group(0) @binding(8) var<storage, read> light: Light;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = linear(group, groups, local);
    if i >= ring.len { return; }
    let sample = projected[i];
    let weight = sample.depth_weight >> 16u;
    if weight == 0u { return; }
    let bin = bin_at(pixel(low16(sample.at)), pixel(sample.at >> 16u));
    let slot = starts[bin] + atomicSub(&counts[bin], 1u) - 1u;
    let code = relight(samples[i]);
    // Coordinates; red and green light; blue light and weight; widths.
    sorted[slot] = vec4<u32>(
        sample.at,
        pack16(tables.light[code.x], tables.light[code.y]),
        pack16(tables.light[code.z], weight),
        sample.widths,
    );
}
