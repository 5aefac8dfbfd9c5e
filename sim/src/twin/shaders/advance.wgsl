// Moves the ring on by the samples placed and counts them. Twin of DeepBuffer::push and of the
// counts in Display::world_sample. One invocation.

@group(0) @binding(2) var<uniform> items: vec4<u32>;
@group(0) @binding(3) var<storage, read> ranks: array<u32>;
@group(0) @binding(4) var<storage, read_write> ring: Ring;

@compute @workgroup_size(1)
fn main() {
    let placed = ranks[items.x];
    if params.capacity != 0u {
        ring.len = min(ring.len + placed, params.capacity);
        ring.next = (ring.next + placed) % params.capacity;
    }
    ring.placed += placed;
    ring.unplaced += items.x - placed;
}
