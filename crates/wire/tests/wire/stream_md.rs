//! The worked examples of `docs/STREAM.md` are what the code writes and reads.
//!
//! In the document each example is a code block `text example NAME`. The line that starts with
//! `frame` is the frame in hexadecimal; every later line is a piece of the packet inside, bytes in
//! hexadecimal or bits after `0b`, then `;` and what they mean. After a change of the format,
//! `UNFRAMED_PRINT_EXAMPLES=1 cargo test -p unframed-wire stream_md -- --nocapture` prints the
//! new bytes to annotate.

use crate::common::*;
use unframed_wire::*;

const DOCUMENT: &str = include_str!("../../../../docs/STREAM.md");

/// Writes one example to a sink.
type Write<'a> = dyn Fn(&mut Writer, &mut dyn FnMut(&[u8])) + 'a;

/// The examples are of so many streams.
const STREAMS: usize = 3;

/// Which stream an example is of.
fn stream_of(name: &str) -> usize {
    match name {
        "screen-hello" | "screen" => 1,
        "lamps-hello" | "lamps" | "shape" | "lamps-world" => 2,
        _ => 0,
    }
}

/// The examples: name, frame, and what it decodes to.
fn examples() -> Vec<(&'static str, Vec<u8>, Owned)> {
    let mut writers = [(); STREAMS].map(|()| Writer::new());
    let mut out = Vec::new();
    let mut add = |name, write: &Write<'_>| {
        let mut frame = Vec::new();
        write(&mut writers[stream_of(name)], &mut |bytes| {
            frame.extend_from_slice(bytes)
        });
        out.push((name, frame));
    };
    let mut world_hello = hello(Layout::World, true);
    world_hello.tile_fields = TileFields {
        gradients: false,
        lifetime: true,
        density: true,
    };
    let lit = lit(1);
    let screen_hello = hello(Layout::Screen, false);
    let time = Tick(1_000_000);
    let view = View {
        time,
        eye: [1000, -2, 300_000],
        rows: [[65_536, 0, 32_768], [0, -65_536, 32_768], [0, 0, 256]],
        frac_bits: 8,
    };
    let pose = Pose {
        object: 1,
        matrix: [[256, 0, 0], [0, 256, 0], [0, 0, 256]],
        frac_bits: 7,
        translation: [100, 200, -1],
    };
    let leaf = |x, w, lifetime, density| {
        let rect = Rect { x, y: 0, w, h: 256 };
        let (lifetime, density) = (LogCode(lifetime), LogCode(density));
        let neutral = LogCode(128);
        TileNode::Leaf(Tile {
            rect,
            gx: neutral,
            gy: neutral,
            gt: neutral,
            lifetime,
            density,
        })
    };
    let nodes = [
        TileNode::Split(Axis::X),
        leaf(0, 128, 120, 150),
        leaf(128, 128, 119, 152),
    ];
    // Three samples of a floor, which call for a mode, and one of a mover. In sorted order.
    let world = [
        WorldSample {
            place: [100, -200, 300],
            rgb: [200, 100, 50],
            object: 0,
            shares: Shares::default(),
        },
        WorldSample {
            place: [104, -200, 301],
            rgb: [202, 103, 50],
            object: 0,
            shares: Shares::default(),
        },
        WorldSample {
            place: [1100, -200, 2301],
            rgb: [190, 97, 40],
            object: 0,
            shares: Shares::default(),
        },
        WorldSample {
            place: [-1, 0, 1],
            rgb: [10, 20, 30],
            object: 1,
            shares: Shares::default(),
        },
    ];
    let lamp = Lamp {
        kind: LampKind::Directional,
        place: [0, Lamp::UNIT, 0],
        tint: [320, 128],
    };
    // A tetrahedron without its base.
    let corners = [[0, 100, 0], [-80, 0, -40], [80, 0, -40], [0, 0, 90]];
    let triangles = [[0, 1, 2], [0, 2, 3], [0, 3, 1]];
    // Three neighbours on a floor, the last of another colour.
    let shaded =
        [(300, 150, 9), (301, 149, 8), (303, 120, 10)].map(|(z, grey, code)| WorldSample {
            place: [100, -200, z],
            rgb: [grey, grey, grey - 10],
            object: 0,
            shares: Shares::new([code, 0]),
        });
    // In sorted order too.
    let screen = [
        ScreenSample {
            x: 100,
            y: 200,
            rgb: [200, 100, 50],
        },
        ScreenSample {
            x: 116,
            y: 200,
            rgb: [202, 103, 50],
        },
        ScreenSample {
            x: 100,
            y: 216,
            rgb: [198, 99, 49],
        },
    ];
    let region = Rect {
        x: 0,
        y: 0,
        w: 256,
        h: 256,
    };
    let refresh = Refresh {
        time: Tick(1_016_667),
        index: 60,
    };
    let status = Status {
        refresh_time: refresh.time,
        received: 9,
        lost: 1,
        damaged: 0,
        buffered: 3,
    };
    let entry = IndexEntry {
        kind: IndexKind::Refresh,
        time: refresh.time,
        offset: 314,
    };
    add("hello", &|w, mut s| w.hello(&world_hello, &mut s).unwrap());
    add("view", &|w, mut s| w.view(&view, &mut s).unwrap());
    add("poses", &|w, mut s| w.poses(time, &[pose], &mut s).unwrap());
    add("tiles", &|w, mut s| {
        w.tiles(time, region, &nodes, &mut s).unwrap()
    });
    add("world", &|w, mut s| {
        w.world_samples(time, &world, &mut s).unwrap()
    });
    add("screen-hello", &|w, mut s| {
        w.hello(&screen_hello, &mut s).unwrap()
    });
    add("screen", &|w, mut s| {
        w.screen_samples(time, &screen, &mut s).unwrap()
    });
    add("refresh", &|w, mut s| w.refresh(refresh, &mut s).unwrap());
    add("cut", &|w, mut s| w.cut(time, &mut s).unwrap());
    add("end", &|w, mut s| {
        assert_eq!(w.end(refresh.time, &mut s).unwrap().samples, 4)
    });
    add("status", &|w, mut s| w.status(&status, &mut s).unwrap());
    add("lamps-hello", &|w, mut s| w.hello(&lit, &mut s).unwrap());
    add("lamps", &|w, mut s| w.lamps(time, &[lamp], &mut s).unwrap());
    add("shape", &|w, mut s| {
        w.shape(1, 0, 1, &corners, &triangles, &mut s).unwrap()
    });
    add("lamps-world", &|w, mut s| {
        w.world_samples(time, &shaded, &mut s).unwrap()
    });
    add("index", &|w, mut s| w.index(500, &[entry], &mut s).unwrap());

    let end = End {
        time: refresh.time,
        samples: 4,
        packets: 7,
    };
    let meanings = [
        Owned::Hello(world_hello),
        Owned::View(view),
        Owned::Poses(time, vec![pose]),
        Owned::Tiles(time, region, tiles_of(&nodes)),
        Owned::World(time, world.to_vec()),
        Owned::Hello(screen_hello),
        Owned::Screen(time, screen.to_vec()),
        Owned::Refresh(refresh),
        Owned::Cut(time),
        Owned::End(end),
        Owned::Status(status),
        Owned::Hello(lit),
        Owned::Lamps(time, vec![lamp]),
        Owned::Shape(
            1,
            0,
            1,
            triangles.map(|t| t.map(|at| corners[at as usize])).to_vec(),
        ),
        Owned::World(time, shaded.to_vec()),
        Owned::Index(vec![entry]),
    ];
    // The index comes with its trailer: an example of its own.
    let (_, both) = out.pop().unwrap();
    let cut = both.iter().position(|&b| b == 0).unwrap() + 1;
    out.extend([
        ("index", both[..cut].to_vec()),
        ("trailer", both[cut..].to_vec()),
    ]);
    let trailer = Owned::Trailer(Trailer {
        offset: 500,
        entries: 1,
    });
    out.into_iter()
        .zip(meanings.into_iter().chain([trailer]))
        .map(|((name, frame), meaning)| (name, frame, meaning))
        .collect()
}

