//! Height fields (`<hfield>`) with heights in the MJCF file.

use robot_dynamics::description::{Elevation, Shape};
use robot_dynamics_mjcf::{LoadOptions, MjcfError, parse, write};

pub(crate) fn robot(hfield: &str) -> String {
    format!(
        "<mujoco><asset><hfield name='hill' size='1 2 0.5 0.1' {hfield}/></asset><worldbody>
           <geom type='hfield' hfield='hill' pos='0 0 1'/>
           <body><freejoint/><geom size='0.1' mass='1'/></body></worldbody></mujoco>"
    )
}

fn elevation(text: &str) -> Option<Elevation> {
    let robot = parse(text, &LoadOptions::default()).expect("a robot");
    match &robot.description.shapes[0].shape {
        Shape::HeightField { elevation, size, .. } => {
            assert_eq!(*size, [1.0, 2.0, 0.5, 0.1]);
            elevation.clone()
        }
        other => panic!("{other:?}"),
    }
}

/// The first row of the text has the largest y. The least height is at 0, the largest at the third number of
/// `size`.
#[test]
fn rows_are_turned_and_heights_are_stretched() {
    let text = robot("nrow='2' ncol='3' elevation='1 2 3  3 3 5'");
    let found = elevation(&text).unwrap();
    assert_eq!((found.rows, found.columns), (2, 3));
    assert_eq!(found.heights, [0.25, 0.25, 0.5, 0.0, 0.125, 0.25]);
    // Missing or equal numbers give a flat field; without counts there are no heights.
    assert_eq!(elevation(&robot("nrow='2' ncol='2'")).unwrap().heights, [0.0; 4]);
    assert_eq!(elevation(&robot("nrow='2' ncol='2' elevation='3 3 3 3'")).unwrap().heights, [0.0; 4]);
    assert_eq!(elevation(&robot("")), None);
    // The heights of a separate file take precedence.
    assert_eq!(elevation(&robot("file='hill.png' nrow='2' ncol='2' elevation='3 3 3 3'")), None);
    // Writing and reading preserve the heights.
    let read = parse(&text, &LoadOptions::default()).expect("a robot");
    let written = write(&read.description, None).expect("a robot");
    assert_eq!(written.left_out, []);
    assert_eq!(elevation(&written.text), Some(found));
}

/// A wrong number of heights is refused, as in MuJoCo.
#[test]
fn too_few_heights_are_refused() {
    let refused = parse(&robot("nrow='2' ncol='3' elevation='1 2 3'"), &LoadOptions::default()).unwrap_err();
    let [MjcfError::WrongCount { attribute, found: 3, .. }] = refused.errors() else { panic!("{refused}") };
    assert_eq!(attribute, "elevation");
}

/// The name of a height field defaults to that of its file.
#[test]
fn a_height_field_is_named_by_its_file() {
    let text = "<mujoco><asset><hfield file='maps/hills.bin' size='1 2 0.5 0.1'/></asset><worldbody>
        <geom type='hfield' hfield='hills'/></worldbody></mujoco>";
    let robot = parse(text, &LoadOptions::default()).expect("a robot");
    assert_eq!(robot.description.shapes[0].shape.file(), Some(("maps/hills.bin", None)));
}
