//! Small files with the traits of public reports: each is read with the values of MuJoCo and Pinocchio, or is
//! refused with advice.

use std::path::PathBuf;

use robot_dynamics::description::LoadReport;
use robot_dynamics::model::Model;
use robot_dynamics::{LoadOptions, load_description};

/// A file's name and its bytes.
type File<'a> = (&'a str, &'a [u8]);

/// A folder of its own, which is removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str, files: &[File<'_>]) -> Self {
        let folder = std::env::temp_dir().join(format!("reported_{name}_{}", std::process::id()));
        for (file, content) in files {
            let path = folder.join(file);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            std::fs::write(path, content).expect("a file");
        }
        Self(folder)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// The robot of a file and its report, or the message.
fn read(name: &str, files: &[File<'_>], options: &LoadOptions) -> Result<(Model, LoadReport), String> {
    let folder = Folder::new(name, files);
    let read = load_description(folder.0.join(files[0].0), options).map_err(|error| error.to_string())?;
    Ok((Model::new(read.description).expect("a robot"), read.report))
}

/// The mass of all links and M of a hinge at 0, without a warning.
fn hinge(name: &str, files: &[File<'_>]) -> [f64; 2] {
    let (model, report) = read(name, files, &LoadOptions::default()).expect(name);
    assert_eq!(report.warnings().count(), 0, "{name}: {report}");
    numbers(&model)
}

fn numbers(model: &Model) -> [f64; 2] {
    assert_eq!(model.nv(), 1);
    let links = &model.description().links;
    let mass = links.iter().filter_map(|link| Some(link.mass_properties.as_ref()?.mass())).sum();
    [mass, model.mass_matrix(&[0.0]).expect("a configuration")[0]]
}

/// The numbers of the reports have six digits.
fn assert_six_digits(name: &str, found: [f64; 2], expected: [f64; 2]) {
    for (own, other) in found.into_iter().zip(expected) {
        assert!((own - other).abs() < 1e-6 * other.abs().max(1.0), "{name}: {found:?} for {expected:?}");
    }
}

/// A body on a hinge, with more elements of MJCF around it.
fn mjcf(geom: &str, around: &str) -> String {
    format!(
        "<mujoco>{around}<worldbody><body name='arm' pos='0 0 1'><joint name='hinge' axis='0 1 0'/>{geom}</body>
         </worldbody></mujoco>"
    )
}

/// An arm on a hinge, with more elements of URDF in the joint and in the robot.
fn urdf(in_joint: &str, in_robot: &str) -> String {
    format!(
        "<robot name='r'><link name='base'/><link name='arm'><inertial><origin xyz='0 0 0.3'/><mass value='1'/>
         <inertia ixx='0.02' ixy='0' ixz='0' iyy='0.01' iyz='0' izz='0.015'/></inertial></link>
         <joint name='hinge' type='revolute'><parent link='base'/><child link='arm'/><origin xyz='0 0 0.5'/>
         <axis xyz='0 1 0'/><limit lower='-1' upper='1' effort='10' velocity='5'/>{in_joint}</joint>{in_robot}</robot>"
    )
}

const BALL: &str = "<geom size='0.1' pos='0.3 0 0'/>";
const BLOCK: &str = "<geom type='mesh' mesh='m' pos='0.3 0.1 0'/>";
const SWINGING_BALL: [f64; 2] = [4.188_790, 0.393_746];
const SWINGING_BLOCK: [f64; 2] = [48.0, 7.96];
const SWINGING_ARM: [f64; 2] = [1.0, 0.1];

const POINTS: [[f64; 3]; 8] = [
    [-0.05, -0.2, -0.2],
    [0.15, -0.2, -0.2],
    [0.15, 0.2, -0.2],
    [-0.05, 0.2, -0.2],
    [-0.05, -0.2, 0.4],
    [0.15, -0.2, 0.4],
    [0.15, 0.2, 0.4],
    [-0.05, 0.2, 0.4],
];
const FACES: [[usize; 3]; 12] = [
    [1, 4, 3],
    [1, 3, 2],
    [5, 6, 7],
    [5, 7, 8],
    [1, 2, 6],
    [1, 6, 5],
    [2, 3, 7],
    [2, 7, 6],
    [3, 4, 8],
    [3, 8, 7],
    [4, 1, 5],
    [4, 5, 8],
];

fn obj(faces: &[[usize; 3]]) -> String {
    let points = POINTS.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n"));
    points.chain(faces.iter().map(|[a, b, c]| format!("f {a} {b} {c}\n"))).collect()
}

fn stl(header: &str, case: fn(&str) -> String) -> String {
    let mut text = format!("{header}\n");
    for face in FACES {
        text += &case("facet normal 0 0 0\nouter loop\n");
        for corner in face {
            let [x, y, z] = POINTS[corner - 1];
            text += &case(&format!("vertex {x} {y} {z}\n"));
        }
        text += &case("endloop\nendfacet\n");
    }
    text + &case("endsolid\n")
}

#[test]
fn files_may_lie_above_the_folder_and_beside_the_including_file() {
    let arm = mjcf(BALL, "<include file='../shared/defaults.xml'/>");
    let defaults = "<mujoco><default><geom density='500'/></default></mujoco>";
    let files = [("arm/arm.xml", arm.as_bytes()), ("shared/defaults.xml", defaults.as_bytes())];
    let half = SWINGING_BALL.map(|x| 0.5 * x);
    assert_six_digits("above", hinge("above", &files), half);
    let whole = ("whole.xml", &b"<mujoco><include file='arm/arm.xml'/></mujoco>"[..]);
    assert_six_digits("whole", hinge("whole", &[&[whole], &files[..]].concat()), half);
    let part = mjcf(BLOCK, "<asset><mesh name='m' file='block.obj'/></asset>");
    let block = obj(&FACES);
    let beside = [
        ("main.xml", &b"<mujoco><include file='parts/part.xml'/></mujoco>"[..]),
        ("parts/part.xml", part.as_bytes()),
        ("parts/block.obj", block.as_bytes()),
    ];
    assert_six_digits("beside", hinge("beside", &beside), SWINGING_BLOCK);
}

#[test]
fn a_floating_base_is_the_robot_and_not_the_table() {
    let text = "<mujoco><worldbody><geom type='plane' size='1 1 1'/>
        <body name='robot' pos='0 0 1'><geom type='box' size='0.1 0.1 0.1'/>
        <body name='arm'><joint name='j' axis='0 1 0'/><geom size='0.1' pos='0.3 0 0'/></body></body>
        <body name='table'><geom type='box' size='1 1 0.1'/></body></worldbody></mujoco>";
    let options = LoadOptions::default().with_floating_base();
    let (model, _) = read("floating", &[("scene.xml", text.as_bytes())], &options).expect("a robot");
    assert_eq!(model.nv(), 7);
    let mass = model.mass_matrix(&model.initial_configuration()).expect("a configuration");
    assert!((mass[0] - 12.188_790).abs() < 1e-6, "{}", mass[0]);
}

#[test]
fn short_keyframes_are_filled() {
    let around = "<actuator><motor name='a' joint='hinge'/><motor name='b' joint='hinge'/></actuator>
        <keyframe><key name='home' qpos='0.5' qvel='0.1' ctrl='1'/></keyframe>";
    let robot = mjcf(BALL, around);
    let scene = "<mujoco><include file='robot.xml'/><worldbody><body name='cube' pos='1 2 3'><freejoint/>
        <geom type='box' size='0.1 0.1 0.1'/></body></worldbody></mujoco>";
    let files = [("scene.xml", scene.as_bytes()), ("robot.xml", robot.as_bytes())];
    let (model, _) = read("keyframe", &files, &LoadOptions::default()).expect("a robot");
    let pose = model.description().poses.iter().find(|pose| pose.name == "home").expect("the keyframe");
    assert_eq!(pose.controls, [1.0, 0.0]);
    let (q, v) = model.named_pose("home").expect("the keyframe");
    assert!(q.contains(&0.5) && v.contains(&0.1) && v.iter().filter(|v| **v != 0.0).count() == 1);
}

#[test]
fn files_that_mujoco_saved_have_no_warning() {
    let saved = "<compiler angle='radian' savecompiled='true'/><actuator>
        <general name='p' joint='hinge' input='pos' biastype='affine' gainprm='30' biasprm='0 -30 -2'/>
        <general name='i' joint='hinge' actdim='1' dyntype='integrator'/></actuator>";
    let geom = "<geom size='0.1' pos='0.3 0 0' castshadow='false'/>";
    let text = mjcf(geom, saved).replace("name='hinge' axis", "name='hinge' springyield='0' axis");
    assert_six_digits("saved", hinge("saved", &[("saved.xml", text.as_bytes())]), SWINGING_BALL);
}

#[test]
fn surfaces_with_exact_inertia_are_oriented_and_closed() {
    let text = mjcf(BLOCK, "<asset><mesh name='m' file='m.obj' inertia='exact'/></asset>");
    let with = |name: &str, faces: &[[usize; 3]]| {
        let mesh = obj(faces);
        read(name, &[("m.xml", text.as_bytes()), ("m.obj", mesh.as_bytes())], &LoadOptions::default())
    };
    assert_six_digits("closed", numbers(&with("closed", &FACES).expect("a robot").0), SWINGING_BLOCK);
    let turned: Vec<_> = FACES
        .iter()
        .enumerate()
        .map(|(k, &[a, b, c])| if k % 3 == 0 { [a, c, b] } else { [a, b, c] })
        .collect();
    for faces in [turned, [FACES, FACES].concat()] {
        let message = with("mixed", &faces).expect_err("not oriented");
        let names_the_fault = message.contains("same direction") || message.contains("twice");
        assert!(names_the_fault, "{message}");
    }
    let (_, report) = with("open", &FACES[2..]).expect("a robot");
    assert!(report.warnings().any(|warning| warning.message().contains("open")), "{report}");
}

#[test]
fn meshes_of_other_programs_are_read() {
    let text = |file: &str| mjcf(BLOCK, &format!("<asset><mesh name='m' file='{file}'/></asset>"));
    let with =
        |name: &str, file: &str, mesh: &[u8]| hinge(name, &[("m.xml", text(file).as_bytes()), (file, mesh)]);
    assert_six_digits("points", with("points", "m.obj", obj(&[]).as_bytes()), SWINGING_BLOCK);
    let latin = [&b"o K\xf6rper1\n"[..], obj(&FACES).as_bytes()].concat();
    assert_six_digits("latin", with("latin", "m.obj", &latin), SWINGING_BLOCK);
    for (name, mesh) in [
        ("no_name", stl("solid", str::to_owned)),
        ("named", stl("solid block", str::to_owned)),
        ("capitals", stl("SOLID BLOCK", str::to_uppercase)),
    ] {
        assert_six_digits(name, with(name, "m.stl", mesh.as_bytes()), SWINGING_BLOCK);
    }
    let sphere = mjcf(
        "<geom type='mesh' mesh='m' pos='0.3 0 0'/>",
        "<asset><mesh name='m' builtin='sphere' params='2' scale='0.1 0.1 0.1'/></asset>",
    );
    assert_six_digits("builtin", hinge("builtin", &[("m.xml", sphere.as_bytes())]), [4.047_045, 0.380_056]);
    let hills: Vec<u8> = [2_i32.to_le_bytes(), 2_i32.to_le_bytes()]
        .into_iter()
        .chain([0.0_f32, 0.5, 1.0, 0.25].map(f32::to_le_bytes))
        .flatten()
        .collect();
    let scene = mjcf(BALL, "<asset><hfield file='hills.bin' size='1 1 0.1 0.1'/></asset>")
        .replace("<worldbody>", "<worldbody><geom type='hfield' hfield='hills'/>");
    let [mass, inertia] = hinge("hills", &[("m.xml", scene.as_bytes()), ("hills.bin", &hills)]);
    assert!(mass >= SWINGING_BALL[0] - 1e-5 && (inertia - SWINGING_BALL[1]).abs() < 1e-6, "{mass} {inertia}");
}

#[test]
fn properties_of_joints_without_effect_are_no_warning() {
    let neutral = urdf("<joint_properties friction='0.0'/>", "");
    assert_six_digits("neutral", hinge("neutral", &[("r.urdf", neutral.as_bytes())]), SWINGING_ARM);
    let some = urdf("<joint_properties damping='1.5' friction='0.2'/>", "");
    let (model, report) =
        read("some", &[("r.urdf", some.as_bytes())], &LoadOptions::default()).expect("a robot");
    assert_eq!(report.warnings().count(), 0, "{report}");
    let joint = &model.description().joints[0];
    assert_eq!((joint.passive.damping, joint.passive.friction), (1.5, 0.2));
}

#[test]
fn loose_markup_and_other_encodings_are_read_with_at_most_a_warning() {
    let text = format!("<?xml version='1.0' encoding='GBK'?>{}", urdf("", "<!-- @ -->"));
    let gbk: Vec<u8> =
        text.bytes().flat_map(|byte| if byte == b'@' { vec![0xbb, 0xfa] } else { vec![byte] }).collect();
    let cases: [(&str, &str, Vec<u8>, [f64; 2]); 6] = [
        ("ampersand", "r.urdf", urdf("", "<gazebo><topic>a&b</topic></gazebo>").into_bytes(), SWINGING_ARM),
        ("dashes", "r.urdf", urdf("", "<!-- left -- right -->").into_bytes(), SWINGING_ARM),
        ("gbk", "r.urdf", gbk, SWINGING_ARM),
        (
            "windows1252",
            "r.urdf",
            [&b"<?xml version='1.0' encoding='windows-1252'?>"[..], urdf("", "").as_bytes()].concat(),
            SWINGING_ARM,
        ),
        (
            "no_space",
            "m.xml",
            mjcf("<geom name='g'type='box' size='0.1 0.1 0.1' pos='0.3 0 0'/>", "").into_bytes(),
            [8.0, 0.773_333],
        ),
        ("rule", "m.xml", mjcf(BALL, "<!------- arm ------->").into_bytes(), SWINGING_BALL),
    ];
    for (name, file, content, expected) in cases {
        let (model, report) = read(name, &[(file, &content)], &LoadOptions::default()).expect(name);
        assert!(report.warnings().count() <= 1, "{name}: {report}");
        assert_six_digits(name, numbers(&model), expected);
    }
}

#[test]
fn a_site_named_as_its_body_keeps_its_place() {
    let text = mjcf(&format!("{BALL}<site name='arm' pos='0.5 0 0'/>"), "");
    let (model, report) =
        read("site", &[("m.xml", text.as_bytes())], &LoadOptions::default()).expect("a robot");
    let place = |frame: &str| {
        let frame = model.frame(frame).expect("a frame");
        model.frame_pose(&[0.0], frame).expect("a configuration").apply([0.0; 3])
    };
    assert_eq!((place("arm"), place("arm_2")), ([0.0, 0.0, 1.0], [0.5, 0.0, 1.0]));
    assert!(report.warnings().any(|warning| warning.message().contains("arm_2")), "{report}");
}

#[test]
fn files_of_other_kinds_are_named() {
    let cases: [(&str, &[u8], &str); 3] = [
        ("robot.mjb", b"\x31\xd4\x00\x00 compiled model of MuJoCo \x00\x01", "MuJoCo"),
        ("robot.srdf", b"<robot name='r'><group name='arm'><joint name='j'/></group></robot>", "SRDF"),
        ("robot.zip", b"PK\x03\x04\x14\x00\x00\x00\x00\x00", "ZIP"),
    ];
    for (file, content, word) in cases {
        let message = read("other", &[(file, content)], &LoadOptions::default()).expect_err(file);
        assert!(message.contains(word), "{file}: {message}");
    }
}
