//! Heights from images.

use bevy::asset::RenderAssetUsages;
use bevy::prelude::*;
use freshet_core::error::{InvalidInput, check_range};
use freshet_core::geometry::{HeightField, MAX_HEIGHTS};

/// Ground with a height for each pixel, `height` where it is white.
pub(super) fn height_field(image: &Image, size: Vec2, height: f32) -> Result<HeightField, InvalidInput> {
    check_range("height", height, -1e6, 1e6, "m")?;
    let usage = image.asset_usage;
    if !usage.contains(RenderAssetUsages::MAIN_WORLD) {
        return Err(InvalidInput::new("image.asset_usage", format_args!("{usage:?}"), "one with MAIN_WORLD"));
    }
    let counts = [image.width(), image.height()];
    let count = counts.map(u64::from).iter().product::<u64>();
    if count > MAX_HEIGHTS as u64 || counts.contains(&1) {
        let value = format!("{} x {} pixels", counts[0], counts[1]);
        let allowed = format!("at least 2 each way, up to {MAX_HEIGHTS} in all");
        return Err(InvalidInput::new("image", value, allowed));
    }
    let mut heights = Vec::with_capacity(count as usize);
    for y in 0..counts[1] {
        for x in 0..counts[0] {
            let color = image.get_color_at(x, y).map_err(|error| {
                let allowed = "pixels in the main world, of 2 dimensions and a format without compression";
                InvalidInput::new("image", error, allowed)
            })?;
            heights.push(height * stored(color));
        }
    }
    HeightField::new(size.to_array(), counts, heights)
}

/// Mean of the three values as they are stored; a picture with gamma is read as `Srgba`.
fn stored(color: Color) -> f32 {
    let [red, green, blue] = match color {
        Color::Srgba(color) => [color.red, color.green, color.blue],
        other => {
            let color = other.to_linear();
            [color.red, color.green, color.blue]
        }
    };
    (red + green + blue) / 3.0
}

#[cfg(test)]
mod tests {
    use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};

    use super::*;

    fn image(size: [u32; 2], format: TextureFormat, data: Vec<u8>) -> Image {
        let size = Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 };
        Image::new(size, TextureDimension::D2, data, format, RenderAssetUsages::MAIN_WORLD)
    }

    #[test]
    fn heights_are_the_values_as_stored() {
        let size = Vec2::new(3.0, 2.0);
        // 51 of 255 is a fifth, with gamma and without.
        let grey = image([3, 2], TextureFormat::R8Unorm, vec![0, 51, 255, 102, 153, 204]);
        let field = height_field(&grey, size, 10.0).unwrap();
        assert_eq!((field.counts(), field.size()), ([3, 2], [3.0, 2.0]));
        let wanted = [0.0, 2.0, 10.0, 4.0, 6.0, 8.0];
        let near = |a: &[f32], b: &[f32]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5);
        assert!(near(field.heights(), &wanted), "{:?}", field.heights());
        // The first row is at the lowest z, x runs along it.
        assert!((field.height(0.0, -1.0) - 2.0).abs() < 1e-5);
        let colored = [0u8, 51, 255, 102, 153, 204].iter().flat_map(|&value| [value, value, value, 255]).collect();
        let colored = image([3, 2], TextureFormat::Rgba8UnormSrgb, colored);
        assert!(near(height_field(&colored, size, 10.0).unwrap().heights(), &wanted));
        let exact = [0.0f32, 0.2, 1.0, 0.4, 0.6, 0.8].iter().flat_map(|value| value.to_le_bytes()).collect();
        let exact = image([3, 2], TextureFormat::R32Float, exact);
        assert!(near(height_field(&exact, size, 10.0).unwrap().heights(), &wanted));
    }

    #[test]
    fn images_that_are_no_ground_are_refused() {
        let refused = |image: Image, height| height_field(&image, Vec2::ONE, height).unwrap_err().to_string();
        let line = || image([4, 1], TextureFormat::R8Unorm, vec![0; 4]);
        assert!(refused(line(), 1.0).starts_with("image: 4 x 1 pixels is not allowed"));
        assert!(refused(line(), f32::NAN).starts_with("height: NaN"));
        let large = image([1025, 1024], TextureFormat::R8Unorm, vec![0; 1025 * 1024]);
        assert!(refused(large, 1.0).contains("up to 1048576 in all"));
        let mut gone = image([2, 2], TextureFormat::R8Unorm, vec![0; 4]);
        gone.data = None;
        assert!(refused(gone, 1.0).starts_with("image: "));
        let mut elsewhere = image([2, 2], TextureFormat::R8Unorm, vec![0; 4]);
        elsewhere.asset_usage = RenderAssetUsages::RENDER_WORLD;
        assert!(refused(elsewhere, 1.0).contains("MAIN_WORLD"));
    }
}
