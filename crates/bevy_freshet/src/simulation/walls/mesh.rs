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

#[cfg(test)]
mod tests {
    use super::*;

    const KEPT: RenderAssetUsages = RenderAssetUsages::MAIN_WORLD;

    /// A square of two triangles, facing +z.
    fn square(topology: PrimitiveTopology, order: &[usize]) -> Mesh {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0f32]];
        let corners: Vec<[f32; 3]> = order.iter().map(|&corner| corners[corner]).collect();
        Mesh::new(topology, KEPT).with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners)
    }

    /// Corners of the triangles of a mesh.
    fn corners(mesh: &Mesh) -> Vec<[Vec3; 3]> {
        let (vertices, triangles) = triangles(mesh).unwrap();
        triangles.iter().map(|triangle| triangle.map(|index| vertices[index as usize])).collect()
    }

    fn made(mesh: impl Into<Mesh>, stretch: Mat3) -> TriangleMesh {
        let (vertices, triangles) = triangles(&mesh.into()).unwrap();
        stretched(vertices, triangles, stretch).unwrap()
    }

    #[test]
    fn lists_and_strips_are_the_same_triangles() {
        use PrimitiveTopology::{TriangleList, TriangleStrip};
        let each = [0, 1, 2, 2, 1, 3];
        let wanted = corners(&square(TriangleList, &each));
        assert_eq!(wanted.len(), 2);
        let all = [0, 1, 2, 3];
        let is_same = |mesh: Mesh| {
            let found = corners(&mesh);
            // A triangle may begin with any of its corners.
            let same =
                |a: [Vec3; 3], b: [Vec3; 3]| (0..3).any(|turn| [a[turn], a[(turn + 1) % 3], a[(turn + 2) % 3]] == b);
            assert!(found.len() == 2 && found.iter().zip(&wanted).all(|(a, b)| same(*a, *b)), "{found:?}");
        };
        let small = each.iter().map(|&corner| corner as u16).collect();
        is_same(square(TriangleList, &all).with_inserted_indices(Indices::U16(small)));
        let large = each.iter().map(|&corner| corner as u32).collect();
        is_same(square(TriangleList, &all).with_inserted_indices(Indices::U32(large)));
        is_same(square(TriangleStrip, &all));
        is_same(square(TriangleStrip, &all).with_inserted_indices(Indices::U32(vec![0, 1, 2, 3])));
        let restarted = vec![0, 1, 2, u16::MAX, 2, 1, 3];
        is_same(square(TriangleStrip, &all).with_inserted_indices(Indices::U16(restarted)));
        let restarted = vec![0, 1, 2, u32::MAX, 2, 1, 3];
        is_same(square(TriangleStrip, &all).with_inserted_indices(Indices::U32(restarted)));
    }

    #[test]
    fn meshes_that_look_closed_are_closed() {
        let ball = Sphere::new(0.7);
        for (name, mesh) in [
            ("box", Mesh::from(Cuboid::new(1.0, 2.0, 3.0))),
            ("ball", ball.mesh().ico(5).unwrap()),
            ("ball of meridians", ball.mesh().uv(31, 17)),
            ("cylinder", Cylinder::new(0.3, 1.0).into()),
            ("capsule", Capsule3d::new(0.3, 1.0).into()),
            ("cone", Cone::new(0.3, 1.0).into()),
            ("ring", Torus::new(0.2, 0.9).into()),
        ] {
            for offset in [Vec3::ZERO, Vec3::splat(20.0)] {
                assert!(made(mesh.clone().translated_by(offset), Mat3::IDENTITY).is_closed(), "{name} at {offset}");
            }
        }
        assert!(!made(Plane3d::new(Vec3::Y, Vec2::ONE), Mat3::IDENTITY).is_closed());
    }

    #[test]
    fn scales_go_into_the_vertices() {
        let scale = Vec3::new(0.1, 3.0, 0.5);
        let scaled = made(Cuboid::new(1.0, 1.0, 1.0), Mat3::from_diagonal(scale));
        let mut corners = scaled.vertices().to_vec();
        corners.iter_mut().for_each(|corner| *corner = (*corner / (0.5 * scale)).abs());
        assert!(corners.iter().all(|corner| corner.distance(Vec3::ONE) < 1e-6), "{corners:?}");
        // Mirrored, it still faces outwards.
        for stretch in [Mat3::from_diagonal(scale), Mat3::from_diagonal(-scale)] {
            let winding = made(Cuboid::new(1.0, 1.0, 1.0), stretch).winding_number(Vec3::ZERO);
            assert!((winding - 1.0).abs() < 0.03, "{winding}");
        }
    }

    #[test]
    fn meshes_without_triangles_are_refused_with_the_reason() {
        let refused = |mesh: Mesh| {
            let made =
                triangles(&mesh).and_then(|(vertices, triangles)| stretched(vertices, triangles, Mat3::IDENTITY));
            made.unwrap_err().to_string()
        };
        let list = || square(PrimitiveTopology::TriangleList, &[0, 1, 2, 2, 1, 3]);
        for topology in [PrimitiveTopology::PointList, PrimitiveTopology::LineList, PrimitiveTopology::LineStrip] {
            let said = refused(square(topology, &[0, 1, 2]));
            let wanted =
                format!("primitive_topology: {topology:?} is not allowed; allowed: TriangleList or TriangleStrip");
            assert_eq!(said, wanted);
        }
        assert!(refused(square(PrimitiveTopology::TriangleList, &[0, 1, 2, 3])).starts_with("corners: 4 of them"));
        assert!(refused(square(PrimitiveTopology::TriangleStrip, &[0, 1])).starts_with("triangles: 0 of them"));
        assert!(refused(list().with_inserted_indices(Indices::U32(vec![0, 1, 6]))).starts_with("triangles[0]: 6"));
        let empty = Mesh::new(PrimitiveTopology::TriangleList, KEPT);
        assert!(refused(empty.clone()).starts_with("ATTRIBUTE_POSITION: none"));
        let flat = empty.with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, vec![[0.0f32, 0.0]; 3]);
        assert!(refused(flat).starts_with("ATTRIBUTE_POSITION: none"));
        let nowhere = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [f32::NAN, 0.0, 0.0f32]];
        let nowhere =
            Mesh::new(PrimitiveTopology::TriangleList, KEPT).with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, nowhere);
        assert!(refused(nowhere).starts_with("vertices[2]"));
        let mut elsewhere = list();
        elsewhere.asset_usage = RenderAssetUsages::RENDER_WORLD;
        assert!(refused(elsewhere).contains("MAIN_WORLD"));
        let mut gone = list();
        gone.take_gpu_data().unwrap();
        assert!(refused(gone).starts_with("data: "));
    }
}