fn tiles_of(nodes: &[TileNode]) -> Vec<Tile> {
    let leaf = |n: &TileNode| match n {
        TileNode::Leaf(tile) => Some(*tile),
        TileNode::Split(_) => None,
    };
    nodes.iter().filter_map(leaf).collect()
}

fn hex(bytes: &[u8]) -> String {
    bytes
        .iter()
        .map(|b| format!("{b:02x}"))
        .collect::<Vec<_>>()
        .join(" ")
}

fn bits_of(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:08b}")).collect()
}

/// Frame and packet bits of the example `name` of `document`.
fn example(document: &str, name: &str) -> Option<(String, String)> {
    let start = document.find(&format!("```text example {name}\n"))?;
    let mut lines = document[start..]
        .lines()
        .skip(1)
        .take_while(|line| *line != "```");
    let frame = lines.next()?.strip_prefix("frame ")?.trim().to_string();
    let mut bits = String::new();
    for line in lines {
        for token in line.split(';').next()?.split_whitespace() {
            // A byte is two digits, so that the byte 0b is not taken for bits.
            match token.strip_prefix("0b").filter(|_| token.len() > 2) {
                Some(more) => bits.push_str(more),
                None => bits.push_str(&bits_of(&[u8::from_str_radix(token, 16).ok()?])),
            }
        }
    }
    Some((frame, bits))
}

