//! Snapshots of the messages of this crate, each with the input that gives it.
//!
//! After a change of wording, run the tests with `INSTA_UPDATE=always` and review the difference of the
//! snapshots.

use std::fmt::Write as _;
use std::path::Path;

use insta::assert_snapshot;
use robot_dynamics::description::{LinkShape, Pose, Shape, ShapeRole};
use robot_dynamics::output::{resolve, write_files};
use robot_dynamics::{height_field, mesh_corners};

/// Adds an input and its message.
fn add(out: &mut String, input: &str, message: impl std::fmt::Display) {
    writeln!(out, "{input}\n=> {message}\n").expect("to a string");
}

fn shape(shape: Shape) -> LinkShape {
    LinkShape::new("world", ShapeRole::Collision, Pose::IDENTITY, shape)
}

fn hill(file: Option<&Path>) -> LinkShape {
    let size = [1.0, 1.0, 0.5, 0.1];
    shape(Shape::HeightField { name: "hill".into(), file: file.map(Path::to_owned), size, elevation: None })
}

#[test]
fn files_of_shapes() {
    let folder = std::env::temp_dir().join(format!("messages_{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let mut out = String::new();
    let ball = shape(Shape::Sphere { radius: 1.0 });
    add(&mut out, "the height field of a sphere", height_field(&ball).unwrap_err());
    add(&mut out, "a height field without a file", height_field(&hill(None)).unwrap_err());
    let file = folder.join("hill.bin");
    let missing = height_field(&hill(Some(&file))).unwrap_err();
    // The cause is a message of the system.
    add(&mut out, "a missing file", missing.split_once(": ").expect("a cause").0);
    let counts: Vec<u8> = [2_i32, 3, 0].iter().flat_map(|count| count.to_le_bytes()).collect();
    for (input, bytes) in [
        ("a file of 2 × 3 with one height", &counts[..]),
        ("negative counts", &[0xff; 12]),
        ("an empty file", &[]),
    ] {
        std::fs::write(&file, bytes).unwrap();
        add(&mut out, input, height_field(&hill(Some(&file))).unwrap_err());
    }
    std::fs::write(&file, b"\x89PNG and more").unwrap();
    let picture = height_field(&hill(Some(&file))).unwrap_err();
    if cfg!(not(feature = "png")) {
        assert_snapshot!("pictures_without_the_feature", picture);
    }
    add(&mut out, "the corners of a sphere", mesh_corners(&ball).unwrap_err());
    add(&mut out, "a mesh without a file", mesh_corners(&shape(Shape::mesh("arm.stl"))).unwrap_err());
    std::fs::remove_dir_all(&folder).unwrap();
    assert_snapshot!(out);
}

#[test]
fn files_that_are_not_written() {
    let folder = std::env::temp_dir().join(format!("messages_output_{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let mut out = String::new();
    let shown = |text: String| text.replace(&folder.display().to_string(), "FOLDER");
    let error = write_files(&[(folder.clone(), "")]).expect_err("a folder");
    add(&mut out, "a folder", shown(error.to_string()));
    std::fs::write(folder.join("file"), "").unwrap();
    let error = write_files(&[(folder.join("file/below.txt"), "")]).expect_err("a file");
    let text = shown(error.to_string());
    // The cause is a message of the system.
    add(&mut out, "a file below a file", text.rsplit_once(": ").expect("a cause").0);
    #[cfg(unix)]
    {
        let link = folder.join("link");
        std::os::unix::fs::symlink(&link, &link).unwrap();
        add(&mut out, "a link to itself", resolve(&link).expect_err("a circle"));
    }
    std::fs::remove_dir_all(&folder).unwrap();
    assert_snapshot!(out);
}

#[cfg(feature = "json")]
#[test]
fn lines_of_json() {
    use robot_dynamics::json::StateLine;
    let mut out = String::new();
    for line in
        ["", "[1]", "{\"q\":[0.1]}", "{\"q\":[0.1],\"v\":[\"a\"]}", "{\"q\":[],\"v\":[],\"u\":[]}", "{\"q\":"]
    {
        add(&mut out, line, StateLine::parse(line.as_bytes()).expect_err("no state"));
    }
    assert_snapshot!(out);
}
