//! Every check of an audit detects two routes that differ by a relative change of 1e-6 in the masses.

use std::error::Error;
use std::path::PathBuf;

use robot_dynamics::description::MassProperties;
use robot_dynamics::model::Model;
use robot_dynamics::verification::audit::{Check, Verdict, audit, audit_against};

/// Whether a check compares two routes.
fn compares(check: &Check) -> bool {
    let alone = ["mass_matrix", "inertia_triangle"].contains(&check.name.as_str());
    !alone && !check.name.starts_with("drift_")
}

/// The robot with all masses and moments multiplied by 1 + `part`.
fn heavier(model: &Model, part: f64) -> Result<Model, Box<dyn Error>> {
    let mut description = model.description().clone();
    for link in &mut description.links {
        if let Some(p) = &mut link.mass_properties {
            let (mass, inertia) = (p.mass() * (1.0 + part), p.inertia_about_center_of_mass() * (1.0 + part));
            *p = MassProperties::new(mass, p.center_of_mass(), inertia)?;
        }
    }
    Ok(Model::new(description)?)
}

#[test]
fn every_comparison_detects_a_relative_error_of_1e_6() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../robots");
    for name in
        ["dual_arm", "gantry", "gripper", "hand", "humanoid", "panda", "quadruped", "three_r", "two_r", "ur5"]
    {
        let robot = robot_dynamics::urdf::load(
            folder.join(format!("{name}.urdf")),
            &robot_dynamics::urdf::LoadOptions::default(),
        )?;
        let model = Model::new(robot.description)?;
        let comparisons = |checks: Vec<Check>| checks.into_iter().filter(compares).collect::<Vec<_>>();
        let same = comparisons(audit(&model, 4, 1));
        assert!(same.len() >= 9, "{name}: only {} comparisons", same.len());
        for check in same {
            assert_eq!(check.verdict, Verdict::Ok, "{name}: {check:?}");
        }
        for check in comparisons(audit_against(&model, &heavier(&model, 1e-6)?, 4, 1)) {
            assert_eq!(check.verdict, Verdict::Short, "{name}: {check:?}");
            // With a clear margin.
            assert!(check.found > 3.0 * check.allowed, "{name}: {check:?}");
        }
    }
    Ok(())
}
