//! Height fields.

use std::sync::{Arc, OnceLock};

use glam::Vec3;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::triangle_mesh::{MAX_TRIANGLES, TriangleMesh};
use crate::error::{InvalidInput, check_range};

/// Most heights of a field.
pub const MAX_HEIGHTS: usize = 1 << 20;

/// Ground over a rectangle around the origin, of heights on a grid, bilinear between them. Copies share their data.
///
/// ```
/// use freshet_core::prelude::*;
/// let slope = HeightField::new([4.0, 2.0], [2, 2], vec![0.0, 1.0, 0.0, 1.0])?;
/// assert_eq!(slope.height(0.0, 0.5), 0.5);
/// # Ok::<(), InvalidInput>(())
/// ```
#[derive(Clone)]
pub struct HeightField(Arc<Shared>);

struct Shared {
    data: Data,
    /// Made when it is first asked; it follows from the data.
    surface: OnceLock<TriangleMesh>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "HeightField")]
struct Data {
    size: [f32; 2],
    counts: [u32; 2],
    heights: Vec<f32>,
}

impl HeightField {
    /// A field of edge lengths `size` along x and z, m, 1e-5 to 1e6, with `counts` heights along x and z, at least 2 each; x runs
    /// fastest. Heights are along y, m, within 1e6.
    ///
    /// # Errors
    /// A number out of its range, a number of heights other than the product of the counts, or more than [`MAX_HEIGHTS`].
    pub fn new(size: [f32; 2], counts: [u32; 2], heights: Vec<f32>) -> Result<Self, InvalidInput> {
        let field = Self(Arc::new(Shared { data: Data { size, counts, heights }, surface: OnceLock::new() }));
        field.validate()?;
        Ok(field)
    }

    /// Edge lengths along x and z, m.
    pub fn size(&self) -> [f32; 2] {
        self.0.data.size
    }

    /// Number of heights along x and z.
    pub fn counts(&self) -> [u32; 2] {
        self.0.data.counts
    }

    /// Heights, m, x running fastest.
    pub fn heights(&self) -> &[f32] {
        &self.0.data.heights
    }

    /// Height at a place, m; beyond the edges that of the nearest edge.
    pub fn height(&self, x: f32, z: f32) -> f32 {
        let ([a, b, c, d], [u, v]) = self.cell(x, z);
        let (near, far) = (a + (b - a) * u, c + (d - c) * u);
        near + (far - near) * v
    }

    /// Unit normal of the bilinear surface at a place.
    pub fn normal(&self, x: f32, z: f32) -> Vec3 {
        let ([a, b, c, d], [u, v]) = self.cell(x, z);
        let [step_x, step_z] = self.steps();
        let along_x = ((b - a) * (1.0 - v) + (d - c) * v) / step_x;
        let along_z = ((c - a) * (1.0 - u) + (d - b) * u) / step_z;
        Vec3::new(-along_x, 1.0, -along_z).normalize_or(Vec3::Y)
    }

    /// Whether a place lies within the rectangle, or beyond it by less than `margin`, m.
    pub(crate) fn covers(&self, x: f32, z: f32, margin: f32) -> bool {
        let [size_x, size_z] = self.size();
        x.abs() <= 0.5 * size_x + margin && z.abs() <= 0.5 * size_z + margin
    }

    /// m.
    fn steps(&self) -> [f32; 2] {
        [0, 1].map(|axis| self.size()[axis] / (self.counts()[axis].max(2) - 1) as f32)
    }

