//! Snapshots of all messages, each with the input that gives it.
//!
//! After a change of wording, run the tests with `INSTA_UPDATE=always` and review the difference of the
//! snapshots.

use std::fmt::Write as _;

use insta::assert_snapshot;
use robot_dynamics::description::{
    ContactPairDescription, Equality, EqualityDescription, JointKind, LinkShape, Mimic, Pose,
    RobotDescription, SensorDescription, SensorKind, Shape, ShapeRole, pendulum,
};
use robot_dynamics_mjcf::{
    Disposition, FileSet, Finding, LoadError, LoadOptions, load_from_files, parse, write,
};

use crate::account::WARNINGS;
use crate::attach::{LEG, REFUSED, with_leg};
use crate::faults::{FAULTS, THREE, in_body, in_file};
use crate::reading::scene;
use crate::sensors::UNANSWERED;

/// Adds an input and its message.
fn add(out: &mut String, input: &str, message: impl std::fmt::Display) {
    let input = if input.is_empty() { "(empty)" } else { input };
    writeln!(out, "{input}\n=> {message}\n").expect("to a string");
}

fn refused(text: &str) -> LoadError {
    parse(text, &LoadOptions::default()).expect_err(text)
}

/// The findings of a file, except for parts that are read.
fn list_findings(text: &str, options: &LoadOptions) -> String {
    let report = parse(text, options).expect(text).report;
    let is_relevant = |finding: &&Finding| finding.disposition() != Disposition::Read;
    let with_place =
        |finding: &Finding| format!("line {}: {}: {}", finding.line(), finding.place(), finding.message());
    report.findings.iter().filter(is_relevant).map(with_place).collect::<Vec<_>>().join("\n=> ")
}

#[test]
fn errors() {
    let mut out = String::new();
    for (frame, text, ..) in FAULTS {
        add(&mut out, text, refused(&frame(text)));
    }
    add(&mut out, THREE, refused(THREE));
    for text in [
        "<joint type='slide'/><joint type='slide' axis='1 0 0'/><joint type='ball'/><joint type='ball'/>",
        "<joint springdamper='0 1'/>",
        "<inertial pos='0 0 0' mass='1' fullinertia='1 1 1 0 0 0' euler='1 0 0'/>",
        "<geom type='mesh'/>",
        "<replicate count='1000000'><body><geom size='1'/><geom size='1'/></body></replicate>",
        "<geom type='hfield' hfield='hill'/>",
    ] {
        add(&mut out, text, refused(&in_body(text)));
    }
    for text in [
        "<worldbody><body name='m' mocap='true'><joint/></body></worldbody>",
        "<worldbody>\n<inertial pos='0 0 0' mass='1'/></worldbody>",
        "<default><default class='c'/><default class='c'/></default>",
        "<actuator><motor name='m' joint='j'/><motor name='m' joint='j'/></actuator>",
        "<actuator><motor name='m' site='s' armature='1'/></actuator>",
        "<tendon><fixed name='t'><joint joint='j' coef='1'/></fixed><fixed name='t'><joint joint='j' coef='1'/></fixed></tendon>",
        "<worldbody><body><joint name='b' type='ball'/><geom size='1'/></body></worldbody><tendon><fixed><joint joint='b' coef='1'/></fixed></tendon>",
        "<worldbody><body><joint name='b' type='ball'/><geom size='1'/></body></worldbody><equality><joint joint1='b'/></equality>",
        "<equality><connect site1='s' site2='t'/></equality>",
        "<sensor><gyro name='g' site='s'/><gyro name='g' site='s'/></sensor>",
        "<sensor><gyro/></sensor>",
        "<sensor><gyro site='t'/></sensor>",
        "<sensor><tendonpos tendon='t'/></sensor>",
        "<sensor><framepos objtype='geom' objname='x'/></sensor>",
    ] {
        add(&mut out, text, refused(&in_file(text)));
    }
    let hill = "<mujoco><asset><hfield name='hill' size='1 2 0.5 0.1' nrow='2' ncol='3' elevation='1 2 3'/></asset><worldbody>\n<geom type='hfield' hfield='hill'/></worldbody></mujoco>";
    add(&mut out, hill, refused(hill));
    for text in ["<mujocoinclude/>", "<sdf/>", "<html/>"] {
        add(&mut out, text, refused(text));
    }
    let strict = parse(&in_file("<gravity/>"), &LoadOptions::default().with_strict()).expect_err("a warning");
    add(&mut out, "<gravity/>, strict", strict);
    let ball = "<geom size='0.1'/>";
    let robot = |name: &str| {
        format!("<body name='{name}'>{ball}<body><joint name='{name} elbow'/>{ball}</body></body>")
    };
    let door = format!("<body name='door'><joint name='hinge'/>{ball}</body>");
    for bodies in [robot("r2d2") + &robot("c3po"), door] {
        let error =
            parse(&scene(&bodies), &LoadOptions::default().with_floating_base()).expect_err("no base");
        add(&mut out, &format!("{bodies}, floating"), error);
    }
    assert_snapshot!(out);
}

