//! SDF models: frames, joints, included models, loops.
//!
//! Tolerance: 1e-12 of the largest entry. The poses of links in SDF are relative to the model, so that a
//! chain of poses is multiplied out and divided again.

use std::collections::HashMap;
use std::fmt::Write;
use std::path::PathBuf;

use robot_dynamics::description::{
    Base, Equality, JointKind, LinkDescription, MassProperties, Pose, RobotDescription, Shape,
};
use robot_dynamics::model::{Model, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::urdf::UrdfError;
use robot_dynamics::{
    FileSet, LoadOptions, LoadedDescription, load_description, load_description_from_files,
    load_description_from_text,
};

const ROUNDING: f64 = 1e-12;

fn read(text: &str) -> RobotDescription {
    load(text).description
}

fn load(text: &str) -> LoadedDescription {
    load_description_from_text(text, &LoadOptions::default())
        .unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// A model with these elements.
fn model(version: &str, elements: &str) -> String {
    format!("<sdf version='{version}'>\n<model name='m'>\n{elements}\n</model></sdf>")
}

/// A link of 1 kg with a centre of mass off its origin.
fn link(name: &str, pose: &str) -> String {
    format!(
        "<link name='{name}'>{pose}<inertial><pose>0.1 0.2 0.3 0 0 0</pose><mass>1</mass><inertia><ixx>0.5</ixx>\
         <iyy>0.6</iyy><izz>0.7</izz><ixy>0.01</ixy></inertia></inertial></link>\n"
    )
}

fn joint(name: &str, kind: &str, parent: &str, child: &str, rest: &str) -> String {
    format!(
        "<joint name='{name}' type='{kind}'><parent>{parent}</parent><child>{child}</child>{rest}</joint>\n"
    )
}

fn refused(text: &str) -> robot_dynamics::urdf::LoadError {
    match load_description_from_text(text, &LoadOptions::default()) {
        Err(robot_dynamics::FileError::Urdf(error)) => error,
        other => panic!("{other:?}\n{text}"),
    }
}

fn assert_near(what: &str, found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let scale = expected.iter().fold(1e-3_f64, |most, x| most.max(x.abs()));
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() <= ROUNDING * scale, "{what}: {found} for {expected}");
    }
}

fn assert_same(what: &str, one: &RobotDescription, other: &RobotDescription) {
    let [one, other] =
        [one, other].map(|robot| Model::new(robot.clone()).unwrap_or_else(|error| panic!("{what}: {error}")));
    assert_eq!((one.nq(), one.nv()), (other.nq(), other.nv()), "{what}");
    let mut random = SplitMix64::new(7);
    for _ in 0..3 {
        let state = random_state(&one, &mut random);
        let [m, other_m] = [&one, &other].map(|model| model.mass_matrix(&state.q).expect("M"));
        assert_near(&format!("{what}: M"), other_m.as_slice(), m.as_slice());
        let [h, other_h] = [&one, &other].map(|model| model.bias(&state.q, &state.v).expect("h"));
        assert_near(&format!("{what}: bias"), other_h.as_slice(), h.as_slice());
    }
}

/// x y z roll pitch yaw.
fn pose_text(pose: &Pose) -> String {
    let [[a, b, c], [d, e, f], [g, h, i]] = pose.rotation;
    let cosine = a.hypot(d);
    let [roll, pitch, yaw] = if cosine > 1e-9 {
        [h.atan2(i), (-g).atan2(cosine), d.atan2(a)]
    } else {
        [(-f).atan2(e), (-g).atan2(cosine), 0.0]
    };
    let _ = (b, c);
    let [x, y, z] = pose.translation;
    format!("{x:e} {y:e} {z:e} {roll:e} {pitch:e} {yaw:e}")
}

/// The variants in which a robot is written as SDF.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Variant {
    /// Version 1.4: poses of links in the model, axes in the model's frame.
    Old,
    /// Version 1.6: axes in the joint's frame.
    Plain,
    /// Version 1.9: poses relative to the parent's joint, axes expressed in the model.
    Relative,
}

