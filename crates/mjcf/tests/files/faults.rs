//! Files without a meaning, each refused with its line, its place and what to do.

use mjcf::{Options, parse};

/// Inside a body `a` with a shape, from line 2.
fn in_body(text: &str) -> String {
    format!("<mujoco><worldbody><body name='a'><geom size='0.1'/>\n{text}\n</body></worldbody></mujoco>")
}

/// Inside `<mujoco>`, with a body `a`, its joint `j` and its site `s`, from line 2.
fn in_file(text: &str) -> String {
    format!(
        "<mujoco><worldbody><body name='a'><joint name='j'/><geom name='g' size='0.1'/><site name='s'/></body></worldbody>\n{text}\n</mujoco>"
    )
}

fn whole(text: &str) -> String {
    text.to_owned()
}

type Frame = fn(&str) -> String;

/// How the text is framed, the text, and the whole message.
#[rustfmt::skip]
const FAULTS: &[(Frame, &str, &str)] = &[
    (whole, "", "the file is empty; a robot file holds one outermost element"),
    (whole, "<robot/>", "line 1: the outermost element is <robot>, not <mujoco>; this is URDF; read it with `urdf::load`"),
    (whole, "<mujoco>", "line 1, column 9: not well-formed XML: the root node was opened but never closed"),
    (whole, "<!DOCTYPE x><mujoco/>", "line 1: a robot file needs no <!DOCTYPE …>, and its entities are not expanded; delete it"),
    (in_body, "<joint name='j' type='hing'/>", r#"line 2: joint "j": type="hing" is unknown; use hinge, slide, ball, free"#),
    (in_body, "<joint axis='0 0 0'/>", r#"line 2: joint: axis is zero; give a direction such as "0 0 1""#),
    (in_body, "<joint axis='0 0'/>", r#"line 2: joint: axis="0 0" holds 2 numbers, not 3"#),
    (in_body, "<joint damping='1,5'/>", r#"line 2: joint: damping="1,5" is not a number; it has a comma: write a decimal point, and white space between numbers"#),
    (in_body, "<joint ref='nan'/>", r#"line 2: joint: ref="nan" is not a finite number; write an ordinary number"#),
    (in_body, "<joint ref='1e40'/>", r#"line 2: joint: ref="1e40" is beyond 1e30; give SI units (m, kg, s)"#),
    (in_body, "<joint class='x'/>", r#"line 2: joint "x": the default class "x" does not exist; add it or correct the name"#),
    (in_body, "<joint/><freejoint name='f'/>", r#"line 2: freejoint "f": a free joint stands alone; remove the body's other joints"#),
    (in_body, "<body name='b'><freejoint/></body>", "line 2: freejoint: a free joint is for a body in the world; use other joints inside a body"),
    (in_body, "<body name='a'/>", r#"line 2: body "a": the body "a" is already defined on line 1; give each its own name"#),
    (in_body, "<body name='world'/>", r#"line 2: body "world": the body "world" is already defined on line 1; give each its own name"#),
    (in_body, "<joint name='j'/><joint name='j'/>", r#"line 2: joint "j": the joint "j" is already defined on line 2; give each its own name"#),
    (in_body, "<body euler='1 0 0' quat='1 0 0 0'/>", "line 2: body: both `quat` and `euler` are given; keep one of them"),
    (in_body, "<body quat='0 0 0 0'/>", r#"line 2: body: quat is zero; write "1 0 0 0" for no turn"#),
    (in_body, "<body zaxis='0 0 0'/>", r#"line 2: body: zaxis is zero; give a direction such as "0 0 1""#),
    (in_body, "<inertial mass='1'/>", r#"line 2: body "a"/inertial: the attribute `pos` is missing; write pos="X Y Z""#),
    (in_body, "<inertial pos='0 0 0' mass='-1'/>", r#"line 2: body "a"/inertial: mass=-1 is negative; it is zero or positive"#),
    (in_body, "<inertial pos='0 0 0' mass='1' diaginertia='1 1 1' fullinertia='1 1 1 0 0 0'/>", r#"line 2: body "a"/inertial: both `diaginertia` and `fullinertia` are given; keep one of them"#),
    (in_body, "<geom type='box' size='1 0 1'/>", "line 2: geom: size is zero; give a positive length in each direction"),
    (in_body, "<geom size='-1'/>", "line 2: geom: size=-1 is negative; it is zero or positive"),
    (in_body, "<geom type='sphere' fromto='0 0 0 0 0 1' size='1'/>", "line 2: geom: fromto is for a capsule, cylinder, ellipsoid or box, not for a sphere"),
    (in_body, "<geom type='capsule' fromto='0 0 1 0 0 1' size='1'/>", "line 2: geom: fromto is zero; its two points are the same; move one of them"),
    (in_body, "<geom type='mesh' mesh='m'/>", r#"line 2: geom: the mesh "m" does not exist; add it or correct the name"#),
    (in_body, "<replicate count='1.5'/>", "line 2: replicate: count=1.5 is not a number of copies"),
    (whole, "<mujoco><worldbody>\n<joint name='j'/></worldbody></mujoco>", r#"line 2: joint "j": the world has no joints; put it into a body"#),
    (whole, "<mujoco>\n<compiler coordinate='global'/></mujoco>", r#"line 2: compiler: coordinate="global" has gone from the format: load and save the file with MuJoCo 2.3.3 or older"#),
    (whole, "<mujoco>\n<compiler eulerseq='xyw'/></mujoco>", "line 2: compiler: eulerseq is three letters of x, y, z, X, Y, Z"),
    (whole, "<mujoco><default>\n<default/></default></mujoco>", r#"line 2: default: the attribute `class` is missing; write class="NAME""#),
    (in_file, "<contact><exclude body1='a' body2='b'/></contact>", r#"line 2: exclude: the body "b" does not exist; add it or correct the name"#),
    (in_file, "<contact><pair geom1='a' geom2='g'/></contact>", r#"line 2: pair: the geom "a" does not exist; add it or correct the name"#),
    (in_file, "<contact><pair geom1='g'/></contact>", r#"line 2: pair: the attribute `geom2` is missing; write geom2="GEOM""#),
    (in_file, "<contact><pair geom1='g' geom2='g' condim='2'/></contact>", "line 2: pair: condim=2 is none; use 1, 3, 4 or 6"),
    (in_file, "<equality><joint joint1='k'/></equality>", r#"line 2: joint: the joint "k" does not exist; add it or correct the name"#),
    (in_file, "<equality><connect body1='a'/></equality>", r#"line 2: connect: the attribute `anchor` is missing; write anchor="X Y Z""#),
    (in_file, "<tendon><fixed name='t'><joint joint='k' coef='1'/></fixed></tendon>", r#"line 2: joint: the joint "k" does not exist; add it or correct the name"#),
    (in_file, "<actuator><motor name='m'/></actuator>", r#"line 2: motor "m": it acts on nothing: give it a joint, a tendon or a site"#),
    (in_file, "<actuator><motor name='m' tendon='t'/></actuator>", r#"line 2: motor "m": the tendon "t" does not exist; add it or correct the name"#),
    (in_file, "<actuator><position joint='j' inheritrange='1'/></actuator>", "line 2: position: inheritrange: what it acts on has no range to take"),
    (in_file, "<keyframe><key name='k' qpos='1 2'/></keyframe>", r#"line 2: key "k": qpos="1 …" holds 2 numbers, not 1"#),
];

#[test]
fn every_fault_is_refused_with_its_message_alone() {
    for (frame, text, message) in FAULTS {
        let error = parse(&frame(text), &Options::default()).expect_err(text);
        assert_eq!(error.to_string(), *message, "{text}");
    }
}

#[test]
fn all_errors_of_a_file_come_at_once_in_the_order_of_lines() {
    let text = "<mujoco><worldbody>\n<body name='a' pos='x 0 0'>\n<joint type='y'/>\n<geom size='z'/></body></worldbody></mujoco>";
    let error = parse(text, &Options::default()).expect_err("three");
    let lines: Vec<_> = error.errors().iter().map(mjcf::MjcfError::line).collect();
    assert_eq!(lines, [Some(2), Some(3), Some(4)]);
    assert!(error.to_string().starts_with("3 errors\n  line 2"), "{error}");
}
