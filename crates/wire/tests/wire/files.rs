//! Recordings: index, repair, summary.

use crate::common::*;
use crate::link::frames;
use unframed_wire::recording::*;
use unframed_wire::*;

fn recording() -> Vec<u8> {
    let mut recorder = Recorder::new(Vec::new());
    frames()
        .iter()
        .for_each(|frame| recorder.write(frame).unwrap());
    recorder.finish().unwrap()
}

#[test]
fn the_index_points_at_its_packets_and_can_be_rebuilt() {
    let bytes = recording();
    let entries = read_index(&bytes).unwrap();
    assert_eq!(entries.len(), 40);
    assert_eq!(rebuild_index(&bytes), entries);
    for entry in &entries {
        let mut receiver = Receiver::new();
        let mut input = &bytes[entry.offset as usize..];
        // A Refresh alone is early: join at the Hello before it, as a player would.
        if entry.kind == IndexKind::Hello {
            assert!(matches!(receiver.push(&mut input), Some(Packet::Hello(_))));
        } else {
            let start = &bytes[..frames()[0].len()];
            assert!(receiver.push(&mut &start[..]).is_some());
            let packet = receiver.push(&mut input);
            assert!(matches!(packet, Some(Packet::Refresh(r)) if r.time == entry.time));
        }
    }
    let (packets, counters) = receive(&bytes, 4096);
    assert_eq!((counters.lost, counters.damaged), (0, 0));
    let trailer = Trailer {
        offset: frames().concat().len() as u64,
        entries: 40,
    };
    assert_eq!(packets.last(), Some(&Owned::Trailer(trailer)));
}

#[test]
fn a_missing_or_damaged_index_is_noticed_and_repaired() {
    let whole = recording();
    let body = frames().concat().len();
    for cut in [body, body + 1, body + 40, whole.len() - 1] {
        let mut bytes = whole[..cut].to_vec();
        assert_eq!(read_index(&bytes), None, "cut at {cut}");
        assert_eq!(index(&bytes), read_index(&whole).unwrap());
        repair(&mut bytes);
        assert_eq!(bytes, whole, "cut at {cut}");
    }
    for at in body..whole.len() {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x10;
        assert_eq!(read_index(&bytes), None, "flipped at {at}");
        repair(&mut bytes);
        assert_eq!(bytes, whole, "flipped at {at}");
    }
    assert_eq!(read_index(&[]), None);
    assert_eq!(read_index(&[0]), None);
}

#[test]
fn the_summary_adds_up() {
    let bytes = recording();
    let s = Summary::of(&bytes).unwrap();
    let body = frames().concat().len() as u64;
    assert_eq!(
        (s.samples, s.bytes, s.lost, s.damaged),
        (20 * 160, body, 0, 0)
    );
    let of = |kind| s.packets_of(kind);
    assert_eq!([of(Kind::Hello), of(Kind::View), of(Kind::Tiles)], [20; 3]);
    assert_eq!([of(Kind::Lamps), of(Kind::Shape)], [20; 2]);
    assert_eq!(
        (s.sample_packets(), of(Kind::Refresh), of(Kind::End)),
        (80, 20, 1)
    );
    assert_eq!(s.end.map(|e| (e.samples, e.packets)), Some((3200, 220)));
    // The clock wraps inside.
    assert!(
        (s.seconds - 20.0 * 0.016_667).abs() < 1e-9,
        "{} s",
        s.seconds
    );
    assert_eq!(s.timeline.len(), 20);
    assert_eq!(s.timeline.iter().map(|l| l.samples).sum::<u64>(), 3200);
    assert_eq!(s.timeline[19].micros - s.timeline[0].micros, 19 * 16_667);
    assert!(s.indexed);
    // Lose a Samples packet of the third refresh.
    let mut cut = frames();
    cut.remove(2 * 11 + 7);
    let s = Summary::of(&cut.concat()).unwrap();
    assert_eq!(
        (s.samples, s.lost, s.timeline[2].lost, s.timeline[2].samples),
        (3160, 1, 1, 120)
    );
    assert!(!s.indexed);
}

#[test]
fn what_is_not_a_recording_says_so() {
    assert_eq!(Summary::of(&[]), Err(NotARecording::Empty));
    assert_eq!(Summary::of(&[0, 0]), Err(NotARecording::NoHello(None)));
    let error = Summary::of(b"glTF\0\0\0").unwrap_err();
    assert_eq!(error, NotARecording::NoHello(Some(Damage::Framing)));
    assert!(error.to_string().contains("Hello"));
}