#[test]
fn meshes() {
    let mut out = String::new();
    for mesh in [
        "vertex='0 0 0'",
        "vertex='0 0 0 1 0 0 0 1 0 0 0'",
        "vertex='0 0 0 1 0 0 0 1 0 0 0 1' face='0 1 4'",
        "vertex='0 0 0 1 0 0 0 1 0 0 0 1' face='0 1 2 0 3 1 0 2 3 1 3 2' inertia='exact'",
        "vertex='0 0 0 1 0 0 0 1 0 0 1 0' face='0 1 2 1 3 2'",
        "vertex='0 0 0 1 0 0 0 1 0 0 0 1' refquat='0 0 0 0'",
        "vertex='0 0 0 1 0 0 0 1 0 0 0 1' scale='0 1 x'",
        "builtin='plate' params='1 3'",
        "builtin='wedge' params='3 3'",
        "builtin='wedge' params='3 3 200 40 0'",
        "builtin='box' params='3 3'",
        "builtin='sphere' params='3 2'",
        "builtin='sphere' params='5'",
        "builtin='supertorus' params='4 1 0 1'",
        "file='x.stl'",
        "",
    ] {
        let text = format!(
            "<mujoco><asset><mesh name='m' {mesh}/></asset><worldbody><body><joint/><geom type='mesh' mesh='m'/></body></worldbody></mujoco>"
        );
        add(&mut out, mesh, refused(&text));
    }
    for (file, content) in [
        ("m.stl", &b"solid"[..]),
        ("m.stl", b"solid m\nfacet\n"),
        ("m.obj", b"v 0 0 0\nf 1 2 3\n"),
        ("m.obj", b"v x\n"),
        ("m.obj", b""),
        ("m.msh", b"short"),
        ("m.msh", &[0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0]),
        ("m.dae", b""),
    ] {
        let text = format!(
            "<mujoco><asset><mesh name='m' file='{file}'/></asset><worldbody><body><joint/><geom type='mesh' mesh='m'/></body></worldbody></mujoco>"
        );
        let files = FileSet::new([("robot.xml", text.as_bytes()), (file, content)]);
        let error = load_from_files(&files, "robot.xml", &LoadOptions::default()).expect_err(file);
        add(&mut out, &format!("{file}: {}", String::from_utf8_lossy(content).escape_debug()), error);
    }
    assert_snapshot!(out);
}