/// A robot as SDF. Its joints are in the frames of their children.
fn written(robot: &RobotDescription, variant: Variant) -> String {
    let mut text = String::new();
    let world: HashMap<&str, Pose> = world_poses(robot);
    let parent_of: HashMap<&str, _> =
        robot.joints.iter().map(|joint| (joint.child.as_str(), joint)).collect();
    for LinkDescription { name, mass_properties, .. } in &robot.links {
        let pose = match (variant, parent_of.get(name.as_str())) {
            (Variant::Relative, Some(joint)) => {
                format!("<pose relative_to='{}'>{}</pose>", joint.parent, pose_text(&joint.parent_from_joint))
            }
            _ => format!("<pose>{}</pose>", pose_text(&world[name.as_str()])),
        };
        let (mass, center, inertia) = match mass_properties {
            Some(body) => (body.mass(), body.center_of_mass(), body.inertia_about_center_of_mass()),
            None => (0.0, nalgebra_zero(), robot_dynamics::nalgebra::Matrix3::zeros()),
        };
        let _ = write!(
            text,
            "<link name='{name}'>{pose}<inertial><pose>{:e} {:e} {:e} 0 0 0</pose><mass>{mass:e}</mass><inertia>\
             <ixx>{:e}</ixx><ixy>{:e}</ixy><ixz>{:e}</ixz><iyy>{:e}</iyy><iyz>{:e}</iyz><izz>{:e}</izz></inertia>\
             </inertial></link>",
            center[0],
            center[1],
            center[2],
            inertia[(0, 0)],
            inertia[(0, 1)],
            inertia[(0, 2)],
            inertia[(1, 1)],
            inertia[(1, 2)],
            inertia[(2, 2)]
        );
    }
    for made in &robot.joints {
        let (kind, axis) = match made.kind {
            JointKind::Fixed => ("fixed", None),
            JointKind::Revolute { axis } => ("revolute", Some(axis)),
            JointKind::Continuous { axis } => {
                (if variant == Variant::Relative { "continuous" } else { "revolute" }, Some(axis))
            }
            JointKind::Prismatic { axis } => ("prismatic", Some(axis)),
            other => panic!("{other:?}"),
        };
        let axis = axis.map_or_else(String::new, |axis| {
            let in_model = world[made.child.as_str()].rotate(axis);
            let numbers = |[x, y, z]: [f64; 3]| format!("{x:e} {y:e} {z:e}");
            let xyz = match variant {
                Variant::Old => format!("<xyz>{}</xyz>", numbers(in_model)),
                Variant::Plain => format!("<xyz>{}</xyz>", numbers(axis)),
                Variant::Relative => format!("<xyz expressed_in='__model__'>{}</xyz>", numbers(in_model)),
            };
            let mimic = made.mimic.as_ref().map_or_else(String::new, |mimic| {
                // ratio·(q − 1) + offset.
                format!(
                    "<mimic joint='{}'><multiplier>{:e}</multiplier><offset>{:e}</offset><reference>1</reference></mimic>",
                    mimic.joint,
                    mimic.ratio,
                    mimic.offset + mimic.ratio
                )
            });
            let passive = &made.passive;
            format!(
                "<axis>{xyz}<limit><lower>{:e}</lower><upper>{:e}</upper></limit><dynamics><damping>{:e}</damping>\
                 <spring_stiffness>{:e}</spring_stiffness><spring_reference>{:e}</spring_reference></dynamics>{mimic}</axis>",
                made.limits.lower.max(-1e16),
                made.limits.upper.min(1e16),
                passive.damping,
                passive.stiffness,
                passive.rest
            )
        });
        text += &joint(&made.name, kind, &made.parent, &made.child, &axis);
    }
    if robot.base == Base::Fixed {
        let children: Vec<&str> = robot.joints.iter().map(|joint| joint.child.as_str()).collect();
        let root = robot.links.iter().find(|link| !children.contains(&link.name.as_str())).expect("a root");
        text += &joint("to_world", "fixed", "world", &root.name, "");
    }
    let version = match variant {
        Variant::Old => "1.4",
        Variant::Plain => "1.6",
        Variant::Relative => "1.11",
    };
    model(version, &text)
}

fn nalgebra_zero() -> robot_dynamics::nalgebra::Vector3<f64> {
    robot_dynamics::nalgebra::Vector3::zeros()
}

fn world_poses(robot: &RobotDescription) -> HashMap<&str, Pose> {
    let mut world: HashMap<&str, Pose> = HashMap::new();
    while world.len() < robot.links.len() {
        for link in &robot.links {
            let joint = robot.joints.iter().find(|joint| joint.child == link.name);
            let pose = match joint {
                None => Some(Pose::IDENTITY),
                Some(joint) => {
                    world.get(joint.parent.as_str()).map(|pose| pose.compose(&joint.parent_from_joint))
                }
            };
            if let Some(pose) = pose {
                world.insert(&link.name, pose);
            }
        }
    }
    world
}

