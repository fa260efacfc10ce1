//! Collapse of a column of liquid without viscosity, rotation and surface tension: nonlinear potential flow, solved here.
//!
//! Not an experiment, but what the equations of motion say of one: a simulation that is far from both is wrong, one that
//! is far from one of them may be right.
//!
//! The potential and its normal derivative on the surface are joined by Green's third identity, with linear elements whose
//! integrals are exact, and images in the wall x = 0 and the floor y = 0. Nodes of the surface move with the liquid, their
//! potential by Bernoulli's equation with pressure zero (Longuet-Higgins & Cokelet 1976, Proc. R. Soc. A 350, 1). Lengths are in
//! units of the column's width `a`, times in units of `sqrt(a/g)`.

use crate::measure::curve::Curve;

/// A node of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    x: f64,
    y: f64,
    potential: f64,
}

impl Node {
    fn fields(self) -> [f64; 3] {
        [self.x, self.y, self.potential]
    }

    fn of(fields: [f64; 3]) -> Self {
        Self { x: fields[0], y: fields[1], potential: fields[2] }
    }

    fn moved(self, rate: [f64; 3], time: f64) -> Self {
        Self {
            x: self.x + rate[0] * time,
            y: (self.y + rate[1] * time).max(0.0),
            potential: self.potential + rate[2] * time,
        }
    }

    fn distance(self, other: Self) -> f64 {
        (self.x - other.x).hypot(self.y - other.y)
    }
}

/// Longest step, and one that is never needed before the surface breaks up.
const STEP: f64 = 0.02;
const SHORTEST_STEP: f64 = 1e-4;
/// Longest and shortest elements. In the thin tongue they are [`ELEMENT_OVER_DEPTH`] as long as it is deep.
const ELEMENTS: (f64, f64) = (0.08, 0.12);
const ELEMENT_OVER_DEPTH: f64 = 1.2;

/// A collapse over `tau`, right to about 0.01: elements shorter by a third change heights by less, and fronts by less than a hundredth of
/// them (tested). It ends early where the thin tongue cannot be resolved any more.
#[derive(Clone, Debug, PartialEq)]
pub struct Collapse {
    /// Height at the back wall, over the height at the start.
    pub height: Curve,
    /// How far from the wall all of the liquid but [`BEYOND`] is, in widths: the tip of the tongue is thinner than what an experiment sees,
    /// or a particle.
    pub front: Curve,
}

/// Share of the liquid that is farther than the front.
pub const BEYOND: f64 = 0.005;

/// The collapse of a column `aspect` times as high as wide, until `end`.
pub fn collapse(aspect: f64, end: f64) -> Collapse {
    refined(aspect, end, 1.0).0
}

/// The collapse, and the share of the liquid's area that is there at the end. `refinement` divides the elements' lengths.
fn refined(aspect: f64, end: f64, refinement: f64) -> (Collapse, f64) {
    let rows = 50;
    let top = (0..=rows).map(|i| (f64::from(i) / f64::from(rows), aspect));
    let side = (1..=rows).map(|i| (1.0, aspect * (1.0 - f64::from(i) / f64::from(rows))));
    let mut nodes: Vec<Node> = top.chain(side).map(|(x, y)| Node { x, y, potential: 0.0 }).collect();
    nodes = regrid(&nodes, refinement);
    for _ in 0..3 {
        smooth(&mut nodes, |f| (f[1] + 2.0 * f[2] + f[3]) / 4.0);
    }
    let start = area(&nodes);
    let mut found =
        Collapse { height: [(0.0, 1.0)].into_iter().collect(), front: [(0.0, front(&nodes))].into_iter().collect() };
    let (mut time, mut steps) = (0.0, 0_u32);
    while time < end {
        let first = rates(&nodes);
        let step = longest_step(&nodes, &first).min(end - time);
        if step < SHORTEST_STEP.min(end - time) {
            break;
        }
        let middle: Vec<Node> = nodes.iter().zip(&first).map(|(node, &rate)| node.moved(rate, step / 2.0)).collect();
        nodes = nodes.iter().zip(rates(&middle)).map(|(node, rate)| node.moved(rate, step)).collect();
        (time, steps) = (time + step, steps + 1);
        if nodes.iter().any(|node| !(node.x * node.y * node.potential).is_finite()) {
            break;
        }
        if steps.is_multiple_of(2) {
            // Longuet-Higgins & Cokelet 1976, eq. 3.6: takes away what alternates from node to node.
            smooth(&mut nodes, |f| (-f[0] + 4.0 * f[1] + 10.0 * f[2] + 4.0 * f[3] - f[4]) / 16.0);
        }
        nodes = regrid(&nodes, refinement);
        found.height.push(time, nodes[0].y / aspect);
        found.front.push(time, front(&nodes));
    }
    (found, area(&nodes) / start)
}

