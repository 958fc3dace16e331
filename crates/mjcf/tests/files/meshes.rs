//! Masses and inertias of meshes.

use robot_dynamics::algorithms::inverse_dynamics;
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics_mjcf::{LoadOptions, Robot, parse};

/// A hinge that carries a tetrahedron with these faces.
fn swinging(faces: &str) -> Result<Robot, String> {
    let text = format!(
        "<mujoco><asset>
           <mesh name='m' vertex='0 0 0  0.3 0 0  0 0.4 0  0 0 0.5' face='{faces}' inertia='exact'/>
         </asset><worldbody><body pos='0 0 1'>
           <joint axis='0 1 0'/><geom type='mesh' mesh='m' pos='0.2 0.1 0'/>
         </body></worldbody></mujoco>"
    );
    parse(&text, &LoadOptions::default()).map_err(|error| error.to_string())
}

/// Mass, torque at rest, and M of the hinge.
fn numbers(robot: &Robot) -> [f64; 3] {
    let mass = robot.description.links[1].mass_properties.expect("a mass").mass();
    let model = Model::new(robot.description.clone()).expect("a model");
    let torque = |a: f64| {
        let mut tau = [0.0];
        inverse_dynamics(&model, &mut Workspace::new(&model), &[0.0], &[0.0], &[a], &mut tau);
        tau[0]
    };
    [mass, torque(0.0), torque(1.0) - torque(0.0)]
}

/// With `inertia="exact"` the surface must be oriented, as in MuJoCo. An open one is taken as MuJoCo takes
/// it, with a warning. The numbers are those of mujoco 4.0.0. It diagonalizes inertia with an error of 1e-9,
/// and its sums have other orders.
#[test]
fn exact_inertia_checks_the_surface() {
    let near = |robot: &Robot, expected: [f64; 3]| {
        let found = numbers(robot);
        assert!(found.iter().zip(expected).all(|(x, y)| (x - y).abs() < 1e-9 * y.abs()), "{found:?}");
    };
    let closed = swinging("0 2 1  0 3 2  0 1 3  1 2 3").expect("a robot");
    near(&closed, [10.000000546375919, -26.977501766346435, 1.0400000755989431]);
    assert_eq!(closed.report.warnings().count(), 0);

    let open = swinging("0 3 2  0 1 3  1 2 3").expect("a robot");
    near(&open, [6.666667030917279, -17.428138434925827, 0.7363986866945922]);
    let warnings: Vec<String> = open.report.warnings().map(|each| each.message().to_string()).collect();
    assert!(matches!(&warnings[..], [one] if one.contains("open at 3 edges")), "{warnings:?}");

    for (faces, fault) in [
        ("0 2 1  0 3 2  0 1 3  2 1 3", "same direction"),
        ("0 2 1  0 3 2  0 1 3  1 2 3  0 2 1  0 3 2  0 1 3  1 2 3", "occurs twice"),
        ("0 1 2  0 2 3  0 3 1  2 1 3", "not positive"),
    ] {
        let message = swinging(faces).expect_err(faces);
        assert!(message.contains(fault), "{message}");
    }
}