/// Every URDF file of this repository, written as SDF in three ways, has the same M and bias.
#[test]
fn robots_are_those_of_the_urdf_files() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../robots");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).expect("the folder") {
        let path = entry.expect("an entry").path();
        if path.extension().is_none_or(|extension| extension != "urdf") {
            continue;
        }
        for floats in [false, true] {
            let options =
                if floats { LoadOptions::default().with_floating_base() } else { LoadOptions::default() };
            let mut robot = load_description(&path, &options).expect("a robot").description;
            robot.joints.iter_mut().for_each(|joint| joint.passive.armature = 0.0);
            for variant in [Variant::Old, Variant::Plain, Variant::Relative] {
                if variant != Variant::Relative && robot.joints.iter().any(|joint| joint.mimic.is_some()) {
                    continue;
                }
                let what = format!("{} as {variant:?}, floating: {floats}", path.display());
                assert_same(&what, &robot, &read(&written(&robot, variant)));
                count += 1;
            }
        }
    }
    assert!(count > 40, "{count}");
}

/// A rod of 2 kg with its centre at 0.5 m: M = I + m l², g = m g l cos q, by hand.
#[test]
fn a_pendulum_has_the_values_by_hand() {
    let text = model(
        "1.9",
        "<link name='rod'><pose>0 0 1 0 0 0</pose><inertial><pose>0.5 0 0 0 0 0</pose><mass>2</mass><inertia><ixx>0.1</ixx>\
         <iyy>0.2</iyy><izz>0.3</izz></inertia></inertial></link>\
         <joint name='hinge' type='revolute'><parent>world</parent><child>rod</child><axis><xyz>0 1 0</xyz></axis></joint>",
    );
    let robot = Model::new(read(&text)).expect("a robot");
    let m = robot.mass_matrix(&[0.4]).expect("M")[(0, 0)];
    assert!((m - (0.2 + 2.0 * 0.25)).abs() < 1e-15, "{m}");
    let g = robot.gravity_forces(&[0.4]).expect("g")[0];
    assert!((g + 2.0 * 9.81 * 0.5 * 0.4_f64.cos()).abs() < 1e-14, "{g}");
}

/// A hinge at a distance from its child's origin, in a frame of its own, about an axis in another frame.
#[test]
fn joint_frames_are_relative_to_the_child() {
    let urdf = r#"<robot name="m"><link name="base"/><link name="hinge_link"/>
      <link name="arm"><inertial><origin xyz="0.1 0.2 0.3"/><mass value="1"/><inertia ixx="0.5" iyy="0.6" izz="0.7" ixy="0.01" ixz="0" iyz="0"/></inertial></link>
      <joint name="hinge" type="continuous"><parent link="base"/><child link="hinge_link"/><origin xyz="1 2 3.5" rpy="0 0 0"/><axis xyz="0 0.6 0.8"/></joint>
      <joint name="fixed" type="fixed"><parent link="hinge_link"/><child link="arm"/><origin xyz="0 0 -0.5"/></joint></robot>"#;
    let expected = load_description_from_text(urdf, &LoadOptions::default()).expect("a robot").description;
    let arm = link("arm", "<pose>1 2 3 0 0 0</pose>");
    // The joint's frame is turned by a quarter about z: its x is the model's y.
    let in_joint = "<pose>0 0 0.5 0 0 1.5707963267948966</pose><axis><xyz>0.6 0 0.8</xyz></axis>";
    let in_model =
        "<pose>0 0 0.5 0.3 0.2 0.1</pose><axis><xyz expressed_in='__model__'>0 0.6 0.8</xyz></axis>";
    let in_frame = "<pose relative_to='pin'/><axis><xyz expressed_in='pin'>0 0.6 0.8</xyz></axis>";
    let pin =
        "<frame name='pin' attached_to='arm'><pose relative_to='__model__'>1 2 3.5 0 0 0</pose></frame>";
    for rest in [in_joint, in_model, in_frame] {
        let text = model("1.9", &format!("{arm}{pin}{}", joint("hinge", "continuous", "world", "arm", rest)));
        assert_same(rest, &expected, &read(&text));
    }
    // Up to 1.6: `frame`, and the axis in the model's frame.
    let old = "<pose>0 0 0.5 0.3 0.2 0.1</pose><axis><xyz>0 0.6 0.8</xyz><use_parent_model_frame>1</use_parent_model_frame></axis>";
    let text = model("1.6", &format!("{arm}{}", joint("hinge", "revolute", "world", "arm", old)));
    assert_same("1.6", &expected, &read(&text));
    // The named frame is on its link.
    let robot = read(&model("1.9", &format!("{arm}{pin}")));
    let frame = &robot.frames[0];
    assert_eq!((frame.link.as_str(), frame.link_from_frame.translation), ("arm", [0.0, 0.0, 0.5]));
}

