//! Shapes of links, and the report of invalid shapes.

use robot_dynamics::description::{Pose, Shape, ShapeRole};
use robot_dynamics_urdf::{Disposition, LoadOptions, Robot, parse};

pub(crate) fn with_shapes(inside: &str) -> Robot {
    let text = format!("<robot name=\"r\"><link name=\"arm\">\n{inside}\n</link></robot>");
    parse(&text, &LoadOptions::default().with_strict()).expect("shapes never refuse a file")
}

#[test]
fn every_shape_is_read_with_its_place() {
    let robot = with_shapes(
        r#"<visual><origin xyz="1 2 3" rpy="0 0 1.5"/><geometry><box size="0.1 0.2 0.3"/></geometry></visual>
           <collision><geometry><cylinder radius="0.1" length="0.5"/></geometry></collision>
           <collision><origin xyz="0 0 1"/><geometry><sphere radius="0.2"/></geometry></collision>
           <collision><geometry><capsule radius="0.1" length="0.4"/></geometry></collision>
           <visual><geometry><mesh filename="package://nowhere/arm.dae" scale="0.001 0.001 0.001"/></geometry></visual>
           <visual><geometry><mesh filename="arm.stl"/></geometry></visual>"#,
    );
    let shapes: Vec<Shape> = robot.description.shapes.iter().map(|shape| shape.shape.clone()).collect();
    let mesh = |name: &str, scale: f64| Shape::Mesh { name: name.into(), file: None, scale: [scale; 3] };
    assert_eq!(
        shapes,
        [
            Shape::Box { size: [0.1, 0.2, 0.3] },
            Shape::Cylinder { radius: 0.1, length: 0.5 },
            Shape::Sphere { radius: 0.2 },
            Shape::Capsule { radius: 0.1, length: 0.4 },
            mesh("package://nowhere/arm.dae", 0.001),
            mesh("arm.stl", 1.0),
        ]
    );
    assert!(robot.description.shapes.iter().all(|shape| shape.link == "arm"));
    let roles: Vec<ShapeRole> = robot.description.shapes.iter().map(|shape| shape.role).collect();
    let (visual, collision) = (ShapeRole::Visual, ShapeRole::Collision);
    assert_eq!(roles, [visual, collision, collision, collision, visual, visual]);
    assert_eq!(
        robot.description.shapes[0].link_from_shape,
        Pose::from_xyz_rpy([1.0, 2.0, 3.0], [0.0, 0.0, 1.5])
    );
    assert_eq!(robot.description.shapes[2].link_from_shape, Pose::from_translation([0.0, 0.0, 1.0]));
    assert_eq!(robot.report.counts.ignored, 0, "{}", robot.report);
    assert_eq!(robot.report.counts.not_dynamics, 6);
}

/// Contents of a `<visual>` without a valid shape.
#[rustfmt::skip]
pub(crate) const BAD_SHAPES: &[&str] = &[
    "",
    "<geometry/>",
    "<geometry><box/></geometry>",
    "<geometry><box size=\"1 2\"/></geometry>",
    "<geometry><box size=\"1 2 3 4\"/></geometry>",
    "<geometry><box size=\"1 2 -3\"/></geometry>",
    "<geometry><sphere radius=\"big\"/></geometry>",
    "<geometry><sphere radius=\"inf\"/></geometry>",
    "<geometry><cylinder radius=\"-1\" length=\"1\"/></geometry>",
    "<geometry><cylinder radius=\"1\"/></geometry>",
    "<geometry><mesh/></geometry>",
    "<geometry><cone radius=\"1\"/></geometry>",
    "<origin xyz=\"1 2\"/><geometry><sphere radius=\"1\"/></geometry>",
];

/// An invalid shape is omitted and reported with its line. The robot loads.
#[test]
fn invalid_shapes_are_reported() {
    for inside in BAD_SHAPES {
        let robot = with_shapes(&format!("<visual>{inside}</visual>"));
        assert!(robot.description.shapes.is_empty(), "{inside}");
        let is_ignored = |entry: &&robot_dynamics_urdf::Finding| {
            entry.disposition() == Disposition::Ignored { physics: false }
        };
        let ignored: Vec<_> = robot.report.findings.iter().filter(is_ignored).collect();
        let [entry] = ignored[..] else { panic!("{inside}: {}", robot.report) };
        assert_eq!((entry.line(), entry.place()), (2, "link \"arm\"/visual"), "{inside}");
        assert_eq!(robot.report.counts.ignored_physics, 0);
    }
}

/// A rotation does not show whether 90 meant degrees. The written angles do.
#[test]
fn angles_are_kept_as_written() {
    let robot = parse(
        r#"<robot name="r">
          <link name="base"><visual><origin rpy="1 0 0"/><geometry><sphere radius="1"/></geometry></visual></link>
          <link name="arm"><inertial><origin rpy="0 90 0"/><mass value="1"/>
            <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
          <joint name="elbow" type="continuous"><parent link="base"/><child link="arm"/>
            <origin xyz="1 0 0" rpy="0 0 -180"/></joint>
        </robot>"#,
        &LoadOptions::default(),
    )
    .expect("a robot");
    let mut angles: Vec<(&str, [f64; 3])> =
        robot.angles.iter().map(|written| (written.place.as_str(), written.angles)).collect();
    angles.sort_by_key(|(place, _)| *place);
    assert_eq!(
        angles,
        [
            ("joint \"elbow\"", [0.0, 0.0, -180.0]),
            ("link \"arm\"", [0.0, 90.0, 0.0]),
            ("link \"base\"/visual", [1.0, 0.0, 0.0]),
        ]
    );
}
