//! The report of a robot lists all files that were read.

use std::fs;
use std::path::PathBuf;

use robot_dynamics::{
    FileSet, LoadOptions, load_description, load_description_from_files, load_description_from_text,
};

/// The sorted names of files. All paths must be absolute.
fn names(files: &[PathBuf]) -> Vec<String> {
    assert!(files.iter().all(|file| file.is_absolute()), "{files:?}");
    let mut names: Vec<String> =
        files.iter().map(|file| file.file_name().unwrap().to_str().unwrap().to_owned()).collect();
    names.sort();
    names
}

const MAIN: &str = r#"<mujoco>
  <asset>
    <model name="child" file="child.xml"/>
    <mesh name="block" file="block.obj"/> <mesh name="unused" file="unused.obj"/>
    <hfield name="hills" file="hills.bin" size="2 2 1 0.1"/>
  </asset>
  <include file="part.xml"/>
  <worldbody>
    <geom type="hfield" hfield="hills"/>
    <body><joint axis="0 1 0"/><geom type="mesh" mesh="block"/><geom type="mesh" mesh="block"/></body>
    <attach model="child" prefix="child_"/>
  </worldbody>
</mujoco>"#;
const PART: &str = "<mujocoinclude><option timestep='0.001'/></mujocoinclude>";
const CHILD: &str = "<mujoco><worldbody><body><freejoint/><geom size='0.1'/></body></worldbody></mujoco>";
const BLOCK: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

#[test]
fn every_file_of_a_robot_is_listed_once() {
    let folder = std::env::temp_dir().join(format!("files_read_{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let urdf = "<robot name='r'><link name='l'><visual><geometry><mesh filename='block.obj'/></geometry></visual>\
                <collision><geometry><mesh filename='missing.obj'/></geometry></collision></link></robot>";
    let files = [
        ("main.xml", MAIN),
        ("part.xml", PART),
        ("child.xml", CHILD),
        ("block.obj", BLOCK),
        ("unused.obj", BLOCK),
        ("hills.bin", "heights"),
        ("robot.urdf", urdf),
    ];
    for (name, text) in files {
        fs::write(folder.join(name), text).unwrap();
    }
    let read =
        |name: &str| load_description(folder.join(name), &LoadOptions::default()).unwrap().report.files;
    assert_eq!(names(&read("main.xml")), ["block.obj", "child.xml", "hills.bin", "main.xml", "part.xml"]);
    assert_eq!(names(&read("robot.urdf")), ["block.obj", "robot.urdf"]);
    // The main file is first, by its canonical path.
    assert_eq!(read("main.xml")[0], folder.canonicalize().unwrap().join("main.xml"));
    // Texts and files in memory are not listed.
    let set = FileSet::new(files);
    assert!(
        load_description_from_files(&set, "main.xml", &LoadOptions::default())
            .unwrap()
            .report
            .files
            .is_empty()
    );
    assert!(load_description_from_text(CHILD, &LoadOptions::default()).unwrap().report.files.is_empty());
    fs::remove_dir_all(&folder).unwrap();
}
