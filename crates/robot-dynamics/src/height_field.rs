//! Reads the height field of a shape.

use std::io::Read;
use std::path::Path;

use crate::contact::HeightField;
use crate::description::{Elevation, LinkShape, Shape};

/// The height field of a shape, for `ContactSet::with_described_height_fields`.
///
/// The heights are those of the robot's file, or come from a separate file in MuJoCo's binary format: the
/// number of rows and of columns (int32) and the heights (float32), little-endian. With the feature `png` the
/// file can be a picture. The height is then the red value of each pixel in 8 bits, as in MuJoCo, and the
/// lowest line is that of the least y. Heights from a file are scaled to the largest height of the shape.
///
/// ```
/// use robot_dynamics::{height_field, mjcf};
/// let text = "<mujoco><asset><hfield name='ramp' size='1 2 0.5 0.1' nrow='2' ncol='2' elevation='7 7 3 3'/></asset>
///     <worldbody><geom type='hfield' hfield='ramp'/></worldbody></mujoco>";
/// let robot = robot_dynamics_mjcf::parse(text, &robot_dynamics_mjcf::LoadOptions::default())?;
/// let field = height_field(&robot.description.shapes[0])?;
/// assert_eq!([field.height(0.0, -2.0), field.height(0.0, 1.0)], [Some(0.0), Some(0.375)]); // it rises along y
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// A message if the shape is not a height field, or if its file was not found or is invalid.
pub fn height_field(shape: &LinkShape) -> Result<HeightField, String> {
    let Shape::HeightField { file, size: [x, y, highest, _], elevation, .. } = &shape.shape else {
        return Err("it is not a height field".into());
    };
    let elevation = match elevation {
        Some(elevation) => elevation.clone(),
        None => read(file.as_deref().ok_or("its file was not found")?, *highest)?,
    };
    let Elevation { rows, columns, heights, .. } = elevation;
    HeightField::new(rows, columns, [*x, *y], heights).map_err(|error| error.to_string())
}

/// The largest number of heights in a file: 4096 rows and columns.
const HEIGHT_LIMIT: usize = 1 << 24;

/// The largest size of a file in bytes: all heights in single precision.
const SIZE_LIMIT: u64 = 4 * HEIGHT_LIMIT as u64 + 8;

/// Reads MuJoCo's binary format, or a picture.
fn read(path: &Path, highest: f64) -> Result<Elevation, String> {
    // A pipe is not opened, because this would wait for a writer.
    if std::fs::metadata(path).is_ok_and(|metadata| !metadata.is_file()) {
        return Err("its file is not a regular file".into());
    }
    let mut bytes = Vec::new();
    std::fs::File::open(path)
        .and_then(|file| file.take(SIZE_LIMIT + 1).read_to_end(&mut bytes))
        .map_err(|error| format!("its file cannot be read: {error}"))?;
    if bytes.len() as u64 > SIZE_LIMIT {
        return Err(format!("its file has more than {SIZE_LIMIT} bytes"));
    }
    if bytes.starts_with(b"\x89PNG") {
        return picture(&bytes, highest);
    }
    let words: Vec<[u8; 4]> = bytes.as_chunks().0.to_vec();
    let count = |at: usize| words.get(at).and_then(|word| usize::try_from(i32::from_le_bytes(*word)).ok());
    let (Some(rows), Some(columns)) = (count(0), count(1)) else {
        return Err(
            "its file is not a height field: it does not begin with the numbers of rows and columns".into()
        );
    };
    if !bytes.len().is_multiple_of(4) || rows.checked_mul(columns) != Some(words.len() - 2) {
        return Err(format!("its file does not have the heights of {rows} rows and {columns} columns"));
    }
    let numbers: Vec<f64> = words[2..].iter().map(|word| f64::from(f32::from_le_bytes(*word))).collect();
    Ok(Elevation::stretched(rows, columns, &numbers, highest))
}

#[cfg(not(feature = "png"))]
fn picture(_: &[u8], _: f64) -> Result<Elevation, String> {
    Err("its file is a picture, which needs the feature `png` of the crate robot-dynamics; or give the heights as `elevation`, or in MuJoCo's binary format".into())
}