#[test]
fn included_and_attached_files() {
    let mut out = String::new();
    let include = |file: &str| format!("<mujoco><include file='{file}'/></mujoco>");
    let attach = |file: &str| {
        format!(
            "<mujoco><asset><model name='k' file='{file}'/></asset><worldbody><attach model='k' prefix='p'/></worldbody></mujoco>"
        )
    };
    let long = |link: &dyn Fn(&str) -> String| {
        (0..80).map(|k| (format!("f{k}.xml"), link(&format!("f{}.xml", k + 1)))).collect::<Vec<_>>()
    };
    let two = |main: String, other: String| vec![("f0.xml".to_owned(), main), ("a.xml".to_owned(), other)];
    for (input, files) in [
        ("an include of itself", vec![("f0.xml".to_owned(), include("f0.xml"))]),
        ("an include outside the folder", vec![("f0.xml".to_owned(), include("../f0.xml"))]),
        ("an include without a file", vec![("f0.xml".to_owned(), "<mujoco><include/></mujoco>".into())]),
        ("a missing include", vec![("f0.xml".to_owned(), include("a.xml"))]),
        ("a chain of includes", long(&include)),
        ("an included text that is no XML", two(include("a.xml"), "<mujoco>\n<body></mujoco>".into())),
        ("a model that attaches itself", vec![("f0.xml".to_owned(), attach("f0.xml"))]),
        ("a model outside the folder", vec![("f0.xml".to_owned(), attach("../f0.xml"))]),
        (
            "a model without a file",
            vec![("f0.xml".to_owned(), "<mujoco><asset><model/></asset></mujoco>".into())],
        ),
        ("a missing model", vec![("f0.xml".to_owned(), attach("a.xml"))]),
        ("a chain of models", long(&attach)),
        ("a model of another format", two(attach("a.xml"), "<robot/>".into())),
        ("no main file", Vec::new()),
    ] {
        let error =
            load_from_files(&FileSet::new(files), "f0.xml", &LoadOptions::default()).expect_err(input);
        add(&mut out, input, error.to_string().lines().take(3).collect::<Vec<_>>().join("\n"));
    }
    add(&mut out, "an include of a text", refused(&include("a.xml")));
    add(&mut out, "a model of a text", refused("<mujoco><asset><model file='a.xml'/></asset></mujoco>"));
    for (text, _) in REFUSED {
        let files = FileSet::new([("main.xml", with_leg(text)), ("leg.xml", LEG.into())]);
        add(&mut out, text, load_from_files(&files, "main.xml", &LoadOptions::default()).expect_err(text));
    }
    let hill = "<mujoco model='leg'><asset><material name='red' rgba='1 0 0 1'/></asset></mujoco>";
    let main = with_leg("<attach model='leg' prefix='p_'/>")
        .replace("</asset>", "<material name='p_red' rgba='1 1 1 1'/></asset>");
    let files = FileSet::new([("main.xml", main.as_str()), ("leg.xml", hill)]);
    add(
        &mut out,
        &main,
        load_from_files(&files, "main.xml", &LoadOptions::default()).expect_err("two materials"),
    );
    let mut doubling: Vec<(String, String)> = (0..40)
        .map(|k| {
            let twice = "<attach model='n' prefix='a'/><attach model='n' prefix='b'/>";
            let next = k + 1;
            (format!("f{k}.xml"), format!("<mujoco><asset><model name='n' file='f{next}.xml'/></asset><worldbody>{twice}</worldbody></mujoco>"))
        })
        .collect();
    doubling.push(("f40.xml".into(), LEG.into()));
    let error =
        load_from_files(&FileSet::new(doubling), "f0.xml", &LoadOptions::default()).expect_err("too many");
    add(
        &mut out,
        "forty models, each of which attaches the next one twice",
        error.errors().last().expect("one"),
    );
    assert_snapshot!(out);
}

#[test]
fn findings_of_attached_files() {
    let mut out = String::new();
    let leg = LEG
        .replace("<geom/></body>", "<geom/><body name='foot'><joint name='toe'/><geom/></body></body>")
        .replace("<default>", "<option gravity='0 0 -1'/><deformable/><default>");
    for main in [
        with_leg("<attach model='leg' body='foot' prefix='p_'/>"),
        with_leg("<attach model='leg' prefix='p_'/>")
            .replace("<asset>", "<compiler conflict='merge'/><asset>"),
    ] {
        let files = FileSet::new([("main.xml", main.as_str()), ("leg.xml", &leg)]);
        let report = load_from_files(&files, "main.xml", &LoadOptions::default()).expect("a robot").report;
        add(&mut out, &main, report);
    }
    assert_snapshot!(out);
}

