//! Walls that are made of a mesh, heights or an image: made once, and again when their source, their scale or their component
//! changes.

mod ground;
mod hull;
mod mesh;
pub(crate) mod stretch;

use bevy::asset::{AssetLoadFailedEvent, LoadState};
use bevy::ecs::change_detection::Tick;
use bevy::ecs::message::MessageCursor;
use bevy::ecs::system::SystemParam;
use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use freshet_core::error::InvalidInput;
use freshet_core::geometry::HeightField;
use freshet_core::scene::BoundaryShape;

use crate::components::boundary::{FluidBoundary, FluidBoundaryShape};
use crate::components::boundary_mesh::FluidMesh;
use stretch::is_same_stretch;

/// What a shape is made of. Handles of an id are all the same to it, so that a hundred rocks of one mesh and scale are made once.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Source {
    Mesh(AssetId<Mesh>),
    Hull(AssetId<Mesh>),
    Image(AssetId<Image>),
    /// The numbers are in the component of this entity.
    Own(Entity),
}

impl Source {
    fn of(entity: Entity, shape: &FluidBoundaryShape) -> Self {
        match shape {
            FluidBoundaryShape::Mesh { mesh: FluidMesh::Asset(handle), .. } => Self::Mesh(handle.id()),
            FluidBoundaryShape::ConvexHull { mesh: FluidMesh::Asset(handle) } => Self::Hull(handle.id()),
            FluidBoundaryShape::HeightImage { image, .. } => Self::Image(image.id()),
            _ => Self::Own(entity),
        }
    }
}

/// What was made of a source.
#[derive(Default)]
struct Made {
    /// By scale, in the order in which they were first asked for.
    shapes: Vec<MadeShape>,
    is_used: bool,
}

struct MadeShape {
    stretch: Mat3,
    /// When the component was written, if the numbers are in it.
    written: Option<Tick>,
    /// What was made, or what is wrong with the source.
    shape: Result<BoundaryShape, String>,
    /// The source has changed since.
    is_stale: bool,
    is_used: bool,
}

/// The shapes made so far, and still in use.
#[derive(Resource, Default)]
pub(crate) struct WallShapes {
    made: HashMap<Source, Made>,
    has_news: bool,
    #[cfg(test)]
    conversions: u32,
}

/// What comes of a wall.
pub(crate) enum Found {
    Shape(BoundaryShape),
    /// Its mesh or image is not there yet.
    Waits,
    Wrong(String),
}

impl WallShapes {
    /// Whether the source of a wall has come, changed or failed since the last planning.
    pub(crate) fn has_news(&self) -> bool {
        self.has_news
    }

    /// How often a shape has been made.
    #[cfg(test)]
    pub(crate) fn conversions(&self) -> u32 {
        self.conversions
    }

    /// Begins a planning.
    pub(crate) fn begin(&mut self) {
        self.has_news = false;
    }

    /// The shape of a wall whose vertices are to be stretched first.
    pub(crate) fn find(
        &mut self,
        entity: Entity,
        boundary: &Ref<FluidBoundary>,
        stretch: Mat3,
        assets: &WallAssets,
    ) -> Found {
        let source = Source::of(entity, &boundary.shape);
        let written = matches!(source, Source::Own(_)).then(|| boundary.last_changed());
        let stretch = match boundary.shape {
            FluidBoundaryShape::HeightImage { size, height, .. } => {
                Mat3::from_diagonal(Vec3::new(size.x, height, size.y))
            }
            _ => stretch,
        };
        let made = self.made.entry(source).or_default();
        made.is_used = true;
        let place = made.shapes.iter().position(|made| is_same_stretch(stretch, made.stretch));
        let old = place.map(|place| &mut made.shapes[place]);
        if let Some(old) = old {
            old.is_used = true;
            if !old.is_stale && old.written == written {
                return old.found(boundary);
            }
            if let Some(shape) = make(&boundary.shape, stretch, assets) {
                // An equal one is kept, with the search tree that planning has made for it.
                if shape != old.shape {
                    old.shape = shape;
                }
                (old.written, old.is_stale) = (written, false);
            }
            // What is no longer there leaves the wall as it is.
            let found = old.found(boundary);
            self.count();
            return found;
        }
        let Some(shape) = make(&boundary.shape, stretch, assets) else { return Found::Waits };
        let new = MadeShape { stretch, written, shape, is_stale: false, is_used: true };
        let found = new.found(boundary);
        made.shapes.push(new);
        self.count();
        found
    }

    /// Ends a planning: what it did not ask for is forgotten.
    pub(crate) fn drop_unused(&mut self) {
        self.made.retain(|_, made| {
            made.shapes.retain_mut(|shape| std::mem::take(&mut shape.is_used));
            std::mem::take(&mut made.is_used)
        });
    }

    fn notice(&mut self, source: Source) {
        if let Some(made) = self.made.get_mut(&source) {
            made.shapes.iter_mut().for_each(|shape| shape.is_stale = true);
            self.has_news = true;
        }
    }

    fn count(&mut self) {
        #[cfg(test)]
        {
            self.conversions += 1;
        }
    }
}

impl MadeShape {
    fn found(&self, boundary: &FluidBoundary) -> Found {
        match (&self.shape, &boundary.shape) {
            // A mesh is made once for all sides.
            (Ok(BoundaryShape::Mesh { mesh, .. }), FluidBoundaryShape::Mesh { fluid, .. }) => {
                Found::Shape(BoundaryShape::Mesh { mesh: mesh.clone(), fluid: fluid.map(Into::into) })
            }
            (Ok(shape), _) => Found::Shape(shape.clone()),
            (Err(message), _) => Found::Wrong(message.clone()),
        }
    }
}

