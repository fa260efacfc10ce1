//! Triangle meshes.

use std::sync::{Arc, OnceLock};

use glam::{DVec3, Vec3};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::mesh_tree::MeshTree;
use crate::error::InvalidInput;
use crate::scene::check_position;

/// Most triangles of a mesh, and most vertices.
pub const MAX_TRIANGLES: usize = 4 << 20;

/// Triangles between vertices. No manifold is demanded: edges may be shared by any number of triangles, triangles may cross,
/// repeat, or have no area, vertices may be unused.
///
/// Copies share their data. Seen from in front of a triangle its corners go round counter-clockwise.
///
/// ```
/// use freshet_core::prelude::*;
/// let mesh = TriangleMesh::new(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]])?;
/// assert!(!mesh.is_closed());
/// # Ok::<(), InvalidInput>(())
/// ```
#[derive(Clone)]
pub struct TriangleMesh(Arc<Shared>);

struct Shared {
    data: Data,
    /// Both are worked out when they are first asked; they follow from the data.
    tree: OnceLock<MeshTree>,
    is_closed: OnceLock<bool>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "TriangleMesh")]
struct Data {
    vertices: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

impl TriangleMesh {
    /// A mesh of vertices, m, and for each triangle the indices of its three.
    ///
    /// # Errors
    /// No triangle, or more than [`MAX_TRIANGLES`] of them or of vertices; a vertex that is not within 1e6 m of the origin; an
    /// index without a vertex.
    pub fn new(vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Result<Self, InvalidInput> {
        let mesh = Self::unchecked(vertices, triangles);
        mesh.validate()?;
        Ok(mesh)
    }

    /// A mesh without indices: each three vertices, m, are a triangle.
    ///
    /// # Errors
    /// As [`new`](Self::new); a number of vertices that is no multiple of three.
    pub fn from_soup(vertices: Vec<Vec3>) -> Result<Self, InvalidInput> {
        if !vertices.len().is_multiple_of(3) {
            return Err(InvalidInput::new("vertices", vertices.len(), "a multiple of three"));
        }
        let triangles = 0..vertices.len().min(3 * MAX_TRIANGLES + 3) as u32 / 3;
        let triangles = triangles.map(|index| [3 * index, 3 * index + 1, 3 * index + 2]).collect();
        Self::new(vertices, triangles)
    }

    pub(super) fn unchecked(vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Self {
        Self(Arc::new(Shared { data: Data { vertices, triangles }, tree: OnceLock::new(), is_closed: OnceLock::new() }))
    }

    /// Vertices, m.
    pub fn vertices(&self) -> &[Vec3] {
        &self.0.data.vertices
    }

    /// For each triangle the indices of its vertices.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.0.data.triangles
    }

    /// Corners of each triangle, m.
    pub(crate) fn corners(&self) -> impl Iterator<Item = [Vec3; 3]> {
        self.triangles().iter().map(|triangle| triangle.map(|index| self.vertices()[index as usize]))
    }

    /// Sum of the areas of all triangles, m2.
    pub fn area(&self) -> f64 {
        let area = |[a, b, c]: [Vec3; 3]| 0.5 * (b - a).as_dvec3().cross((c - a).as_dvec3()).length();
        self.corners().map(area).sum()
    }

    /// Lowest and highest corner of the box around all triangles, m.
    pub(crate) fn bounds(&self) -> (Vec3, Vec3) {
        self.tree().bounds()
    }

    /// Whether it encloses space: its edges in one direction meet as many in the other, vertices in one place being one.
    ///
    /// Triangles with two corners in one place do not count. A mesh with a hole, however small, is not closed.
    pub fn is_closed(&self) -> bool {
        *self.0.is_closed.get_or_init(|| self.has_balanced_edges())
    }

    fn has_balanced_edges(&self) -> bool {
        // Zero has two signs.
        let key = |corner: Vec3| (corner + 0.0).to_array().map(f32::to_bits);
        let mut edges: Vec<([[u32; 3]; 2], i32)> = Vec::with_capacity(3 * self.triangles().len());
        for corners in self.corners() {
            let keys = corners.map(key);
            if keys[0] == keys[1] || keys[1] == keys[2] || keys[2] == keys[0] {
                continue;
            }
            for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                let (a, b) = (keys[a], keys[b]);
                edges.push(if a < b { ([a, b], 1) } else { ([b, a], -1) });
            }
        }
        edges.sort_unstable();
        let is_balanced = |edge: &[([[u32; 3]; 2], i32)]| edge.iter().map(|(_, way)| way).sum::<i32>() == 0;
        !edges.is_empty() && edges.chunk_by(|a, b| a.0 == b.0).all(is_balanced)
    }

    /// How often the surface goes around a point (generalised winding number, Jacobson et al. 2013), good to 0.02: 1 inside of a
    /// closed mesh whose triangles face outwards, -1 if they face inwards, 0 outside.
    pub fn winding_number(&self, point: Vec3) -> f32 {
        self.tree().winding_number(point.as_dvec3()) as f32
    }

    /// Whether a point is inside: the surface goes round it more than half a time, either way round.
    pub fn is_inside(&self, point: Vec3) -> bool {
        self.encloses(point.as_dvec3())
    }

    pub(crate) fn encloses(&self, point: DVec3) -> bool {
        self.tree().winding_number(point).abs() > 0.5
    }

    /// The point of the surface that is nearest to another, if nearer than `limit`, m.
    pub(crate) fn nearest(&self, point: DVec3, limit: f64) -> Option<DVec3> {
        self.tree().nearest(point, limit)
    }

    /// The tree of its triangles.
    pub(crate) fn tree(&self) -> &MeshTree {
        self.0.tree.get_or_init(|| MeshTree::new(self.corners().collect()))
    }

    /// Checks every number.
    pub(crate) fn validate(&self) -> Result<(), InvalidInput> {
        let (vertices, triangles) = (self.vertices(), self.triangles());
        for (field, count) in [("vertices", vertices.len()), ("triangles", triangles.len())] {
            if count == 0 || count > MAX_TRIANGLES {
                return Err(InvalidInput::new(
                    field,
                    format_args!("{count} of them"),
                    format_args!("1 to {MAX_TRIANGLES}"),
                ));
            }
        }
        for (index, &vertex) in vertices.iter().enumerate() {
            check_position("vertex", vertex)
                .map_err(|error| InvalidInput { field: format!("vertices[{index}]"), ..error })?;
        }
        for (index, triangle) in triangles.iter().enumerate() {
            if let Some(corner) = triangle.iter().find(|corner| **corner as usize >= vertices.len()) {
                let allowed = format!("0 to {}, an index of a vertex", vertices.len() - 1);
                return Err(InvalidInput::new(format_args!("triangles[{index}]"), corner, allowed));
            }
        }
        Ok(())
    }
}

impl PartialEq for TriangleMesh {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.0.data == other.0.data
    }
}

impl std::fmt::Debug for TriangleMesh {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("TriangleMesh")
            .field("vertices", &self.vertices().len())
            .field("triangles", &self.triangles().len())
            .finish()
    }
}

impl Serialize for TriangleMesh {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.data.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for TriangleMesh {
    /// Numbers are checked with those of the scene, where their line is known.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Data::deserialize(deserializer).map(|data| Self::unchecked(data.vertices, data.triangles))
    }
}