/// No node moves farther than its element is long, and no element is stretched by more than a quarter.
fn longest_step(nodes: &[Node], rates: &[[f64; 3]]) -> f64 {
    let pairs = nodes.windows(2).zip(rates.windows(2));
    pairs.fold(STEP, |step, (nodes, rates)| {
        let length = nodes[0].distance(nodes[1]);
        let stretch = (rates[0][0] - rates[1][0]).hypot(rates[0][1] - rates[1][1]);
        step.min(length).min(0.25 * length / stretch.max(1e-9))
    })
}

/// Area under the surface.
fn area(nodes: &[Node]) -> f64 {
    nodes.windows(2).map(|pair| (pair[1].x - pair[0].x) * (pair[0].y + pair[1].y) / 2.0).sum()
}

/// Where [`BEYOND`] of the area is farther from the wall.
fn front(nodes: &[Node]) -> f64 {
    let mut left = BEYOND * area(nodes);
    for pair in nodes.windows(2).rev() {
        let (width, depth) = (pair[1].x - pair[0].x, (pair[0].y + pair[1].y) / 2.0);
        let strip = width * depth;
        if strip >= left {
            // Depth changes little within an element.
            return pair[1].x - width * left / strip;
        }
        left -= strip;
    }
    0.0
}

/// Replaces each node but the two at each end by a mean over five.
fn smooth(nodes: &mut [Node], mean: impl Fn([f64; 5]) -> f64) {
    let old = nodes.to_vec();
    for (five, node) in old.windows(5).zip(&mut nodes[2..]) {
        let field = |k: usize| mean([0, 1, 2, 3, 4].map(|i| five[i].fields()[k]));
        *node = Node::of([field(0), field(1), field(2)]);
    }
}

/// Distance along the surface from the wall.
fn arc(nodes: &[Node]) -> Vec<f64> {
    let mut arc = vec![0.0];
    for pair in nodes.windows(2) {
        arc.push(arc[arc.len() - 1] + pair[0].distance(pair[1]));
    }
    arc
}

/// Derivatives by the distance along the surface, of second order. At the wall x is odd, y and the potential are even; at the
/// tip all go on as they are.
fn slopes(nodes: &[Node], arc: &[f64]) -> Vec<[f64; 3]> {
    let (first, last) = (nodes[1], nodes.len() - 1);
    let slope = |i: usize, k: usize| {
        let at = |i: usize| nodes[i].fields()[k];
        let (before, h0) = match i {
            0 => (if k == 0 { -first.x } else { at(1) }, arc[1]),
            _ => (at(i - 1), arc[i] - arc[i - 1]),
        };
        let (after, h1) = match i {
            _ if i == last => (2.0 * at(i) - at(i - 1), h0),
            _ => (at(i + 1), arc[i + 1] - arc[i]),
        };
        (after - at(i)) / h1 * h0 / (h0 + h1) + (at(i) - before) / h0 * h1 / (h0 + h1)
    };
    (0..nodes.len()).map(|i| [0, 1, 2].map(|k| slope(i, k))).collect()
}

/// Distributes the nodes anew, by cubic Hermite interpolation: short elements where the liquid is thin.
fn regrid(nodes: &[Node], refinement: f64) -> Vec<Node> {
    let arc = arc(nodes);
    let slopes = slopes(nodes, &arc);
    let (shortest, longest) = ELEMENTS;
    // How many elements belong between the wall and each node.
    let mut count = vec![0.0];
    for (pair, arcs) in nodes.windows(2).zip(arc.windows(2)) {
        let depth = (pair[0].y + pair[1].y) / 2.0;
        let length = (ELEMENT_OVER_DEPTH * depth).clamp(shortest, longest) / refinement;
        count.push(count[count.len() - 1] + (arcs[1] - arcs[0]) / length);
    }
    let whole = count[count.len() - 1];
    let elements = whole.ceil();
    let mut anew: Vec<Node> = (0..=elements as usize)
        .map(|index| {
            let target = whole * index as f64 / elements;
            let i = count.partition_point(|&c| c < target).clamp(1, nodes.len() - 1) - 1;
            let s = ((target - count[i]) / (count[i + 1] - count[i])).clamp(0.0, 1.0);
            let length = arc[i + 1] - arc[i];
            let (a, b) = (nodes[i].fields(), nodes[i + 1].fields());
            Node::of([0, 1, 2].map(|k| {
                let (m0, m1) = (slopes[i][k] * length, slopes[i + 1][k] * length);
                let rest = 1.0 - s;
                rest * rest * ((1.0 + 2.0 * s) * a[k] + s * m0) + s * s * ((3.0 - 2.0 * s) * b[k] - rest * m1)
            }))
        })
        .collect();
    let last = anew.len() - 1;
    (anew[0].x, anew[last].y) = (0.0, 0.0);
    anew
}

