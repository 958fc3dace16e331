//! Stiff damping, springs, dry friction and limits in one step: orders, closed forms, bounds, energy
//! accounts.

use nalgebra::{Matrix3, Vector3};
use robot_dynamics::description::{
    ActuatorDescription, JointDescription, JointKind, Limits, LinkDescription, MassProperties, Mimic,
    PassiveForces, Pose, RandomRobotOptions, RobotDescription, TendonDescription, Transmission, pendulum,
    random_robot,
};
use robot_dynamics::model::{Model, difference, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{
    ConstantTorque, Effect, ImplicitIntegrator, Integrator, Method, Run, RunError, RunOptions,
    SimulationBuilder, StateTransition, StepForces, StepWorkspace, Stepper, step,
};

use crate::common::damped_tree;

fn let_go(model: &Model, q: &[f64], v: &[f64], h: f64, steps: usize) -> Run {
    let mut simulation = SimulationBuilder::new(model).method(Method::Implicit).dt(h).build().unwrap();
    simulation.run_steps_from(q, v, steps, RunOptions::new().sample_ends()).unwrap()
}

/// A sled of mass m on a straight rail with a given direction and passive forces.
fn sled(mass: f64, axis: [f64; 3], passive: PassiveForces, limits: Limits) -> Model {
    let mut robot = RobotDescription::new("sled");
    robot.links.push(LinkDescription::new("rail", None));
    robot.links.push(LinkDescription::new("sled", MassProperties::point(mass, Vector3::zeros()).unwrap()));
    let slide = JointDescription::new("slide", JointKind::Prismatic { axis }, "rail", "sled", Pose::IDENTITY);
    robot.joints.push(slide.with_passive(passive).with_limits(limits));
    Model::new(robot).unwrap()
}

/// Against the classical Runge–Kutta method with a hundredth of the step, on trees with ball and floating
/// joints, damping and springs. Halving h divides the error by 4.
#[test]
fn smooth_motion_has_order_2() {
    for seed in 0..5 {
        let mut robot = damped_tree(seed).description().clone();
        for joint in &mut robot.joints {
            joint.passive.friction = 0.0;
            joint.limits = Limits::default();
            if !matches!(joint.kind, JointKind::Spherical | JointKind::Floating) {
                joint.passive = joint.passive.with_spring(5.0, 0.2);
            }
        }
        let model = Model::new(robot).unwrap();
        let state = random_state(&model, &mut SplitMix64::new(seed));
        let tau = vec![0.0; model.nv()];
        let forces = StepForces::new(&tau, true);
        let time = 0.1;
        let (mut q, mut v) = (state.q.clone(), state.v.clone());
        let mut workspace = StepWorkspace::new(&model);
        for _ in 0..2000 {
            step(&model, Integrator::RungeKutta4, &mut workspace, &forces, time / 2000.0, &mut q, &mut v)
                .unwrap();
        }
        let error = |steps: usize| {
            let run = let_go(&model, &state.q, &state.v, time / steps as f64, steps);
            let mut way = vec![0.0; model.nv()];
            difference(&model, &q, &run.q, &mut way);
            let of_v = run.v.iter().zip(&v).map(|(a, b)| a - b);
            of_v.chain(way).fold(0.0_f64, |most, x| most.max(x.abs()))
        };
        let (coarse, fine) = (error(100), error(200));
        let order = (coarse / fine).log2();
        println!("robot {seed}: error {fine:.1e}, order {order:.2}");
        assert!(order > 1.8, "robot {seed}: {coarse:e}, {fine:e}, order {order}");
    }
}

/// With damping ten thousand times the stability limit of an explicit step, no motion grows at any step.
#[test]
fn stiff_damping_stays_bounded() {
    for seed in 0..8 {
        let mut robot = random_robot(seed, &RandomRobotOptions::default());
        robot.gravity = [0.0; 3];
        let mut random = SplitMix64::new(seed);
        for joint in &mut robot.joints {
            let damping = 10.0_f64.powf(random.uniform(-2.0, 6.0));
            joint.passive = PassiveForces::default().with_damping(damping);
            joint.limits = Limits::default();
        }
        let model = Model::new(robot).unwrap();
        let state = random_state(&model, &mut random);
        for h in [1e-3, 1e-2] {
            let run = let_go(&model, &state.q, &state.v, h, 1000);
            let energy_account = run.energy_account;
            assert!(
                energy_account.now() <= energy_account.start() * 1.001,
                "robot {seed}, h {h}: {energy_account:?}"
            );
            assert!(energy_account.dissipated() >= 0.0);
        }
    }
}

/// A stiff spring of 1e8 N/m decays with steps of a hundred periods; an explicit step diverges.
#[test]
fn stiff_springs_decay() {
    let passive = PassiveForces::default().with_spring(1e8, 0.0);
    let model = sled(1.0, [1.0, 0.0, 0.0], passive, Limits::default());
    let run = let_go(&model, &[0.01], &[0.0], 0.06, 30);
    assert!(run.q[0].abs() < 1e-12 && run.v[0].abs() < 1e-9, "{:?} {:?}", run.q, run.v);
}

/// On a slope of 30° a sled sticks below the friction limit without creeping, and slides above it with a = g
/// sin α − f/m.
#[test]
fn friction_sticks_and_slides_on_a_slope() {
    let (mass, alpha) = (2.0, 30.0_f64.to_radians());
    let downhill = [alpha.cos(), 0.0, -alpha.sin()];
    let pull = mass * 9.81 * alpha.sin();
    let friction =
        |f: f64| sled(mass, downhill, PassiveForces::default().with_friction(f), Limits::default());
    let held = let_go(&friction(1.0001 * pull), &[0.0], &[0.0], 1e-3, 10_000);
    assert!(held.q[0].abs() < 1e-15 && held.v[0] == 0.0, "{:?} {:?}", held.q, held.v);
    let sliding = let_go(&friction(0.5 * pull), &[0.0], &[0.0], 1e-3, 1000);
    let a = 0.5 * pull / mass;
    assert!((sliding.v[0] - a).abs() < 1e-12 && (sliding.q[0] - 0.5 * a).abs() < 1e-12, "{:?}", sliding.q);
    let lost = 0.5 * pull * sliding.q[0];
    assert!(
        (sliding.energy_account.dissipated() - lost).abs() < 1e-11
            && sliding.energy_account.max_imbalance() < 1e-11
    );
}

/// Friction alone brakes a sled: it stops after v²/(2f/m), up to the step in which it stops, and stays. The
/// energy account holds all of its energy.
#[test]
fn friction_brakes_to_rest() {
    let model = sled(2.0, [1.0, 0.0, 0.0], PassiveForces::default().with_friction(3.0), Limits::default());
    let h = 1e-3;
    let run = let_go(&model, &[0.0], &[1.2345], h, 3000);
    let way = 1.2345_f64.powi(2) / 2.0 / 1.5;
    assert_eq!(run.v[0], 0.0);
    assert!((run.q[0] - way).abs() < 1.5 * h * h, "{} {way}", run.q[0]);
    assert!(run.energy_account.max_imbalance() < 1e-12, "{:?}", run.energy_account);
}

/// A sled thrown at a limit stops there and loses its energy to the limit; before the limit it moves freely.
#[test]
fn limits_stop_motion() {
    let model = sled(2.0, [1.0, 0.0, 0.0], PassiveForces::default(), Limits::new(-0.3, 0.5));
    let run = let_go(&model, &[0.0], &[3.0], 1e-3, 1000);
    // In the step of its arrival it may stop short of the limit.
    assert!(run.q[0] <= 0.5 && run.q[0] > 0.5 - 3e-3 && run.v[0] == 0.0, "{:?} {:?}", run.q, run.v);
    assert!((run.energy_account.dissipated() - 9.0).abs() < 1e-12, "{:?}", run.energy_account);
    let free = SimulationBuilder::new(&model)
        .method(Method::Implicit)
        .without(Effect::Limits)
        .build()
        .unwrap()
        .run_steps_from(&[0.0], &[3.0], 1000, RunOptions::new())
        .unwrap();
    assert!((free.q[0] - 3.0).abs() < 1e-12);
}

/// A robot that starts beyond a joint limit returns slowly and gains no energy.
#[test]
fn start_beyond_limit_returns() {
    let model = sled(2.0, [1.0, 0.0, 0.0], PassiveForces::default(), Limits::new(-0.3, 0.5));
    let run = let_go(&model, &[0.6], &[0.0], 1e-3, 1000);
    assert!((run.q[0] - 0.5 - 0.1 * (-10.0_f64).exp()).abs() < 1e-9, "{:?}", run.q);
    assert!(run.energy_account.kinetic() < 1e-20);
}

/// Random trees with friction and limits are released for 5 s. No joint passes a limit, each loss never
/// decreases, and the energy grows by no more than the error of the scheme.
#[test]
fn trees_come_to_rest_within_their_limits() {
    for seed in 0..6 {
        let mut robot = damped_tree(seed).description().clone();
        for joint in &mut robot.joints {
            joint.passive = PassiveForces::default().with_damping(0.5).with_friction(0.3);
            if !matches!(joint.kind, JointKind::Spherical | JointKind::Floating | JointKind::Fixed) {
                joint.limits = Limits::new(-1.0, 1.0);
            }
        }
        let model = Model::new(robot).unwrap();
        let mut random = SplitMix64::new(seed);
        let state = random_state(&model, &mut random);
        let q = robot_dynamics::model::random_within_limits(&model, &mut random);
        let mut implicit = ImplicitIntegrator::new(&model);
        let mut workspace = StepWorkspace::new(&model);
        let tau = vec![0.0; model.nv()];
        let forces = StepForces::new(&tau, true);
        let (mut q, mut v) = (q, state.v.clone());
        let mut last = implicit.losses().unwrap();
        let mut energy_account =
            robot_dynamics::simulation::energy_account(&model, workspace.dynamics(), &q, &v);
        for _ in 0..5000 {
            let before = (q.clone(), v.clone());
            implicit.step(&model, &mut workspace, &forces, 1e-3, &mut q, &mut v).unwrap();
            let transition =
                StateTransition { from: (&before.0, &before.1), to: (&q, &v), forces: &forces, h: 1e-3 };
            implicit.record(&model, &mut workspace, &mut energy_account, transition);
            let losses = implicit.losses().unwrap();
            assert!(
                losses.damping >= last.damping
                    && losses.friction >= last.friction
                    && losses.stops >= last.stops
            );
            last = losses;
            for joint in model.joints().iter().filter(|joint| joint.nv == 1) {
                let x = q[joint.q_index];
                assert!((-1.0 - 1e-9..=1.0 + 1e-9).contains(&x), "robot {seed}, {}: {x}", joint.name);
            }
        }
        println!(
            "robot {seed}: {last:?}, imbalance {:.1e} of {:.1e} J",
            energy_account.max_imbalance(),
            energy_account.scale()
        );
        // Impacts reduce the order of the scheme; the imbalance stays below a thousandth at 1 ms.
        assert!(
            energy_account.max_imbalance() < 1e-3 * energy_account.scale(),
            "robot {seed}: {energy_account:?}"
        );
    }
}

/// The limit of a mimic joint holds its leader.
#[test]
fn limit_of_mimic_joint_holds_leader() {
    let mut robot = pendulum(2.0, 0.5);
    let hinge = JointKind::Revolute { axis: [0.0, 1.0, 0.0] };
    robot.links.push(LinkDescription::new("shin", robot.links[1].mass_properties));
    let at_tip = Pose::from_translation([0.5, 0.0, 0.0]);
    let knee = JointDescription::new("knee", hinge, "rod", "shin", at_tip);
    robot.joints.push(knee.with_limits(Limits::new(-0.5, 0.5)).with_mimic(Mimic::new("hinge", -2.0, 0.1)));
    let model = Model::new(robot).unwrap();
    // −2 q + 0.1 ≥ −0.5 holds q at 0.3; gravity moves it in that direction.
    let run = let_go(&model, &[0.0], &[0.0], 1e-3, 3000);
    assert!((run.q[0] - 0.3).abs() < 1e-12 && run.v[0] == 0.0, "{:?} {:?}", run.q, run.v);
}

/// Damping and friction without limits: the imbalance of the energy account decreases with the square of the
/// step, although joints stick and break away.
#[test]
fn energy_account_of_friction_closes_with_order_2() {
    for seed in 0..6 {
        let mut robot = damped_tree(seed).description().clone();
        for joint in &mut robot.joints {
            joint.passive = PassiveForces::default().with_damping(0.5).with_friction(0.3);
            joint.limits = Limits::default();
        }
        let model = Model::new(robot).unwrap();
        let state = random_state(&model, &mut SplitMix64::new(seed));
        let missed = |h: f64, steps: usize| {
            let_go(&model, &state.q, &state.v, h, steps).energy_account.max_imbalance()
        };
        let (coarse, fine) = (missed(1e-3, 2000), missed(5e-4, 4000));
        let order = (coarse / fine).log2();
        println!("robot {seed}: {fine:.1e} J, order {order:.2}");
        assert!(order > 1.8, "robot {seed}: {coarse:e}, {fine:e}");
    }
}

/// A joint without inertia has no acceleration, but damping determines its motion: it follows its spring.
#[test]
fn damping_moves_massless_joint() {
    let mut robot = pendulum(2.0, 0.5);
    robot.gravity = [0.0; 3];
    robot.links[1].mass_properties = None;
    robot.joints[0].passive = PassiveForces::default().with_damping(2.0).with_spring(10.0, 0.5);
    let model = Model::new(robot.clone()).unwrap();
    let run = let_go(&model, &[0.0], &[0.0], 1e-3, 400);
    // d q̇ = k (rest − q).
    let exact = 0.5 * (1.0 - (-0.4_f64 * 10.0 / 2.0).exp());
    assert!((run.q[0] - exact).abs() < 1e-3, "{} {exact}", run.q[0]);
    robot.joints[0].passive.damping = 0.0;
    robot.joints[0].passive.stiffness = 0.0;
    let model = Model::new(robot).unwrap();
    let mut simulation = SimulationBuilder::new(&model).method(Method::Implicit).dt(1e-3).build().unwrap();
    let failure = simulation.run_steps_from(&[0.0], &[0.0], 10, RunOptions::new()).unwrap_err();
    let RunError::SingularMass { source, .. } = &failure.error else { panic!("{failure}") };
    assert_eq!(source.joints(), ["hinge"]);
}

/// Servos, springs and dampers of tendons, and gravity compensation, all too stiff for explicit steps: no
/// motion grows, and the servo reaches its target. With soft ones the energy account closes with order 2.
#[test]
fn stiff_actuators_are_implicit() {
    for seed in 0..4 {
        let driven = |stiff: f64| {
            let mut robot = damped_tree(seed).description().clone();
            for joint in &mut robot.joints {
                joint.passive = PassiveForces::default().with_damping(0.2);
                joint.limits = Limits::default();
            }
            let model = Model::new(robot.clone()).unwrap();
            let singles: Vec<_> =
                model.joints().iter().filter(|joint| joint.nv == 1).map(|joint| joint.name.clone()).collect();
            let terms: Vec<_> = singles.iter().map(|name| (name.clone(), 0.5)).collect();
            let mut tendon = TendonDescription::new("cable", terms);
            tendon.passive = PassiveForces::default().with_spring(5.0 * stiff, 0.1).with_damping(0.5 * stiff);
            robot.tendons.push(tendon);
            for name in &singles {
                let to_joint = Transmission::joint(name.clone(), 1.0);
                robot
                    .actuators
                    .push(ActuatorDescription::new(name.clone(), to_joint).servo(10.0 * stiff, stiff));
            }
            for link in &mut robot.links {
                link.gravity_compensation = 0.5;
            }
            Model::new(robot).unwrap()
        };
        let run = |model: &Model, h: f64, steps: usize| {
            let state = random_state(model, &mut SplitMix64::new(seed));
            let mut simulation =
                SimulationBuilder::new(model).method(Method::Implicit).dt(h).build().unwrap();
            let controls = vec![0.2; simulation.control_names().count()];
            simulation.set_controls(&controls);
            simulation.run_steps_from(&state.q, &state.v, steps, RunOptions::new().sample_ends()).unwrap()
        };
        let soft = driven(1.0);
        let (coarse, fine) = (run(&soft, 1e-3, 500), run(&soft, 5e-4, 1000));
        let order = (coarse.energy_account.max_imbalance() / fine.energy_account.max_imbalance()).log2();
        println!("robot {seed}: {:.1e} J, order {order:.2}", fine.energy_account.max_imbalance());
        assert!(order > 1.8, "robot {seed}: order {order}");
        let stiff = driven(1e6);
        let run = run(&stiff, 1e-3, 1500);
        // At rest 10 (0.2 − x) = 0.5·5 (0.5 n x − 0.1) at each of the n joints. Their time constant is 0.1 s
        // or less, and weight and inertia are a millionth.
        let singles: Vec<_> = stiff.joints().iter().filter(|joint| joint.nv == 1).collect();
        let at_rest = 2.25 / (10.0 + 1.25 * singles.len() as f64);
        for joint in singles {
            let q = run.q[joint.q_index];
            assert!((q - at_rest).abs() < 1e-4, "robot {seed}, {}: {q} {at_rest}", joint.name);
        }
    }
}

/// Wheels on three axles with one cable over all of them, too stiff for explicit steps. Across the cable,
/// where it exerts no force, the wheels are free: n·I v = n·τ t for each n with c·n = 0, to rounding. Along
/// the cable they are held.
#[test]
fn stiff_cable_acts_along_itself_only() {
    let (inertia, c, tau) = ([0.1, 0.4, 0.02], [1.0, -2.0, 0.5], [0.3, 0.1, -0.2]);
    let mut robot = RobotDescription::new("wheels");
    robot.links.push(LinkDescription::new("frame", None));
    for (k, &moment) in inertia.iter().enumerate() {
        let wheel = MassProperties::new(1.0, Vector3::zeros(), Matrix3::identity() * moment).unwrap();
        robot.links.push(LinkDescription::new(format!("wheel {k}"), wheel));
        let axle = JointKind::Revolute { axis: [0.0, 0.0, 1.0] };
        let at = Pose::from_translation([k as f64, 0.0, 0.0]);
        robot.joints.push(JointDescription::new(
            format!("axle {k}"),
            axle,
            "frame",
            format!("wheel {k}"),
            at,
        ));
    }
    let terms: Vec<_> = c.iter().enumerate().map(|(k, &factor)| (format!("axle {k}"), factor)).collect();
    let mut cable = TendonDescription::new("cable", terms);
    cable.passive = PassiveForces::default().with_spring(1e8, 0.0).with_damping(1e5);
    robot.tendons.push(cable);
    let model = Model::new(robot).unwrap();
    let (h, steps) = (1e-3, 500);
    let run = SimulationBuilder::new(&model)
        .method(Method::Implicit)
        .dt(h)
        .build()
        .unwrap()
        .run_steps_from(
            &[0.0; 3],
            &[0.0; 3],
            steps,
            RunOptions::new().controller(&mut ConstantTorque(tau.to_vec())),
        )
        .unwrap();
    let t = h * steps as f64;
    for n in [[2.0, 1.0, 0.0], [0.0, 1.0, 4.0], [1.0, 0.0, -2.0]] {
        let along = |x: &dyn Fn(usize) -> f64| (0..3).map(|k| n[k] * x(k)).sum::<f64>();
        let (momentum, impulse) = (along(&|k| inertia[k] * run.v[k]), along(&|k| tau[k]) * t);
        // κ of M̂ is (γh)² k / 0.02, about 1e3, in each of 500 steps.
        assert!((momentum - impulse).abs() < 1e-10, "{n:?}: {momentum} {impulse}");
    }
    let length: f64 = (0..3).map(|k| c[k] * run.q[k]).sum();
    // A force of at most 2 N stretches the cable by 2e-8 m.
    assert!(length.abs() < 1e-7, "{length:e}");
}

/// Damping of 500 times the mass over a step, and friction, too stiff for an explicit step. The dissipated
/// energy equals the initial energy, to rounding.
#[test]
fn stiff_losses_are_accounted_to_rounding() {
    let passive = PassiveForces::default().with_damping(1e6).with_friction(3.0);
    let model = sled(2.0, [1.0, 0.0, 0.0], passive, Limits::default());
    let run = let_go(&model, &[0.0], &[3.0], 1e-3, 100);
    assert_eq!(run.v[0], 0.0);
    let losses = run.losses.unwrap();
    // M̂ is 500 times M: 10 κ ε of 9 J.
    assert!((losses.damping + losses.friction - 9.0).abs() < 1e-11, "{losses:?}");
}
