//! Snapshots: bytes and back, and what is said of bytes that are none.

use freshet_core::prelude::*;
use freshet_core::snapshot::{BodyPose, Exchange, SnapshotError};
use proptest::prelude::*;

fn snapshot() -> Snapshot {
    let error = Impulse { linear: Vec3::new(0.5, -0.25, 8.0), angular: Vec3::new(-1.0, 2.0, 1e-9) };
    Snapshot {
        tick: 300,
        time: 5.000_000_000_1,
        carry: 0.003,
        emitted: Some(4.99),
        next_id: 1000,
        gravity: Vec3::new(0.0, -9.81, 0.0),
        ids: vec![3, 4, 999],
        positions: vec![Vec3::ZERO, Vec3::new(0.1, 0.2, 0.3), Vec3::splat(-1e6)],
        velocities: vec![Vec3::X, Vec3::Y, Vec3::splat(f32::MIN_POSITIVE)],
        remaining_lives: vec![f32::INFINITY, 0.5, -0.001],
        pressures: vec![0.0, 2.5, 1e-3],
        excesses: vec![0.0, -0.4, 1e-3],
        last_substep: 0.004,
        integrator: Integrator::Leapfrog,
        histories: vec![0.004, 0.0, 0.003],
        exchanges: vec![[Exchange { tick_plus_one: 300, error }; 4], [Exchange::default(); 4]],
        poses: vec![None, Some(BodyPose { position: Vec3::NEG_Y, rotation: Quat::from_rotation_x(0.3), swollen: 0.5 })],
    }
}

/// Where the body begins: after eight bytes of magic and four of checksum.
const BODY: usize = 12;

/// A body with the beginning that belongs to it: what is wrong with it is found by what comes after the checksum.
fn sealed(body: &[u8]) -> Vec<u8> {
    [b"FRESHET\x06", &crc32(body).to_le_bytes()[..], body].concat()
}

/// CRC-32 (IEEE 802.3), bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ if crc & 1 == 1 { 0xedb8_8320 } else { 0 })
    })
}

fn changed(change: impl FnOnce(&mut Snapshot)) -> Snapshot {
    let mut snapshot = snapshot();
    change(&mut snapshot);
    snapshot
}

#[test]
fn bytes_and_back() {
    for snapshot in [snapshot(), Snapshot::default()] {
        assert_eq!(Snapshot::from_bytes(&snapshot.to_bytes().unwrap()).unwrap(), snapshot);
    }
}

#[test]
fn another_file_is_no_snapshot() {
    let bytes = snapshot().to_bytes().unwrap();
    // Another kind of file, an empty one, another version of the format.
    for other in [&b"(resolution: Spacing(1))"[..], b"", b"FRESH", &[&bytes[..7], &[1], &bytes[8..]].concat()] {
        match Snapshot::from_bytes(other) {
            Err(SnapshotError::NotASnapshot { found, expected }) => {
                assert_eq!(found, &other[..other.len().min(8)]);
                assert_eq!(expected, b"FRESHET\x06");
            }
            result => panic!("{result:?}"),
        }
    }
}

#[test]
fn truncated_anywhere_it_is_damaged() {
    let bytes = snapshot().to_bytes().unwrap();
    for length in 8..bytes.len() {
        let error = Snapshot::from_bytes(&bytes[..length]).unwrap_err();
        assert!(matches!(error, SnapshotError::Damaged(_) | SnapshotError::Checksum { .. }), "{length}: {error:?}");
        // Even where the checksum is right.
        if length >= BODY {
            let sealed = sealed(&bytes[BODY..length]);
            assert!(matches!(Snapshot::from_bytes(&sealed), Err(SnapshotError::Damaged(_))), "{length}");
        }
    }
    let longer = sealed(&[&bytes[BODY..], &[0]].concat());
    assert!(
        matches!(Snapshot::from_bytes(&longer), Err(SnapshotError::Damaged(message)) if message.contains("1 bytes"))
    );
}

#[test]
fn no_flipped_bit_goes_unnoticed() {
    let bytes = snapshot().to_bytes().unwrap();
    for bit in 0..8 * bytes.len() {
        let mut flipped = bytes.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        match Snapshot::from_bytes(&flipped) {
            Err(SnapshotError::NotASnapshot { .. }) => assert!(bit < 8 * 8, "bit {bit}"),
            Err(error @ SnapshotError::Checksum { found, expected }) => {
                assert!(bit >= 8 * 8 && found != expected, "bit {bit}");
                let message = error.to_string();
                assert!([found, expected].iter().all(|sum| message.contains(&format!("{sum:08x}"))), "{message}");
            }
            result => panic!("bit {bit}: {result:?}"),
        }
    }
}

#[test]
fn a_length_that_the_bytes_do_not_have_takes_no_memory() {
    // Where the nine lists of an empty snapshot have their lengths, put one that is far too large: a vector of it would
    // overflow an address space.
    let bytes = Snapshot::default().to_bytes().unwrap();
    let body = &bytes[BODY..];
    assert_eq!(body.len(), 41);
    assert_eq!(sealed(body), bytes);
    for at in (27..33).chain(38..41) {
        for length in [u64::from(u32::MAX), 1 << 40, 1 << 60, u64::MAX] {
            let mut varint = Vec::new();
            let mut rest = length;
            while rest >= 128 {
                varint.push(rest as u8 | 128);
                rest >>= 7;
            }
            varint.push(rest as u8);
            let huge = sealed(&[&body[..at], &varint, &body[at + 1..]].concat());
            assert!(matches!(Snapshot::from_bytes(&huge), Err(SnapshotError::Damaged(_))), "{at} {length}");
        }
    }
}

