//! Where the triangles of a wall come from.

use bevy::prelude::*;
use freshet_core::geometry::TriangleMesh;

/// Triangles of a [`FluidBoundaryShape`](super::boundary::FluidBoundaryShape).
#[derive(Clone, Debug, PartialEq, Reflect)]
#[reflect(Clone, Debug, PartialEq)]
pub enum FluidMesh {
    /// A mesh of Bevy's: a triangle list or strip with positions of `Float32x3`, kept in the main world
    /// (`RenderAssetUsages::MAIN_WORLD`). It may load later. What bends it when it is drawn (skins, morph targets) does not count.
    Asset(Handle<Mesh>),
    /// The triangles themselves, which needs no assets: for servers, and for scenes from files.
    Triangles {
        /// Vertices, m, within 1e6 of the centre.
        vertices: Vec<Vec3>,
        /// For each triangle the indices of its three; seen from in front they go round counter-clockwise.
        triangles: Vec<[u32; 3]>,
    },
}

impl From<Handle<Mesh>> for FluidMesh {
    fn from(mesh: Handle<Mesh>) -> Self {
        Self::Asset(mesh)
    }
}

impl From<&TriangleMesh> for FluidMesh {
    fn from(mesh: &TriangleMesh) -> Self {
        Self::Triangles { vertices: mesh.vertices().to_vec(), triangles: mesh.triangles().to_vec() }
    }
}