/// Rates of x, y and the potential of each node, as it moves with the liquid.
fn rates(nodes: &[Node]) -> Vec<[f64; 3]> {
    let arc = arc(nodes);
    let outward = normal_velocity(nodes);
    let mut velocity: Vec<[f64; 2]> = slopes(nodes, &arc)
        .into_iter()
        .zip(outward)
        .map(|([x, y, potential], outward)| {
            let length = x.hypot(y);
            let (tx, ty, along) = (x / length, y / length, potential / length);
            [along * tx - outward * ty, along * ty + outward * tx]
        })
        .collect();
    let last = nodes.len() - 1;
    velocity[0][0] = 0.0;
    // At the tip the derivative along the surface is one-sided, and poor: half of what a straight line would say.
    let tip = velocity[last - 1][0] + 0.5 * (velocity[last - 1][0] - velocity[last - 2][0]);
    velocity[last] = [tip, 0.0];
    let bernoulli = |node: &Node, [u, v]: [f64; 2]| [u, v, 0.5 * (u * u + v * v) - node.y];
    nodes.iter().zip(velocity).map(|(node, velocity)| bernoulli(node, velocity)).collect()
}

/// Derivative of the potential along the outward normal, from Green's identity at each node.
fn normal_velocity(nodes: &[Node]) -> Vec<f64> {
    let count = nodes.len();
    let mut single = vec![vec![0.0; count]; count];
    let mut right = vec![0.0; count];
    for (i, node) in nodes.iter().enumerate() {
        let mut double = vec![0.0; count];
        for (sx, sy) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
            // To mirror the point is to mirror the elements.
            let point = [node.x * sx, node.y * sy];
            for element in 0..count - 1 {
                let (a, b) = (nodes[element], nodes[element + 1]);
                let [of_single, of_double] = influence(point, [a.x, a.y], [b.x, b.y]);
                for end in 0..2 {
                    single[i][element + end] += of_single[end];
                    double[element + end] += of_double[end];
                }
            }
        }
        // Less the potential here, so that the angle of the surface does not matter: a constant has no normal derivative.
        let share = |(share, other): (&f64, &Node)| share * (other.potential - node.potential);
        right[i] = double.iter().zip(nodes).map(share).sum();
    }
    solve(single, right)
}

/// Integrals of `ln r` and of its derivative along the outward normal over the element from `a` to `b`, outward on its left,
/// each times the two linear functions that are one at `a` and at `b`.
fn influence(point: [f64; 2], a: [f64; 2], b: [f64; 2]) -> [[f64; 2]; 2] {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let length = dx.hypot(dy);
    let (tx, ty) = (dx / length, dy / length);
    let (rx, ry) = (point[0] - a[0], point[1] - a[1]);
    // The point, along the element and along the outward normal.
    let (along, beside) = (rx * tx + ry * ty, ry * tx - rx * ty);
    let (to_a, to_b) = (along * along + beside * beside, (length - along).powi(2) + beside * beside);
    let log = |square: f64| 0.5 * square.max(1e-28).ln();
    let (log_a, log_b) = (log(to_a), log(to_b));
    // The angle under which the point sees the element; none from the element itself.
    let angle = if beside.abs() < 1e-14 {
        0.0
    } else {
        ((length - along) / beside.abs()).atan() + (along / beside.abs()).atan()
    };
    let whole = (length - along) * log_b + along * log_a - length + beside.abs() * angle;
    let moment = 0.5 * (to_b * log_b - to_a * log_a) - 0.25 * (to_b - to_a) + along * whole;
    let normal_whole = -beside.signum() * angle;
    let normal_moment = -beside * (log_b - log_a) + along * normal_whole;
    let ends = |whole: f64, moment: f64| [whole - moment / length, moment / length];
    [ends(whole, moment), ends(normal_whole, normal_moment)]
}

