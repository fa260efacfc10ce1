//! A tree of boxes around triangles, for the nearest point and the winding number.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};

use super::triangle::{nearest_on_triangle, solid_angle};

/// Most triangles of a leaf.
const LEAF: usize = 4;

/// From how many of its radii on a box of triangles is seen as one dipole; the winding number then is good to 0.02.
const FAR: f64 = 2.3;

#[derive(Clone, Debug)]
struct Node {
    min: Vec3,
    max: Vec3,
    /// Of a leaf its first triangle, otherwise its second child; the first follows the node.
    next: u32,
    /// Triangles of a leaf; zero if it is none.
    count: u32,
    /// Sum of the area vectors, m2, their centre weighted by area, and the radius around it.
    area: Vec3,
    center: Vec3,
    radius: f32,
}

/// A triangle near a middle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near {
    /// Its index in the tree's order.
    triangle: u32,
    /// No larger than its distance from the middle, m.
    distance: f32,
}

impl Near {
    fn new(triangle: u32, distance: f64) -> Self {
        Self { triangle, distance: (distance * (1.0 - 1e-6)) as f32 }
    }

    /// No larger than its distance from the middle, m.
    pub fn distance(self) -> f64 {
        f64::from(self.distance)
    }

    fn sort(list: &mut [Self]) {
        list.sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance).then(a.triangle.cmp(&b.triangle)));
    }
}

/// Triangles looked at, for tests of what a search costs.
#[cfg(test)]
pub(crate) mod work {
    use std::cell::Cell;

    thread_local! {
        static TRIANGLES: Cell<u64> = const { Cell::new(0) };
    }

    pub fn count() {
        TRIANGLES.set(TRIANGLES.get() + 1);
    }

    /// How many this thread has looked at since it was asked last.
    pub fn take() -> u64 {
        TRIANGLES.replace(0)
    }
}

/// Triangles, sorted into boxes that halve their number.
#[derive(Clone, Debug)]
pub(crate) struct MeshTree {
    nodes: Vec<Node>,
    triangles: Vec<[Vec3; 3]>,
}

impl MeshTree {
    pub fn new(mut triangles: Vec<[Vec3; 3]>) -> Self {
        let mut nodes = Vec::with_capacity(triangles.len());
        if !triangles.is_empty() {
            build(&mut nodes, &mut triangles, 0);
        }
        Self { nodes, triangles }
    }

