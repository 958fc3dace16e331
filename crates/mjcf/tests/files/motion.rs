//! Compares motions with actuators, tendons, springs, damping and gravity compensation with MuJoCo's RK4 over
//! one second.
//!
//! Both use the same stages, in steps of 1 ms, or of 0.2 ms with free bodies and muscles. Muscles'
//! activations are exact here and by RK4 in MuJoCo. The velocity of a free body is along its own axes here
//! and along the axes of the world in MuJoCo. The two ends therefore differ by the error of the method, (ω
//! h)⁴ with spins up to 60 rad/s. The tolerance is 1e-9 of the largest number, or of one. Where MuJoCo's
//! inertias have an error of 1e-9, it is a hundred times that, because the error acts for one second.

use robot_dynamics::conventions::{
    configuration_from_mujoco, configuration_to_mujoco, velocity_from_mujoco, velocity_to_mujoco,
};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{Effect, Method, SimulationBuilder};

use crate::golden::{SUMMED, goldens, numbers};

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
        let (start_q, start_v) = (numbers(&motion["qpos"]), numbers(&motion["qvel"]));
        if model.nv() == 0 {
            continue;
        }
        let (mut q, mut v) = (vec![0.0; model.nq()], vec![0.0; model.nv()]);
        configuration_from_mujoco(&model, &start_q, &mut q);
        velocity_from_mujoco(&model, &q, &start_v, &mut v);
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
        configuration_to_mujoco(&model, simulation.q(), &mut q);
        velocity_to_mujoco(&model, simulation.q(), simulation.v(), &mut v);
        for (what, found, end) in [("q", &q, "end_qpos"), ("v", &v, "end_qvel")] {
            let expected = numbers(&motion[end]);
            let scale = expected.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
            let off = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / scale;
            let allowed = if golden.tolerance() > SUMMED { 100.0 * golden.tolerance() } else { ALLOWED };
            assert!(off <= allowed, "{}: {what}: {off:e}\n{found:?}\n{expected:?}", golden.file);
        }
        compared += 1;
        driven += usize::from(!controls.is_empty());
    }
    assert!(compared >= 20 && driven >= 5, "{compared} motions, {driven} with actuators");
}
