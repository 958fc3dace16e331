//! Included files are located and named in messages. Cycles are refused, and files outside the folder if
//! reading is confined.

use std::path::{Path, PathBuf};

use robot_dynamics::description::Shape;
use robot_dynamics::mjcf::{FileSet, LoadError, LoadOptions, MjcfError, Robot, load, load_from_files, parse};

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

    pub(crate) fn path(&self) -> &Path {
        &self.0
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

/// As in MuJoCo, the files of a robot may be anywhere on the disk: above the main file's folder, beside the
/// including file, at an absolute path, and named with `\\`.
#[test]
fn files_may_be_anywhere_on_the_disk() {
    let elsewhere = Folder::with(
        "elsewhere",
        &[("part.xml", "<mujoco><worldbody><body name='d'/></worldbody></mujoco>")],
    );
    let block = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    let main = format!(
        "<mujoco><include file='../shared/a.xml'/><include file='{}'/><include file='..\\shared\\c.xml'/>
           <asset><model name='tool' file='../shared/tool.xml'/></asset>
           <worldbody><attach model='tool' prefix='t_'/></worldbody></mujoco>",
        elsewhere.0.join("part.xml").display()
    );
    let body = "<body name='a'><freejoint/><geom type='mesh' mesh='block'/></body>";
    let a = format!(
        "<mujoco><asset><mesh file='block.obj'/></asset><worldbody>{body}</worldbody><include file='b.xml'/></mujoco>"
    );
    let folder = Folder::with(
        "above",
        &[
            ("arm/main.xml", &main),
            ("whole.xml", "<mujoco><include file='arm/main.xml'/></mujoco>"),
            ("shared/a.xml", &a),
            ("shared/block.obj", block),
            ("shared/b.xml", "<mujoco><worldbody><body name='b'/></worldbody></mujoco>"),
            ("shared/c.xml", "<mujoco><worldbody><body name='c'/></worldbody></mujoco>"),
            ("shared/tool.xml", "<mujoco><worldbody><body name='e'/></worldbody></mujoco>"),
        ],
    );
    let robot = folder.load("arm/main.xml").expect("a robot");
    let links: Vec<&str> = robot.description.links.iter().map(|link| link.name.as_str()).collect();
    assert_eq!(links, ["world", "a", "b", "d", "c", "t_e"]);
    let mass = robot.description.links[1].mass_properties.expect("a block").mass();
    assert!((mass - 1000.0 / 6.0).abs() < 1e-3, "{mass}");
    let file = robot.description.shapes[0].shape.file().and_then(|(_, path)| path);
    assert!(file.expect("the mesh").ends_with("shared/block.obj"));
    // The files that an included file names are also searched beside it.
    let whole = folder.load("whole.xml").expect("a robot");
    assert_eq!(whole.description.links, robot.description.links);
}

/// A confined reading, and one of files in memory, refuse files outside their root, and name the root.
#[test]
fn confined_reading_stays_in_the_folder_of_the_main_file() {
    let outside = std::env::temp_dir().join(format!("mjcf-outside-{}.xml", std::process::id()));
    std::fs::write(&outside, "<mujoco/>").expect("a file");
    let name = outside.file_name().expect("a name").to_string_lossy().into_owned();
    let confined = LoadOptions::default().with_confined();
    for file in
        [format!("../{name}"), format!("x/../../{name}"), outside.display().to_string(), "/etc/passwd".into()]
    {
        let text = format!("<mujoco><include file='{file}'/></mujoco>");
        let folder = Folder::with("leaves", &[("main.xml", &text)]);
        let (named, reason) = refused(load(folder.0.join("main.xml"), &confined));
        assert_eq!(named, file);
        assert!(
            reason.contains("to which reading is confined") && reason.contains("mjcf-leaves"),
            "{reason}"
        );
        let given = FileSet::new([("main.xml", text)]);
        let (_, reason) = refused(load_from_files(&given, "main.xml", &LoadOptions::default()));
        assert_eq!(reason, "it is outside the given files");
    }
    let mesh = format!(
        "<mujoco><asset><mesh name='m' file='../{name}' content_type='model/obj'/></asset>
           <worldbody><body><freejoint/><geom type='mesh' mesh='m'/></body></worldbody></mujoco>"
    );
    let folder = Folder::with("leaves-mesh", &[("main.xml", &mesh)]);
    let error = load(folder.0.join("main.xml"), &confined).expect_err("outside").to_string();
    assert!(error.contains("to which reading is confined"), "{error}");
    std::fs::remove_file(outside).expect("the file");
}

/// A pipe as an included file, a model or a mesh is refused at once. Opening it would wait for a writer.
#[cfg(unix)]
#[test]
fn pipes_and_devices_are_refused() {
    let model = "<asset><model name='m' file='pipe.stl'/></asset>";
    let mesh = "<asset><mesh name='m' file='pipe.stl'/></asset>
        <worldbody><body><freejoint/><geom type='mesh' mesh='m'/></body></worldbody>";
    for content in ["<include file='pipe.stl'/>", "<include file='/dev/zero'/>", model, mesh] {
        let folder = Folder::with("pipe", &[("main.xml", &format!("<mujoco>{content}</mujoco>"))]);
        let made = std::process::Command::new("mkfifo").arg(folder.0.join("pipe.stl")).status();
        assert!(made.expect("mkfifo").success());
        let error = folder.load("main.xml").expect_err("no regular file").to_string();
        assert!(error.contains("not a regular file"), "{error}");
    }
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
    let in_memory = load_from_files(&given, "given/scene.xml", &LoadOptions::default()).expect("it is there");
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
    assert_eq!(refused(load_from_files(&broken, "scene.xml", &LoadOptions::default())).0, "robot/body.xml");
    let error = load_from_files(&broken, "robot.xml", &LoadOptions::default()).expect_err("none");
    let [MjcfError::Xml { source: robot_dynamics_xml::XmlError::Unreadable { path, .. }, .. }] =
        error.errors()
    else {
        panic!("{error}")
    };
    assert_eq!(path, std::path::Path::new("robot.xml"));
}
