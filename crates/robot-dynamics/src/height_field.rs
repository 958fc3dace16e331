//! The heights of a shape that is a height field.

use std::path::Path;

use multibody::{Elevation, HeightField, LinkShape, Shape};

/// The height field of a shape, as `ContactSet::with_described_height_fields` asks for it: of the heights that the robot's file has, or of a file in MuJoCo's binary format, which
/// is the number of rows and of columns (int32) and the heights (float32), little-endian. These are stretched to the shape's largest height. Pictures (PNG) are not read.
///
/// ```
/// use robot_dynamics::{height_field, mjcf};
/// let text = "<mujoco><asset><hfield name='ramp' size='1 2 0.5 0.1' nrow='2' ncol='2' elevation='7 7 3 3'/></asset>
///     <worldbody><geom type='hfield' hfield='ramp'/></worldbody></mujoco>";
/// let robot = mjcf::parse(text, &mjcf::Options::default())?;
/// let field = height_field(&robot.description.shapes[0])?;
/// assert_eq!([field.height(0.0, -2.0), field.height(0.0, 1.0)], [Some(0.0), Some(0.375)]); // it rises along y
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// The shape is no height field, its file was not found, or what is wrong with it.
pub fn height_field(shape: &LinkShape) -> Result<HeightField, String> {
    let Shape::HeightField { file, size: [x, y, highest, _], elevation, .. } = &shape.shape else {
        return Err("it is no height field".into());
    };
    let opened;
    let elevation = if let Some(elevation) = elevation {
        elevation
    } else {
        opened = read(file.as_deref().ok_or("its file was not found")?, *highest)?;
        &opened
    };
    let Elevation { rows, columns, heights, .. } = elevation;
    HeightField::new(*rows, *columns, [*x, *y], heights.clone()).map_err(|error| error.to_string())
}

/// MuJoCo's binary format.
fn read(path: &Path, highest: f64) -> Result<Elevation, String> {
    let bytes = std::fs::read(path).map_err(|error| format!("its file cannot be read: {error}"))?;
    if bytes.starts_with(b"\x89PNG") {
        return Err("its file is a picture, which is not read; give its heights as `elevation`, or in MuJoCo's binary format".into());
    }
    let words: Vec<[u8; 4]> = bytes.as_chunks().0.to_vec();
    let count = |at: usize| words.get(at).and_then(|word| usize::try_from(i32::from_le_bytes(*word)).ok());
    let (Some(rows), Some(columns)) = (count(0), count(1)) else {
        return Err("its file is no height field: it begins with no numbers of rows and columns".into());
    };
    if !bytes.len().is_multiple_of(4) || rows.checked_mul(columns) != Some(words.len() - 2) {
        return Err(format!(
            "its file has not the heights of {rows} rows and {columns} columns that it begins with"
        ));
    }
    let numbers: Vec<f64> = words[2..].iter().map(|word| f64::from(f32::from_le_bytes(*word))).collect();
    Ok(Elevation::stretched(rows, columns, &numbers, highest))
}

#[cfg(test)]
mod tests {
    use super::*;
    use multibody::{Pose, ShapeRole};

    /// A file in the binary format, with its counts, its order and its scale; what is none is refused.
    #[test]
    fn binary_files_are_read() {
        let folder = std::env::temp_dir().join(format!("height-field-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = folder.join("hill.bin");
        let shape = |file: &Path| {
            let size = [1.0, 1.0, 0.5, 0.1];
            let shape =
                Shape::HeightField { name: "hill".into(), file: Some(file.into()), size, elevation: None };
            LinkShape::new("world", ShapeRole::Collision, Pose::IDENTITY, shape)
        };
        let mut bytes: Vec<u8> = [2_i32, 3].iter().flat_map(|count| count.to_le_bytes()).collect();
        bytes.extend([4.0_f32, 4.0, 6.0, 8.0, 4.0, 4.0].iter().flat_map(|height| height.to_le_bytes()));
        std::fs::write(&file, &bytes).unwrap();
        let field = height_field(&shape(&file)).unwrap();
        let found = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (0.0, 1.0)].map(|(x, y)| field.height(x, y));
        assert_eq!(found, [Some(0.0), Some(0.25), Some(0.5), Some(0.0)]);
        for (bytes, said) in [
            (&bytes[..28], "2 rows and 3 columns"),
            (&b"\x89PNG and more"[..], "a picture"),
            (&[0xff; 12][..], "no numbers of rows"),
            (&[][..], "no numbers of rows"),
        ] {
            std::fs::write(&file, bytes).unwrap();
            let error = height_field(&shape(&file)).unwrap_err();
            assert!(error.contains(said), "{error}");
        }
        std::fs::remove_dir_all(&folder).unwrap();
        assert!(height_field(&shape(&file)).unwrap_err().contains("cannot be read"));
    }
}