    /// Lowest and highest corner of the box around all.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        self.nodes.first().map_or((Vec3::ZERO, Vec3::ZERO), |root| (root.min, root.max))
    }

    fn corners(&self, index: usize) -> [DVec3; 3] {
        let [a, b, c] = self.triangles[index];
        [a.as_dvec3(), b.as_dvec3(), c.as_dvec3()]
    }

    /// The nearest point that is nearer than `limit`, m.
    pub fn nearest(&self, point: DVec3, limit: f64) -> Option<DVec3> {
        let (mut best, mut found) = (limit * limit, None);
        if self.nodes.is_empty() {
            return None;
        }
        // Halves of halves: no way down is longer than the bits of a triangle's index, and each step leaves one node behind.
        let mut stack = [(0.0, 0); 34];
        let mut waiting = 1;
        stack[0] = (self.gap(0, point), 0);
        while waiting > 0 {
            waiting -= 1;
            let (gap, index) = stack[waiting];
            if gap >= best {
                continue;
            }
            let node = &self.nodes[index];
            for triangle in node.next as usize..(node.next + node.count) as usize {
                let near = self.nearest_on(triangle, point);
                let distance = near.distance_squared(point);
                if distance < best {
                    (best, found) = (distance, Some(near));
                }
            }
            if node.count == 0 {
                let mut children = [index + 1, node.next as usize].map(|child| (self.gap(child, point), child));
                if children[0].0 < children[1].0 {
                    children.swap(0, 1);
                }
                for child in children.into_iter().filter(|child| child.0 < best) {
                    stack[waiting] = child;
                    waiting += 1;
                }
            }
        }
        found
    }

    /// Adds the triangles nearer to a point than `reach` to a list, nearest first; none, and false, if there are more than `most`.
    pub fn list_near(&self, point: DVec3, reach: f64, most: usize, list: &mut Vec<Near>) -> bool {
        let first = list.len();
        let mut stack: Vec<usize> = (0..self.nodes.len().min(1)).collect();
        while let Some(index) = stack.pop() {
            if self.gap(index, point) > reach * reach {
                continue;
            }
            let node = &self.nodes[index];
            for triangle in node.next..node.next + node.count {
                let distance = self.nearest_on(triangle as usize, point).distance(point);
                if distance <= reach {
                    if list.len() - first == most {
                        list.truncate(first);
                        return false;
                    }
                    list.push(Near::new(triangle, distance));
                }
            }
            if node.count == 0 {
                stack.extend([index + 1, node.next as usize]);
            }
        }
        Near::sort(&mut list[first..]);
        true
    }

    /// The nearest point of a list's triangles; `off` is how far the point is from the middle they are near to, m.
    pub fn nearest_of(&self, list: &[Near], off: f64, point: DVec3) -> Option<DVec3> {
        let (mut best, mut found) = (f64::INFINITY, None);
        for near in list {
            if near.distance() - off > best {
                break;
            }
            let foot = self.nearest_on(near.triangle as usize, point);
            let distance = foot.distance(point);
            if distance < best {
                (best, found) = (distance, Some(foot));
            }
        }
        found
    }

    /// Adds those triangles of a list to `next` that are nearer than `reach` to another point, `off` from the middle, nearest first.
    pub fn list_again(&self, list: &[Near], off: f64, point: DVec3, reach: f64, next: &mut Vec<Near>) {
        let first = next.len();
        for near in list.iter().take_while(|near| near.distance() - off <= reach) {
            let distance = self.nearest_on(near.triangle as usize, point).distance(point);
            if distance <= reach {
                next.push(Near::new(near.triangle, distance));
            }
        }
        Near::sort(&mut next[first..]);
    }

    /// Corners of a triangle of a list, m.
    pub fn corners_of(&self, near: Near) -> [DVec3; 3] {
        self.corners(near.triangle as usize)
    }

    fn nearest_on(&self, triangle: usize, point: DVec3) -> DVec3 {
        #[cfg(test)]
        work::count();
        nearest_on_triangle(point, self.corners(triangle))
    }

    /// Square of the distance from a node's box.
    fn gap(&self, index: usize, point: DVec3) -> f64 {
        let node = &self.nodes[index];
        point.distance_squared(point.clamp(node.min.as_dvec3(), node.max.as_dvec3()))
    }

    /// How often the surface goes around a point (Jacobson et al. 2013, eq. 5), far triangles as dipoles (Barill et al. 2018).
    pub fn winding_number(&self, point: DVec3) -> f64 {
        let mut angle = 0.0;
        let mut stack: Vec<usize> = (0..self.nodes.len().min(1)).collect();
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index];
            let way = node.center.as_dvec3() - point;
            let distance = way.length();
            if distance > FAR * f64::from(node.radius) && distance > 0.0 {
                angle += node.area.as_dvec3().dot(way) / distance.powi(3);
            } else if node.count > 0 {
                let range = node.next as usize..(node.next + node.count) as usize;
                #[cfg(test)]
                range.clone().for_each(|_| work::count());
                angle += range.map(|triangle| solid_angle(point, self.corners(triangle))).sum::<f64>();
            } else {
                stack.extend([index + 1, node.next as usize]);
            }
        }
        angle / (4.0 * PI)
    }
}

