//! Contact of robots from files: each step's answer against another method, and against the laws themselves.

use std::path::PathBuf;

use robot_dynamics::simulator::{Method, SimulationBuilder};
use robot_dynamics::{
    ContactSet, Ground, Model, Options, StepForces, StepWorkspace, Stepper, Workspace, admm, load_with,
    mesh_corners, neutral,
};

fn robot(file: &str) -> Model {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../robots").join(file);
    let options = Options::default().with_floating_base();
    load_with(path, &options).unwrap_or_else(|error| panic!("{file}: {error}")).model
}

/// Dropped from 5 cm: in each step with contacts the velocities by the alternating direction method of multipliers are those of the step.
#[test]
fn dropped_robots_move_as_by_the_alternating_method() {
    for (file, steps) in [("quadruped.urdf", 400), ("humanoid.urdf", 400)] {
        let model = robot(file);
        let contacts = ContactSet::with_meshes(&model, &[Ground::level(0.0)], mesh_corners).unwrap();
        let (mut q, mut v) = (neutral(&model), vec![0.0; model.nv()]);
        let gap = contacts.clearance(&model, &mut Workspace::new(&model), &q).unwrap();
        q[2] += 0.05 - gap;
        let simulation = SimulationBuilder::new(&model).method(Method::Implicit).contacts(contacts);
        let mut implicit = simulation.build().unwrap().stepper();
        let (mut workspace, tau) = (StepWorkspace::new(&model), vec![0.0; model.nv()]);
        let (mut same, mut several, mut unsettled, mut without, mut farthest) = (0, 0, 0, 0, 0.0_f64);
        for step in 0..steps {
            implicit
                .step(&model, &mut workspace, &StepForces::new(&tau, true), 1e-3, &mut q, &mut v)
                .unwrap_or_else(|error| panic!("{file}, step {step}: {error}"));
            let Some(problem) = implicit.contact_problem() else { continue };
            if !problem.is_solved {
                without += 1;
                continue;
            }
            let other = admm::solve(&problem, &admm::Options::default());
            if !other.is_settled {
                unsettled += 1;
                continue;
            }
            let fastest = problem.free_velocity.amax().max(1e-3);
            // The library looks for s to 1e-7 of the speeds.
            let own = problem.violation(&problem.impulse).worst();
            assert!(own < 1e-6 * fastest, "{file}, step {step}: {own} from the laws");
            let off = (&problem.velocity - &other.velocity).amax() / fastest;
            if off < 1e-5 {
                (same, farthest) = (same + 1, farthest.max(off));
            } else {
                several += 1;
            }
        }
        println!(
            "{file}: {same} steps the same to {farthest:.1e} of the speeds, {several} with several solutions, {without} without \
             one, {unsettled} that the other method did not finish"
        );
        let all = same + several + unsettled + without;
        assert!(all > steps / 2 && same * 100 >= 95 * all, "{file}: {same} of {all}");
        let laws = implicit.contact_laws().unwrap();
        assert!(laws.solved >= all && laws.violation.worst() < 1e-5, "{file}: {laws:?}");
    }
}