#[test]
fn findings() {
    let mut out = String::new();
    let options = LoadOptions::default();
    for (frame, text, _) in WARNINGS {
        add(&mut out, text, list_findings(&frame(text), &options));
    }
    for text in [
        "<worldbody><body name='b'><joint name='k'/><geom size='1' adhesion='0'/></body></worldbody><actuator><motor joint='j' delay='0'/></actuator><option><flag override='disable'/></option>",
        "<size memory='1M'/><custom/><extension/>",
        "<compiler><lengthrange/></compiler>",
        "hello",
        "<equality><tendon/></equality>",
        "<equality><flex/></equality>",
        "<default class='other'/>",
        "<default><geom/><geom/></default>",
        "<worldbody><body mocap='true'/></worldbody>",
        "<worldbody><body><joint/><geom size='1'/><site name='a'/></body></worldbody>",
        "<worldbody><body><joint name='k' type='free' armature='1'/><geom size='1'/></body></worldbody>",
        "<worldbody><body><joint name='k' type='free' range='0 1'/><geom size='1'/></body></worldbody>",
        "<worldbody><body><joint name='k' armature='-1' damping='-1'/><geom size='1'/></body></worldbody>",
        "<worldbody><body><joint name='k' limited='true' range='1 0'/><geom size='1'/></body></worldbody>",
        "<worldbody><body name='b'><joint name='k'/><inertial pos='0 0 0' mass='1'/><inertial pos='0 0 0' mass='1'/></body></worldbody>",
        "<worldbody><body name='b'><joint name='k'/><geom size='1'/><geom type='hfield' hfield='h'/></body></worldbody><asset><hfield name='h' nrow='1' ncol='1' size='1 1 1 1'/></asset>",
        "<worldbody><body name='b'><joint name='k'/><geom size='1'/><geom type='sdf'/></body></worldbody>",
        "<compiler boundmass='1000'/>",
        "<compiler balanceinertia='true'/><worldbody><body name='b'><joint name='k'/><inertial pos='0 0 0' mass='1' diaginertia='1 1 3'/></body></worldbody>",
        "<worldbody><body name='b'><joint name='k' springdamper='1 1'/></body></worldbody>",
        "<actuator><general joint='j' biastype='user'/></actuator>",
        "<actuator><general joint='j' dyntype='user'/></actuator>",
        "<actuator><motor body='a'/></actuator>",
        "<worldbody><body><joint name='f' type='free'/><geom size='1'/></body></worldbody><actuator><motor joint='f'/></actuator>",
        "<tendon><spatial name='t'><site site='s'/><site site='s'/></spatial></tendon><actuator><motor tendon='t' armature='1'/></actuator>",
        "<tendon><fixed name='t' actuatorfrcrange='-1 2'><joint joint='j' coef='1'/></fixed></tendon>",
        "<worldbody><body><joint name='l' limited='true' range='0 90'/><geom size='1'/></body></worldbody><actuator><intvelocity joint='l' inheritrange='1'/></actuator>",
        "<keyframe><key qpos='0'/></keyframe><worldbody><body><joint name='b' type='ball'/><geom size='1'/></body></worldbody><keyframe><key qpos='0 0 0 0 0'/></keyframe>",
        "<contact><pair geom1='g' geom2='g' friction='0.3 0.4'/></contact>",
        "<sensor><gyro site='s' delay='1'/></sensor>",
        "<sensor><framepos objtype='camera' objname='c'/></sensor>",
    ] {
        let file = in_file(text);
        match parse(&file, &options) {
            Ok(_) => add(&mut out, text, list_findings(&file, &options)),
            Err(error) => add(&mut out, text, error),
        }
    }
    for text in [
        UNANSWERED,
        "<mujoco mood='good'><worldbody/></mujoco>",
        "<mujoco>\n<worldbody/><x:y/></mujoco>",
        "<mujoco><asset><mesh name='m' vertex='0 0 0 1 0 0 0 1 0 0 0 1' refquat='0 1 0 1' scale='1 2 1' file='m.stl'/></asset><worldbody><geom type='mesh' mesh='m'/></worldbody></mujoco>",
        "<mujoco><asset><mesh name='m' vertex='0 0 0 1 0 0 0 1 0 0 0 1'/></asset><worldbody><body><joint/><geom type='mesh' mesh='m' shellinertia='true'/></body></worldbody></mujoco>",
    ] {
        add(&mut out, text, list_findings(text, &options));
    }
    let ball = "<geom size='0.1'/>";
    let robot = format!("<body name='r2d2'>{ball}<body name='arm'><joint name='elbow'/>{ball}</body></body>");
    let free = robot.replacen("<geom", "<freejoint name='f'/><geom", 1);
    let floating = LoadOptions::default().with_floating_base();
    for bodies in [&robot, &free] {
        add(&mut out, &format!("{bodies}, floating"), list_findings(&scene(bodies), &floating));
    }
    let alone = format!("<mujoco><worldbody>{free}</worldbody></mujoco>");
    add(&mut out, &format!("{alone}, floating"), list_findings(&alone, &floating));
    let text = "<mujoco><worldbody><body name='a'><joint name='j'/><inertial pos='0 0 0' mass='1' diaginertia='1 1 3'/></body></worldbody></mujoco>";
    add(
        &mut out,
        &format!("{text}, repaired"),
        list_findings(text, &LoadOptions::default().with_repaired_inertia()),
    );
    assert_snapshot!(out);
}