/// A chain of frames, a pose in degrees, and a quaternion.
#[test]
fn poses_follow_their_frames() {
    let frames = "<frame name='a'><pose degrees='true'>1 0 0 0 0 90</pose></frame>\
        <frame name='b' attached_to='l'><pose relative_to='a' rotation_format='quat_xyzw'>1 0 0 0 0 2 0</pose></frame>";
    let robot =
        read(&model("1.9", &format!("{}{frames}", link("l", "<pose relative_to='b'>0 1 0 0 0 0</pose>"))));
    // In the model: a is at (1, 0, 0) with x along y; b one ahead at (1, 1, 0), turned back by half a turn.
    let place = robot.joints[0].parent_from_joint;
    assert_near("l", &place.translation, &[2.0, 1.0, 0.0]);
    assert_near("x", &place.rotate([1.0, 0.0, 0.0]), &[0.0, -1.0, 0.0]);
    assert_eq!((robot.joints[0].name.as_str(), robot.joints[0].kind), ("floating_base", JointKind::Floating));
    let cycle =
        "<frame name='a'><pose relative_to='b'/></frame><frame name='b'><pose relative_to='a'/></frame>";
    assert_eq!(refused(&model("1.9", &format!("{}{cycle}", link("l", "")))).errors().len(), 1);
    let cycle = "<frame name='a' attached_to='b'/><frame name='b' attached_to='a'/>";
    assert!(!refused(&model("1.9", &format!("{}{cycle}", link("l", "")))).errors().is_empty());
}

#[test]
fn joints_of_all_types_are_read() {
    let two = |kind: &str, rest: &str| {
        let text = format!("{}{}{}", link("a", ""), link("b", ""), joint("j", kind, "a", "b", rest));
        read(&model("1.9", &format!("{text}{}", joint("w", "fixed", "world", "a", ""))))
    };
    let find = |robot: &RobotDescription, name: &str| {
        robot
            .joints
            .iter()
            .find(|joint| joint.name == name)
            .unwrap_or_else(|| panic!("{name}: {robot:?}"))
            .clone()
    };
    let screw = find(&two("screw", "<screw_thread_pitch>0.5</screw_thread_pitch><axis/>"), "j");
    let pitch = 0.5 / core::f64::consts::TAU;
    assert_eq!(screw.kind, JointKind::Helical { axis: [0.0, 0.0, 1.0], pitch });
    let old = find(&two("screw", "<thread_pitch>-4</thread_pitch><axis/>"), "j");
    assert_eq!(old.kind, JointKind::Helical { axis: [0.0, 0.0, 1.0], pitch: 0.25 });
    assert_eq!(find(&two("ball", ""), "j").kind, JointKind::Spherical);
    let axes = "<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2>";
    let universal = two("universal", axes);
    let kind = JointKind::Universal { first: [1.0, 0.0, 0.0], second: [0.0, 1.0, 0.0] };
    assert_eq!(find(&universal, "j").kind, kind);
    // Different limits need two joints, with the same equations of motion.
    let bounded = axes.replace("1 0 0</xyz>", "1 0 0</xyz><limit><lower>-1</lower></limit>");
    let two_joints = two("revolute2", &bounded);
    assert_same("two axes", &universal, &two_joints);
    assert_eq!(find(&two_joints, "j").limits.lower, -1.0);
    assert_eq!(find(&two_joints, "j_axis2").limits.lower, f64::NEG_INFINITY);
    let slide =
        find(&two("prismatic", "<axis><limit><lower>-1e16</lower><effort>-1</effort></limit></axis>"), "j");
    assert_eq!((slide.limits.lower, slide.limits.effort), (f64::NEG_INFINITY, f64::INFINITY));
}