/// Solves `matrix x = right` by elimination with pivots in columns.
fn solve(mut matrix: Vec<Vec<f64>>, mut right: Vec<f64>) -> Vec<f64> {
    let count = right.len();
    for column in 0..count {
        let largest = |&a: &usize, &b: &usize| matrix[a][column].abs().total_cmp(&matrix[b][column].abs());
        let pivot = (column..count).max_by(largest).unwrap_or(column);
        matrix.swap(column, pivot);
        right.swap(column, pivot);
        let (above, below) = matrix.split_at_mut(column + 1);
        let lead = &above[column];
        for (offset, row) in below.iter_mut().enumerate() {
            let factor = row[column] / lead[column];
            row[column..].iter_mut().zip(&lead[column..]).for_each(|(value, lead)| *value -= factor * lead);
            right[column + 1 + offset] -= factor * right[column];
        }
    }
    for row in (0..count).rev() {
        let known: f64 = (row + 1..count).map(|column| matrix[row][column] * right[column]).sum();
        right[row] = (right[row] - known) / matrix[row][row];
    }
    right
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::martin_moyce_1952::{SQUARE, TALL};

    #[test]
    fn flow_in_a_corner_has_its_normal_velocity() {
        // x^2 - y^2 keeps to wall and floor; its derivative is 2 along the normal of x = 1 and -2 along that of y = 1.
        let at = |x: f64, y: f64| Node { x, y, potential: x * x - y * y };
        let top = (0..=40).map(|i| at(f64::from(i) / 40.0, 1.0));
        let side = (1..=40).map(|i| at(1.0, 1.0 - f64::from(i) / 40.0));
        let found = normal_velocity(&top.chain(side).collect::<Vec<_>>());
        assert!(found[..38].iter().all(|q| (q + 2.0).abs() < 0.01), "{found:?}");
        assert!(found[43..].iter().all(|q| (q - 2.0).abs() < 0.01), "{found:?}");
    }

    #[test]
    fn elimination_solves_what_needs_pivots() {
        let x = solve(vec![vec![0.0, 2.0, 1.0], vec![1.0, 1.0, 0.0], vec![3.0, 0.0, 1.0]], vec![7.0, 3.0, 6.0]);
        assert!(x.iter().zip([1.0, 2.0, 3.0]).all(|(x, expected)| (x - expected).abs() < 1e-12), "{x:?}");
    }

    #[test]
    fn heights_are_those_that_martin_and_moyce_measured() {
        for experiment in [&SQUARE, &TALL] {
            let end = experiment.heights.last().map_or(0.0, |point| point.0);
            let (Collapse { height: heights, .. }, area) = refined(experiment.aspect, end + 0.01, 1.0);
            assert!((area - 1.0).abs() < 0.02, "{area} of the area is left");
            let errors = experiment.heights.iter().map(|&(tau, height)| heights.at(tau).map(|found| found - height));
            let errors: Option<Vec<f64>> = errors.collect();
            let rms = |errors: Vec<f64>| (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
            let rms = errors.map(rms);
            assert!(rms.is_some_and(|rms| rms < 0.02), "{}: {rms:?}", experiment.name);
        }
    }

    #[test]
    fn shorter_elements_give_the_same_heights_and_fronts() {
        for (aspect, end) in [(1.0, 6.3), (2.0, 7.4)] {
            let [coarse, fine] = [1.0, 1.5].map(|refinement| refined(aspect, end, refinement).0);
            for tau in (1..=8).map(|i| end * f64::from(i) / 8.1) {
                let at = |curve: &Curve| curve.at(tau).unwrap_or(f64::NAN);
                let heights = [&coarse, &fine].map(|of| at(&of.height));
                assert!((heights[0] - heights[1]).abs() < 0.01, "n^2 = {aspect}, tau = {tau}: {heights:?}");
                let fronts = [&coarse, &fine].map(|of| at(&of.front));
                assert!((fronts[0] / fronts[1] - 1.0).abs() < 0.01, "n^2 = {aspect}, tau = {tau}: {fronts:?}");
            }
        }
    }
}