/// All findings of one file.
#[test]
fn report() {
    let text = "<mujoco model='m'><compiler angle='radian' settotalmass='2' alignfree='true'/>
<option gravity='0 0 -1' timestep='0.001' impratio='2' integrator='RK4'><flag spring='disable'/></option>
<worldbody><body name='a'><joint name='j'/><geom name='g' size='0.1'/><site name='s'/>
  <body name='b' pos='1 0 0'><joint name='k' type='slide'/><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/></body></body>
  <body name='c'><freejoint name='f'/><geom size='0.1'/></body>
  <replicate count='2'><body name='d'><geom size='0.1'/></body></replicate></worldbody>
<tendon><fixed name='t'><joint joint='j' coef='1'/></fixed></tendon>
<equality><joint name='e' joint1='j' joint2='k'/></equality>
<actuator><motor name='m' joint='j'/></actuator>
<sensor><gyro name='s' site='s'/></sensor>
<keyframe><key name='home' qpos='0 0 0 0 0 1 0 0 0'/></keyframe></mujoco>";
    let report = parse(text, &LoadOptions::default()).expect(text).report;
    assert_snapshot!(report.to_string());
}

/// A robot with features that MJCF lacks.
fn robot_with_losses() -> RobotDescription {
    let mut robot = pendulum(2.0, 0.5);
    robot.joints[0].limits.velocity = 3.0;
    robot.joints[0].limits.lower = 1.0;
    robot.joints[0].limits.upper = -1.0;
    robot.joints[0].actuator_force_range = [1.0, 1.0];
    let rod = robot.links[1].name.clone();
    for (name, shape) in [
        ("floor", Shape::Plane { half_size: [1.0; 2] }),
        ("flat", Shape::Box { size: [1.0, 1.0, 0.0] }),
        ("lost", Shape::mesh("lost.stl")),
    ] {
        robot
            .shapes
            .push(LinkShape::new(rod.clone(), ShapeRole::Collision, Pose::IDENTITY, shape).with_name(name));
    }
    robot.contact_pairs.push(ContactPairDescription::new(["floor", "flat"]));
    robot.sensors.push(SensorDescription::new("all", SensorKind::Touch, "tip"));
    let mut follower = robot.joints[0].clone();
    let mut link = robot.links[1].clone();
    (follower.name, follower.parent, follower.child) = ("second".into(), rod, "third".into());
    link.name = "third".into();
    follower.mimic = Some(Mimic::new("hinge", 2.0, 0.1));
    robot.links.push(link);
    robot.joints.push(follower);
    robot
}

