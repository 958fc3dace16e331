//! A quadruped that stands under pushes in the simulator.

use robot_dynamics::algorithms::frame_pose;
use robot_dynamics::contact::Ground;
use robot_dynamics::control::PoseReference;
use robot_dynamics::control::whole_body::ALL_AXES;
use robot_dynamics::simulation::{AppliedWrench, SimulationBuilder};

use super::*;

#[path = "../../../../robot-dynamics/examples/07_whole_body.rs"]
mod example;

/// Pushes of 40 N to the side and along the trunk move it by a few millimetres; afterwards it is back. The
/// simulator finds its own contact forces, and their sum is the weight again.
#[test]
fn a_quadruped_stands_under_pushes() {
    let model = quadruped();
    let q = standing(&model);
    let rest = vec![0.0; model.nv()];
    let trunk = model.frame_named("trunk").expect("a trunk");
    let pose = frame_pose(&model, &mut Workspace::new(&model), &q, trunk);
    let mut control = on_feet(&model, 0.6).with_dissipation();
    let reference = PoseReference::at_rest(pose);
    let gains = PdGains::critical(200.0);
    let hold = Objective::FramePose { frame: trunk, axes: ALL_AXES.to_vec(), reference, gains };
    control.add_task(hold, 1.0).expect("a task");
    control.add_task(posture(&model, &q, 50.0), 1e-3).expect("a task");
    control.add_task(Objective::ContactForces, 1e-6).expect("a task");
    let ground = Ground::through([0.0; 3], [0.0, 0.0, 1.0]).expect("a plane");
    let mut simulation =
        SimulationBuilder::new(&model).ground(ground).dt(2e-3).build().expect("a simulation");
    simulation.set_state(&q, &rest).expect("a state");
    let mut farthest: f64 = 0.0;
    for step in 0..1000 {
        let solution = control.solve(simulation.q(), simulation.v()).expect("a solution");
        simulation.set_torques(&solution.torque);
        match step {
            100 => simulation.set_wrenches(&[AppliedWrench::force(trunk, [0.0, 40.0, 0.0])]),
            150 => simulation.set_wrenches(&[AppliedWrench::force(trunk, [40.0, 0.0, 0.0])]),
            200 => simulation.set_wrenches(&[]),
            _ => {}
        }
        simulation.step().expect("a step");
        let now = frame_pose(&model, &mut Workspace::new(&model), simulation.q(), trunk).translation;
        farthest = farthest.max(largest((0..2).map(|k| now[k] - pose.translation[k])));
    }
    let now = frame_pose(&model, &mut Workspace::new(&model), simulation.q(), trunk).translation;
    let off = largest((0..3).map(|k| now[k] - pose.translation[k]));
    // 40 N move a mass of 20 kg with a stiffness of 200 1/s² by up to 10 mm.
    assert!(farthest > 1e-3 && farthest < 0.02, "{farthest}");
    // Friction of the joints at rest, 0.1 N·m, holds it off by less than a millimetre.
    assert!(off < 2e-3, "{off}");
    let carried: f64 = simulation.contacts().iter().map(|contact| contact.force[2]).sum();
    assert!((carried - model.mass() * 9.81).abs() < 0.05 * model.mass() * 9.81, "{carried}");
}

/// The example's quadruped returns after a push, and stands on three feet while it lifts the fourth.
#[test]
fn the_example_lifts_a_foot() {
    let numbers = example::numbers().expect("a run");
    let [most, left] = numbers.pushed;
    // 40 N for 0.1 s give 20 kg a speed of 0.2 m/s, and a critical spring of 150 1/s² stops it in 6 mm.
    assert!(most > 1e-3 && most < 0.015, "{most}");
    // 0.2 s after the push (1 + 2.4) exp(−2.4) = 0.31 of it is left.
    assert!(left < 0.5 * most, "{left}");
    // Friction of 0.1 N·m holds a resting knee off by up to 0.1/(150·0.004) = 0.17 rad, 33 mm at the foot,
    // with the stiffness 150 1/s² and the inertia 0.004 kg·m². Its compensation leaves a part of that.
    assert!(numbers.height > 0.03 && numbers.height < 0.055, "{}", numbers.height);
    assert!((numbers.carried - 1.0).abs() < 0.05, "{}", numbers.carried);
    let (_, load) = numbers.loads.last().expect("a step");
    assert_eq!(load[0], 0.0);
    assert!(load[1..].iter().all(|load| *load > 0.0));
}
