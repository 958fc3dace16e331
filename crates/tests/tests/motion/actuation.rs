//! Tendons, actuators, gravity compensation and equalities: forces against derivatives of energies, energy
//! accounts, and limits.

use nalgebra::Vector3;
use robot_dynamics::algorithms::{gravity, potential_energy};
use robot_dynamics::constraints::ConstraintSet;
use robot_dynamics::description::{
    Activation, ActuatorDescription, Base, Equality, EqualityDescription, JointDescription, JointKind,
    LinkDescription, MassProperties, Mimic, NamedPose, PassiveForces, PolynomialStiffnessDamping, Pose,
    PoseSpring, RandomRobotOptions, RobotDescription, TendonDescription, Transmission, pendulum,
    random_robot,
};
use robot_dynamics::model::{Model, Workspace, integrate, neutral, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{
    Actuation, Effect, Integrator, Method, Run, RunError, RunOptions, SimulationBuilder,
};

use crate::common::damped_tree;

/// A run of explicit steps of order 4 with actuators and springs, and with held controls.
fn driven_run(model: &Model, h: f64, (q, v): (&[f64], &[f64]), controls: &[f64], steps: usize) -> Run {
    let builder = SimulationBuilder::new(model).dt(h).method(Method::Fixed(Integrator::RungeKutta4));
    let mut simulation = builder.without(Effect::Contacts).build().unwrap();
    simulation.reset(q, v).unwrap();
    simulation.set_controls(controls);
    simulation.run_steps(steps, RunOptions::new().sample_ends()).unwrap()
}

/// The joints of a random robot with one degree of freedom.
fn single_joints(robot: &RobotDescription) -> Vec<String> {
    let model = Model::new(robot.clone()).unwrap();
    model.joints().iter().filter(|joint| joint.nv == 1).map(|joint| joint.name.clone()).collect()
}

/// Nonlinear springs on all spherical and floating joints.
fn spring_placements(
    robot: &mut RobotDescription,
    terms: PolynomialStiffnessDamping,
    random: &mut SplitMix64,
) {
    for joint in &mut robot.joints {
        if matches!(joint.kind, JointKind::Spherical | JointKind::Floating) {
            let mut three = || core::array::from_fn(|_| random.uniform(-1.0, 1.0));
            joint.spring = Some(PoseSpring { stiffness: 12.0, rest: Pose::from_xyz_rpy(three(), three()) });
            joint.higher_terms = terms;
        }
    }
}

/// A random robot with a tendon over all its single-coordinate joints, a servo on the tendon, half of each
/// link's weight compensated, and nonlinear springs.
fn driven(seed: u64) -> RobotDescription {
    let mut robot = random_robot(seed, &RandomRobotOptions::default());
    let mut random = SplitMix64::new(seed);
    let joints = single_joints(&robot);
    let terms: Vec<_> = joints.iter().map(|name| (name.clone(), random.uniform(-1.0, 1.0))).collect();
    let mut tendon = TendonDescription::new("cable", terms);
    tendon.offset = 0.3;
    tendon.passive = PassiveForces::default().with_spring(20.0, 0.1).with_damping(0.4);
    tendon.dead_band = 0.05;
    tendon.higher_terms.stiffness = [3.0, 2.0];
    robot.tendons.push(tendon);
    for joint in robot.joints.iter_mut().filter(|joint| joint.name == joints[0]) {
        joint.higher_terms.stiffness = [-1.0, 4.0];
    }
    spring_placements(
        &mut robot,
        PolynomialStiffnessDamping { stiffness: [2.0, 3.0], damping: [0.0; 2] },
        &mut random,
    );
    let over_cable = Transmission::Tendon { tendon: "cable".into(), gear: 2.0 };
    robot.actuators.push(ActuatorDescription::new("winch", over_cable).servo(30.0, 1.0));
    let on_joint = Transmission::joint(joints[0].clone(), 3.0);
    robot.actuators.push(ActuatorDescription::new("motor", on_joint));
    for link in &mut robot.links {
        link.gravity_compensation = 0.5;
    }
    robot
}

/// τ of springs and gravity compensation is minus the derivative of the stored energy, along every degree of
/// freedom.
#[test]
fn conservative_forces_are_derivatives_of_stored_energy() {
    for seed in 0..8 {
        let mut robot = driven(seed);
        robot.tendons[0].passive.damping = 0.0;
        let model = Model::new(robot).unwrap();
        let actuation = Actuation::new(&model).unwrap();
        let mut memory = actuation.workspace();
        let state = random_state(&model, &mut SplitMix64::new(seed));
        let mut tau = vec![0.0; model.nv()];
        actuation.passive_forces(&model, &mut memory, &state.q, &state.v, &mut tau);
        let largest = tau.iter().fold(1.0_f64, |most, tau| most.max(tau.abs()));
        for k in 0..model.nv() {
            let mut energy = |h: f64| {
                let (mut way, mut q) = (vec![0.0; model.nv()], state.q.clone());
                way[k] = h;
                integrate(&model, &state.q, &way, &mut q);
                actuation.stored_energy(&mut memory, &q)
            };
            let h = 1e-3;
            // Fourth-order central difference: h⁴ and ε/h are both below 1e-10 of the largest force.
            let slope = (8.0 * (energy(h) - energy(-h)) - (energy(2.0 * h) - energy(-2.0 * h))) / (12.0 * h);
            assert!((tau[k] + slope).abs() < 1e-8 * largest, "robot {seed}, freedom {k}: {} {slope}", tau[k]);
        }
    }
}

/// The bound on a tendon's total force scales the actuators' forces before their own bounds; the values are
/// MuJoCo's (4.0.0).
#[test]
fn bounds_of_a_tendon_act_before_those_of_its_actuators() {
    let mut robot = pendulum(2.0, 0.5);
    let mut tendon = TendonDescription::new("cable", [("hinge".to_owned(), 1.0)]);
    tendon.limits = tendon.limits.with_effort(1.0);
    robot.tendons.push(tendon);
    for name in ["strong", "weak"] {
        let on_cable = Transmission::Tendon { tendon: "cable".into(), gear: 1.0 };
        let mut motor = ActuatorDescription::new(name, on_cable);
        motor.force_range = [-1.0, 1.0];
        robot.actuators.push(motor);
    }
    let model = Model::new(robot).unwrap();
    let actuation = Actuation::new(&model).unwrap();
    let mut forces = [0.0; 2];
    actuation.actuator_forces(&model, &mut actuation.workspace(), &[10.0, 2.0], &[0.0], &[0.0], &mut forces);
    assert!((forces[0] - 5.0 / 6.0).abs() < 1e-15 && (forces[1] - 1.0 / 6.0).abs() < 1e-15, "{forces:?}");
}

/// An integrated control stops at the bound of its activation, and leaves it at once when the control turns.
#[test]
fn activations_stop_at_their_bounds() {
    let mut robot = pendulum(2.0, 0.5);
    let mut motor = ActuatorDescription::new("motor", Transmission::joint("hinge", 1.0));
    motor.activation = Activation::Integrator;
    motor.activation_range = [-0.2, 0.3];
    robot.actuators.push(motor);
    let actuation = Actuation::new(&Model::new(robot).unwrap()).unwrap();
    let mut activation = [0.0];
    for (control, h, expected) in [(1.0, 0.25, 0.25), (1.0, 0.25, 0.3), (-1.0, 0.25, 0.05), (-2.0, 1.0, -0.2)]
    {
        actuation.activate(&[control], h, &mut activation);
        assert!((activation[0] - expected).abs() < 1e-15, "{control}: {activation:?}");
    }
}

/// With all weight compensated the passive forces are g, and V plus the stored energy is constant.
#[test]
fn full_gravity_compensation_is_gravity_forces() {
    for seed in 0..6 {
        let mut robot = random_robot(seed, &RandomRobotOptions::default());
        for link in &mut robot.links {
            link.gravity_compensation = 1.0;
        }
        for joint in &mut robot.joints {
            joint.passive = PassiveForces::default();
        }
        let model = Model::new(robot).unwrap();
        let actuation = Actuation::new(&model).unwrap();
        let (mut memory, mut workspace) = (actuation.workspace(), Workspace::new(&model));
        let mut sums = Vec::new();
        for draw in 0..3 {
            let state = random_state(&model, &mut SplitMix64::new(draw));
            let (mut tau, mut g) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
            actuation.passive_forces(&model, &mut memory, &state.q, &state.v, &mut tau);
            gravity(&model, &mut workspace, &state.q, &mut g);
            for k in 0..model.nv() {
                // Both are the same sums over the same masses, and one factor is exactly 1.
                assert!((tau[k] - g[k]).abs() <= 1e-14 * g[k].abs().max(1.0), "robot {seed}");
            }
            sums.push(
                potential_energy(&model, &mut workspace, &state.q)
                    + actuation.stored_energy(&mut memory, &state.q),
            );
        }
        assert!(sums.iter().all(|sum| sum.abs() < 1e-11), "robot {seed}: {sums:?}");
    }
}

/// Servos, springs, dampers and gravity compensation act at every stage: the energy account closes to the
/// order of the method.
#[test]
fn energy_account_of_driven_runs_closes() {
    for seed in 0..4 {
        let mut robot = damped_tree(seed).description().clone();
        let joints = single_joints(&robot);
        let terms: Vec<_> = joints.iter().map(|name| (name.clone(), 0.4)).collect();
        let mut tendon = TendonDescription::new("cable", terms);
        tendon.passive = PassiveForces::default().with_spring(10.0, 0.0).with_damping(0.4);
        let terms = PolynomialStiffnessDamping { stiffness: [0.5, 1.0], damping: [0.2, 0.1] };
        tendon.higher_terms = terms;
        robot.tendons.push(tendon);
        for joint in robot.joints.iter_mut().filter(|joint| joint.name == joints[0]) {
            joint.higher_terms = terms;
        }
        spring_placements(&mut robot, terms, &mut SplitMix64::new(seed));
        let servo =
            ActuatorDescription::new("servo", Transmission::joint(joints[0].clone(), 1.0)).servo(8.0, 0.5);
        robot.actuators.push(servo);
        for link in &mut robot.links {
            link.gravity_compensation = 0.8;
        }
        let model = Model::new(robot).unwrap();
        let state = random_state(&model, &mut SplitMix64::new(seed));
        let run = |h: f64, steps: usize| driven_run(&model, h, (&state.q, &state.v), &[0.5], steps);
        let (coarse, fine) = (run(2e-3, 100), run(1e-3, 200));
        let (energy_account, largest) = (fine.energy_account, fine.energy_account.max_imbalance());
        let order = (coarse.energy_account.max_imbalance() / largest).log2();
        println!("robot {seed}: imbalance {largest:.1e} J, order {order:.2}");
        assert!(
            energy_account.work().abs() > 1e-3 && energy_account.dissipated() > 1e-3,
            "{energy_account:?}"
        );
        assert!(largest < 1e-10 || order > 3.5, "robot {seed}: {largest:e}, order {order}");
        assert!(
            largest < 1e-4 * energy_account.scale(),
            "robot {seed}: {largest:e} of {}",
            energy_account.scale()
        );
    }
}

/// A brick with one thruster at its centre hovers. With the thruster off centre it turns according to m and
/// I.
#[test]
fn thruster_carries_brick() {
    let mut robot = RobotDescription::new("brick");
    robot.base = Base::Floating;
    let brick = MassProperties::solid_box(1000.0, Vector3::new(0.3, 0.2, 0.1)).unwrap();
    robot.links.push(LinkDescription::new("brick", brick));
    let up = Transmission::Frame { frame: "brick".into(), gear: [0.0, 0.0, 1.0, 0.0, 0.1, 0.0] };
    robot.actuators.push(ActuatorDescription::new("thruster", up));
    let model = Model::new(robot.clone()).unwrap();
    let actuation = Actuation::new(&model).unwrap();
    let mut tau = [0.0; 6];
    let weight = 9.81 * brick.mass();
    actuation.forces(&model, &mut actuation.workspace(), &[weight], &neutral(&model), &[0.0; 6], &mut tau);
    assert!((tau[2] - weight).abs() < 1e-12 && (tau[4] - 0.1 * weight).abs() < 1e-12, "{tau:?}");
    let Transmission::Frame { gear, .. } = &mut robot.actuators[0].transmission else { unreachable!() };
    gear[4] = 0.0;
    let model = Model::new(robot).unwrap();
    let run = driven_run(&model, 1e-3, (&neutral(&model), &[0.0; 6]), &[weight], 1000);
    assert!(run.q[..3].iter().all(|x| x.abs() < 1e-12), "{:?}", run.q);
}

/// Ranges of controls, forces, joints and tendons each bound their quantity.
#[test]
fn ranges_bound_their_quantities() {
    let torque = |change: &dyn Fn(&mut RobotDescription)| {
        let mut robot = pendulum(2.0, 0.5);
        robot.tendons.push(TendonDescription::new("cable", [("hinge".to_owned(), 0.5)]));
        let over_cable = Transmission::Tendon { tendon: "cable".into(), gear: 1.0 };
        robot.actuators.push(ActuatorDescription::new("winch", over_cable));
        robot.actuators.push(ActuatorDescription::new("motor", Transmission::joint("hinge", 1.0)));
        change(&mut robot);
        let model = Model::new(robot).unwrap();
        let actuation = Actuation::new(&model).unwrap();
        let mut tau = [0.0];
        actuation.forces(&model, &mut actuation.workspace(), &[10.0, 4.0], &[0.3], &[0.0], &mut tau);
        tau[0]
    };
    assert_eq!(torque(&|_| {}), 0.5 * 10.0 + 4.0);
    assert_eq!(torque(&|robot| robot.actuators[0].control_range = [-6.0, 6.0]), 0.5 * 6.0 + 4.0);
    assert_eq!(torque(&|robot| robot.actuators[1].force_range = [-1.0, 1.0]), 0.5 * 10.0 + 1.0);
    assert_eq!(
        torque(&|robot| robot.tendons[0].limits = robot.tendons[0].limits.with_effort(2.0)),
        0.5 * 2.0 + 4.0
    );
    assert_eq!(torque(&|robot| robot.joints[0].actuator_force_range = [-3.0, 3.0]), 3.0);
}

/// A motor with a first-order lag reaches 1 − 1/e of its control after its time constant.
#[test]
fn activations_follow_first_order_lag() {
    let mut robot = pendulum(2.0, 0.5);
    let mut motor = ActuatorDescription::new("motor", Transmission::joint("hinge", 1.0));
    motor.activation = Activation::Filter { time_constant: 0.1 };
    robot.actuators.push(motor);
    let model = Model::new(robot).unwrap();
    for method in [Method::Fixed(Integrator::RungeKutta4), Method::Implicit, Method::Mujoco] {
        let mut simulation = SimulationBuilder::new(&model).method(method).build().unwrap();
        simulation.set_controls(&[2.0]);
        simulation.run_for(0.1).unwrap();
        let last = simulation.activations()[0];
        assert!((last - 2.0 * (1.0 - (-1.0_f64).exp())).abs() < 1e-12, "{method}: {last}");
    }
}

/// A control of NaN is an error that names the actuator. A variational method leaves the actuators out and
/// lists them.
#[test]
fn invalid_controls_are_errors() {
    let mut robot = pendulum(2.0, 0.5);
    robot.actuators.push(ActuatorDescription::new("motor", Transmission::joint("hinge", 1.0)));
    let model = Model::new(robot).unwrap();
    let mut simulation = SimulationBuilder::new(&model).build().unwrap();
    simulation.run_for(5e-3).unwrap();
    simulation.set_controls(&[f64::NAN]);
    let failure = simulation.step().unwrap_err();
    let RunError::StepInput { step: 5, source, .. } = &failure else { panic!("{failure}") };
    assert!(source.to_string().contains("`motor`"), "{source}");
    assert_eq!(simulation.steps(), 5);
    let variational = Integrator::ALL.into_iter().find(|row| !row.is_explicit()).unwrap();
    let simulation = SimulationBuilder::new(&model).method(Method::Fixed(variational)).build().unwrap();
    assert_eq!(simulation.left_out().len(), 1, "{:?}", simulation.left_out());
}

/// The pendulum with a second rod on a knee joint.
fn two_rods() -> RobotDescription {
    let mut robot = pendulum(2.0, 0.5);
    let hinge = JointKind::Revolute { axis: [0.0, 1.0, 0.0] };
    robot.links.push(LinkDescription::new("shin", robot.links[1].mass_properties));
    let at_tip = Pose::from_translation([0.5, 0.0, 0.0]);
    robot.joints.push(JointDescription::new("knee", hinge, "rod", "shin", at_tip));
    robot
}

/// The rows of a quartic relation are the derivatives of its φ, and its bias is their rate along v.
#[test]
fn rows_of_polynomial_are_its_derivatives() {
    let mut robot = two_rods();
    let relation = Equality::Joints {
        joint: ("knee".into(), 0.1),
        leader: Some(("hinge".into(), -0.2)),
        polynomial: [0.3, -0.7, 0.5, 0.2, -0.1],
    };
    robot.equalities.push(EqualityDescription::new("cam", relation));
    let model = Model::new(robot).unwrap();
    let set = ConstraintSet::from_equalities(&model).unwrap();
    assert_eq!(set.row_names(), ["cam.position"]);
    let mut workspace = Workspace::new(&model);
    let (q, v) = ([0.4, -0.3], [0.7, 1.1]);
    let rows = set.rows(&model, &mut workspace, &q, &v);
    let x: f64 = 0.4 + 0.2;
    let p = 0.3 - 0.7 * x + 0.5 * x * x + 0.2 * x.powi(3) - 0.1 * x.powi(4);
    let slope = -0.7 + x + 0.6 * x * x - 0.4 * x.powi(3);
    let curvature = 1.0 + 1.2 * x - 1.2 * x * x;
    assert!((rows.position_error[0] - (-0.3 - 0.1 - p)).abs() < 1e-15);
    assert!((rows.matrix[(0, 0)] + slope).abs() < 1e-15 && rows.matrix[(0, 1)] == 1.0);
    assert!((rows.bias[0] + curvature * 0.49).abs() < 1e-15, "{}", rows.bias[0]);
}

/// A linear relation as an equality and as a mimic joint gives the same motion.
#[test]
fn mimic_joint_moves_as_its_equality() {
    let mut robot = two_rods();
    let relation = Equality::Joints {
        joint: ("knee".into(), 0.0),
        leader: Some(("hinge".into(), 0.0)),
        polynomial: [0.2, -0.5, 0.0, 0.0, 0.0],
    };
    robot.equalities.push(EqualityDescription::new("gear", relation));
    let full = Model::new(robot.clone()).unwrap();
    let set = ConstraintSet::from_equalities(&full).unwrap();
    let (q, v) = ([0.4, 0.2 - 0.5 * 0.4], [1.5, -0.5 * 1.5]);
    let options = robot_dynamics::constraints::ConstraintOptions::default();
    let motion = robot_dynamics::constraints::constrained_forward_dynamics(
        &full,
        &mut Workspace::new(&full),
        &set,
        &options,
        &q,
        &v,
        &[0.3, 0.0],
    )
    .unwrap();
    assert_eq!(robot.couplings_to_followers(), ["knee"]);
    assert_eq!(robot.joints[1].mimic, Some(Mimic::new("hinge", -0.5, 0.2)));
    let reduced = Model::new(robot).unwrap();
    let a = reduced.forward_dynamics(&[0.4], &[1.5], &[0.3]).unwrap();
    assert!(
        (motion.acceleration[0] - a[0]).abs() < 1e-12 * a[0].abs(),
        "{} {}",
        motion.acceleration[0],
        a[0]
    );
}

/// Locking a joint keeps the length of a tendon, and the terms of that joint become constants.
#[test]
fn locked_joints_become_constants_of_tendons() {
    let mut robot = two_rods();
    robot
        .tendons
        .push(TendonDescription::new("cable", [("hinge".to_owned(), 2.0), ("knee".to_owned(), 1.0)]));
    let over_cable = Transmission::Tendon { tendon: "cable".into(), gear: 1.0 };
    robot.actuators.push(ActuatorDescription::new("servo", over_cable).servo(10.0, 0.0));
    let relation = Equality::Joints {
        joint: ("knee".into(), 0.0),
        leader: Some(("hinge".into(), 0.1)),
        polynomial: [0.0, 1.0, 2.0, 0.0, 0.0],
    };
    robot.equalities.push(EqualityDescription::new("cam", relation));
    robot
        .poses
        .push(NamedPose::new("bent", [("hinge".to_owned(), vec![0.3]), ("knee".to_owned(), vec![0.7])]));
    robot.lock_joint("hinge", &[0.3]).unwrap();
    let model = Model::new(robot).unwrap();
    let actuation = Actuation::new(&model).unwrap();
    let mut tau = [0.0];
    actuation.forces(&model, &mut actuation.workspace(), &[0.0], &[0.7], &[0.0], &mut tau);
    assert!((tau[0] + 10.0 * (2.0 * 0.3 + 0.7)).abs() < 1e-14);
    let set = ConstraintSet::from_equalities(&model).unwrap();
    let rows = set.rows(&model, &mut Workspace::new(&model), &[0.7], &[0.0]);
    assert!((rows.position_error[0] - (0.7 - (0.2 + 2.0 * 0.04))).abs() < 1e-15);
    assert_eq!(model.named_pose("bent"), Some((vec![0.7], vec![0.0])));
    assert_eq!(model.named_pose("straight"), None);
}

/// A buoy on a spring about its position, and one on a ball joint. Their springs are too stiff for explicit
/// steps. Implicit steps come to rest at the equilibrium of MuJoCo's equations, and the energy account of
/// soft springs closes with order 2.
#[test]
fn springs_of_free_and_ball_joints_reach_equilibrium() {
    let robot = |stiffness: f64, damping: f64| {
        let mut robot = RobotDescription::new("buoy");
        robot.links.push(LinkDescription::new("world", None));
        let body = MassProperties::solid_box(400.0, Vector3::new(0.2, 0.3, 0.1)).unwrap();
        for (name, kind, at) in
            [("buoy", JointKind::Floating, [0.0; 3]), ("lamp", JointKind::Spherical, [1.0, 0.0, 0.0])]
        {
            let properties = body.transformed(&nalgebra::Rotation3::identity(), &Vector3::new(0.0, 0.2, 0.0));
            robot.links.push(LinkDescription::new(name, properties));
            let mut joint = JointDescription::new(
                format!("{name}_joint"),
                kind,
                "world",
                name,
                Pose::from_translation(at),
            );
            let rest = Pose::from_xyz_rpy([0.1, 0.2, 0.3], [0.3, -0.2, 0.5]);
            joint.spring = Some(PoseSpring { stiffness, rest });
            joint.higher_terms = PolynomialStiffnessDamping { stiffness: [0.0, 2.0], damping: [0.3, 0.1] };
            joint.passive = PassiveForces::default().with_damping(damping);
            robot.joints.push(joint);
        }
        Model::new(robot).unwrap()
    };
    let run = |model: &Model, h: f64, steps: usize| {
        let v: Vec<f64> = (0..model.nv()).map(|k| 0.1 * (k as f64).cos()).collect();
        SimulationBuilder::new(model)
            .method(Method::Implicit)
            .dt(h)
            .build()
            .unwrap()
            .run_steps_from(&neutral(model), &v, steps, RunOptions::new().sample_ends())
            .unwrap()
    };
    let stiff = robot(1e6, 2e4);
    let end = run(&stiff, 1e-2, 1000);
    let (mut tau, mut g) = (vec![0.0; 9], vec![0.0; 9]);
    let actuation = Actuation::new(&stiff).unwrap();
    actuation.passive_forces(&stiff, &mut actuation.workspace(), &end.q, &[0.0; 9], &mut tau);
    gravity(&stiff, &mut Workspace::new(&stiff), &end.q, &mut g);
    assert!(end.v.iter().all(|v| v.abs() < 1e-9), "{:?}", end.v);
    assert!(tau.iter().zip(&g).all(|(tau, g)| (tau - g).abs() < 1e-4), "{tau:?} {g:?}");
    let mild = robot(40.0, 0.2);
    let (coarse, fine) = (run(&mild, 4e-4, 500), run(&mild, 2e-4, 1000));
    let scale = fine.energy_account.scale();
    let (coarse, fine) = (coarse.energy_account.max_imbalance(), fine.energy_account.max_imbalance());
    println!("imbalance {coarse:.1e} J, {fine:.1e} J of {scale:.1e} J");
    assert!(fine < 1e-3 * scale && coarse / fine > 3.5, "{coarse:e} {fine:e}");
}