/// The child of one joint is its parent in the tree: q keeps its meaning.
#[test]
fn reversed_joints_keep_their_coordinates() {
    let links = format!("{}{}", link("a", ""), link("b", "<pose>1 0 0 0 0 0.3</pose>"));
    for kind in ["revolute", "prismatic", "universal"] {
        let axes = match kind {
            "universal" => "<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2>",
            _ => "<axis><xyz>0 0.6 0.8</xyz></axis>",
        };
        // From a to b as written, and with b as the root.
        let written = joint("j", kind, "a", "b", axes);
        let forward =
            read(&model("1.9", &format!("{links}{written}{}", joint("w", "fixed", "world", "a", ""))));
        let reversed =
            read(&model("1.9", &format!("{links}{written}{}", joint("w", "fixed", "world", "b", ""))));
        let place = |robot: &RobotDescription, q: &[f64], link: &str| {
            let model = Model::new(robot.clone()).expect("a robot");
            let order: Vec<usize> = ["j", "j_axis2"]
                .iter()
                .filter_map(|name| model.joints().iter().find(|joint| joint.name == *name))
                .map(|joint| joint.q_index)
                .collect();
            let mut own = q.to_vec();
            if order.len() == 2 {
                (own[order[0]], own[order[1]]) = (q[0], q[1]);
            }
            let mut workspace = robot_dynamics::model::Workspace::new(&model);
            let frame = model.frame_named(link).expect("a frame");
            robot_dynamics::algorithms::frame_pose(&model, &mut workspace, &own, frame)
        };
        let q: &[f64] = if kind == "universal" { &[0.7, -0.4] } else { &[0.7] };
        let relative =
            |robot: &RobotDescription| place(robot, q, "a").inverse().compose(&place(robot, q, "b"));
        let (one, other) = (relative(&forward), relative(&reversed));
        assert_near(kind, &other.translation, &one.translation);
        assert_near(kind, other.rotation.as_flattened(), one.rotation.as_flattened());
    }
}

#[test]
fn nested_and_merged_models_keep_names_apart() {
    let inner = format!(
        "<model name='hand'><pose>0 0 1 0 0 0</pose>{}</model>",
        link("palm", "<pose>0 1 0 0 0 0</pose>")
    );
    let outer = format!("{}{inner}{}", link("arm", ""), joint("wrist", "fixed", "arm", "hand::palm", ""));
    let robot = read(&model("1.9", &outer));
    assert_eq!(robot.links[2].name, "hand::palm");
    let wrist = robot.joints.iter().find(|joint| joint.name == "wrist").expect("the wrist");
    assert_eq!(wrist.parent_from_joint.translation, [0.0, 1.0, 1.0]);
    // The frame of a nested model, and one of its links as a parent of poses.
    let probe =
        "<frame name='probe' attached_to='hand'><pose relative_to='hand::palm'>0 0 1 0 0 0</pose></frame>";
    let robot = read(&model("1.9", &format!("{outer}{probe}")));
    assert_eq!(
        (robot.frames[0].link.as_str(), robot.frames[0].link_from_frame.translation),
        ("hand::palm", [0.0, 0.0, 1.0])
    );
    let merged =
        outer.replace("<model name='hand'>", "<model name='hand' merge='true'>").replace("hand::", "");
    let robot = read(&model("1.12", &merged));
    assert_eq!((robot.links[2].name.as_str(), robot.joints.len()), ("palm", 2));
    // The pose of a model places its placement frame.
    let placed = outer.replace("<model name='hand'>", "<model name='hand' placement_frame='palm'>");
    let robot = read(&model("1.9", &placed));
    let wrist = robot.joints.iter().find(|joint| joint.name == "wrist").expect("the wrist");
    assert_eq!(wrist.parent_from_joint.translation, [0.0, 0.0, 1.0]);
}

#[test]
fn static_models_and_links_without_joints() {
    let text = model(
        "1.9",
        &format!("<static>true</static>{}{}", link("a", ""), link("b", "<pose>1 0 0 0 0 0</pose>")),
    );
    let robot = read(&text);
    assert!(robot.joints.iter().all(|joint| joint.kind == JointKind::Fixed) && robot.joints.len() == 2);
    let free = read(&text.replace("true", "false"));
    assert!(free.joints.iter().all(|joint| joint.kind == JointKind::Floating));
    let names: Vec<&str> = free.joints.iter().map(|joint| joint.name.as_str()).collect();
    assert_eq!(names, ["a_joint", "b_joint"]);
    // A link without gravity, and the default mass.
    let robot = read(&model("1.9", "<link name='a'><gravity>0</gravity></link>"));
    let body = robot.links[1].mass_properties.expect("the default");
    assert_eq!((robot.links[1].gravity_compensation, body.mass()), (1.0, 1.0));
    assert_eq!(body.inertia_about_center_of_mass()[(0, 0)], 1.0);
}