fn unframed(frame: &[u8]) -> Vec<u8> {
    let mut packet = vec![0xA5; frame.len()];
    let n = cobs::decode(&frame[..frame.len() - 1], &mut packet)
        .unwrap()
        .frame_size();
    packet.truncate(n);
    packet
}

#[test]
fn stream_md_examples_are_what_the_code_writes() {
    let print = std::env::var_os("UNFRAMED_PRINT_EXAMPLES").is_some();
    for (name, frame, _) in examples() {
        let packet = unframed(&frame);
        if print {
            println!("{name}\nframe {}\npacket {}", hex(&frame), hex(&packet));
            println!("bits from byte 7: {}", bits_of(&packet[7..]));
            continue;
        }
        let (documented, bits) = example(DOCUMENT, name)
            .unwrap_or_else(|| panic!("docs/STREAM.md has no well-formed example {name}"));
        assert_eq!(documented, hex(&frame), "frame of the example {name}");
        assert_eq!(bits, bits_of(&packet), "packet of the example {name}");
    }
}

#[test]
fn stream_md_examples_decode_to_what_they_say() {
    let mut receivers = [const { Receiver::new() }; STREAMS];
    for (name, frame, meaning) in examples() {
        let receiver = &mut receivers[stream_of(name)];
        let mut input = &frame[..];
        assert_eq!(
            receiver.push(&mut input).map(Owned::from),
            Some(meaning),
            "{name}"
        );
    }
}

#[test]
fn stream_md_states_the_constants_of_the_code() {
    for constant in [
        format!("version {}", schema::VERSION),
        format!("{:#010x}", schema::HASH),
        format!("{} bytes before COBS", MAX_PACKET),
        format!("1..={MAX_SAMPLES} samples"),
        format!("1..={MAX_POSES} poses"),
        format!("0..={MAX_INDEX_ENTRIES} entries"),
        format!("0..={LAMPS}; 0 unless layout world"),
        format!("{} bytes of payload", MAX_PACKET - 7),
    ] {
        assert!(
            DOCUMENT.contains(&constant),
            "docs/STREAM.md does not say {constant:?}"
        );
    }
    let schema: String = schema::SCHEMA.split_whitespace().collect();
    let document: String = DOCUMENT.split_whitespace().collect();
    assert!(
        document.contains(&schema),
        "docs/STREAM.md does not quote the schema"
    );
}

#[test]
fn a_changed_example_would_be_noticed() {
    let (frame, bits) = example(DOCUMENT, "cut").unwrap();
    let changed = DOCUMENT.replace(&frame, &frame.replacen('0', "1", 1));
    assert_ne!(example(&changed, "cut"), Some((frame, bits)));
    assert_eq!(example(DOCUMENT, "nothing"), None);
}