    /// The four heights around a place, and where between them it is, 0 to 1.
    fn cell(&self, x: f32, z: f32) -> ([f32; 4], [f32; 2]) {
        let (size, counts, steps) = (self.size(), self.counts(), self.steps());
        let split = |axis: usize, at: f32| {
            let last = counts[axis].max(2) - 2;
            let along = ((at + 0.5 * size[axis]) / steps[axis]).clamp(0.0, (last + 1) as f32);
            let index = (along as u32).min(last);
            (index as usize, along - index as f32)
        };
        let ((i, u), (j, v)) = (split(0, x), split(1, z));
        let at = |i: usize, j: usize| self.heights()[j * counts[0] as usize + i];
        ([at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)], [u, v])
    }

    /// The surface as triangles that face up. Warped cells are cut until these are within a hundredth of a cell's edge of it, or
    /// into 128, or as many as a mesh may have.
    pub(crate) fn surface(&self) -> &TriangleMesh {
        self.0.surface.get_or_init(|| {
            let (counts, steps) = (self.counts(), self.steps());
            let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
            let tolerance = 0.01 * steps[0].min(steps[1]);
            let cells = f64::from(counts[0] - 1) * f64::from(counts[1] - 1);
            let most = ((MAX_TRIANGLES as f64 / (2.0 * cells)).sqrt() as u32).clamp(1, 8);
            for j in 0..counts[1] - 1 {
                for i in 0..counts[0] - 1 {
                    let corner = [i, j].map(|index| index as f32);
                    let low = [0, 1].map(|axis| corner[axis] * steps[axis] - 0.5 * self.size()[axis]);
                    let at = |u: f32, v: f32| {
                        let (x, z) = (low[0] + u * steps[0], low[1] + v * steps[1]);
                        let ([a, b, c, d], _) = self.cell(low[0] + 0.5 * steps[0], low[1] + 0.5 * steps[1]);
                        let (near, far) = (a + (b - a) * u, c + (d - c) * u);
                        Vec3::new(x, near + (far - near) * v, z)
                    };
                    let warp = (at(0.0, 0.0) - at(1.0, 0.0) - at(0.0, 1.0) + at(1.0, 1.0)).y.abs();
                    // Two triangles miss a warped cell by a quarter of this in its middle.
                    let parts = ((0.25 * warp / tolerance).sqrt().ceil() as u32).clamp(1, most);
                    let first = vertices.len() as u32;
                    let along = || (0..=parts).map(|index| index as f32 / parts as f32);
                    vertices.extend(along().flat_map(|v| along().map(move |u| (u, v))).map(|(u, v)| at(u, v)));
                    for row in 0..parts {
                        for column in 0..parts {
                            let a = first + row * (parts + 1) + column;
                            let (b, c, d) = (a + 1, a + parts + 1, a + parts + 2);
                            triangles.extend([[a, c, b], [b, c, d]]);
                        }
                    }
                }
            }
            TriangleMesh::unchecked(vertices, triangles)
        })
    }

    /// Checks every number.
    pub(crate) fn validate(&self) -> Result<(), InvalidInput> {
        for size in self.size() {
            check_range("size", size, 1e-5, 1e6, "m")?;
        }
        let [along_x, along_z] = self.counts().map(u64::from);
        if along_x < 2 || along_z < 2 || along_x.saturating_mul(along_z) > MAX_HEIGHTS as u64 {
            let allowed = format!("at least 2 along each axis, up to {MAX_HEIGHTS} in all");
            return Err(InvalidInput::new("counts", format_args!("{along_x} x {along_z}"), allowed));
        }
        if self.heights().len() as u64 != along_x * along_z {
            let value = format!("{} of them", self.heights().len());
            return Err(InvalidInput::new("heights", value, format_args!("{}, as counts say", along_x * along_z)));
        }
        for (index, &height) in self.heights().iter().enumerate() {
            check_range("height", height, -1e6, 1e6, "m")
                .map_err(|error| InvalidInput { field: format!("heights[{index}]"), ..error })?;
        }
        Ok(())
    }
}

impl PartialEq for HeightField {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.0.data == other.0.data
    }
}

impl std::fmt::Debug for HeightField {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("HeightField").field("size", &self.size()).field("counts", &self.counts()).finish()
    }
}

impl Serialize for HeightField {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.data.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for HeightField {
    /// Numbers are checked with those of the scene, where their line is known.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let data = Data::deserialize(deserializer)?;
        Ok(Self(Arc::new(Shared { data, surface: OnceLock::new() })))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_and_normals_are_bilinear() {
        let field = HeightField::new([2.0, 4.0], [3, 2], vec![0.0, 1.0, 3.0, 2.0, 2.0, 2.0]).unwrap();
        assert_eq!(field.height(-1.0, -2.0), 0.0);
        assert_eq!(field.height(1.0, -2.0), 3.0);
        assert_eq!(field.height(-0.5, 0.0), 1.25, "the mean of 0, 1, 2 and 2");
        assert_eq!(field.height(9.0, 9.0), 2.0, "beyond the edges that of the edge");
        // In the middle of a cell the slopes are means of those of its edges: 0.5 along x, 0.375 along z.
        let normal = field.normal(-0.5, 0.0);
        assert!(normal.distance(Vec3::new(-0.5, 1.0, -0.375).normalize()) < 1e-6, "{normal}");
        for point in field.surface().vertices() {
            assert!((field.height(point.x, point.z) - point.y).abs() < 1e-5);
        }
        for [a, b, c] in field.surface().corners() {
            assert!((b - a).cross(c - a).y > 0.0, "triangles face up");
            let middle = (a + b + c) / 3.0;
            assert!((field.height(middle.x, middle.z) - middle.y).abs() < 0.01);
        }
    }

    #[test]
    fn bad_fields_are_refused_with_the_field() {
        let refused = |size, counts, heights| HeightField::new(size, counts, heights).unwrap_err().to_string();
        assert!(refused([0.0, 1.0], [2, 2], vec![0.0; 4]).starts_with("size: 0 is not allowed"));
        assert!(refused([1.0, f32::NAN], [2, 2], vec![0.0; 4]).starts_with("size: NaN"));
        assert!(refused([1.0, 1.0], [1, 4], vec![0.0; 4]).starts_with("counts: 1 x 4"));
        assert!(refused([1.0, 1.0], [u32::MAX, u32::MAX], vec![]).starts_with("counts: "));
        assert!(refused([1.0, 1.0], [2, 3], vec![0.0; 4]).starts_with("heights: 4 of them is not allowed; allowed: 6"));
        assert!(refused([1.0, 1.0], [2, 2], vec![0.0, 0.0, f32::NAN, 0.0]).starts_with("heights[2]: NaN"));
    }
}
