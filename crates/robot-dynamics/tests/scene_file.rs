//! Scene files against the same robot written by hand, and their errors.

use std::path::{Path, PathBuf};
use std::time::Instant;

use robot_dynamics::description::{JointKind, Mount, Object, Pose, Scene, Shape};
use robot_dynamics::model::{Model, random_state};
use robot_dynamics::nalgebra::Vector3;
use robot_dynamics::number::SplitMix64;
use robot_dynamics::{
    FileError, FileSet, LoadOptions, MeshMass, MeshSolid, load_description, load_description_from_files,
    load_description_from_text, mesh_object,
};

const ARM: &str = r#"<robot name="arm">
  <link name="mount"><inertial><origin xyz="0 0 0.1"/><mass value="3"/>
    <inertia ixx="0.02" iyy="0.03" izz="0.04" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="rod"><inertial><origin xyz="0.2 0 0"/><mass value="1.5"/>
    <inertia ixx="0.001" iyy="0.02" izz="0.021" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="shoulder" type="continuous"><parent link="mount"/><child link="rod"/>
    <origin xyz="0 0 0.2" rpy="0.3 0 0"/><axis xyz="0 1 0"/><dynamics damping="0.2"/></joint></robot>"#;

const CART: &str = r#"<mujoco model="cart"><worldbody><body name="cart"><inertial pos="0 0 0.1" mass="20"
  diaginertia="1 1.2 1.5"/></body></worldbody></mujoco>"#;

const SCENE: &str = r#"<scene name="cell">
  <robot file="cart.xml" joint="fixed"/>
  <robot file="arm.urdf" on="cart" xyz="0.1 0 0.3" rpy="0 0 0.5" prefix="a_" joint="planar"/>
  <ground friction="0.7"/>
  <table name="table" size="1 0.6 0.4" xyz="0.9 0 0"/>
  <wall name="wall" from="0 2" to="3 2" height="2.5"/>
  <box name="cube" size="0.1 0.1 0.2" mass="0.5" xyz="0.8 0 0.5" rpy="0 0 1"/>
  <sphere name="ball" radius="0.05" density="1000" xyz="1 0 0.46"/>
  <box name="door" size="0.8 0.04 2" mass="20" joint="revolute" axis="1 0 0" xyz="0 1 1"/>
</scene>"#;

/// The same robot by hand.
fn by_hand() -> String {
    let ball = 1000.0 * 4.0 / 3.0 * core::f64::consts::PI * 0.05_f64.powi(3);
    format!(
        r#"<mujoco model="cell"><compiler eulerseq="XYZ" angle="radian" autolimits="true"/><worldbody>
      <geom name="ground" type="plane" size="0 0 1" friction="0.7"/>
      <geom name="table" type="box" size="0.5 0.3 0.2" pos="0.9 0 0.2"/>
      <geom name="wall" type="box" size="1.5 0.05 1.25" pos="1.5 2 1.25"/>
      <body name="cart"><inertial pos="0 0 0.1" mass="20" diaginertia="1 1.2 1.5"/>
        <body name="a_mount" pos="0.1 0 0.3" euler="0 0 0.5">
          <joint name="px" type="slide" axis="1 0 0"/><joint name="py" type="slide" axis="0 1 0"/>
          <joint name="turn" axis="0 0 1"/>
          <inertial pos="0 0 0.1" mass="3" diaginertia="0.02 0.03 0.04"/>
          <body name="a_rod" pos="0 0 0.2" euler="0.3 0 0"><joint name="a_shoulder" axis="0 1 0" damping="0.2"/>
            <inertial pos="0.2 0 0" mass="1.5" diaginertia="0.001 0.02 0.021"/></body>
        </body></body>
      <body name="cube" pos="0.8 0 0.5" euler="0 0 1"><freejoint name="cube_joint"/>
        <geom type="box" size="0.05 0.05 0.1" mass="0.5"/></body>
      <body name="ball" pos="1 0 0.46"><freejoint name="ball_joint"/><inertial pos="0 0 0" mass="{ball:?}"
        diaginertia="{i:?} {i:?} {i:?}"/><geom type="sphere" size="0.05"/></body>
      <body name="door" pos="0 1 1"><joint name="door_joint" axis="1 0 0"/>
        <geom type="box" size="0.4 0.02 1" mass="20"/></body>
    </worldbody></mujoco>"#,
        i = 0.4 * ball * 0.05 * 0.05
    )
}