#[test]
fn an_invalid_value_is_refused_by_name() {
    let cases: [(Snapshot, [&str; 3]); 26] = [
        (changed(|s| s.positions.truncate(2)), ["positions", "2", "3, one for each id"]),
        (changed(|s| s.velocities.push(Vec3::ZERO)), ["velocities", "4", "3, one for each id"]),
        (changed(|s| s.pressures.truncate(1)), ["pressures", "1", "none or 3, one for each id"]),
        (changed(|s| s.pressures[1] = -1.0), ["pressures[1]", "-1", "0 or more"]),
        (changed(|s| s.excesses.truncate(1)), ["excesses", "1", "none or 3, one for each id"]),
        (changed(|s| s.excesses[1] = -1.0), ["excesses[1]", "-1", "more than -1"]),
        (changed(|s| s.histories.truncate(2)), ["histories", "2", "none or 3, 1 for each id as leapfrog keeps"]),
        (changed(|s| s.histories[2] = f32::NAN), ["histories[2]", "NaN", "finite"]),
        (changed(|s| s.last_substep = 2.0), ["last_substep", "2", "1"]),
        (changed(|s| s.remaining_lives.clear()), ["remaining_lives", "0", "3, one for each id"]),
        (changed(|s| s.ids.truncate(2)), ["positions", "3", "2, one for each id"]),
        (changed(|s| s.positions[1].y = f32::NAN), ["positions[1]", "NaN", "finite"]),
        (changed(|s| s.velocities[2].z = f32::INFINITY), ["velocities[2]", "inf", "finite"]),
        (changed(|s| s.remaining_lives[1] = f32::NAN), ["remaining_lives[1]", "NaN", "a number"]),
        (changed(|s| s.next_id = 999), ["ids[2]", "999", "less than next_id = 999"]),
        (changed(|s| s.ids[1] = 3), ["ids[1]", "3", "more than the one before, 3"]),
        (changed(|s| s.ids[0] = 5), ["ids[1]", "4", "more than the one before, 5"]),
        (changed(|s| s.time = f64::NAN), ["time", "NaN", "0 s or more"]),
        (changed(|s| s.time = -1.0), ["time", "-1", "0 s or more"]),
        (changed(|s| s.carry = f32::NAN), ["carry", "NaN", "0 to 1 s"]),
        (changed(|s| s.carry = 1.5), ["carry", "1.5", "0 to 1 s"]),
        (changed(|s| s.emitted = Some(f64::NAN)), ["emitted", "NaN", "finite"]),
        (changed(|s| s.gravity.x = f32::INFINITY), ["gravity", "inf", "finite"]),
        (changed(|s| s.poses[1].as_mut().unwrap().position.y = f32::INFINITY), ["poses[1].position", "inf", "finite"]),
        (changed(|s| s.poses[1].as_mut().unwrap().rotation.w = 7.0), ["poses[1].rotation", "7", "unit"]),
        (changed(|s| s.exchanges[1][2].error.linear.x = f32::NAN), ["exchanges[1][2]", "NaN", "finite"]),
    ];
    for (snapshot, [field, value, allowed]) in cases {
        let error = Snapshot::from_bytes(&snapshot.to_bytes().unwrap()).unwrap_err();
        assert_eq!(snapshot.validate().unwrap_err(), error);
        let SnapshotError::Invalid(invalid) = &error else { panic!("{error:?}") };
        assert!(invalid.field.starts_with(field) && invalid.value.contains(value), "{error}");
        assert!(invalid.allowed.contains(allowed), "{error}");
        let message = error.to_string();
        assert!([field, value, allowed].iter().all(|part| message.contains(part)), "{message}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(500) })]

    #[test]
    fn any_bytes_give_a_snapshot_or_an_error(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let _ = Snapshot::from_bytes(&bytes);
        let _ = Snapshot::from_bytes(&sealed(&bytes));
    }

    #[test]
    fn damaged_bytes_with_the_right_checksum_give_a_valid_snapshot_or_an_error(
        edits in proptest::collection::vec((any::<proptest::sample::Index>(), any::<u8>()), 1..5),
    ) {
        let mut body = snapshot().to_bytes().unwrap().split_off(BODY);
        for (at, byte) in edits {
            let at = at.index(body.len());
            body[at] = byte;
        }
        if let Ok(snapshot) = Snapshot::from_bytes(&sealed(&body)) {
            prop_assert!(snapshot.validate().is_ok());
        }
    }

    #[test]
    fn any_state_survives(count in 0..200usize, seed in any::<u32>(), tick in 0..=1u64 << 63) {
        let value = |index: usize| f32::from_bits((seed ^ index as u32).wrapping_mul(0x9e37_79b9)).clamp(-1e9, 1e9);
        let vector = |index: usize| {
            let vector = Vec3::new(value(index), value(index + 1000), value(index + 2000));
            if vector.is_finite() { vector } else { Vec3::ONE }
        };
        let snapshot = Snapshot {
            tick,
            next_id: u32::MAX,
            ids: (0..count as u32).map(|id| id * 7).collect(),
            positions: (0..count).map(vector).collect(),
            velocities: (3000..3000 + count).map(vector).collect(),
            remaining_lives: vec![f32::INFINITY; count],
            ..Snapshot::default()
        };
        prop_assert_eq!(Snapshot::from_bytes(&snapshot.to_bytes().unwrap()).unwrap(), snapshot);
    }
}
