//! Whether volumes share space, in a time that grows with the particles near other volumes.

use glam::Vec3;

use crate::plan::SceneError;
use crate::scene::Volume;

/// Edge of a cell over the spacing. A point of a shape is less than `sqrt(3)` spacings from a particle of that shape, so the
/// 27 cells around it hold one.
const CELL: f32 = 2.0;

/// Particles of two volumes may be as near as half a spacing, and none may lie within another volume's shape.
///
/// `ids`: first particle and number of particles of each volume. Positions are no farther from the origin than `f32` can tell
/// apart, so that cells can be counted in `i32`.
pub(crate) fn check_overlap(
    volumes: &[Volume],
    positions: &[Vec3],
    ids: &[(u32, u32)],
    spacing: f32,
) -> Result<(), SceneError> {
    let particles = |volume: usize| {
        let (first, count) = ids[volume];
        &positions[first as usize..(first + count) as usize]
    };
    let boxes: Vec<Bounds> =
        (0..volumes.len()).map(|volume| Bounds::around(particles(volume), CELL * spacing)).collect();
    let shared = shared_boxes(&boxes);
    let mut sites = Vec::new();
    for (volume, shared) in shared.iter().enumerate().filter(|(_, shared)| shared.low.x <= shared.high.x) {
        sites.extend(particles(volume).iter().filter(|&&point| shared.contains(point)).map(|&point| {
            let [x, y, z] = (point / (CELL * spacing)).floor().as_ivec3().to_array();
            Site { cell: [z, y, x], volume: volume as u32, point }
        }));
    }
    // Two boxes that touch, neither a whole number of cells long, have particles just half a spacing apart: hence 0.48.
    let limit = (0.48 * spacing).powi(2);
    let is_near = |site: &Site, other: &Site| site.point.distance_squared(other.point) < limit;
    let is_within = |site: &Site, volume: u32| is_inside(&volumes[volume as usize], site.point, spacing);
    match find(sites, is_near, is_within) {
        Some((site, other)) => {
            let (a, b) = (site.volume as usize, other as usize);
            Err(SceneError::Overlap { first: a.min(b), second: a.max(b), place: site.point.to_string() })
        }
        None => Ok(()),
    }
}

/// Whether a point lies in a volume's shape, by more than rounding.
fn is_inside(volume: &Volume, point: Vec3, spacing: f32) -> bool {
    let local = volume.rotation.conjugate() * (point - volume.center);
    volume.shape.contains(local, 0.05 * spacing)
}

/// An axis-aligned box, empty where low is above high.
#[derive(Clone, Copy)]
struct Bounds {
    low: Vec3,
    high: Vec3,
}

impl Bounds {
    const EMPTY: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };

    fn around(points: &[Vec3], margin: f32) -> Self {
        points.iter().fold(Self::EMPTY, |all, &point| Self {
            low: all.low.min(point - margin),
            high: all.high.max(point + margin),
        })
    }

    fn contains(&self, point: Vec3) -> bool {
        point.cmpge(self.low).all() && point.cmple(self.high).all()
    }

    fn and(&self, other: &Self) -> Self {
        Self { low: self.low.max(other.low), high: self.high.min(other.high) }
    }

    fn or(&self, other: &Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    fn meets(&self, other: &Self) -> bool {
        (0..3).all(|axis| self.low[axis] <= other.high[axis] && other.low[axis] <= self.high[axis])
    }
}

/// Others a volume has something in common with, from which on all of it is looked at.
const CROWD: u32 = 64;

/// For each box, one around all that it has in common with others; the whole box where these are many.
fn shared_boxes(boxes: &[Bounds]) -> Vec<Bounds> {
    let all = boxes.iter().fold(Bounds::EMPTY, |all, bounds| all.or(bounds));
    // Sweeps along the axis on which there is most room.
    let axis = (all.high - all.low).max_position();
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    order.sort_by(|&a, &b| boxes[a].low[axis].total_cmp(&boxes[b].low[axis]));
    let sorted: Vec<Bounds> = order.iter().map(|&index| boxes[index]).collect();
    let mut shared = vec![Bounds::EMPTY; boxes.len()];
    let mut company = vec![0; boxes.len()];
    for (a, first) in sorted.iter().enumerate() {
        for (b, second) in sorted.iter().enumerate().skip(a + 1) {
            if second.low[axis] > first.high[axis] {
                break;
            }
            if (company[a] > CROWD && company[b] > CROWD) || !first.meets(second) {
                continue;
            }
            let common = first.and(second);
            for one in [a, b] {
                company[one] += 1;
                let part = if company[one] > CROWD { &sorted[one] } else { &common };
                shared[order[one]] = shared[order[one]].or(part);
            }
        }
    }
    shared
}

