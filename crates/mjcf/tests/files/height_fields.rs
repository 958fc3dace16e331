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

/// The mass of a height field as in mujoco 4.0.0: that of a box of 0.4 · 0.6 · 0.7 m.
#[test]
fn a_height_field_has_the_mass_of_a_box() {
    let text = "<mujoco><asset><hfield name='h' nrow='2' ncol='2' size='0.2 0.3 0.4 0.5' elevation='0 1 2 3'/></asset>
        <worldbody><body><freejoint/><geom type='hfield' hfield='h' pos='1 0 0' euler='0 0 30'/></body></worldbody></mujoco>";
    let robot = parse(text, &LoadOptions::default()).expect("a robot");
    assert_eq!(robot.report.warnings().count(), 0, "{}", robot.report);
    let body = robot.description.links[1].mass_properties.expect("a mass");
    assert!((body.mass() - 168.0).abs() < 1e-12, "{}", body.mass());
    let mut moments: Vec<f64> = body.principal().moments.iter().copied().collect();
    moments.sort_by(f64::total_cmp);
    for (found, expected) in moments.iter().zip([7.28, 9.1, 11.9]) {
        assert!((found - expected).abs() < 1e-12, "{moments:?}");
    }
    assert!((body.center_of_mass().x - 1.0).abs() < 1e-15);
}

/// A signed distance field of a mesh has the mass of the mesh, as in mujoco 4.0.0.
#[test]
fn a_signed_distance_field_has_the_mass_of_its_mesh() {
    let mass = |form: &str| {
        let text = format!(
            "<mujoco><asset><mesh name='m' builtin='sphere' params='1'/></asset><worldbody><body><freejoint/>
             <geom type='{form}' mesh='m'/></body></worldbody></mujoco>"
        );
        parse(&text, &LoadOptions::default()).expect("a robot").description.links[1].mass_properties
    };
    assert!(mass("mesh").is_some());
    assert_eq!(mass("mesh"), mass("sdf"));
}

/// The points of a mesh can come from a plugin, which MuJoCo alone has.
#[test]
fn a_signed_distance_field_of_a_plugin_has_no_mass() {
    let text = "<mujoco><asset><mesh name='m'><plugin plugin='mujoco.sdf.torus'/></mesh></asset><worldbody>
        <body><freejoint/><geom size='1'/><geom type='sdf' mesh='m'/></body></worldbody></mujoco>";
    let robot = parse(text, &LoadOptions::default()).expect("a robot");
    assert!(robot.report.to_string().contains("its mass is not in the model"), "{}", robot.report);
}
