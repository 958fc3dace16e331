//! The laws, as the command's audit asks for them, on random robots of every kind.

use crate::common::families;
use multibody::audit::{Verdict, audit};

#[test]
fn random_robots_pass_their_audit() {
    let mut audited = 0;
    for family in families() {
        // What badly conditioned robots fall short of is their condition itself.
        for robot in family.robots().filter(|robot| robot.condition() < 1e6).take(3) {
            for check in audit(&robot.model, 3, robot.seed) {
                let kappa = check.name == "mass_matrix" || check.name == "inertia_triangle";
                assert!(
                    check.verdict == Verdict::Ok || kappa,
                    "{} seed {}: {check:?}",
                    robot.family,
                    robot.seed
                );
                audited += usize::from(!kappa);
            }
        }
    }
    assert!(audited > 200, "only {audited} checks");
}
