//! Regressors times inertial parameters are forces and energies, on every kind of robot.
//!
//! Tolerance: 1e-12 of the size of the terms allows 4500 roundings in sums over at most about 60 bodies.

use robot_dynamics::algorithms::{
    PARAMETERS_PER_LINK, inertial_parameters, inverse_dynamics, joint_torque_regressor, kinetic_energy,
    kinetic_energy_regressor, potential_energy, potential_energy_regressor,
};
use robot_dynamics::description::PassiveForces;
use robot_dynamics::model::{Model, Workspace};

use crate::common::{Family, Robot, dot, families, max_difference, size, times};

const ROUNDING: f64 = 1e-12;

/// The robot without armature, springs and tendons, which are not inertial parameters; `None` if the rest is
/// not a valid robot.
fn bare(robot: &Robot) -> Option<Model> {
    let mut description = robot.model.description().clone();
    for joint in &mut description.joints {
        joint.passive = PassiveForces::default();
    }
    description.tendons.clear();
    Model::new(description).ok()
}

#[test]
fn regressors_times_parameters_are_forces_and_energies() {
    let mut tested = 0;
    for robot in families().iter().flat_map(Family::robots) {
        let Some(model) = &bare(&robot) else { continue };
        tested += 1;
        let (q, v, a) = (&robot.state.q[..], &robot.state.v[..], &robot.state.a[..]);
        let (w, nv) = (&mut Workspace::new(model), model.nv());
        let parameters = inertial_parameters(model);
        let n = parameters.len();
        assert_eq!(n, PARAMETERS_PER_LINK * model.moving_links().count());

        let (mut regressor, mut tau) = (vec![0.0; nv * n], vec![0.0; nv]);
        joint_torque_regressor(model, w, q, v, a, &mut regressor);
        inverse_dynamics(model, w, q, v, a, &mut tau);
        let terms: Vec<f64> = regressor
            .chunks(n)
            .map(|row| row.iter().zip(&parameters).map(|(y, p)| (y * p).abs()).sum())
            .collect();
        let defect = max_difference(&times(&regressor, &parameters), &tau);
        robot.require("Y π = τ", defect, ROUNDING * size(&terms));

        let mut row = vec![0.0; n];
        kinetic_energy_regressor(model, w, q, v, &mut row);
        let kinetic = kinetic_energy(model, w, q, v);
        let terms: f64 = row.iter().zip(&parameters).map(|(y, p)| (y * p).abs()).sum();
        robot.require("y π = K", (dot(&row, &parameters) - kinetic).abs(), ROUNDING * terms);

        potential_energy_regressor(model, w, q, &mut row);
        let potential = potential_energy(model, w, q);
        let terms: f64 = row.iter().zip(&parameters).map(|(y, p)| (y * p).abs()).sum();
        robot.require("y π = V", (dot(&row, &parameters) - potential).abs(), ROUNDING * terms);
    }
    assert!(tested > 300, "only {tested} robots do without armature");
}

/// The parameters equal those of the description if no link is fixed to another.
#[test]
fn parameters_are_those_of_description() {
    let mut tested = 0;
    for robot in families().iter().flat_map(Family::robots) {
        let (model, description) = (&robot.model, robot.model.description());
        if description.joints.iter().any(|joint| joint.kind.nv() == 0) {
            continue;
        }
        let parameters = inertial_parameters(model);
        for (name, found) in model.moving_links().zip(parameters.chunks(PARAMETERS_PER_LINK)) {
            tested += 1;
            let link = description.links.iter().find(|link| link.name == name).expect("a link of the robot");
            let Some(p) = &link.mass_properties else {
                robot.require("a massless link's parameters", size(found), 0.0);
                continue;
            };
            let (m, c, i) = (p.mass(), p.center_of_mass(), p.inertia_about_origin());
            let expected = [
                m,
                m * c.x,
                m * c.y,
                m * c.z,
                i[(0, 0)],
                i[(0, 1)],
                i[(1, 1)],
                i[(0, 2)],
                i[(1, 2)],
                i[(2, 2)],
            ];
            robot.require("π", max_difference(found, &expected), ROUNDING * size(&expected));
        }
    }
    assert!(tested > 100, "only {tested} links were compared");
}