/// Reads the first channel of a picture, in 8 bits.
#[cfg(feature = "png")]
fn picture(bytes: &[u8], highest: f64) -> Result<Elevation, String> {
    let wrong = |error: png::DecodingError| format!("its file is not a valid picture: {error}");
    let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::EXPAND | png::Transformations::STRIP_16);
    let mut reader = decoder.read_info().map_err(wrong)?;
    let info = reader.info();
    if u64::from(info.width) * u64::from(info.height) > HEIGHT_LIMIT as u64 {
        return Err(format!(
            "its picture of {} × {} pixels has more than {HEIGHT_LIMIT} pixels, the largest number of heights",
            info.width, info.height
        ));
    }
    let size = reader.output_buffer_size().ok_or("its picture is too large")?;
    let mut pixels = vec![0; size];
    let frame = reader.next_frame(&mut pixels).map_err(wrong)?;
    let channels = frame.color_type.samples();
    // The lines of a picture start at the top.
    let lines = pixels[..frame.buffer_size()].chunks_exact(frame.line_size).rev();
    let heights: Vec<f64> =
        lines.flat_map(|line| line.chunks_exact(channels).map(|pixel| f64::from(pixel[0]))).collect();
    let columns = frame.line_size / channels;
    Ok(Elevation::stretched(heights.len() / columns, columns, &heights, highest))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::{Pose, ShapeRole};

    fn shape(file: &Path) -> LinkShape {
        let size = [1.0, 1.0, 0.5, 0.1];
        let shape =
            Shape::HeightField { name: "hill".into(), file: Some(file.into()), size, elevation: None };
        LinkShape::new("world", ShapeRole::Collision, Pose::IDENTITY, shape)
    }

    /// A file of a hundred bytes that states a large picture is refused before memory is taken for it.
    #[cfg(feature = "png")]
    #[test]
    fn large_pictures_are_refused() {
        let mut bytes = Vec::new();
        let mut writer = png::Encoder::new(&mut bytes, 30_000, 30_000).write_header().unwrap();
        writer.write_chunk(png::chunk::IDAT, &[]).unwrap();
        drop(writer);
        assert!(bytes.len() < 100);
        let error = picture(&bytes, 1.0).unwrap_err();
        assert!(error.contains("30000 × 30000 pixels has more than 16777216"), "{error}");
    }

    /// Pictures of all colour types give the heights of MuJoCo 4.0.0.
    #[cfg(feature = "png")]
    #[test]
    fn pictures_are_read() {
        use png::{BitDepth, ColorType};
        let file = std::env::temp_dir().join(format!("height-field-{}.png", std::process::id()));
        let grey = [10.0, 20.0, 30.0, 0.0, 100.0, 255.0];
        let deep: Vec<u8> =
            [0_u16, 25700, 65535, 2815, 5140, 7710].iter().flat_map(|x| x.to_be_bytes()).collect();
        let rgba = [0, 9, 200, 255, 100, 7, 7, 0, 255, 1, 1, 9, 10, 0, 0, 1, 20, 99, 99, 2, 30, 255, 255, 3];
        let rgb: Vec<u8> = rgba.chunks(4).flat_map(|pixel| pixel[..3].to_vec()).collect();
        for (color, depth, pixels, expected) in [
            (ColorType::Grayscale, BitDepth::Eight, &[0, 100, 255, 10, 20, 30][..], grey),
            (ColorType::Grayscale, BitDepth::Sixteen, &deep, grey),
            (ColorType::Rgb, BitDepth::Eight, &rgb, grey),
            (ColorType::Rgba, BitDepth::Eight, &rgba, grey),
            (
                ColorType::Indexed,
                BitDepth::Eight,
                &[0, 1, 2, 2, 1, 0],
                [255.0, 100.0, 0.0, 0.0, 100.0, 255.0],
            ),
            (
                ColorType::Grayscale,
                BitDepth::Four,
                &[0x0a, 0xf0, 0x12, 0x30],
                [17.0, 34.0, 51.0, 0.0, 170.0, 255.0],
            ),
        ] {
            let mut encoder = png::Encoder::new(std::fs::File::create(&file).unwrap(), 3, 2);
            encoder.set_color(color);
            encoder.set_depth(depth);
            if color == ColorType::Indexed {
                encoder.set_palette(&[0, 50, 50, 100, 0, 0, 255, 255, 255][..]);
            }
            encoder.write_header().unwrap().write_image_data(pixels).unwrap();
            let field = height_field(&shape(&file)).unwrap();
            let places = [(-1.0, -1.0), (0.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (0.0, 1.0), (1.0, 1.0)];
            for ((x, y), brightness) in places.into_iter().zip(expected) {
                let height = field.height(x, y).unwrap();
                assert!((height - 0.5 * brightness / 255.0).abs() < 1e-15, "{color:?} {depth:?}: {height}");
            }
        }
        std::fs::remove_file(&file).unwrap();
    }

    /// A binary file gives its heights in the right order and scale. Invalid files are refused.
    #[test]
    fn binary_files_are_read() {
        let folder = std::env::temp_dir().join(format!("height-field-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = folder.join("hill.bin");
        let mut bytes: Vec<u8> = [2_i32, 3].iter().flat_map(|count| count.to_le_bytes()).collect();
        bytes.extend([4.0_f32, 4.0, 6.0, 8.0, 4.0, 4.0].iter().flat_map(|height| height.to_le_bytes()));
        std::fs::write(&file, &bytes).unwrap();
        let field = height_field(&shape(&file)).unwrap();
        let found = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (0.0, 1.0)].map(|(x, y)| field.height(x, y));
        assert_eq!(found, [Some(0.0), Some(0.25), Some(0.5), Some(0.0)]);
        for bytes in [&bytes[..28], &b"\x89PNG and more"[..], &[0xff; 12][..], &[][..]] {
            std::fs::write(&file, bytes).unwrap();
            height_field(&shape(&file)).unwrap_err();
        }
        std::fs::remove_dir_all(&folder).unwrap();
        height_field(&shape(&file)).unwrap_err();
    }
}
