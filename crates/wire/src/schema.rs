//! Version and schema hash: two ends that disagree on a layout must not guess.

/// The version of the wire format that this crate speaks.
pub const VERSION: u8 = 1;

/// The first bytes of every Hello payload.
pub const MAGIC: [u8; 4] = *b"UFRM";

/// Every payload's fields in order, in a notation of our own (explained in `docs/STREAM.md`).
/// Any change of layout changes this text, hence [`HASH`].
pub const SCHEMA: &str = "\
1 hello magic:4 version:u8 schema:u32 width:u16 height:u16 flags:u8 fields:u8 encoding:u8 \
rate:u32 refresh:u32 origin:3f32 unit:f32 lamps:u8;\
2 view time:u32 eye:3i32 rows:9i32 frac:u8;\
3 poses time:u32 n(object:u8 frac:u8 matrix:9i32 translation:3i32);\
4 tiles time:u32 region:4u16 fields:u8 bits(k:3*n tree(split:1 axis:1|leaf:delta));\
5 world time:u32 runs-1:u8 runs(object:u8 length-1:u8) \
bits(flat:1 centre:6 k:3 colour:24 shares:6|0 samples(suffix mode axes colour shares:lamps));\
6 screen time:u32 count-1:u8 bits(k:5 colour:24 samples(gap colour));\
7 refresh time:u32 index:u32;\
8 cut time:u32;\
9 end time:u32 samples:u64 packets:u64;\
10 status time:u32 received:u32 lost:u32 damaged:u32 buffered:u32;\
11 index n(kind:u8 time:u32 offset:u64);\
12 trailer offset:u64 entries:u32;\
13 lamps time:u32 lamps(kind:u8 place:3i32 tint:2u16);\
14 shape object:u8 part:u8 parts-1:u8 vertices-1:u8 triangles-1:u8 \
vertices(place:3i16) triangles(corners:3u8);\
frame type:u8 seq:u16 payload crc32c cobs";

/// FNV-1a, 32 bits, of [`SCHEMA`].
pub const HASH: u32 = fnv1a(SCHEMA.as_bytes());

const fn fnv1a(bytes: &[u8]) -> u32 {
    let mut hash = 0x811c_9dc5u32;
    let mut i = 0;
    while i < bytes.len() {
        hash = (hash ^ bytes[i] as u32).wrapping_mul(0x0100_0193);
        i += 1;
    }
    hash
}

#[cfg(test)]
mod tests {
    #[test]
    fn fnv_matches_its_published_vectors() {
        // Fowler, Noll, Vo: test vectors of the 32-bit FNV-1a.
        assert_eq!(super::fnv1a(b""), 0x811c_9dc5);
        assert_eq!(super::fnv1a(b"a"), 0xe40c_292c);
        assert_eq!(super::fnv1a(b"foobar"), 0xbf9c_f968);
    }
}
