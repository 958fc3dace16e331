//! The checks of the command's audit, on random robots of every kind.

use robot_dynamics::description::{Base, LinkDescription, MassProperties, RobotDescription};
use robot_dynamics::model::Model;
use robot_dynamics::verification::audit::{Verdict, audit};

use crate::common::{Family, families};

/// The families run in parallel, as this is the slowest test of the program.
#[test]
fn random_robots_pass_their_audit() {
    let audited: usize = std::thread::scope(|scope| {
        let families = families().into_iter().map(|family| scope.spawn(move || checks_passed(&family)));
        let running: Vec<_> = families.collect();
        running.into_iter().map(|one| one.join().expect("every check passes")).sum()
    });
    assert!(audited > 200, "only {audited} checks");
}

/// The number of checks that some robots of a family pass.
fn checks_passed(family: &Family) -> usize {
    let mut passed = 0;
    // Badly conditioned robots fail only the check of their condition number.
    for robot in family.robots().filter(|robot| robot.condition() < 1e6).take(3) {
        for check in audit(&robot.model, 3, robot.seed) {
            let kappa = check.name == "mass_matrix" || check.name == "inertia_triangle";
            assert!(check.verdict == Verdict::Ok || kappa, "{} seed {}: {check:?}", robot.family, robot.seed);
            passed += usize::from(!kappa);
        }
    }
    passed
}

/// A drone of 27 g, whose moments of inertia are a thousandth of the terms m |r|² of its motion through the
/// air. u × m u is zero, but the products are not.
#[test]
fn light_floating_robot_passes_its_audit() {
    let inertia = nalgebra::Matrix3::from_diagonal(&nalgebra::Vector3::new(2.4e-5, 2.4e-5, 3.2e-5));
    let mass = MassProperties::new(0.027, nalgebra::Vector3::zeros(), inertia).expect("a body");
    let mut robot = RobotDescription::new("drone");
    robot.base = Base::Floating;
    robot.links.push(LinkDescription::new("drone", Some(mass)));
    let checks = audit(&Model::new(robot).expect("a robot"), 20, 1);
    let short: Vec<_> = checks.iter().filter(|check| check.verdict == Verdict::Short).collect();
    assert!(checks.len() > 8 && short.is_empty(), "{short:?}");
}