/// Builds the node of some triangles, of which `first` come before, and all below it.
fn build(nodes: &mut Vec<Node>, triangles: &mut [[Vec3; 3]], first: usize) {
    let corners = || triangles.iter().flatten().copied();
    let min = corners().fold(Vec3::INFINITY, Vec3::min);
    let max = corners().fold(Vec3::NEG_INFINITY, Vec3::max);
    let vector = |[a, b, c]: &[Vec3; 3]| 0.5 * (*b - *a).as_dvec3().cross((*c - *a).as_dvec3());
    let area: DVec3 = triangles.iter().map(vector).sum();
    let weight: f64 = triangles.iter().map(|triangle| vector(triangle).length()).sum();
    let middle = |triangle: &[Vec3; 3]| triangle.iter().map(|corner| corner.as_dvec3()).sum::<DVec3>() / 3.0;
    let center = if weight > 0.0 {
        triangles.iter().map(|triangle| middle(triangle) * vector(triangle).length()).sum::<DVec3>() / weight
    } else {
        (0.5 * (min + max)).as_dvec3()
    };
    let radius = corners().map(|corner| corner.as_dvec3().distance(center)).fold(0.0, f64::max);
    let index = nodes.len();
    let (center, area) = (center.as_vec3(), area.as_vec3());
    let count = if triangles.len() <= LEAF { triangles.len() } else { 0 };
    nodes.push(Node { min, max, next: first as u32, count: count as u32, area, center, radius: radius as f32 });
    if count == 0 {
        let half = triangles.len() / 2;
        let axis = (max - min).max_position();
        let along = |triangle: &[Vec3; 3]| triangle[0][axis] + triangle[1][axis] + triangle[2][axis];
        // A stable sort: the same order from the same input, however many lie in one place.
        triangles.sort_by(|a, b| along(a).total_cmp(&along(b)));
        let (low, high) = triangles.split_at_mut(half);
        build(nodes, low, first);
        nodes[index].next = nodes.len() as u32;
        build(nodes, high, first + half);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball of triangles, by latitude and longitude.
    fn ball(rows: u32) -> Vec<[Vec3; 3]> {
        let at = |i: u32, j: u32| {
            let (theta, phi) = (PI * f64::from(i) / f64::from(rows), PI * f64::from(j) / f64::from(rows));
            DVec3::new(theta.sin() * phi.cos(), theta.cos(), -theta.sin() * phi.sin()).as_vec3()
        };
        let quads = (0..rows).flat_map(|i| (0..2 * rows).map(move |j| (i, j)));
        quads
            .flat_map(|(i, j)| {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect()
    }

    #[test]
    fn the_tree_answers_as_a_search_over_all() {
        let all = ball(14);
        let tree = MeshTree::new(all.clone());
        let mut state = 3u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            3.0 * f64::from(state >> 8) / 16_777_216.0 - 1.5
        };
        let mut inside = 0;
        for _ in 0..500 {
            let point = DVec3::new(random(), random(), random());
            let corners = || all.iter().map(|triangle| triangle.map(|corner| corner.as_dvec3()));
            let distance =
                corners().map(|t| nearest_on_triangle(point, t).distance(point)).fold(f64::INFINITY, f64::min);
            let found = tree.nearest(point, f64::INFINITY).map(|near| near.distance(point)).unwrap();
            assert!((found - distance).abs() < 1e-9);
            assert!(tree.nearest(point, 0.99 * distance).is_none());
            let winding = corners().map(|t| solid_angle(point, t)).sum::<f64>() / (4.0 * PI);
            assert!((tree.winding_number(point) - winding).abs() < 0.02, "{winding}");
            let near = corners().filter(|t| nearest_on_triangle(point, *t).distance(point) <= distance + 0.2).count();
            let mut list = vec![Near::new(7, 0.0)];
            assert!(!tree.list_near(point, distance + 0.2, near - 1, &mut list) && list.len() == 1);
            assert!(tree.list_near(point, distance + 0.2, near, &mut list) && list.len() == 1 + near);
            // What is nearest to a place a tenth away is on a list that reaches two tenths farther.
            let beside = point + 0.1 * DVec3::new(random(), random(), random()).normalize();
            let found = tree.nearest_of(&list[1..], 0.1, beside).map(|near| near.distance(beside)).unwrap();
            assert!((found - tree.nearest(beside, 9.0).unwrap().distance(beside)).abs() < 1e-9);
            inside += u32::from(winding > 0.5);
        }
        assert!(inside > 50);
    }
}