/// Makes a shape; none if its source is not there yet.
fn make(shape: &FluidBoundaryShape, stretch: Mat3, assets: &WallAssets) -> Option<Result<BoundaryShape, String>> {
    let made = match shape {
        FluidBoundaryShape::Mesh { mesh, .. } => assets.triangles(mesh)?.and_then(|(vertices, triangles)| {
            let mesh = mesh::stretched(vertices, triangles, stretch).map_err(|error| error.inside("shape.mesh"))?;
            Ok(BoundaryShape::Mesh { mesh, fluid: None })
        }),
        FluidBoundaryShape::ConvexHull { mesh } => assets.vertices(mesh)?.and_then(|vertices| {
            let points = vertices.into_iter().map(|vertex| stretch * vertex).collect();
            let points = hull::hull_points(points).map_err(|error| error.inside("shape.mesh"))?;
            Ok(BoundaryShape::ConvexHull { points })
        }),
        FluidBoundaryShape::HeightField { size, counts, heights } => {
            let field = HeightField::new(size.to_array(), counts.to_array(), heights.clone());
            field.map(|field| BoundaryShape::HeightField { field }).map_err(|error| error.inside("shape"))
        }
        FluidBoundaryShape::HeightImage { image, size, height } => assets.image(image)?.and_then(|image| {
            let field = ground::height_field(image, *size, *height).map_err(|error| error.inside("shape"))?;
            Ok(BoundaryShape::HeightField { field })
        }),
        // Others are not made of anything.
        other => other.to_model().ok_or_else(|| InvalidInput::new("shape", "this shape", "another one")),
    };
    Some(made.map_err(|error| error.to_string()))
}

/// Bevy's assets, where the app has any.
#[derive(SystemParam)]
pub(crate) struct WallAssets<'w> {
    meshes: Option<Res<'w, Assets<Mesh>>>,
    images: Option<Res<'w, Assets<Image>>>,
    server: Option<Res<'w, AssetServer>>,
}

/// None as long as the asset is not there.
type Loaded<T> = Option<Result<T, InvalidInput>>;

impl WallAssets<'_> {
    fn triangles(&self, mesh: &FluidMesh) -> Loaded<(Vec<Vec3>, Vec<[u32; 3]>)> {
        Some(match mesh {
            FluidMesh::Triangles { vertices, triangles } => Ok((vertices.clone(), triangles.clone())),
            FluidMesh::Asset(handle) => {
                let mesh = get(handle, self.meshes.as_deref(), self.server.as_deref(), "shape.mesh")?;
                mesh.and_then(|mesh| mesh::triangles(mesh).map_err(|error| error.inside("shape.mesh")))
            }
        })
    }

    fn vertices(&self, mesh: &FluidMesh) -> Loaded<Vec<Vec3>> {
        Some(match mesh {
            FluidMesh::Triangles { vertices, .. } => Ok(vertices.clone()),
            FluidMesh::Asset(handle) => {
                let mesh = get(handle, self.meshes.as_deref(), self.server.as_deref(), "shape.mesh")?;
                mesh.and_then(|mesh| mesh::vertices(mesh).map_err(|error| error.inside("shape.mesh")))
            }
        })
    }

    fn image(&self, image: &Handle<Image>) -> Loaded<&Image> {
        get(image, self.images.as_deref(), self.server.as_deref(), "shape.image")
    }
}

fn get<'a, A: Asset>(
    handle: &Handle<A>,
    assets: Option<&'a Assets<A>>,
    server: Option<&AssetServer>,
    field: &str,
) -> Loaded<&'a A> {
    let name = || handle.path().map_or_else(|| handle.id().to_string(), ToString::to_string);
    let Some(assets) = assets else {
        let allowed =
            "numbers in the component, as the app has no such assets (AssetPlugin with MeshPlugin or ImagePlugin)";
        return Some(Err(InvalidInput::new(field, name(), allowed)));
    };
    if let Some(asset) = assets.get(handle) {
        return Some(Ok(asset));
    }
    match server.and_then(|server| server.get_load_state(handle.id())) {
        Some(LoadState::Failed(error)) => {
            Some(Err(InvalidInput::new(field, name(), format_args!("an asset that loads ({error})"))))
        }
        _ => None,
    }
}

/// What has become of the assets of a kind since it was asked last.
#[derive(SystemParam)]
pub(crate) struct News<'w, 's, A: Asset> {
    events: Option<Res<'w, Messages<AssetEvent<A>>>>,
    failures: Option<Res<'w, Messages<AssetLoadFailedEvent<A>>>>,
    heard: Local<'s, MessageCursor<AssetEvent<A>>>,
    heard_failures: Local<'s, MessageCursor<AssetLoadFailedEvent<A>>>,
}

impl<A: Asset> News<'_, '_, A> {
    /// Tells of assets that have come, changed or failed. What has gone leaves walls as they are.
    fn tell(&mut self, mut tell: impl FnMut(AssetId<A>)) {
        if let Some(events) = &self.events {
            for event in self.heard.read(events) {
                if let AssetEvent::Added { id } | AssetEvent::Modified { id } = event {
                    tell(*id);
                }
            }
        }
        if let Some(failures) = &self.failures {
            for failure in self.heard_failures.read(failures) {
                tell(failure.id);
            }
        }
    }
}

/// Notices what concerns walls; planning follows in the same tick.
pub(crate) fn notice_assets(mut meshes: News<Mesh>, mut images: News<Image>, mut shapes: ResMut<WallShapes>) {
    meshes.tell(|id| {
        shapes.notice(Source::Mesh(id));
        shapes.notice(Source::Hull(id));
    });
    images.tell(|id| shapes.notice(Source::Image(id)));
}
