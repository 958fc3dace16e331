//! Each check must be able to fail: two routes that differ by a millionth of the masses are told apart.

use std::path::PathBuf;

use dynamics::MassProperties;
use multibody::Model;

use super::check::{Check, Verdict};
use super::probe::Probe;
use super::{forward, gravity, inverse, lagrange, mass_matrix, power, skew};

/// Every check that compares two routes.
fn comparisons(probe: &Probe<'_>) -> Vec<Check> {
    let [_, columns] = mass_matrix::checks(probe);
    let mut checks = vec![
        columns,
        gravity::slope_of_potential(probe),
        skew::defect(probe),
        inverse::undoes_forward(probe),
        forward::two_routes(probe),
        power::balance(probe),
    ];
    checks.extend(lagrange::checks(probe));
    checks
}

/// The robot with all masses and moments 1 + `part` times as large.
fn heavier(model: &Model, part: f64) -> Model {
    let mut description = model.description().clone();
    for link in &mut description.links {
        if let Some(p) = &mut link.mass_properties {
            let (mass, inertia) = (p.mass() * (1.0 + part), p.inertia_about_center_of_mass() * (1.0 + part));
            *p = MassProperties::new(mass, p.center_of_mass(), inertia).unwrap();
        }
    }
    Model::new(description).unwrap()
}

#[test]
fn every_comparison_sees_a_millionth_of_the_mass() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../robots");
    for name in
        ["dual_arm", "gantry", "gripper", "hand", "humanoid", "panda", "quadruped", "three_r", "two_r", "ur5"]
    {
        let robot = urdf::load(folder.join(format!("{name}.urdf")), &urdf::Options::default()).unwrap();
        let model = Model::new(robot.description).unwrap();
        let mut probe = Probe::new(&model, 4, 1);
        for check in comparisons(&probe) {
            assert_eq!(check.verdict, Verdict::Ok, "{name}: {check:?}");
        }
        let other = heavier(&model, 1e-6);
        probe.oracle = &other;
        for check in comparisons(&probe) {
            assert_eq!(check.verdict, Verdict::Short, "{name}: {check:?}");
            // Not by a hair.
            assert!(check.found > 3.0 * check.allowed, "{name}: {check:?}");
        }
    }
}