/// A four-bar linkage whose last hinge closes the loop stays closed.
#[test]
fn loops_become_equalities() {
    let bar = |name: &str, pose: &str| link(name, &format!("<pose>{pose} 0 0 0</pose>"));
    let links =
        [bar("base", "0 0 0"), bar("crank", "0 0 0"), bar("rod", "0 0 0.2"), bar("rocker", "0.5 0 0")]
            .concat();
    let y = "<axis><xyz>0 1 0</xyz></axis>";
    let joints = [
        joint("w", "fixed", "world", "base", ""),
        joint("a", "revolute", "base", "crank", y),
        joint("b", "revolute", "crank", "rod", y),
        joint("c", "revolute", "base", "rocker", y),
        joint("d", "revolute", "rocker", "rod", &format!("<pose>0.5 0 0.1 0 0 0</pose>{y}")),
    ]
    .concat();
    let loaded = load(&model("1.9", &format!("{links}{joints}")));
    assert_eq!(loaded.description.equalities.len(), 2);
    assert!(loaded.report.counts.warnings == 0, "{}", loaded.report);
    let robot = loaded.compile().expect("a robot");
    assert_eq!(robot.model.nv(), 3);
    let mut simulation = robot.simulation().build().expect("a simulation");
    simulation.run_for(0.5).expect("a motion");
    let q = simulation.q().to_vec();
    assert!(q[0].abs() > 0.1, "it moves: {q:?}");
    let mut workspace = robot_dynamics::model::Workspace::new(&robot.model);
    let mut at = |frame: &str| {
        let frame = robot.model.frame_named(frame).expect("a frame");
        robot_dynamics::algorithms::frame_pose(&robot.model, &mut workspace, &q, frame).translation
    };
    for pin in ["d_1", "d_2"] {
        let (one, other) = (at(&format!("{pin}.a")), at(&format!("{pin}.b")));
        // The correction of positions keeps the error of a step of 1 ms small.
        assert!((0..3).all(|i| (one[i] - other[i]).abs() < 1e-4), "{pin}: {one:?} {other:?}");
    }
    let welded = joints.replace("name='d' type='revolute'", "name='d' type='fixed'");
    let robot = read(&model("1.9", &format!("{links}{welded}")));
    assert!(matches!(robot.equalities[0].kind, Equality::Weld { .. }));
    let sliding = joints.replace("name='d' type='revolute'", "name='d' type='prismatic'");
    let error = refused(&model("1.9", &format!("{links}{sliding}")));
    assert!(matches!(error.errors(), [UrdfError::BadSemantics { .. }]), "{error}");
}

#[test]
fn included_models_are_found() {
    let wheel = model("1.6", &link("rim", "")).replace("name='m'", "name='wheel'");
    let include = |rest: &str| format!("<include{rest}</include>");
    let car = |include: &str| model("1.9", &format!("{}{include}", link("chassis", "")));
    let one = include("><uri>model://wheel</uri><name>left</name><pose>0 1 0 0 0 0</pose>");
    let folder = std::env::temp_dir().join(format!("sdf-includes-{}", std::process::id()));
    let path = folder.join("models/wheel");
    std::fs::create_dir_all(&path).expect("a folder");
    let config =
        "<model><name>wheel</name><sdf version='1.5'>old.sdf</sdf><sdf version='1.6'>wheel.sdf</sdf></model>";
    for (name, text) in [("model.config", config), ("wheel.sdf", &wheel), ("old.sdf", "<sdf/>")] {
        std::fs::write(path.join(name), text).expect("a file");
    }
    let main = folder.join("car.sdf");
    std::fs::write(&main, car(&one)).expect("a file");
    let options = LoadOptions::default().with_package_path(folder.join("models"));
    let loaded = load_description(&main, &options).unwrap_or_else(|error| panic!("{error}"));
    let robot = &loaded.description;
    assert_eq!(robot.links[2].name, "left::rim");
    assert_eq!(robot.joints[1].parent_from_joint.translation, [0.0, 1.0, 0.0]);
    assert_eq!(loaded.report.files.len(), 2);
    // A path, the models' folder beside the file, and a merge.
    let by_path = include(" merge='true'><uri>models/wheel/wheel.sdf</uri>");
    std::fs::write(&main, car(&by_path)).expect("a file");
    let robot = load_description(&main, &LoadOptions::default()).expect("a robot").description;
    assert_eq!(robot.links[2].name, "rim");
    // Confined reading keeps to the folder of the main file.
    let outside = folder.join("models/car/car.sdf");
    std::fs::create_dir_all(outside.parent().expect("a folder")).expect("a folder");
    std::fs::write(&outside, car(&one)).expect("a file");
    assert!(load_description(&outside, &LoadOptions::default()).is_ok());
    let confined = load_description(&outside, &LoadOptions::default().with_confined()).expect_err("outside");
    assert!(confined.to_string().contains("confined"), "{confined}");
    // A file that includes itself, and a missing one.
    std::fs::write(&main, car(&include("><uri>car.sdf</uri>"))).expect("a file");
    let refused = load_description(&main, &LoadOptions::default()).expect_err("endless");
    assert!(refused.to_string().contains("include itself"), "{refused}");
    std::fs::remove_dir_all(folder).expect("the folder");
    // Files in memory.
    let files = FileSet::new([("a/car.sdf", car(&one)), ("a/wheel/model.sdf", wheel)]);
    let robot = load_description_from_files(&files, "a/car.sdf", &LoadOptions::default()).expect("a robot");
    assert_eq!(robot.description.links[2].name, "left::rim");
    let error = load_description_from_text(&car(&one), &LoadOptions::default()).expect_err("no folder");
    assert!(error.to_string().contains("no folder"), "{error}");
}

