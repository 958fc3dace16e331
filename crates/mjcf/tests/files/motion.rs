//! Compares motions with actuators, tendons, springs, damping and gravity compensation with MuJoCo's RK4 over
//! one second.
//!
//! Both use the same stages, in steps of 1 ms, or of 0.2 ms with free bodies and muscles. Muscles'
//! activations are exact here and by RK4 in MuJoCo. The velocity of a free body is along its own axes here
//! and along the axes of the world in MuJoCo. The two ends therefore differ by the error of the method, (ω
//! h)⁴ with spins up to 60 rad/s. The tolerance is 1e-9 of the largest number, or of one. Where MuJoCo's
//! inertias have an error of 1e-9, it is a hundred times that, because the error acts for one second.

use robot_dynamics::model::Model;
use robot_dynamics::simulation::{Effect, Method, SimulationBuilder};

use crate::golden::{Golden, SUMMED, assert_ends, goldens, numbers};

const ALLOWED: f64 = 1e-9;

#[test]
fn motions_end_where_mujocos_do() {
    let (mut compared, mut driven) = (0, 0);
    for golden in goldens() {
        let mut robot = golden.robot.description.clone();
        // Parts that MuJoCo treats as constraints.
        robot.equalities.clear();
        for passive in (robot.joints.iter_mut().map(|joint| &mut joint.passive))
            .chain(robot.tendons.iter_mut().map(|tendon| &mut tendon.passive))
        {
            passive.friction = 0.0;
        }
        let model = Model::new(robot).expect("a robot");
        let motion = &golden.value["motion"];
        if model.nv() == 0 {
            continue;
        }
        let (q, v) = Golden::state(&model, motion);
        let (step, duration) = (numbers(&motion["step"])[0], numbers(&motion["duration"])[0]);
        let controls = numbers(&motion["ctrl"]);
        let mut simulation = SimulationBuilder::new(&model)
            .dt(step)
            .method(Method::Fixed(robot_dynamics::simulation::Integrator::RungeKutta4))
            .without(Effect::Contacts)
            .build()
            .expect("a simulation");
        assert_eq!(simulation.control_names().count(), controls.len(), "{}", golden.file);
        simulation.reset(&q, &v).unwrap_or_else(|error| panic!("{}: {error}", golden.file));
        simulation.set_controls(&controls);
        simulation.run_for(duration).unwrap_or_else(|error| panic!("{}: {error}", golden.file));
        let allowed = if golden.tolerance() > SUMMED { 100.0 * golden.tolerance() } else { ALLOWED };
        assert_ends(&golden.file, &model, motion, (simulation.q(), simulation.v()), allowed);
        compared += 1;
        driven += usize::from(!controls.is_empty());
    }
    assert!(compared >= 20 && driven >= 5, "{compared} motions, {driven} with actuators");
}