fn files() -> FileSet {
    FileSet::new([("cells/cell.scene.xml", SCENE), ("cells/arm.urdf", ARM), ("cells/cart.xml", CART)])
}

/// A folder of its own with the files of the scene.
fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("scene_file_{name}_{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    for (name, text) in [("cell.scene.xml", SCENE), ("arm.urdf", ARM), ("cart.xml", CART)] {
        std::fs::write(folder.join(name), text).expect("a file");
    }
    folder
}

/// M and bias of a scene are those of one MJCF file written by hand, in which a planar joint is two slides
/// and a hinge. Tolerance: rounding, 1e-12 of the largest entry.
#[test]
fn a_scene_is_the_robot_written_by_hand() {
    let options = LoadOptions::default();
    let folder = folder("by_hand");
    let from_disk = load_description(folder.join("cell.scene.xml"), &options).expect("a scene");
    let from_memory =
        load_description_from_files(&files(), "cells/cell.scene.xml", &options).expect("a scene");
    assert_eq!(from_disk.description, from_memory.description);
    assert_eq!(from_disk.report.files.len(), 3);
    assert_eq!(from_disk.report.counts.degrees_of_freedom, 3 + 1 + 6 + 6 + 1);
    std::fs::remove_dir_all(folder).expect("its folder");
    let ours = Model::new(from_disk.description).expect("a scene");
    let theirs = load_description_from_text(&by_hand(), &options).expect("MJCF").description;
    let theirs = Model::new(theirs).expect("MJCF");
    assert_eq!(ours.nv(), theirs.nv());
    let order = |model: &Model, names: &[&str]| -> Vec<usize> {
        let of = |name: &&str| model.joints().iter().find(|joint| joint.name == *name).expect("a joint").v();
        names.iter().flat_map(of).collect()
    };
    let free = ["a_shoulder", "cube_joint", "ball_joint", "door_joint"];
    let own = order(&ours, &[&["a_mount_joint"][..], &free].concat());
    let other = order(&theirs, &[&["px", "py", "turn"][..], &free].concat());
    let mut random = SplitMix64::new(5);
    for _ in 0..10 {
        let state = random_state(&ours, &mut random);
        let (mut q, mut v) = (vec![0.0; theirs.nq()], vec![0.0; theirs.nv()]);
        for joint in theirs.joints().iter().filter(|joint| joint.nv > 0) {
            let planar = ["px", "py", "turn"].iter().position(|name| *name == joint.name);
            let name = if planar.is_some() { "a_mount_joint" } else { joint.name.as_str() };
            let same = ours.joints().iter().find(|own| own.name == name).expect("a joint");
            let part = |values: &[f64]| planar.map_or(values.to_vec(), |k| vec![values[k]]);
            q[joint.q()].copy_from_slice(&part(&state.q[same.q()]));
            v[joint.v()].copy_from_slice(&part(&state.v[same.v()]));
        }
        let (mass, expected) = (ours.mass_matrix(&state.q).expect("M"), theirs.mass_matrix(&q).expect("M"));
        let (bias, b) = (ours.bias(&state.q, &state.v).expect("bias"), theirs.bias(&q, &v).expect("bias"));
        for (i, k) in own.iter().zip(&other) {
            for (j, l) in own.iter().zip(&other) {
                let off = (mass[(*i, *j)] - expected[(*k, *l)]).abs();
                assert!(off < 1e-12 * expected.amax(), "M[{i}, {j}] differs by {off:e}");
            }
            assert!((bias[*i] - b[*k]).abs() < 1e-12 * b.amax(), "bias {i}: {} and {}", bias[*i], b[*k]);
        }
    }
}