/// A particle that may be near another volume.
#[derive(Clone, Copy)]
struct Site {
    /// z, y, x of its cell.
    cell: [i32; 3],
    volume: u32,
    point: Vec3,
}

/// The first site, by cell, that is near one of another volume or within that volume, and the other volume. Looks in the 27
/// cells around each.
fn find(
    mut sites: Vec<Site>,
    is_near: impl Fn(&Site, &Site) -> bool,
    is_within: impl Fn(&Site, u32) -> bool,
) -> Option<(Site, u32)> {
    // Three cells in a row of x lie next to each other, and from cell to cell each of the nine rows only moves on.
    sites.sort_unstable_by_key(|site| (site.cell, site.volume));
    let mut rows = [(0, 0); 9];
    for group in sites.chunk_by(|a, b| a.cell == b.cell) {
        let [z, y, x] = group[0].cell;
        for (row, (start, end)) in (0..).zip(&mut rows) {
            let (z, y) = (z + row / 3 - 1, y + row % 3 - 1);
            while sites.get(*start).is_some_and(|site| site.cell < [z, y, x - 1]) {
                *start += 1;
            }
            *end = (*end).max(*start);
            while sites.get(*end).is_some_and(|site| site.cell <= [z, y, x + 1]) {
                *end += 1;
            }
        }
        let around = rows.map(|(start, end)| &sites[start..end]);
        // Inside of a volume all are its own.
        let own = group[0].volume;
        if around.iter().all(|row| row.iter().all(|site| site.volume == own)) {
            continue;
        }
        for site in group {
            let mut asked = site.volume;
            for other in around.into_iter().flatten().filter(|other| other.volume != site.volume) {
                // Those of a volume follow each other: one question is enough.
                let is_new = std::mem::replace(&mut asked, other.volume) != other.volume;
                if is_near(site, other) || (is_new && is_within(site, other.volume)) {
                    return Some((*site, other.volume));
                }
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::sample_volume;

    /// Over all pairs.
    fn overlaps_slowly(volumes: &[Volume], sampled: &[Vec<Vec3>], spacing: f32) -> bool {
        let pairs = (0..volumes.len()).flat_map(|a| (0..volumes.len()).map(move |b| (a, b))).filter(|(a, b)| a != b);
        pairs.into_iter().any(|(a, b)| {
            sampled[a].iter().any(|&point| {
                is_inside(&volumes[b], point, spacing)
                    || sampled[b].iter().any(|&other| point.distance(other) < 0.48 * spacing)
            })
        })
    }

    #[test]
    fn finds_what_a_search_over_all_pairs_finds() {
        let mut state = 1u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 16_777_216.0
        };
        let (spacing, mut found) = (0.1, [0, 0]);
        for _ in 0..600 {
            let volumes: Vec<Volume> = (0..4)
                .map(|_| {
                    let center = 1.6 * Vec3::new(random(), random(), random());
                    let rotation = glam::Quat::from_scaled_axis(3.0 * Vec3::new(random(), random(), random()));
                    if random() < 0.5 {
                        Volume::ball(0.05 + 0.3 * random(), center)
                    } else {
                        let half = Vec3::splat(0.03) + 0.3 * Vec3::new(random(), random(), random());
                        Volume { rotation, ..Volume::block(half, center) }
                    }
                })
                .collect();
            let sampled: Vec<Vec<Vec3>> =
                volumes.iter().map(|volume| sample_volume(volume, spacing).unwrap()).collect();
            let mut first = 0;
            let ids: Vec<(u32, u32)> = sampled
                .iter()
                .map(|points| {
                    first += points.len() as u32;
                    (first - points.len() as u32, points.len() as u32)
                })
                .collect();
            let wanted = overlaps_slowly(&volumes, &sampled, spacing);
            assert_eq!(check_overlap(&volumes, &sampled.concat(), &ids, spacing).is_err(), wanted, "{volumes:?}");
            found[usize::from(wanted)] += 1;
        }
        assert!(found.iter().all(|&count| count > 100), "{found:?}");
    }
}
