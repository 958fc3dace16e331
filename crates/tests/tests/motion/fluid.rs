//! The forces of a fluid: against the formulas on dense Jacobians, derivatives against differences, the power
//! of drag, and motions with both methods. `crates/mjcf/tests/files/fluid.rs` compares them with MuJoCo.

use std::f64::consts::PI;

use nalgebra::{DVector, Matrix3, Vector3};
use robot_dynamics::algorithms::{ReferenceFrame, frame_jacobian, frame_pose};
use robot_dynamics::description::{
    FluidEllipsoid, FluidForm, FluidShape, FrameDescription, MassProperties, Medium, Mimic, Mount, Pose,
    RandomRobotOptions, RobotDescription, Scene, pendulum, random_robot,
};
use robot_dynamics::model::{Model, RandomState, Workspace, integrate, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{Actuation, FluidForces, Method, RunOptions, SimulationBuilder};

const MEDIUM: Medium = Medium { density: 3.0, viscosity: 0.2, wind: [0.7, -0.4, 0.3] };

/// A random robot in a fluid, with an ellipsoid on every second link and inertia boxes on the others. The
/// links fixed to others have shapes of their own.
fn robot(seed: u64, medium: Medium) -> RobotDescription {
    let mut robot = random_robot(seed, &RandomRobotOptions { joints: 8, ..Default::default() });
    let mut random = SplitMix64::new(seed);
    for index in (0..robot.links.len()).step_by(2) {
        let turn = [0, 1, 2].map(|_| random.uniform(-1.0, 1.0));
        let place = Pose::from_xyz_rpy([0, 1, 2].map(|_| random.uniform(-0.2, 0.2)), turn);
        let half_axes = [0, 1, 2].map(|_| random.uniform(0.05, 0.3));
        let ellipsoid = FluidEllipsoid::new(half_axes).with_coefficients([0.6, 0.2, 1.3, 0.9, 1.1]);
        let link = robot.links[index].name.clone();
        robot.fluid_shapes.push(FluidShape {
            link,
            link_from_shape: place,
            form: FluidForm::Ellipsoid(ellipsoid),
        });
    }
    robot.immerse(medium);
    robot
}

/// Force and moment by the formulas of MuJoCo's documentation, at the shape's centre along its axes.
fn by_formulas(form: &FluidForm, medium: &Medium, v: Vector3<f64>, w: Vector3<f64>) -> [Vector3<f64>; 2] {
    let (rho, beta) = (medium.density, medium.viscosity);
    match form {
        FluidForm::InertiaBox { size } => {
            let r = size.map(|edge| 0.5 * edge);
            let mean = (r[0] + r[1] + r[2]) / 3.0;
            let drag = |i: usize| {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                (2.0 * rho * r[j] * r[k] * v[i].abs() + 6.0 * beta * PI * mean) * -v[i]
            };
            let turn = |i: usize| {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                let quadratic = 0.5 * rho * r[i] * (r[j].powi(4) + r[k].powi(4)) * w[i].abs();
                (quadratic + 8.0 * beta * PI * mean.powi(3)) * -w[i]
            };
            [Vector3::new(drag(0), drag(1), drag(2)), Vector3::new(turn(0), turn(1), turn(2))]
        }
        FluidForm::Ellipsoid(own) => {
            let r = own.half_axes;
            let mut sorted = r;
            sorted.sort_by(f64::total_cmp);
            let [_, middle, longest] = sorted;
            let (volume, mean) = (4.0 / 3.0 * PI * r[0] * r[1] * r[2], (r[0] + r[1] + r[2]) / 3.0);
            let momentum = rho * Vector3::from(own.added_mass).component_mul(&v);
            let angular = rho * Vector3::from(own.added_inertia).component_mul(&w);
            // The lemma of the projected area, for the unit vector along v.
            let u = v.normalize();
            let [ab, bc, ca] = [r[0] * r[1], r[1] * r[2], r[2] * r[0]];
            let over = bc.powi(4) * u.x * u.x + ca.powi(4) * u.y * u.y + ab.powi(4) * u.z * u.z;
            let under = bc.powi(2) * u.x * u.x + ca.powi(2) * u.y * u.y + ab.powi(2) * u.z * u.z;
            let area = PI * (over / under).sqrt();
            let normal = Vector3::new(bc / r[0] * v.x, ca / r[1] * v.y, ab / r[2] * v.z).normalize();
            let kutta = own.kutta_lift * rho * area * u.dot(&normal) * normal.cross(&v).cross(&v);
            let magnus = own.magnus_lift * rho * volume * w.cross(&v);
            let drag_area = own.blunt_drag * area + own.slender_drag * (PI * longest * middle - area);
            let drag = (rho * drag_area * v.norm() + 6.0 * PI * mean * beta) * v;
            let moment = |i: usize| 8.0 * PI / 15.0 * r[i] * r[(i + 1) % 3].max(r[(i + 2) % 3]).powi(4);
            let moments = Vector3::new(moment(0), moment(1), moment(2));
            let most = 8.0 * PI / 15.0 * middle * longest.powi(4);
            let turning = own.angular_drag * moments + own.slender_drag * moments.map(|own| most - own);
            let turn = (rho * turning.component_mul(&w).norm() + 8.0 * PI * mean.powi(3) * beta) * w;
            [momentum.cross(&w) + magnus + kutta - drag, momentum.cross(&v) + angular.cross(&w) - turn]
        }
    }
}

#[test]
fn forces_are_those_of_the_formulas_on_dense_jacobians() {
    for seed in 0..40 {
        let mut described = robot(seed, MEDIUM);
        let shapes = described.fluid_shapes.clone();
        for (number, shape) in shapes.iter().enumerate() {
            let name = format!("shape {number}");
            described.frames.push(FrameDescription::new(name, &shape.link, shape.link_from_shape));
        }
        let model = Model::new(described).expect("a robot");
        let (nv, workspace) = (model.nv(), &mut Workspace::new(&model));
        let RandomState { q, v, .. } = random_state(&model, &mut SplitMix64::new(seed));
        let mut expected = DVector::zeros(nv);
        for (number, shape) in shapes.iter().enumerate() {
            let frame = model.frame(&format!("shape {number}")).expect("a frame");
            let mut jacobian = vec![0.0; 6 * nv];
            frame_jacobian(&model, workspace, &q, frame, ReferenceFrame::LocalWorldAligned, &mut jacobian);
            let jacobian = nalgebra::DMatrix::from_row_slice(6, nv, &jacobian);
            let velocity = &jacobian * DVector::from_column_slice(&v);
            let pose = frame_pose(&model, workspace, &q, frame);
            let turn = Matrix3::from_fn(|i, j| pose.rotation[i][j]);
            let linear = velocity.fixed_rows::<3>(0) - Vector3::from(MEDIUM.wind);
            let angular = velocity.fixed_rows::<3>(3).into_owned();
            let [force, moment] =
                by_formulas(&shape.form, &MEDIUM, turn.transpose() * linear, turn.transpose() * angular);
            let mut wrench = DVector::zeros(6);
            wrench.fixed_rows_mut::<3>(0).copy_from(&(turn * force));
            wrench.fixed_rows_mut::<3>(3).copy_from(&(turn * moment));
            expected += jacobian.transpose() * wrench;
        }
        let fluid = FluidForces::new(&model);
        let mut tau = vec![0.0; nv];
        fluid.forces(&model, &mut fluid.workspace(&model), &q, &v, &mut tau);
        let scale = expected.amax().max(1.0);
        for k in 0..nv {
            assert!((tau[k] - expected[k]).abs() < 1e-11 * scale, "seed {seed}: {k}: {tau:?} {expected}");
        }
    }
}

/// Central differences with steps of 1e-6 have a rounding error of 1e-9, and one of 1e-7 at the kink of
/// |x| x.
#[test]
fn derivatives_agree_with_differences() {
    for seed in 0..40 {
        let mut described = robot(seed, MEDIUM);
        // A mimic joint in some robots.
        let single = |joint: &robot_dynamics::description::JointDescription| joint.kind.nv() == 1;
        let singles: Vec<usize> =
            (0..described.joints.len()).filter(|&k| single(&described.joints[k])).collect();
        if let (true, [leader, .., follower]) = (seed % 3 == 0, &singles[..]) {
            let name = described.joints[*leader].name.clone();
            let joint = described.joints[*follower].clone();
            described.joints[*follower] = joint.with_mimic(Mimic::new(name, -1.5, 0.2));
        }
        let model = Model::new(described).expect("a robot");
        let nv = model.nv();
        let fluid = FluidForces::new(&model);
        let memory = &mut fluid.workspace(&model);
        let RandomState { q, v, .. } = random_state(&model, &mut SplitMix64::new(seed));
        let (mut by_q, mut by_v) = (vec![0.0; nv * nv], vec![0.0; nv * nv]);
        fluid.derivatives(&model, memory, &q, &v, &mut by_q, &mut by_v);
        let scale = by_q.iter().chain(&by_v).fold(1.0_f64, |most, x| most.max(x.abs()));
        let h = 1e-6;
        for k in 0..nv {
            let ends = [h, -h].map(|h| {
                let (mut way, mut moved, mut faster) = (vec![0.0; nv], q.clone(), v.clone());
                way[k] = h;
                integrate(&model, &q, &way, &mut moved);
                faster[k] += h;
                let (mut at_q, mut at_v) = (vec![0.0; nv], vec![0.0; nv]);
                fluid.forces(&model, memory, &moved, &v, &mut at_q);
                fluid.forces(&model, memory, &q, &faster, &mut at_v);
                (at_q, at_v)
            });
            for m in 0..nv {
                let slope = |a: f64, b: f64| (a - b) / (2.0 * h);
                let expected = [slope(ends[0].0[m], ends[1].0[m]), slope(ends[0].1[m], ends[1].1[m])];
                let found = [by_q[m * nv + k], by_v[m * nv + k]];
                for (what, (found, expected)) in ["q", "v"].iter().zip(found.iter().zip(expected)) {
                    assert!(
                        (found - expected).abs() < 1e-7 * scale,
                        "seed {seed}: ∂τ{m}/∂{what}{k}: {found} {expected}"
                    );
                }
            }
        }
    }
}

/// In a fluid at rest, lift and added mass do no work, and drag takes energy.
#[test]
fn power_into_a_fluid_at_rest_is_positive() {
    for seed in 0..40 {
        let model = Model::new(robot(seed, Medium { wind: [0.0; 3], ..MEDIUM })).expect("a robot");
        let RandomState { q, v, .. } = random_state(&model, &mut SplitMix64::new(seed));
        let actuation = Actuation::new(&model).expect("a robot").without_actuators().without_springs();
        let power = actuation.dissipated_power(&model, &mut actuation.workspace(), &q, &v);
        assert!(power > 0.0, "seed {seed}: {power}");
    }
}

/// A ball in a viscous fluid without gravity: v = v₀ e^(−6πβr t/m), by both methods.
#[test]
fn a_ball_slows_down_by_stokes_law() {
    let (radius, mass, beta) = (0.1, 0.5, 0.3);
    let mut robot = RobotDescription::new("ball");
    robot.gravity = [0.0; 3];
    robot.base = robot_dynamics::description::Base::Floating;
    let body = MassProperties::solid_sphere(mass / (4.0 / 3.0 * PI * radius * radius * radius), radius);
    let body = body.expect("a ball");
    robot.links.push(robot_dynamics::description::LinkDescription::new("ball", body));
    let form = FluidForm::Ellipsoid(FluidEllipsoid::new([radius; 3]));
    robot.fluid_shapes.push(FluidShape { link: "ball".into(), link_from_shape: Pose::IDENTITY, form });
    robot.medium = Medium::still(0.0, beta);
    let model = Model::new(robot).expect("a robot");
    let expected = 2.0 * (-6.0 * PI * beta * radius / mass * 1.0_f64).exp();
    for (method, tolerance) in [
        (Method::Implicit, 1e-6),
        (Method::Fixed(robot_dynamics::simulation::Integrator::RungeKutta4), 1e-12),
    ] {
        let mut simulation =
            SimulationBuilder::new(&model).dt(1e-3).method(method).build().expect("a simulation");
        simulation
            .reset(&[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], &[2.0, 0.0, 0.0, 0.0, 0.0, 0.0])
            .expect("a state");
        let run = simulation.run(1.0, RunOptions::new()).expect("a run");
        assert!((run.v[0] - expected).abs() < tolerance, "{method:?}: {} {expected}", run.v[0]);
        let balance = run.energy_account.relative_imbalance();
        assert!(balance.abs() < 1e-5, "{method:?}: {balance}");
    }
}

/// Honey of a hundred thousand Pa·s stops a robot in microseconds; implicit steps of a millisecond remain
/// stable and end at rest.
#[test]
fn implicit_steps_are_stable_in_a_thick_fluid() {
    for seed in 0..6 {
        let medium = if seed % 2 == 0 { Medium::still(0.0, 1e5) } else { Medium::still(1e3, 1e5) };
        let mut described = robot(seed, medium);
        described.gravity = [0.0; 3];
        let model = Model::new(described).expect("a robot");
        let RandomState { q, v, .. } = random_state(&model, &mut SplitMix64::new(seed));
        let mut simulation =
            SimulationBuilder::new(&model).dt(1e-3).method(Method::Implicit).build().expect("a simulation");
        simulation.reset(&q, &v).expect("a state");
        let run =
            simulation.run(0.05, RunOptions::new()).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        let speed = run.v.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let balance = run.energy_account.relative_imbalance().abs();
        assert!(speed < 1e-3 && balance < 1e-2, "seed {seed}: {speed} {balance}");
        // The default method is the one that remains stable.
        let chosen = SimulationBuilder::new(&model).build().expect("a simulation").method();
        assert_eq!(chosen, Method::Implicit);
    }
}

/// Locked joints keep the shapes, scenes rename their links, and the default method includes them.
#[test]
fn edits_and_scenes_keep_the_fluid() {
    let mut arm = pendulum(2.0, 0.5);
    arm.immerse(Medium::still(1000.0, 1e-3));
    let mut scene = Scene::new("two");
    for prefix in ["left_", "right_"] {
        scene.add(&arm, &Mount::at(Pose::IDENTITY).with_prefix(prefix)).expect("an arm");
    }
    let both = scene.into_description();
    let links: Vec<&str> = both.fluid_shapes.iter().map(|shape| shape.link.as_str()).collect();
    assert_eq!((links, both.medium), (vec!["left_rod", "right_rod"], arm.medium));
    let tau = |robot: RobotDescription, q: &[f64], v: &[f64]| {
        let model = Model::new(robot).expect("a robot");
        let fluid = FluidForces::new(&model);
        let mut tau = vec![0.0; v.len()];
        fluid.forces(&model, &mut fluid.workspace(&model), q, v, &mut tau);
        tau
    };
    let one = tau(arm.clone(), &[0.4], &[3.0])[0];
    assert_eq!(tau(both.clone(), &[0.4, 0.1], &[3.0, 0.0]), [one, 0.0]);
    let mut locked = both;
    locked.lock_joint("right_hinge", &[0.1]).expect("a lock");
    assert_eq!(tau(locked, &[0.4], &[3.0]), [one]);
    let model = Model::new(arm).expect("a robot");
    let simulation = SimulationBuilder::new(&model).build().expect("a simulation");
    assert_eq!(simulation.acting(), [robot_dynamics::simulation::Effect::Dissipation]);
}

/// Implicit steps converge to the motion by RK4 with the square of the step, with lift, added mass and wind.
#[test]
fn implicit_steps_are_of_order_two() {
    let mut described = robot(1, MEDIUM);
    for joint in &mut described.joints {
        joint.passive.friction = 0.0;
    }
    let model = Model::new(described).expect("a robot");
    let RandomState { q, v, .. } = random_state(&model, &mut SplitMix64::new(1));
    let end = |method: Method, dt: f64| {
        let builder = SimulationBuilder::new(&model).without(robot_dynamics::simulation::Effect::Limits);
        let mut simulation = builder.dt(dt).method(method).build().expect("a simulation");
        simulation.reset(&q, &v).expect("a state");
        simulation.run(0.1, RunOptions::new()).expect("a run").v
    };
    let reference = end(Method::Fixed(robot_dynamics::simulation::Integrator::RungeKutta4), 1e-4);
    let error = |dt: f64| {
        let v = end(Method::Implicit, dt);
        v.iter().zip(&reference).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let (coarse, fine) = (error(1e-3), error(5e-4));
    let order = (coarse / fine).log2();
    assert!((1.7..2.4).contains(&order), "{coarse:e} {fine:e}: order {order}");
}
