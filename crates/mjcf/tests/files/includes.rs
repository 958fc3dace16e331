//! Included files are located and named in messages. Cycles, and files outside the folder, are refused.

use std::path::PathBuf;

use robot_dynamics::description::Shape;
use robot_dynamics::mjcf::{FileSet, LoadError, LoadOptions, MjcfError, Robot, load, load_among, parse};

/// A temporary folder of files, which is removed on drop.
pub(crate) struct Folder(PathBuf);

impl Folder {
    pub(crate) fn with(name: &str, files: &[(&str, &str)]) -> Self {
        let folder = std::env::temp_dir().join(format!("mjcf-{name}-{}", std::process::id()));
        for (file, text) in files {
            let path = folder.join(file);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            std::fs::write(path, text).expect("a file");
        }
        Self(folder)
    }

    pub(crate) fn load(&self, file: &str) -> Result<Robot, LoadError> {
        load(self.0.join(file), &LoadOptions::default())
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// The file and the reason of a refused include.
fn refused(outcome: Result<Robot, LoadError>) -> (String, String) {
    let error = outcome.expect_err("an include that is refused");
    match error.errors() {
        [MjcfError::Include { file, reason, .. }] => (file.clone(), reason.clone()),
        _ => panic!("{error}"),
    }
}

#[test]
fn an_include_is_found_in_the_main_folder_or_that_of_its_file() {
    let folder = Folder::with(
        "beside",
        &[
            ("main.xml", "<mujoco><include file='parts/a.xml'/></mujoco>"),
            ("parts/a.xml", "<mujoco><include file='b.xml'/><include file='parts/c.xml'/></mujoco>"),
            ("parts/b.xml", "<mujoco><worldbody><body name='b'/></worldbody></mujoco>"),
            ("parts/c.xml", "<mujocoinclude><worldbody><body name='c'/></worldbody></mujocoinclude>"),
        ],
    );
    let robot = folder.load("main.xml").expect("a robot");
    let links: Vec<&str> = robot.description.links.iter().map(|link| link.name.as_str()).collect();
    assert_eq!(links, ["world", "b", "c"]);
}

#[test]
fn messages_name_the_included_file() {
    let folder = Folder::with(
        "named",
        &[
            ("main.xml", "<mujoco><worldbody>\n<include file='part.xml'/></worldbody></mujoco>"),
            ("part.xml", "<mujoco>\n\n<body name='a' pos='0 0'/><body name='b' mood='good'/></mujoco>"),
        ],
    );
    let error = folder.load("main.xml").expect_err("two numbers");
    let [only] = error.errors() else { panic!("{error}") };
    assert_eq!((only.line(), only.place()), (Some(3), Some("part.xml: body \"a\"")));
    let warning = error.report().warnings().next().expect("a warning");
    assert_eq!((warning.line(), warning.place()), (3, "part.xml: body \"b\""));
}

#[test]
fn cycles_and_repetitions_of_includes_are_refused() {
    let folder = Folder::with(
        "circle",
        &[
            ("main.xml", "<mujoco><include file='a.xml'/></mujoco>"),
            ("a.xml", "<mujoco><include file='b.xml'/></mujoco>"),
            ("b.xml", "<mujoco><include file='./x/../a.xml'/></mujoco>"),
            ("self.xml", "<mujoco><include file='self.xml'/></mujoco>"),
            ("twice.xml", "<mujoco><include file='c.xml'/><include file='c.xml'/></mujoco>"),
            ("c.xml", "<mujoco><worldbody/></mujoco>"),
        ],
    );
    for (file, again) in [("main.xml", "./x/../a.xml"), ("self.xml", "self.xml"), ("twice.xml", "c.xml")] {
        assert_eq!(refused(folder.load(file)).0, again);
    }
}

#[test]
fn files_outside_the_folder_are_not_read() {
    let outside = std::env::temp_dir().join(format!("mjcf-outside-{}.xml", std::process::id()));
    std::fs::write(&outside, "<mujoco/>").expect("a file");
    let name = outside.file_name().expect("a name").to_string_lossy().into_owned();
    for file in
        [format!("../{name}"), format!("x/../../{name}"), outside.display().to_string(), "/etc/passwd".into()]
    {
        let text = format!("<mujoco><include file='{file}'/></mujoco>");
        let folder = Folder::with("leaves", &[("main.xml", &text)]);
        assert_eq!(refused(folder.load("main.xml")).0, file);
    }
    std::fs::remove_file(outside).expect("the file");
}

#[test]
fn long_chains_and_missing_files_are_refused() {
    let mut files: Vec<(String, String)> = (0..80)
        .map(|k| (format!("f{k}.xml"), format!("<mujoco><include file='f{}.xml'/></mujoco>", k + 1)))
        .collect();
    files.push(("main.xml".into(), "<mujoco><include file='f0.xml'/></mujoco>".into()));
    let files: Vec<(&str, &str)> = files.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    let folder = Folder::with("deep", &files);
    // f0 to f49 are fifty nested includes.
    assert_eq!(refused(folder.load("main.xml")).0, "f50.xml");
    assert_eq!(refused(folder.load("f79.xml")).0, "f80.xml");
    let options = LoadOptions::default();
    assert_eq!(refused(parse("<mujoco><include file='a.xml'/></mujoco>", &options)).0, "a.xml");
    assert_eq!(refused(parse("<mujoco><include/></mujoco>", &options)).0, "");
}

#[test]
fn an_included_file_that_is_not_xml_is_named() {
    let folder = Folder::with(
        "broken",
        &[("main.xml", "<mujoco><include file='a.xml'/></mujoco>"), ("a.xml", "<mujoco>\n<body></mujoco>")],
    );
    let error = folder.load("main.xml").expect_err("broken");
    let [MjcfError::Xml { file, source }] = error.errors() else { panic!("{error}") };
    assert_eq!((file.as_str(), source.line()), ("a.xml", Some(2)));
}

/// Files in memory give the same robot as on the disk, with includes in other folders and a mesh that inertia
/// comes from.
#[test]
fn files_in_memory_are_read_as_those_on_the_disk() {
    let tetrahedron = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    let files = [
        ("scene.xml", "<mujoco model='scene'><include file='robot/body.xml'/></mujoco>"),
        (
            "robot/body.xml",
            "<mujoco><compiler meshdir='robot/../meshes'/><asset><mesh name='rock' file='rock.obj'/></asset>
            <worldbody><body name='rock'><freejoint/><geom type='mesh' mesh='rock'/></body></worldbody></mujoco>",
        ),
        ("meshes/rock.obj", tetrahedron),
    ];
    let folder = Folder::with("memory", &files);
    let mut on_disk = folder.load("scene.xml").expect("it is there");
    let given = FileSet::new(files.map(|(path, text)| (format!("./given/{path}"), text)));
    let in_memory = load_among(&given, "given/scene.xml", &LoadOptions::default()).expect("it is there");
    assert!(
        (on_disk.description.links[1].mass_properties.expect("a rock").mass() - 1000.0 / 6000.0).abs() < 1e-6
    );
    // Shapes name their file in both cases, but have a path only on the disk.
    for shape in &mut on_disk.description.shapes {
        if let Shape::Mesh { file, .. } = &mut shape.shape {
            assert!(file.take().is_some());
        }
    }
    assert_eq!(in_memory.description, on_disk.description);

    let broken = FileSet::new([("scene.xml", files[0].1)]);
    assert_eq!(refused(load_among(&broken, "scene.xml", &LoadOptions::default())).0, "robot/body.xml");
    let error = load_among(&broken, "robot.xml", &LoadOptions::default()).expect_err("none");
    let [MjcfError::Xml { source: robot_dynamics_xml::XmlError::Unreadable { path, .. }, .. }] =
        error.errors()
    else {
        panic!("{error}")
    };
    assert_eq!(path, std::path::Path::new("robot.xml"));
}