/// The file gives the same robot as the functions of a scene.
#[test]
fn a_file_says_what_a_program_says() {
    let options = LoadOptions::default();
    let [arm, cart] =
        [ARM, CART].map(|text| load_description_from_text(text, &options).expect("a robot").description);
    let mut scene = Scene::new("cell");
    let at = |x, y, z| Pose::from_translation([x, y, z]);
    scene.add(&cart, &Mount::on("world").with_joint(JointKind::Fixed)).expect("a cart");
    let planar = JointKind::Planar { normal: [0.0, 0.0, 1.0] };
    let pose = Pose::from_xyz_rpy([0.1, 0.0, 0.3], [0.0, 0.0, 0.5]);
    scene.add(&arm, &Mount::on("cart").with_pose(pose).with_prefix("a_").with_joint(planar)).expect("an arm");
    scene.add_object(&Object::ground().with_friction(0.7), Pose::IDENTITY).expect("a ground");
    scene.add_object(&Object::table("table", [1.0, 0.6, 0.4]), at(0.9, 0.0, 0.0)).expect("a table");
    scene
        .add_object(&Object::wall("wall", [[0.0, 2.0], [3.0, 2.0]], 2.5, 0.1), at(0.0, 0.0, 0.0))
        .expect("a wall");
    let cube = Object::of_mass("cube", Shape::Box { size: [0.1, 0.1, 0.2] }, 0.5);
    scene.add_object(&cube, Pose::from_xyz_rpy([0.8, 0.0, 0.5], [0.0, 0.0, 1.0])).expect("a cube");
    let ball = Object::of_density("ball", Shape::Sphere { radius: 0.05 }, 1000.0);
    scene.add_object(&ball, at(1.0, 0.0, 0.46)).expect("a ball");
    let door = Object::of_mass("door", Shape::Box { size: [0.8, 0.04, 2.0] }, 20.0);
    let hinge = JointKind::Revolute { axis: [1.0, 0.0, 0.0] };
    scene.add_object(&door, Mount::at(at(0.0, 1.0, 1.0)).with_joint(hinge)).expect("a door");
    let read = load_description_from_files(&files(), "cells/cell.scene.xml", &options).expect("a scene");
    assert_eq!(read.description, scene.into_description());
}