#[test]
fn shapes_and_self_collision_are_read() {
    let shapes = "<collision name='c'><pose>0 0 1 0 0 0</pose><geometry><box><size>1 2 3</size></box></geometry>\
        <surface><friction><ode><mu>0.4</mu></ode></friction></surface></collision>\
        <visual name='v'><geometry><sphere><radius>0.5</radius></sphere></geometry><material><diffuse>1 0 0 1</diffuse></material></visual>\
        <visual name='w'><geometry><mesh><uri>model://x/arm.dae</uri><scale>2 2 2</scale></mesh></geometry></visual>";
    let robot = read(&model("1.9", &format!("<link name='l'>{shapes}</link>")));
    let [collision, ball, mesh] = &robot.shapes[..] else { panic!("{:?}", robot.shapes) };
    assert_eq!(
        (&collision.shape, collision.surface.friction[0]),
        (&Shape::Box { size: [1.0, 2.0, 3.0] }, 0.4)
    );
    assert_eq!(
        (collision.link_from_shape.translation, ball.color),
        ([0.0, 0.0, 1.0], Some([1.0, 0.0, 0.0, 1.0]))
    );
    assert!(matches!(&mesh.shape, Shape::Mesh { scale: [2.0, 2.0, 2.0], .. }));
    // Links of one model do not touch each other, but others.
    let (own, ground) = (collision.surface, robot_dynamics::description::Surface::default());
    assert_eq!(own.contype & own.conaffinity, 0);
    assert!(ground.contype & own.conaffinity != 0);
    let robot = read(&model("1.9", &format!("<self_collide>1</self_collide><link name='l'>{shapes}</link>")));
    assert_ne!(robot.shapes[0].surface.contype & robot.shapes[0].surface.conaffinity, 0);
    // Inertia from collision shapes: a box of 6 m³ with the density of water.
    let text = format!("<link name='l'><inertial auto='true'/>{shapes}</link>");
    let body = read(&model("1.12", &text)).links[1].mass_properties.expect("a body");
    let expected = MassProperties::solid_box(1000.0, [1.0, 2.0, 3.0].into()).expect("a box");
    assert!((body.mass() - 6000.0).abs() < 1e-9 && (body.center_of_mass()[2] - 1.0).abs() < 1e-15);
    let [one, other] = [body, expected].map(|body| body.inertia_about_center_of_mass());
    assert_near("inertia", one.as_slice(), other.as_slice());
}

#[test]
fn a_world_with_one_model_has_its_gravity() {
    let inside = format!("<model name='m'>{}</model>", link("l", ""));
    let world = |models: &str| {
        format!(
            "<sdf version='1.9'><world name='w'><gravity>0 0 -1.6</gravity><light name='sun'/>{models}</world></sdf>"
        )
    };
    assert_eq!(read(&world(&inside)).gravity, [0.0, 0.0, -1.6]);
    let two = refused(&world(&format!("{inside}{}", inside.replace("'m'", "'n'"))));
    assert!(two.to_string().contains("\"m\", \"n\""), "{two}");
    assert!(refused("<sdf version='1.9'/>").to_string().contains("no <model>"));
}