#[test]
fn losses_of_written_files() {
    let mut out = String::new();
    let lines = |robot: &RobotDescription| {
        let written = write(robot, None).expect("a file");
        let lines = written.left_out.iter().map(|lost| {
            format!("{}{}: {}", if lost.physics { "lost physics: " } else { "" }, lost.place, lost.message)
        });
        lines.collect::<Vec<_>>().join("\n=> ")
    };
    add(&mut out, "a robot with everything", lines(&robot_with_losses()));
    let mut world = pendulum(2.0, 0.5);
    world.frames.clear();
    world.links[1].name = "world".into();
    world.joints[0].child = "world".into();
    add(&mut out, "a link named as the world", lines(&world));
    let mut bare = robot_with_losses();
    bare.links[1].mass_properties = None;
    bare.joints[1].mimic = None;
    (bare.shapes, bare.sensors, bare.frames, bare.contact_pairs) = Default::default();
    add(&mut out, "a link without mass between two joints", lines(&bare));
    let text = "<mujoco><worldbody><body name='a'><joint name='j'/><geom name='g' size='0.1'/><body name='b'><joint name='k'/><geom size='0.1'/></body></body></worldbody>
<tendon><fixed name='t' range='0 1'><joint joint='j' coef='1'/></fixed></tendon><equality><joint name='e' joint1='j' joint2='k'/></equality>
<actuator><motor name='m' joint='j'/><motor name='n' tendon='t'/></actuator><sensor><tendonpos name='p' tendon='t'/><actuatorfrc name='q' actuator='m'/></sensor></mujoco>";
    let mut locked = parse(text, &LoadOptions::default()).expect(text).description;
    locked.joints[0].kind = JointKind::Fixed;
    add(&mut out, "a locked joint", lines(&locked));
    let mut helical = pendulum(2.0, 0.5);
    helical.joints[0].kind = JointKind::Helical { axis: [0.0, 0.0, 1.0], pitch: 0.1 };
    let mut nameless = pendulum(2.0, 0.5);
    nameless.joints[0].name = "bell\u{7}".into();
    let mut inside = robot_with_losses();
    inside.joints[1].mimic = None;
    inside.joints[1].kind = JointKind::Floating;
    for (input, robot) in [
        ("a helical joint", helical),
        ("a name with a control character", nameless),
        ("a free joint inside", inside),
    ] {
        add(&mut out, input, write(&robot, None).expect_err(input));
    }
    let mut chain = pendulum(2.0, 0.5);
    chain.frames.clear();
    for k in 0..500 {
        let (mut link, mut joint) = (chain.links[1].clone(), chain.joints[0].clone());
        (link.name, joint.name) = (format!("link{k}"), format!("joint{k}"));
        joint.parent = chain.links[chain.links.len() - 1].name.clone();
        joint.child = link.name.clone();
        chain.links.push(link);
        chain.joints.push(joint);
    }
    add(&mut out, "500 joints in a chain", write(&chain, None).expect_err("too deep"));
    let mut equality = pendulum(2.0, 0.5);
    let kind = Equality::Joints { joint: ("hinge".into(), 0.0), leader: None, polynomial: [0.0; 5] };
    equality.equalities.push(EqualityDescription::new("e", kind));
    equality.joints[0].kind = JointKind::Fixed;
    add(&mut out, "an equality of a locked joint", lines(&equality));
    assert_snapshot!(out);
}