fn refused(text: &str) -> Vec<String> {
    let mut files = files();
    files.insert("cells/cell.scene.xml", text);
    match load_description_from_files(&files, "cells/cell.scene.xml", &LoadOptions::default()) {
        Err(error @ FileError::Scene(_)) => error.messages(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn errors_have_their_lines_and_all_are_listed() {
    let text = r#"<scene gravty="0 0 -1">
  <robot file="armm.urdf"/>
  <robot file="arm.urdf" on="carrt"/>
  <box name="a" size="1 1"/>
  <box name="b" size="1 1 1" mass="1" density="2"/>
  <sphere radius="1"/>
  <cylinder name="c" radius="1" length="nan"/>
  <cone name="d"/>
  <robot file="arm.urdf" joint="hinge" prefix="b_"/>
  <box name="e" size="1 1 1" frictoin="1"/>
  <robot/>
</scene>"#;
    let found = refused(text);
    let expected = [
        "line 1: scene: the attribute `gravty` is unknown; did you mean `gravity`?",
        "line 2: robot \"armm.urdf\": the file is not among the given files",
        "line 3: robot \"arm.urdf\": the robot has no link or frame `carrt`; it has world",
        "line 4: box \"a\": size=\"1 1\" must be 3 finite numbers",
        "line 5: box \"b\": give mass or density, not both",
        "line 6: sphere: the attribute `name` is missing; write name=\"NAME\"",
        "line 7: cylinder \"c\": length=\"nan\" must be a finite number",
        "line 8: cone \"d\": the element <cone> is unknown; a scene has robot, ground, table, wall, box, sphere, \
         cylinder, capsule, ellipsoid, mesh",
        "line 9: robot \"arm.urdf\": joint=\"hinge\" must be fixed, revolute, continuous, prismatic, helical, \
         universal, planar, spherical or floating",
        "line 10: box \"e\": the attribute `frictoin` is unknown; did you mean `friction`?",
        "line 11: robot: the attribute `file` is missing; write file=\"arm.urdf\"",
    ];
    for line in expected {
        assert!(found.iter().any(|message| message == line), "{line}\n is not in {found:#?}");
    }
    assert_eq!(found.len(), expected.len(), "{found:#?}");
    let bad_robot = refused("<scene>\n<robot file=\"bad.urdf\"/></scene>");
    assert_eq!(bad_robot, ["line 2: robot \"bad.urdf\": the file is not among the given files"]);
}

#[test]
fn scenes_nest_but_not_without_end() {
    let mut files = files();
    files.insert("room.scene.xml", "<scene><robot file='cells/cell.scene.xml' prefix='c_'/></scene>");
    let options = LoadOptions::default();
    let room = load_description_from_files(&files, "room.scene.xml", &options).expect("a scene in a scene");
    assert!(room.description.links.iter().any(|link| link.name == "c_a_rod"));
    let itself = refused("<scene><robot file='cell.scene.xml' prefix='a'/></scene>");
    assert!(itself[0].contains("scenes are nested deeper than 8 levels"), "{itself:?}");
    // 40⁶ copies of a robot with 2000 links: the sum of all parts has a limit.
    let links = (0..2000).map(|k| format!("<link name='l{k}'/>")).collect::<Vec<_>>().concat();
    let joint =
        |k: usize| format!("<joint name='j{k}' type='fixed'><parent link='l0'/><child link='l{k}'/></joint>");
    let joints = (1..2000).map(joint).collect::<Vec<_>>().concat();
    files.insert("large.urdf", format!("<robot name='large'>{links}{joints}</robot>"));
    let copy = |k: usize| format!("<robot file='{{}}' prefix='p{k}_'/>");
    let copies = (0..40).map(copy).collect::<Vec<_>>().concat();
    for level in 0..6 {
        let next = if level == 5 { "large.urdf".to_owned() } else { format!("level{}.xml", level + 1) };
        files.insert(format!("level{level}.xml"), format!("<scene>{}</scene>", copies.replace("{}", &next)));
    }
    let refused = load_description_from_files(&files, "level0.xml", &options).expect_err("4·10⁹ robots");
    assert!(refused.messages()[0].contains("the scene has more than"), "{:?}", refused.messages()[0]);
}

#[test]
fn a_confined_scene_opens_no_file_outside_its_folder() {
    let folder = folder("confined");
    let inner = folder.join("inner");
    std::fs::create_dir_all(&inner).expect("a folder");
    std::fs::write(inner.join("s.xml"), "<scene><robot file='../arm.urdf'/></scene>").expect("a file");
    load_description(inner.join("s.xml"), &LoadOptions::default()).expect("files may be anywhere");
    let refused = load_description(inner.join("s.xml"), &LoadOptions::default().with_confined());
    let message = refused.expect_err("a confined scene").messages().remove(0);
    assert!(message.contains("confined"), "{message}");
    let floating =
        load_description(folder.join("cell.scene.xml"), &LoadOptions::default().with_floating_base());
    assert!(floating.expect_err("no base").to_string().contains("floating_base=\"true\""));
    std::fs::remove_dir_all(folder).expect("its folder");
}

/// An object's mass properties by its mesh are those of the primitive with the same surface.
#[test]
fn mesh_objects_have_the_mass_of_their_solid() {
    let folder = folder("mesh");
    let path = folder.join("box.obj");
    let corner = |k: usize| [(k & 1) as f64 * 0.2, ((k >> 1) & 1) as f64 * 0.4, ((k >> 2) & 1) as f64 * 0.6];
    let corners = (0..8).map(corner).map(|[x, y, z]| format!("v {x} {y} {z}\n"));
    let faces = ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"];
    let lines: Vec<String> = corners.chain(faces.map(|face| format!("f {face}\n"))).collect();
    std::fs::write(&path, lines.concat()).expect("a file");
    let cuboid = Shape::Box { size: [0.2, 0.4, 0.6] };
    let expected = cuboid.solid(500.0).expect("a volume").expect("a density");
    for (scale, solid) in
        [([1.0; 3], MeshSolid::Exact), ([-1.0, 1.0, 1.0], MeshSolid::Exact), ([1.0; 3], MeshSolid::Hull)]
    {
        let object = mesh_object("crate", &path, scale, MeshMass::Density(500.0), solid).expect("a box");
        let body = object.mass_properties.expect("a mass");
        // The coordinates have single precision.
        assert!((body.mass() - expected.mass()).abs() < 1e-6 * expected.mass(), "{}", body.mass());
        let center = Vector3::new(0.1 * scale[0], 0.2, 0.3);
        assert!((body.center_of_mass() - center).amax() < 1e-7);
        let off = body.inertia_about_center_of_mass() - expected.inertia_about_center_of_mass();
        assert!(off.amax() < 1e-6, "{off}");
        let by_mass =
            mesh_object("crate", &path, scale, MeshMass::Mass(expected.mass()), solid).expect("a box");
        let by_mass = by_mass.mass_properties.expect("a mass").inertia_about_center_of_mass();
        assert!((by_mass - expected.inertia_about_center_of_mass()).amax() < 1e-6);
    }
    std::fs::write(&path, lines[..13].concat()).expect("a file");
    let refused = mesh_object("crate", &path, [1.0; 3], MeshMass::Mass(1.0), MeshSolid::Exact).unwrap_err();
    assert!(refused.to_string().contains("open at 4 edges"), "{refused}");
    mesh_object("crate", &path, [1.0; 3], MeshMass::Mass(1.0), MeshSolid::Hull).expect("its hull");
    // In a scene's file the shape and the mass are the same, and the hull of the mesh touches the ground.
    std::fs::write(&path, lines.concat()).expect("a file");
    let scene =
        r#"<scene><ground/><mesh name="crate" file="box.obj" scale="0.5" mass="2" xyz="0 0 0.01"/></scene>"#;
    std::fs::write(folder.join("s.xml"), scene).expect("a file");
    let robot = robot_dynamics::load(folder.join("s.xml")).expect("a scene");
    let mut simulation = robot.simulation().build().expect("a simulation");
    simulation.run_for(0.3).expect("a run");
    assert!((simulation.q()[2] + 0.01).abs() < 1e-5, "it rests on the ground: {:?}", simulation.q());
    std::fs::remove_dir_all(&folder).expect("its folder");
    let missing = mesh_object("x", Path::new("nowhere.stl"), [1.0; 3], MeshMass::Fixed, MeshSolid::Exact);
    assert!(missing.unwrap_err().to_string().starts_with("mesh `nowhere.stl`: "));
}

/// Mutants of a scene, with other values, names, elements and bytes, are read or refused: none panics, and
/// none takes long. `MUTANTS=100000` makes that many.
#[test]
fn mutants_are_read_or_refused() {
    let values = [
        "",
        "0",
        "-1",
        "nan",
        "inf",
        "1e308",
        "-1e308",
        "1e-320",
        "0 0 0",
        "1 2",
        "1 2 3",
        "1 0 0 0 0 0",
        "world",
        "cart",
        "a_rod",
        "ground",
        "true",
        "arm.urdf",
        "cell.scene.xml",
        "../cells/arm.urdf",
        "box.obj",
        "helical",
        "floating",
        "universal",
        "exact",
        "a\u{301}",
        "x y",
    ];
    let words = [
        "scene",
        "robot",
        "box",
        "sphere",
        "mesh",
        "ground",
        "wall",
        "table",
        "capsule",
        "ellipsoid",
        "name",
        "file",
        "xyz",
        "rpy",
        "mass",
        "density",
        "on",
        "joint",
        "axis",
        "pitch",
        "scale",
        "solid",
        "inertia",
        "size",
        "radius",
        "srdf",
        "prefix",
        "floating_base",
        "color",
        "friction",
        "half_axes",
    ];
    let mut random = SplitMix64::new(11);
    let mut pick = |count: usize| usize::try_from(random.next_u64() % count as u64).expect("a small number");
    let mut files = files();
    files.insert("cells/box.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 4 3\nf 1 2 4\nf 2 3 4\n");
    let whole = SCENE
        .replace("</scene>", "<mesh name='m' file='box.obj' mass='1' scale='0.5'/></scene>")
        .replace('\'', "\"");
    let count = std::env::var("MUTANTS").ok().and_then(|text| text.parse().ok()).unwrap_or(4000);
    let (mut read, mut compiled) = (0, 0);
    for _ in 0..count {
        // Text between quotes alternates between names of elements or attributes, and values.
        let mut pieces: Vec<String> = whole.split('"').map(str::to_owned).collect();
        for _ in 0..=pick(3) {
            let at = pick(pieces.len());
            match (at % 2, pick(4)) {
                (1, 0..=2) => pieces[at] = values[pick(values.len())].to_owned(),
                (0, 0 | 1) => {
                    let old: Vec<&str> =
                        words.iter().copied().filter(|word| pieces[at].contains(word)).collect();
                    if let Some(old) = old.get(pick(old.len().max(1))) {
                        pieces[at] = pieces[at].replacen(old, words[pick(words.len())], 1);
                    }
                }
                (_, 3) if pieces[at].is_ascii() && !pieces[at].is_empty() => {
                    let byte = pick(pieces[at].len());
                    pieces[at].remove(byte);
                }
                _ => {
                    let again = pieces[at].clone();
                    pieces.insert(at, again);
                }
            }
        }
        let text = pieces.join("\"");
        files.insert("cells/cell.scene.xml", text.clone());
        let start = Instant::now();
        if let Ok(found) =
            load_description_from_files(&files, "cells/cell.scene.xml", &LoadOptions::default())
        {
            read += 1;
            compiled += usize::from(Model::new(found.description).is_ok());
        }
        // A scene is read in about a millisecond; this allows for a loaded machine.
        assert!(start.elapsed().as_secs_f64() < 5.0, "{:?} for\n{text}", start.elapsed());
    }
    println!("{read} of {count} read, {compiled} compiled");
    assert!(read > 200 && compiled > 100, "most mutants break the scene: {read} read, {compiled} compiled");
}
