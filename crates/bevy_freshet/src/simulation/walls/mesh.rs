//! Triangles of Bevy's meshes.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, MeshAccessError, PrimitiveTopology, VertexAttributeValues};
use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use freshet_core::error::InvalidInput;
use freshet_core::geometry::TriangleMesh;

/// Distance over the size of a mesh up to which vertices are one. The seam of a sphere of Bevy's, at the sines of 0 and of a full
/// turn, gapes by 1e-7 of its size, and would make it an open surface.
const SAME_VERTEX: f32 = 1e-6;

/// Positions of a mesh, m.
pub(super) fn vertices(mesh: &Mesh) -> Result<Vec<Vec3>, InvalidInput> {
    let usage = mesh.asset_usage;
    if !usage.contains(RenderAssetUsages::MAIN_WORLD) {
        return Err(InvalidInput::new("asset_usage", format_args!("{usage:?}"), "one with MAIN_WORLD"));
    }
    let allowed = "Float32x3";
    match mesh.try_attribute_option(Mesh::ATTRIBUTE_POSITION).map_err(gone)? {
        Some(VertexAttributeValues::Float32x3(positions)) => Ok(positions.iter().copied().map(Vec3::from).collect()),
        Some(other) => {
            Err(InvalidInput::new("ATTRIBUTE_POSITION", format_args!("{:?}", VertexFormatName(other)), allowed))
        }
        None => Err(InvalidInput::new("ATTRIBUTE_POSITION", "none", allowed)),
    }
}

/// Positions of a mesh, m, and its triangles.
pub(super) fn triangles(mesh: &Mesh) -> Result<(Vec<Vec3>, Vec<[u32; 3]>), InvalidInput> {
    let topology = mesh.primitive_topology();
    if !matches!(topology, PrimitiveTopology::TriangleList | PrimitiveTopology::TriangleStrip) {
        let allowed = "TriangleList or TriangleStrip";
        return Err(InvalidInput::new("primitive_topology", format_args!("{topology:?}"), allowed));
    }
    let vertices = vertices(mesh)?;
    // In a strip the largest index begins a new one.
    let (indices, restart) = match mesh.try_indices_option().map_err(gone)? {
        None => ((0..vertices.len() as u32).collect(), None),
        Some(Indices::U16(indices)) => (indices.iter().copied().map(u32::from).collect(), Some(u32::from(u16::MAX))),
        Some(Indices::U32(indices)) => (indices.clone(), Some(u32::MAX)),
    };
    let indices: Vec<u32> = indices;
    let triangles = if topology == PrimitiveTopology::TriangleStrip {
        indices.split(|index| Some(*index) == restart).flat_map(strip).collect()
    } else {
        let (triangles, rest) = indices.as_chunks::<3>();
        if !rest.is_empty() {
            return Err(InvalidInput::new("corners", format_args!("{} of them", indices.len()), "a multiple of three"));
        }
        triangles.to_vec()
    };
    Ok((vertices, triangles))
}

/// Every second triangle of a strip goes round the other way.
fn strip(indices: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    indices.windows(3).enumerate().map(|(place, corners)| {
        let [a, b, c] = [corners[0], corners[1], corners[2]];
        if place % 2 == 0 { [a, b, c] } else { [b, a, c] }
    })
}

/// The model's mesh of triangles whose vertices are stretched. Where that mirrors them they go round the other way.
pub(super) fn stretched(
    vertices: Vec<Vec3>,
    mut triangles: Vec<[u32; 3]>,
    stretch: Mat3,
) -> Result<TriangleMesh, InvalidInput> {
    let is_sound = |corner: &u32| vertices.get(*corner as usize).is_some();
    // What is not, the model refuses, naming the place.
    if vertices.iter().all(|vertex| vertex.is_finite()) && triangles.iter().flatten().all(is_sound) {
        weld(&vertices, &mut triangles);
    }
    if stretch.determinant() < 0.0 {
        triangles.iter_mut().for_each(|[a, b, _]| std::mem::swap(a, b));
    }
    let vertices = if stretch == Mat3::IDENTITY {
        vertices
    } else {
        vertices.into_iter().map(|vertex| stretch * vertex).collect()
    };
    TriangleMesh::new(vertices, triangles)
}

/// Lets triangles share a vertex where theirs are as near as rounding makes them. Numbers of vertices stay as they are.
fn weld(vertices: &[Vec3], triangles: &mut [[u32; 3]]) {
    let low = vertices.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = vertices.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    let tolerance = SAME_VERTEX * (high - low).max_element();
    let is_useful = tolerance > 0.0 && tolerance.is_finite();
    if !is_useful {
        return;
    }
    // Much larger than the tolerance, so that most points have one cell to look at.
    let edge = 16.0 * tolerance;
    let cell = |point: Vec3| ((point - low) / edge).floor().as_ivec3();
    let mut cells: HashMap<IVec3, Vec<u32>> = HashMap::with_capacity(vertices.len());
    let mut stands_for: Vec<u32> = Vec::with_capacity(vertices.len());
    for (index, &vertex) in (0..).zip(vertices) {
        let (first, last) = (cell(vertex - tolerance), cell(vertex + tolerance));
        let around = (first.x..=last.x)
            .flat_map(|x| (first.y..=last.y).flat_map(move |y| (first.z..=last.z).map(move |z| IVec3::new(x, y, z))));
        let same = around
            .filter_map(|cell| cells.get(&cell))
            .flatten()
            .copied()
            .find(|&other| vertices[other as usize].distance_squared(vertex) <= tolerance * tolerance);
        if same.is_none() {
            cells.entry(cell(vertex)).or_default().push(index);
        }
        stands_for.push(same.unwrap_or(index));
    }
    triangles.iter_mut().flatten().for_each(|corner| *corner = stands_for[*corner as usize]);
}

fn gone(error: MeshAccessError) -> InvalidInput {
    InvalidInput::new("data", error, "a mesh whose data is in the main world")
}

/// Prints the format of values instead of all of them.
struct VertexFormatName<'a>(&'a VertexAttributeValues);

impl std::fmt::Debug for VertexFormatName<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:?}", bevy::mesh::VertexFormat::from(self.0))
    }
}