#[test]
fn errors_name_their_lines() {
    for (elements, line) in [
        (format!("<link name='a'/>\n{}", joint("j", "revolute", "a", "b", "<axis/>")), 4),
        (format!("<link name='a'/>\n{}", joint("j", "spin", "world", "a", "")), 4),
        (format!("<link name='a'/>\n{}", joint("j", "fixed", "a", "a", "")), 4),
        ("<link name='a'/>\n<link name='a'/>".to_owned(), 4),
        ("<link name='a'>\n<pose>1 2 3</pose></link>".to_owned(), 4),
        ("<link name='a'>\n<inertial><mass>-1</mass></inertial></link>".to_owned(), 4),
        ("<link name='a::b'/>".to_owned(), 3),
        (
            format!(
                "<link name='a'/>\n{}",
                joint("j", "revolute", "world", "a", "<axis><xyz>0 0 0</xyz></axis>")
            ),
            4,
        ),
        (format!("<link name='a'/>\n{}", joint("j", "screw", "world", "a", "<axis/>")), 4),
    ] {
        let error = refused(&model("1.9", &elements));
        assert_eq!(error.errors().len(), 1, "{elements}: {error}");
        assert_eq!(error.errors()[0].line(), Some(line), "{error}");
    }
    let near =
        refused(&model("1.9", &format!("<link name='palm'/>{}", joint("j", "fixed", "world", "plam", ""))));
    assert!(near.to_string().contains("did you mean `palm`?"), "{near}");
    // Quantities that are not in the model are warnings.
    let text = "<link name='a'><velocity_decay><linear>0.1</linear></velocity_decay><inertial><fluid_added_mass><xx>1</xx></fluid_added_mass></inertial></link>";
    assert_eq!(load(&model("1.9", text)).report.ignored_physics().count(), 2);
}

/// An arm of a revolute, a universal and a screw joint with an included hand. Drake 1.51.1 computed M and the
/// bias (`CalcMassMatrix`, `CalcBiasTerm` less `CalcGravityGeneralizedForces`) for `model://hand/hand.sdf`, at
/// the base at rest in its pose.
#[test]
fn an_arm_with_an_included_hand_agrees_with_drake() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../testdata/sdf/arm.sdf");
    let robot = load_description(&path, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    let base = robot.description.joints.iter().find(|joint| joint.child == "base").expect("the base");
    assert_near("base", &base.parent_from_joint.translation, &[1.0, 2.0, 3.0]);
    let model = Model::new(robot.description).expect("a robot");
    let names: Vec<&str> =
        model.joints().iter().filter(|joint| joint.nv > 0).map(|joint| &*joint.name).collect();
    assert_eq!(names, ["floating_base", "shoulder", "elbow", "screw", "left::slide"]);
    let q = [&[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0][..], &[0.25, 0.35, 0.45, 0.55, 0.15]].concat();
    let v = [&[0.0; 6][..], &[0.1, 0.3, 0.5, 0.7, -0.1]].concat();
    #[rustfmt::skip]
    let expected = [
        0.7398870244871963, -0.04016801660207245, 0.24746199824571136, 0.078443911392388, -0.010144059477142012,
        -0.04016801660207245, 0.20168091808370095, -0.035466088438524446, 0.010277952301648357, -0.014072012202531414,
        0.24746199824571136, -0.035466088438524446, 0.2322397446047219, 0.04236729142069563, 0.009508619625812582,
        0.078443911392388, 0.010277952301648357, 0.04236729142069563, 0.07226934384253104, 0.009808411462287624,
        -0.010144059477142012, -0.014072012202531414, 0.009508619625812582, 0.009808411462287624, 0.20000000000000004,
    ];
    let m = model.mass_matrix(&q).expect("M");
    let found: Vec<f64> = (6..11).flat_map(|i| (6..11).map(move |j| (i, j))).map(|at| m[at]).collect();
    assert_near("M", &found, &expected);
    let expected =
        [5.824936815610045, -3.9228588291946704, 1.0061674453171832, 0.7787695788631324, 0.7873238020900047];
    assert_near("bias", &model.bias(&q, &v).expect("h").as_slice()[6..], &expected);
}
