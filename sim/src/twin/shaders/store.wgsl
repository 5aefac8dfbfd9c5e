// Stores placed samples in the ring in the order of their arrival, the newest in place of the
// oldest. Twin of DeepBuffer::push.

@group(0) @binding(2) var<uniform> items: vec4<u32>;
@group(0) @binding(3) var<storage, read> ring: Ring;
@group(0) @binding(4) var<storage, read> pending: array<Stored>;
@group(0) @binding(5) var<storage, read> placed: array<u32>;
// How many were placed before each.
@group(0) @binding(6) var<storage, read> ranks: array<u32>;
@group(0) @binding(7) var<storage, read_write> samples: array<Stored>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = linear(group, groups, local);
    if i >= items.x || placed[i] == 0u || params.capacity == 0u { return; }
    // More than the ring holds: only the newest, so that no place is written twice.
    let newer = ranks[items.x] - 1u - ranks[i];
    if newer >= params.capacity { return; }
    samples[(ring.next + ranks[i]) % params.capacity] = pending[i];
}
