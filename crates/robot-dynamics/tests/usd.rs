//! USD files: those that converters write from the robots of this project, and features by hand.
//!
//! Tolerances: USD stores masses, poses of joints and rotations as floats. Floats are read as the shortest
//! decimal numbers that round to them. Where these are the numbers of the robot's file, M and the bias agree
//! to 1e-12 of the largest entry. Otherwise each number has a part of 6e-8 of rounding, half the unit in the
//! last place of a float. A chain of a dozen joints has about 128 such numbers: two rotations of four numbers
//! for each joint, and its masses.

use std::f64::consts::FRAC_PI_2;
use std::path::PathBuf;

use robot_dynamics::description::{Equality, JointKind, MassProperties, Mimic, RobotDescription, Shape};
use robot_dynamics::model::{Model, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::{LoadOptions, LoadedDescription, load_description, load_description_from_text};

const EXACT: f64 = 1e-12;
const FLOAT: f64 = 128.0 * 6e-8;

fn root(path: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
}

fn load(path: &str) -> LoadedDescription {
    load_description(root(path), &LoadOptions::default()).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// The places of a model's coordinates in another, by the names of joints: for q and v.
fn places(model: &Model, other: &Model) -> [Vec<usize>; 2] {
    let mut places = [Vec::new(), Vec::new()];
    for joint in model.joints().iter().filter(|joint| joint.nv > 0) {
        let found = other.joints().iter().find(|other| other.name == joint.name);
        // The joint of a free body has the name of a floating base, or of the file.
        let free = || other.joints().iter().find(|other| other.nv == 6 && joint.nv == 6);
        let found = found.or_else(free).unwrap_or_else(|| panic!("no joint {}", joint.name));
        assert_eq!(found.nv, joint.nv, "{}", joint.name);
        places[0].extend(found.q());
        places[1].extend(found.v());
    }
    places
}

fn assert_same(what: &str, one: &RobotDescription, other: &RobotDescription, tolerance: f64) {
    let [one, other] =
        [one, other].map(|robot| Model::new(robot.clone()).unwrap_or_else(|error| panic!("{what}: {error}")));
    assert_eq!((one.nq(), one.nv()), (other.nq(), other.nv()), "{what}");
    let [in_q, in_v] = places(&one, &other);
    let mut random = SplitMix64::new(7);
    for _ in 0..3 {
        let state = random_state(&one, &mut random);
        let (mut q, mut v) = (state.q.clone(), state.v.clone());
        in_q.iter().enumerate().for_each(|(at, &place)| q[place] = state.q[at]);
        in_v.iter().enumerate().for_each(|(at, &place)| v[place] = state.v[at]);
        let (m, bias) = (one.mass_matrix(&state.q).expect("M"), one.bias(&state.q, &state.v).expect("bias"));
        let other_m = other.mass_matrix(&q).expect("M");
        let other_bias = other.bias(&q, &v).expect("bias");
        for row in 0..one.nv() {
            for column in 0..one.nv() {
                let error = (m[(row, column)] - other_m[(in_v[row], in_v[column])]).abs();
                assert!(error <= tolerance * m.amax(), "{what}: M differs by {error:e} of {:e}", m.amax());
            }
            let error = (bias[row] - other_bias[in_v[row]]).abs();
            assert!(
                error <= tolerance * bias.amax(),
                "{what}: bias differs by {error:e} of {:e}",
                bias.amax()
            );
        }
    }
}

/// The files of `bench/golden/make_usd.py`, by urdf-usd-converter and mujoco-usd-converter.
#[test]
fn converted_robots_have_the_dynamics_of_their_files() {
    let exact = ["two_r", "three_r", "panda", "ur5", "linkage", "gripper_and_box"];
    for entry in std::fs::read_dir(root("testdata/usd")).expect("the folder") {
        let file = entry.expect("a file").file_name().into_string().expect("a name");
        let Some((stem, kind)) = file.strip_suffix(".usdc").and_then(|name| name.rsplit_once('_')) else {
            continue;
        };
        let usd = load(&format!("testdata/usd/{file}"));
        let mut own = load(&format!("robots/{stem}.{kind}"));
        if file == "hand_xml.usdc" {
            // The equality of two joints is a mimic joint in USD.
            let joint = own.description.joints.iter_mut().find(|joint| joint.name == "second_root");
            joint.expect("the joint").mimic = Some(Mimic::new("first_root", 1.0, 0.0));
        }
        if file == "quadruped_urdf.usdc" {
            // Without a mass, USD fills the collision shape of a foot with 1000 kg/m³.
            for link in own.description.links.iter_mut().filter(|link| link.name.ends_with("foot")) {
                link.mass_properties = MassProperties::solid_sphere(1000.0, 0.02).ok();
            }
        }
        let tolerance = if exact.contains(&stem) { EXACT } else { FLOAT };
        assert_same(&file, &own.description, &usd.description, tolerance);
    }
}

/// A flat file of `bench/golden/make_usd_double.py`, with doubles where the schema has floats.
#[test]
fn doubles_are_not_rounded() {
    let (own, usd) = (load("robots/dual_arm.urdf"), load("testdata/usd/dual_arm.usda"));
    assert_same("dual_arm.usda", &own.description, &usd.description, EXACT);
}

const HEADER: &str = "#usda 1.0\n( metersPerUnit = 1\n upAxis = \"Z\" )\n";

fn text_with(header: &str, parts: &str) -> LoadedDescription {
    let text = format!("{header}{parts}");
    load_description_from_text(&text, &LoadOptions::default())
        .unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn text(parts: &str) -> LoadedDescription {
    text_with(HEADER, parts)
}

/// A body of 1 kg at a place, with properties.
fn body(name: &str, at: [f64; 3], rest: &str) -> String {
    let [x, y, z] = at;
    format!(
        "def Xform \"{name}\" (apiSchemas = [\"PhysicsRigidBodyAPI\", \"PhysicsMassAPI\"])\n{{\nfloat physics:mass = 1\n\
         float3 physics:diagonalInertia = (0.1, 0.2, 0.3)\npoint3f physics:centerOfMass = (0, 0, 0)\n\
         double3 xformOp:translate = ({x}, {y}, {z})\nuniform token[] xformOpOrder = [\"xformOp:translate\"]\n{rest}\n}}\n"
    )
}

fn joint(kind: &str, name: &str, ends: [&str; 2], rest: &str) -> String {
    let end = |side: usize| match ends[side] {
        "" => String::new(),
        path => format!("rel physics:body{side} = <{path}>\n"),
    };
    let schemas = match rest.split_once('|') {
        Some((schemas, _)) => format!("(apiSchemas = [{schemas}])\n"),
        None => String::new(),
    };
    let rest = rest.split_once('|').map_or(rest, |(_, rest)| rest);
    format!("def Physics{kind}Joint \"{name}\" {schemas}{{\n{}{}{rest}\n}}\n", end(0), end(1))
}

fn warnings(loaded: &LoadedDescription) -> Vec<String> {
    loaded.report.warnings().map(|finding| format!("{}: {}", finding.place(), finding.message())).collect()
}

/// Centimetres, grams and y upwards: 1 kg at 1 m in front of a hinge about the vertical.
#[test]
fn units_and_the_vertical_are_converted() {
    let header = "#usda 1.0\n( metersPerUnit = 0.01\n kilogramsPerUnit = 0.001\n upAxis = \"Y\" )\n";
    let parts = format!(
        "def PhysicsScene \"scene\" {{ float physics:gravityMagnitude = 162 }}\n{}{}",
        "def Xform \"a\" (apiSchemas = [\"PhysicsRigidBodyAPI\", \"PhysicsMassAPI\"]) { float physics:mass = 1000\n\
         float3 physics:diagonalInertia = (1e6, 2e6, 3e6)\npoint3f physics:centerOfMass = (100, 0, 0) }\n",
        joint(
            "Revolute",
            "j",
            ["", "/a"],
            "\"PhysicsDriveAPI:angular\"|uniform token physics:axis = \"Y\"\n\
            float physics:upperLimit = 90\nfloat drive:angular:physics:stiffness = 1e6\nfloat drive:angular:physics:maxForce = 2e7"
        ),
    );
    let loaded = text_with(header, &parts);
    let robot = &loaded.description;
    assert_eq!(robot.gravity, [0.0, 0.0, -1.62]);
    let body = robot.links[1].mass_properties.expect("a mass");
    assert!((body.mass() - 1.0).abs() < 1e-15 && (body.center_of_mass().x - 1.0).abs() < 1e-15);
    // 10⁶ g cm² are 0.1 kg m².
    assert!((body.inertia_about_center_of_mass()[(1, 1)] - 0.2).abs() < 1e-15);
    let model = Model::new(robot.clone()).expect("a robot");
    assert!((model.mass_matrix(&[0.3]).expect("M")[(0, 0)] - 1.2).abs() < 1e-14);
    assert!(model.gravity_forces(&[0.3]).expect("g")[0].abs() < 1e-15);
    let joint = &robot.joints[0];
    assert!((joint.limits.upper - FRAC_PI_2).abs() < 1e-15 && joint.limits.lower == f64::NEG_INFINITY);
    // 10⁶ g cm²/s² per degree are 0.1 N m per degree.
    let drive = &robot.actuators[0];
    assert!((drive.gain.constant - 0.1 * 1_f64.to_degrees()).abs() < 1e-12);
    assert!((drive.force_range[1] - 2.0).abs() < 1e-15 && (joint.limits.effort - 2.0).abs() < 1e-15);
}

/// The frames of both sides: in body0 at (1, 0, 0) with the x axis along y, in body1 at (0, 0, −1). The hinge
/// is off the origin of body1, which gets a link without mass.
#[test]
fn frames_of_both_sides_place_the_child() {
    let parts = [
        body("a", [0.0; 3], ""),
        body("b", [5.0, 5.0, 5.0], ""),
        joint("Fixed", "base", ["", "/a"], ""),
        joint(
            "Revolute",
            "j",
            ["/a", "/b"],
            "point3f physics:localPos0 = (1, 0, 0)\n\
            quatf physics:localRot0 = (0.70710677, 0, 0, 0.70710677)\npoint3f physics:localPos1 = (0, 0, -1)",
        ),
    ];
    let robot = text(&parts.concat()).description;
    let names: Vec<&str> = robot.links.iter().map(|link| link.name.as_str()).collect();
    assert_eq!(names, ["world", "a", "b", "j_frame"]);
    let model = Model::new(robot).expect("a robot");
    let angle = 0.4_f64;
    let pose = model.frame_pose(&[angle], model.frame("b").expect("b")).expect("a pose");
    // The link turns about the y axis of the world through (1, 0, 0).
    let expected = [1.0 + angle.sin(), 0.0, angle.cos()];
    for (found, expected) in pose.translation.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-15, "{pose:?}");
    }
}

/// A generic joint with a limited and a free translation and a free rotation is a series of joints; three
/// free rotations are a ball joint.
#[test]
fn generic_joints_are_joints_in_series() {
    let locked = |axes: &[&str]| -> String {
        let lock = |axis: &&str| {
            format!("float limit:{axis}:physics:low = 1\nfloat limit:{axis}:physics:high = -1\n")
        };
        axes.iter().map(lock).collect::<Vec<_>>().concat()
    };
    let kinds = |rest: &str| -> Vec<String> {
        let parts = [body("a", [0.0; 3], ""), joint("", "j", ["", "/a"], rest)];
        let robot = text(&parts.concat()).description;
        robot.joints.iter().map(|joint| format!("{} {}", joint.name, joint.kind)).collect()
    };
    let limits = "float limit:transY:physics:low = -1\nfloat limit:transY:physics:high = 2\n";
    let rest = format!("{}{limits}", locked(&["transX", "rotX", "rotY"]));
    assert_eq!(kinds(&rest), ["j_transY prismatic", "j_transZ prismatic", "j_rotZ continuous"]);
    assert_eq!(kinds(&locked(&["transX", "transY", "transZ"])), ["j spherical"]);
    assert_eq!(kinds(&locked(&["transX", "transY", "transZ", "rotX", "rotY"])), ["j continuous"]);
    assert_eq!(kinds(&locked(&["transX", "transY", "transZ", "rotX", "rotY", "rotZ"])), ["j fixed"]);
    assert_eq!(kinds(""), ["j floating"]);
}

/// A joint that the articulation excludes closes a loop; a distance joint is left out with a warning.
#[test]
fn excluded_joints_close_loops() {
    let parts = [
        body("a", [0.0; 3], ""),
        body("b", [1.0, 0.0, 0.0], ""),
        joint("Revolute", "one", ["", "/a"], "uniform token physics:axis = \"Z\""),
        joint(
            "Revolute",
            "two",
            ["", "/b"],
            "uniform token physics:axis = \"Z\"\npoint3f physics:localPos0 = (1, 0, 0)",
        ),
        joint(
            "Spherical",
            "pin",
            ["/a", "/b"],
            "bool physics:excludeFromArticulation = 1\npoint3f physics:localPos0 = (1, 0, 0)",
        ),
        joint("Distance", "rope", ["/a", "/b"], "float physics:maxDistance = 3"),
    ];
    let loaded = text(&parts.concat());
    let [equality] = &loaded.description.equalities[..] else {
        panic!("{:?}", loaded.description.equalities)
    };
    let Equality::Connect { a, b } = &equality.kind else { panic!("{equality:?}") };
    assert_eq!((a.1, b.1), ([1.0, 0.0, 0.0], [0.0; 3]));
    assert_eq!(warnings(&loaded), ["/rope: a joint that limits a distance is not in the model"]);
}

/// The mass of a shape by its own density, then that of the body, of the material, and of water.
#[test]
fn densities_have_an_order() {
    let shape = |schemas: &str, rest: &str| {
        format!(
            "def Xform \"a\" (apiSchemas = [\"PhysicsRigidBodyAPI\"{schemas}])\n{{ {rest} }}\n\
             def Material \"m\" (apiSchemas = [\"PhysicsMaterialAPI\"]) {{ float physics:density = 30 }}"
        )
    };
    let mass = |parts: String| text(&parts).description.links[1].mass_properties.expect("a mass").mass();
    let cube = |schemas: &str, rest: &str| {
        format!(
            "def Cube \"c\" (apiSchemas = [\"PhysicsCollisionAPI\"{schemas}])\n{{ double size = 1\n{rest} }}"
        )
    };
    let bound = "rel material:binding:physics = </m>\n";
    let own = cube(", \"PhysicsMassAPI\"", &format!("{bound}float physics:density = 10"));
    assert_eq!(mass(shape(", \"PhysicsMassAPI\"", &format!("float physics:density = 20\n{own}"))), 10.0);
    let plain = cube("", bound);
    assert_eq!(mass(shape(", \"PhysicsMassAPI\"", &format!("float physics:density = 20\n{plain}"))), 20.0);
    assert_eq!(mass(shape("", &plain)), 30.0);
    assert_eq!(mass(shape("", &cube("", ""))), 1000.0);
    assert_eq!(mass(shape(", \"PhysicsMassAPI\"", &format!("float physics:mass = 5\n{own}"))), 5.0);
}

/// A scaled body and a scaled shape: a cube of edge 2 becomes a box. Its mass and the centre of mass follow.
#[test]
fn scales_change_shapes_and_points() {
    let parts = "def Xform \"a\" (apiSchemas = [\"PhysicsRigidBodyAPI\", \"PhysicsMassAPI\"])\n{\n\
        float physics:density = 10\npoint3f physics:centerOfMass = (1, 0, 0)\nfloat3 xformOp:scale = (2, 1, 1)\n\
        uniform token[] xformOpOrder = [\"xformOp:scale\"]\n\
        def Cube \"c\" (apiSchemas = [\"PhysicsCollisionAPI\"]) { float3 xformOp:scale = (1, 2, 3)\n\
        double3 xformOp:translate = (1, 0, 0)\nuniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:scale\"] } }";
    let robot = text(parts).description;
    assert_eq!(robot.shapes[0].shape, Shape::Box { size: [4.0, 4.0, 6.0] });
    assert_eq!(robot.shapes[0].link_from_shape.translation, [2.0, 0.0, 0.0]);
    let body = robot.links[1].mass_properties.expect("a mass");
    assert!((body.mass() - 960.0).abs() < 1e-10, "{}", body.mass());
    assert_eq!(<[f64; 3]>::from(body.center_of_mass()), [2.0, 0.0, 0.0]);
}

/// Newton's attributes of angles are in degrees, and PhysX's velocities too. Unread ones are one warning for
/// each name.
#[test]
fn attributes_of_other_schemas_are_read() {
    let rest = |more: &str| {
        format!(
            "uniform token physics:axis = \"Z\"\nfloat newton:armature = 0.5\nfloat newton:damping = 2\n\
             float newton:friction = 3\nfloat physxJoint:maxJointVelocity = 90\n{more}"
        )
    };
    let parts = [
        body("a", [0.0; 3], ""),
        body("b", [0.0; 3], ""),
        joint("Revolute", "one", ["", "/a"], &rest("float newton:strange = 1")),
        joint(
            "Revolute",
            "two",
            ["/a", "/b"],
            &rest(
                "float newton:strange = 1\nrel newton:mimicJoint = </one>\n\
            float newton:mimicCoef1 = 2\nfloat newton:mimicCoef0 = 180",
            ),
        ),
    ];
    let loaded = text(&parts.concat());
    let [one, two] = &loaded.description.joints[..] else { panic!("two joints") };
    assert_eq!((one.passive.armature, one.passive.friction), (0.5, 3.0));
    assert!((one.passive.damping - 2_f64.to_degrees()).abs() < 1e-12);
    assert!((one.limits.velocity - FRAC_PI_2).abs() < 1e-15);
    assert_eq!(two.mimic, Some(Mimic::new("one", 2.0, 2.0 * FRAC_PI_2)));
    assert!(matches!(one.kind, JointKind::Continuous { axis: [0.0, 0.0, 1.0] }));
    assert_eq!(warnings(&loaded), ["/one: newton:strange is not in the model, here and at 1 other prims"]);
}

/// PhysX's attributes of one axis replace those of the joint; angular ones are in degrees. Properties that
/// change the motion are reported, and settings of the solver are not.
#[test]
fn physx_attributes_are_read_or_reported() {
    let axis = |rest: &str| {
        format!(
            "uniform token physics:axis = \"Z\"\nfloat physxJoint:armature = 7\nfloat physxJoint:jointFriction = 0.3\n\
             float physxJointAxis:angular:armature = 0.5\nfloat physxJointAxis:angular:maxJointVelocity = 90\n\
             float physxJointAxis:angular:dynamicFrictionEffort = 3\n{rest}"
        )
    };
    let parts = [
        body(
            "a",
            [0.0; 3],
            "float physxRigidBody:linearDamping = 0\nfloat physxRigidBody:angularDamping = 0.05",
        ),
        body(
            "b",
            [0.0; 3],
            "int physxRigidBody:lockedRotAxis = 0\nint physxRigidBody:solverPositionIterationCount = 4",
        ),
        joint(
            "Revolute",
            "one",
            ["", "/a"],
            &axis(
                "float physxJointAxis:angular:staticFrictionEffort = 3\n\
                 float physxJointAxis:angular:viscousFrictionCoefficient = 2\nfloat state:angular:physics:position = 1",
            ),
        ),
        joint(
            "Revolute",
            "two",
            ["/a", "/b"],
            &axis(
                "float physxJointAxis:angular:staticFrictionEffort = 4\n\
                 rel physxMimicJoint:rotZ:referenceJoint = </one>\nfloat physxMimicJoint:rotZ:gearing = -2\n\
                 float physxMimicJoint:rotZ:offset = 90",
            ),
        ),
    ];
    let loaded = text(&parts.concat());
    let [one, two] = &loaded.description.joints[..] else { panic!("two joints") };
    assert_eq!((one.passive.armature, one.passive.friction), (0.5, 3.0));
    assert!((one.passive.damping - 2_f64.to_degrees()).abs() < 1e-12);
    assert!((one.limits.velocity - FRAC_PI_2).abs() < 1e-15);
    assert_eq!((two.passive.friction, &two.mimic), (3.0, &Some(Mimic::new("one", 2.0, -FRAC_PI_2))));
    assert_eq!(
        warnings(&loaded),
        [
            "/two: a static friction of 4 is not in the model; the dynamic one, 3, is",
            "/one: physxJoint:jointFriction is not in the model, here and at 1 other prims",
            "/a: physxRigidBody:angularDamping is not in the model",
        ]
    );
}

/// Errors name the prim and the remedy.
#[test]
fn errors_name_the_prim() {
    let refused = |parts: &str| {
        let text = format!("{HEADER}{parts}");
        load_description_from_text(&text, &LoadOptions::default()).expect_err("an error").to_string()
    };
    let missing = refused(&[body("a", [0.0; 3], ""), joint("Fixed", "j", ["/b", "/a"], "")].concat());
    assert_eq!(missing, "/j: its body0 </b> does not exist; correct the path");
    assert!(refused("def Xform \"a\" {}").contains("no rigid bodies: apply PhysicsRigidBodyAPI"));
    let both = refused(&[body("a", [0.0; 3], ""), joint("Fixed", "j", ["/a", "/a"], "")].concat());
    assert!(both.starts_with("/j: both sides are on one body"), "{both}");
    assert!(refused("def Xform {").contains("not valid USD"));
}
