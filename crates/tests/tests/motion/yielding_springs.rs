//! Springs that yield: against the closed form of an ideal elasto-plastic spring, and their energy.

use robot_dynamics::description::{PassiveForces, TendonDescription, pendulum};
use robot_dynamics::mjcf::{LoadOptions, parse};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{Integrator, Method, RunOptions, SimulationBuilder};

const METHODS: [Method; 3] = [Method::Fixed(Integrator::RungeKutta4), Method::Implicit, Method::Mujoco];

/// A cart of 2 kg on a spring of 50 N/m that yields at 0.1 m, thrown at 1 m/s. The spring stretches by 0.1 m,
/// then the constant force 5 N stops the cart at x = 0.1 + (½·2·1² − ½·50·0.1²)/5 = 0.25 m, and the spring
/// rests at 0.15 m.
#[test]
fn cart_moves_its_spring() {
    let text = "<mujoco><option gravity='0 0 0'/><worldbody><body><joint name='x' type='slide' axis='1 0 0'
        stiffness='50' springyield='0.1'/><geom size='0.1' mass='2'/></body></worldbody></mujoco>";
    let model = Model::new(parse(text, &LoadOptions::default()).unwrap().description).unwrap();
    for method in METHODS {
        let mut simulation = SimulationBuilder::new(&model).dt(1e-4).method(method).build().unwrap();
        simulation.reset(&[0.0], &[1.0]).unwrap();
        let mut farthest = 0.0_f64;
        let mut least = f64::INFINITY;
        for _ in 0..20_000 {
            simulation.step().unwrap();
            farthest = farthest.max(simulation.q()[0]);
            if farthest > 0.2 {
                least = least.min(simulation.q()[0]);
            }
        }
        // The spring yields at the end of a step. Within a step of h the force exceeds its bound by up to k v
        // h, 0.1 % here, which is 1.5e-4 of the way of 0.15 m.
        let allowed = 1.5e-4;
        assert!((farthest - 0.25).abs() < allowed, "{method:?}: {farthest}");
        // It then swings elastically about 0.15 m.
        assert!((least - 0.05).abs() < allowed, "{method:?}: {least}");
    }
}

/// The energy that springs of joints and tendons lose as they yield is part of the losses, so the account
/// closes. A state that is set keeps the springs as they are; a restart makes them new.
#[test]
fn yielding_loses_energy() {
    let mut robot = pendulum(2.0, 0.5);
    robot.joints[0].passive = PassiveForces::default().with_spring(20.0, 0.3);
    robot.joints[0].spring_yield = 0.2;
    let mut strap = TendonDescription::new("strap", [("hinge".to_owned(), 0.1)]);
    strap.passive = PassiveForces::default().with_spring(300.0, 0.0);
    (strap.dead_band, strap.spring_yield) = (0.02, 0.01);
    robot.tendons.push(strap);
    let model = Model::new(robot).unwrap();
    for method in METHODS {
        // MuJoCo's step has order 1.
        let (h, steps) = if method == Method::Mujoco { (1e-4, 10_000) } else { (1e-3, 1000) };
        let mut simulation = SimulationBuilder::new(&model).dt(h).method(method).build().unwrap();
        let mut run =
            || simulation.run_steps_from(&[0.0], &[6.0], steps, RunOptions::new().sample_ends()).unwrap();
        let first = run();
        let account = &first.energy_account;
        assert!(account.dissipated() > 1.0, "{method:?}: {account:?}");
        let allowed = if method == Method::Mujoco { 5e-3 } else { 2e-4 };
        let imbalance = account.max_imbalance() / account.scale();
        assert!(imbalance < allowed, "{method:?}: {imbalance:e}");
        assert_eq!(run().q, first.q, "{method:?}");
        let ahead = |simulation: &mut robot_dynamics::simulation::Simulation| {
            let (q, v) = (simulation.q().to_vec(), simulation.v().to_vec());
            simulation.set_state(&q, &v).unwrap();
            simulation.step().unwrap();
            simulation.q()[0]
        };
        let snapshot = simulation.snapshot();
        let with_old_springs = ahead(&mut simulation);
        simulation.restore(&snapshot);
        simulation.step().unwrap();
        let off = (simulation.q()[0] - with_old_springs).abs();
        assert!(off < 1e-9, "{method:?}: {off:e}");
    }
}
