//! Shapes of walls as geometry: meshes, height fields, bodies of revolution, convex hulls, and distances from them.
//!
//! What a shape needs for a scene is two questions: which point of its surface is nearest, and on which side of it a point is.
//! Everything is in the shape's own axes, in metres; placing it in the world is up to the caller.

mod convex_hull;
mod height_field;
pub(crate) mod mesh_tree;
pub(crate) mod round;
mod triangle;
mod triangle_mesh;

pub use self::convex_hull::{MAX_HULL_POINTS, convex_hull};
pub use self::height_field::{HeightField, MAX_HEIGHTS};
pub(crate) use self::triangle::nearest_on_triangle;
pub use self::triangle_mesh::{MAX_TRIANGLES, TriangleMesh};
