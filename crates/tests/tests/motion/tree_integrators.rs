//! Every fixed-step integrator on trees, floating bases and ball joints.

use dynamics::{FixedSize, Reach2R, SystemStep};
use nalgebra::{DMatrix, Matrix3, SVector, UnitQuaternion, Vector3};
use robot_dynamics::algorithms::{kinetic_energy, mass_matrix, potential_energy};
use robot_dynamics::derivatives::{LinearizeStepWorkspace, LinearizedStep, RobotState, linearize_step};
use robot_dynamics::description::{
    Base, JointDescription, JointKind, JointKinds, LinkDescription, MassProperties, PassiveForces, Pose,
    RandomRobotOptions, RobotDescription, random_robot,
};
use robot_dynamics::model::{Model, Workspace, difference, integrate, neutral, random_state};
use robot_dynamics::number::{Dual, SplitMix64};
use robot_dynamics::simulation::{
    Integrator, IntegratorError, StepForces, StepStagesWorkspace, StepWorkspace, Symplectic, step,
    step_stages,
};

const VARIATIONAL: [Integrator; 2] = [Integrator::VariationalMidpoint, Integrator::VariationalYoshida4];

struct State {
    q: Vec<f64>,
    v: Vec<f64>,
}

/// A floating link with a ball joint, a hinge, a screw and a slide: small enough to measure orders.
fn creature(passive: PassiveForces) -> Model {
    let mut robot = RobotDescription::new("creature");
    robot.base = Base::Floating;
    let link = |name: &str, x: f64| {
        let inertia = Matrix3::new(0.05, 0.01, 0.0, 0.01, 0.08, -0.01, 0.0, -0.01, 0.06);
        let center = Vector3::new(x, 0.1, -0.05);
        let properties = MassProperties::new(1.0 + x, center, inertia).unwrap();
        LinkDescription::new(name, properties)
    };
    robot.links.extend([
        link("body", 0.2),
        link("head", 0.3),
        link("arm", 0.1),
        link("drill", 0.2),
        link("tail", 0.1),
    ]);
    let joints = [
        ("neck", JointKind::Spherical, "body", "head", [0.4, 0.0, 0.1]),
        ("elbow", JointKind::Revolute { axis: [0.0, 1.0, 0.3] }, "head", "arm", [0.2, 0.1, 0.0]),
        ("screw", JointKind::Helical { axis: [1.0, 0.0, 0.0], pitch: 0.1 }, "body", "drill", [0.0, 0.3, 0.0]),
        ("slide", JointKind::Prismatic { axis: [0.0, 0.6, 0.8] }, "arm", "tail", [0.1, 0.0, 0.0]),
    ];
    for (name, kind, parent, child, at) in joints {
        let joint =
            JointDescription::new(name, kind, parent, child, Pose::from_xyz_rpy(at, [0.1, -0.2, 0.3]));
        let stiffness = if kind == JointKind::Spherical { 0.0 } else { passive.stiffness };
        robot.joints.push(joint.with_passive(passive.with_spring(stiffness, passive.rest)));
    }
    Model::new(robot).unwrap()
}

/// Three links on hinges with a fixed base.
fn arm() -> Model {
    let options = RandomRobotOptions {
        joints: 3,
        kinds: JointKinds::Turning,
        chain: 1.0,
        fixed: 0.0,
        massless: 0.0,
        passive: 0.0,
        mass_ratio: 2.0,
        ..Default::default()
    };
    Model::new(random_robot(4, &options)).unwrap()
}

/// The same robot without gravity.
fn without_gravity(model: &Model) -> Model {
    let mut robot = model.description().clone();
    robot.gravity = [0.0; 3];
    Model::new(robot).unwrap()
}

fn start(model: &Model, seed: u64) -> State {
    let state = random_state(model, &mut SplitMix64::new(seed));
    State { q: state.q, v: state.v }
}

fn advance(
    model: &Model,
    state: &State,
    forces: &StepForces<'_>,
    h: f64,
    steps: usize,
    row: Integrator,
) -> State {
    let mut workspace = StepWorkspace::new(model);
    let (mut q, mut v) = (state.q.clone(), state.v.clone());
    for done in 0..steps {
        step(model, row, &mut workspace, forces, h, &mut q, &mut v)
            .unwrap_or_else(|error| panic!("{row} on {}, step {done} of {h} s: {error}", model.name()));
    }
    State { q, v }
}

/// The largest entry of q₁ ⊖ q₀ and v₁ − v₀.
fn distance(model: &Model, a: &State, b: &State) -> f64 {
    let mut d = vec![0.0; model.nv()];
    difference(model, &a.q, &b.q, &mut d);
    let v = a.v.iter().zip(&b.v).map(|(a, b)| a - b);
    d.iter().copied().chain(v).map(f64::abs).fold(0.0, f64::max)
}

fn energy(model: &Model, state: &State) -> f64 {
    let mut workspace = Workspace::new(model);
    kinetic_energy(model, &mut workspace, &state.q, &state.v)
        + potential_energy(model, &mut workspace, &state.q)
}

/// Halving the step divides the error at a fixed time by 2^order, with motors, damping, springs and armature.
/// The robots are a fixed arm and a creature with a floating base and a ball joint. The measured exponent is
/// within 0.15 of the order: at these steps the next term of the error expansion has that size.
#[test]
fn every_method_has_its_order() {
    let passive = PassiveForces::default()
        .with_armature(0.02)
        .with_damping(0.3)
        .with_friction(0.0)
        .with_spring(2.0, 0.1);
    for (model, seed) in [(arm(), 1), (creature(passive), 2), (creature(PassiveForces::default()), 3)] {
        let initial = start(&model, seed);
        let tau: Vec<f64> = (0..model.nv()).map(|k| 0.4 - 0.15 * k as f64).collect();
        let forces = StepForces::new(&tau, true);
        let time = 0.25;
        // Two methods that share only the robot agree on the reference.
        let reference = advance(&model, &initial, &forces, time / 2048.0, 2048, Integrator::RungeKutta4);
        let other = advance(&model, &initial, &forces, time / 2048.0, 2048, Integrator::VariationalYoshida4);
        let disagreement = distance(&model, &reference, &other);
        assert!(disagreement < 1e-10, "{}: references differ by {disagreement:e}", model.name());
        for row in Integrator::ALL {
            let coarse = match row.order() {
                1 => 512,
                2 => 64,
                _ => 32,
            };
            let error = |steps: usize| {
                let end = advance(&model, &initial, &forces, time / steps as f64, steps, row);
                distance(&model, &end, &reference)
            };
            let measured = (error(coarse) / error(2 * coarse)).log2();
            println!("{row:22} on {:10} order {measured:.3}", model.name());
            let order = f64::from(row.order());
            assert!((measured - order).abs() < 0.15, "{row} on {}: order {measured}", model.name());
        }
    }
}

/// On plain coordinates each method takes the step of the crate `dynamics`: the same arithmetic in another
/// order. Tolerance: 1e-12 of entries up to 10.
#[test]
fn plain_coordinates_match_chapter() {
    let options = RandomRobotOptions {
        joints: 4,
        kinds: JointKinds::VectorSpace,
        massless: 0.0,
        chain: 0.8,
        ..Default::default()
    };
    let mut compared = 0;
    for seed in 0..60 {
        let mut robot = random_robot(seed, &options);
        robot.joints.iter_mut().for_each(|joint| joint.passive.friction = 0.0);
        let model = Model::new(robot.clone()).unwrap();
        if model.nv() != 5 {
            continue;
        }
        compared += 1;
        let closed: FixedSize<5> = FixedSize::new(Model::new(robot).unwrap()).unwrap();
        let state = random_state(&model, &mut SplitMix64::new(seed));
        let (q, v, tau) = (&state.q, &state.v, &state.tau);
        let vector = |x: &[f64]| SVector::<f64, 5>::from_column_slice(x);
        for row in Integrator::ALL {
            let expected = row.step(&closed, &vector(q), &vector(v), &vector(tau), 1e-3).unwrap();
            let forces = StepForces::new(tau, true);
            let end = advance(&model, &State { q: q.clone(), v: v.clone() }, &forces, 1e-3, 1, row);
            let defect = (vector(&end.q) - expected.0).amax().max((vector(&end.v) - expected.1).amax());
            assert!(defect < 1e-12, "{row}, robot {seed}: {defect:e}");
        }
    }
    assert!(compared >= 5, "only {compared} robots have 5 degrees of freedom");
}

/// The two-link arm from its description against its closed form, 1000 steps of every method.
///
/// The difference of one rounding grows with the sensitivity of the motion, a factor of about 10 in this
/// second.
#[test]
fn described_2r_arm_matches_closed_form() {
    let (model, arm) = (described_2r(), Reach2R::worked_example());
    let forces = StepForces::new(&[3.0, -1.0], false);
    for row in Integrator::ALL {
        let mut workspace = StepWorkspace::new(&model);
        let (mut q, mut v) = ([0.6, 1.1], [0.3, -0.2]);
        let (mut q_closed, mut v_closed) = (SVector::from(q), SVector::from(v));
        for i in 0..1000 {
            step(&model, row, &mut workspace, &forces, 1e-3, &mut q, &mut v).unwrap();
            (q_closed, v_closed) =
                row.step(&arm, &q_closed, &v_closed, &SVector::from([3.0, -1.0]), 1e-3).unwrap();
            let defect = (SVector::from(q) - q_closed).amax().max((SVector::from(v) - v_closed).amax());
            // One step agrees to 1e-14; each further step adds at most that.
            assert!(defect < 1e-14 * f64::from(i + 1) + 1e-14, "{row}, step {i}: {defect:e}");
        }
    }
}

/// The rods of the worked example, turning about −y in the x–z plane.
fn described_2r() -> Model {
    let mut robot = RobotDescription::new("2R");
    robot.links.push(LinkDescription::new("base", None));
    for (name, mass) in [("upper", 2.0), ("fore", 1.0)] {
        let moment = mass / 12.0;
        let inertia = Matrix3::from_diagonal(&Vector3::new(0.0, moment, moment));
        let rod = MassProperties::new(mass, Vector3::new(0.5, 0.0, 0.0), inertia).unwrap();
        robot.links.push(LinkDescription::new(name, rod));
    }
    let hinge = JointKind::Revolute { axis: [0.0, -1.0, 0.0] };
    let elbow = Pose::from_translation([1.0, 0.0, 0.0]);
    robot.joints.push(JointDescription::new("shoulder", hinge, "base", "upper", Pose::IDENTITY));
    robot.joints.push(JointDescription::new("elbow", hinge, "upper", "fore", elbow));
    Model::new(robot).unwrap()
}

/// Step, flip, step, flip returns to the start for the methods that the table lists as reversible, and only
/// for them.
///
/// Each direction is solved to a few roundings of terms of size 10: 1e-13 over one step of each.
#[test]
fn reversible_methods_return_to_start() {
    let model = creature(PassiveForces::default().with_armature(0.1).with_spring(2.0, 0.0));
    let tau = vec![0.3; model.nv()];
    let forces = StepForces::new(&tau, false);
    for seed in 0..10 {
        let initial = start(&model, seed);
        for row in Integrator::ALL {
            let mut there = advance(&model, &initial, &forces, 0.02, 1, row);
            there.v.iter_mut().for_each(|v| *v = -*v);
            let mut back = advance(&model, &there, &forces, 0.02, 1, row);
            back.v.iter_mut().for_each(|v| *v = -*v);
            let defect = distance(&model, &initial, &back);
            if row.reversible() {
                assert!(defect < 1e-13, "{row}, seed {seed}: {defect:e}");
            } else {
                assert!(defect > 1e-9, "{row}, seed {seed}: {defect:e}");
            }
        }
    }
}

/// The symplectic methods preserve the canonical form of T*Q on a floating creature with a ball joint; the
/// others do not.
///
/// In body coordinates the form on tangents (η, δp) is δp·η′ − δp′·η − p·\[η,η′\]. The Jacobian of the map is
/// computed by five-point differences of step 1e-3. Their error is 1e-12 times fifth derivatives, of fourth
/// order, and their rounding 1e-13/1e-3 = 1e-10 times entries up to 10.
#[test]
fn symplectic_methods_preserve_canonical_form() {
    let model = creature(PassiveForces::default().with_spring(2.0, 0.0));
    let nv = model.nv();
    let initial = start(&model, 6);
    let tau = vec![0.0; nv];
    let forces = StepForces::new(&tau, false);
    let mass_at = |q: &[f64]| {
        let mut mass = vec![0.0; nv * nv];
        mass_matrix(&model, &mut Workspace::new(&model), q, &mut mass);
        DMatrix::from_row_slice(nv, nv, &mass)
    };
    let momentum = |s: &State| mass_at(&s.q) * nalgebra::DVector::from_column_slice(&s.v);
    let p0 = momentum(&initial);
    // The state at displacement (η, δp) from the initial one.
    let at = |k: usize, x: f64| {
        let (mut delta, mut p) = (vec![0.0; nv], p0.clone());
        if k < nv {
            delta[k] = x;
        } else {
            p[k - nv] += x;
        }
        let mut q = vec![0.0; model.nq()];
        integrate(&model, &initial.q, &delta, &mut q);
        let v = mass_at(&q).cholesky().unwrap().solve(&p);
        State { q, v: v.as_slice().to_vec() }
    };
    for row in Integrator::ALL {
        let h = 0.05;
        let end = advance(&model, &initial, &forces, h, 1, row);
        let p1 = momentum(&end);
        let mut jacobian = DMatrix::zeros(2 * nv, 2 * nv);
        for k in 0..2 * nv {
            let image = |x: f64| {
                let moved = advance(&model, &at(k, x), &forces, h, 1, row);
                let mut eta = vec![0.0; nv];
                difference(&model, &end.q, &moved.q, &mut eta);
                let dp = momentum(&moved) - &p1;
                DMatrix::from_iterator(2 * nv, 1, eta.into_iter().chain(dp.iter().copied()))
            };
            let x = 1e-3;
            let column = ((image(x) - image(-x)) * 8.0 - (image(2.0 * x) - image(-2.0 * x))) / (12.0 * x);
            jacobian.view_mut((0, k), (2 * nv, 1)).copy_from(&column);
        }
        let defect = (jacobian.transpose() * form(&model, &p1) * &jacobian - form(&model, &p0)).amax();
        println!("{row:22} symplectic defect {defect:.1e}");
        if row.symplectic() == Symplectic::Always {
            assert!(defect < 1e-8, "{row}: {defect:e}");
        } else {
            assert!(defect > 1e-5, "{row}: {defect:e}");
        }
    }
}

/// The matrix of the canonical form at momentum p.
fn form(model: &Model, p: &nalgebra::DVector<f64>) -> DMatrix<f64> {
    let nv = model.nv();
    let mut form = DMatrix::zeros(2 * nv, 2 * nv);
    for k in 0..nv {
        form[(nv + k, k)] = 1.0;
        form[(k, nv + k)] = -1.0;
    }
    for joint in model.joints() {
        // Structure constants of so(3) and se(3), linear first.
        let i = joint.v_index;
        let bracket = |a: usize, b: usize| -> Vec<f64> {
            let unit = |k: usize| Vector3::from_fn(|r, _| if r == k % 3 { 1.0 } else { 0.0 });
            let cross = unit(a).cross(&unit(b));
            match (joint.nv, a < 3, b < 3) {
                (3, ..) => cross.as_slice().to_vec(),
                (6, true, true) => vec![0.0; 6],
                (6, false, false) => [0.0; 3].iter().chain(cross.iter()).copied().collect(),
                (6, ..) => cross.iter().chain(&[0.0; 3]).copied().collect(),
                _ => vec![0.0],
            }
        };
        for a in 0..joint.nv {
            for b in 0..joint.nv {
                let along: f64 = bracket(a, b).iter().enumerate().map(|(k, c)| c * p[i + k]).sum();
                form[(i + a, i + b)] -= along;
            }
        }
    }
    form
}

/// A free brick spins about its middle axis for 1e5 steps of 1/100 s at 5 rad/s: 800 turns with flips. Its
/// joint frame is not at its centre of mass. The variational methods conserve L, P and K to round-off;
/// classical Runge–Kutta and Euler do not.
///
/// Each step rounds v by up to 1.1e-16. Half of that, all with one sign, is 6e-12 over the run. A random walk
/// would stay below 1e-13, but rounding I ω and dividing by I again has a bias.
#[test]
fn free_body_conserves_momenta_and_energy() {
    free_body(Vector3::zeros(), 100_000);
    free_body(Vector3::new(0.4, -0.3, 0.2), 20_000);
}

fn free_body(c: Vector3<f64>, steps: usize) {
    let mut robot = RobotDescription::new("brick");
    robot.base = Base::Floating;
    robot.gravity = [0.0; 3];
    let brick = MassProperties::solid_box(1000.0, Vector3::new(0.3, 0.2, 0.1)).unwrap();
    let moved = brick.transformed(&nalgebra::Rotation3::identity(), &c);
    robot.links.push(LinkDescription::new("brick", moved));
    let model = Model::new(robot).unwrap();
    // The centre of mass moves at 0.1 m/s: v_c = u + ω × c.
    let omega = Vector3::new(0.01, 5.0, 0.02);
    let u = Vector3::new(0.1, 0.0, 0.0) - omega.cross(&c);
    let initial = State { q: neutral(&model), v: u.iter().chain(omega.iter()).copied().collect() };
    // Away from the centre of mass P, L and K are differences of larger terms; the tolerance is relative to
    // those.
    let p_size = brick.mass() * (0.1 + u.norm());
    let l_size = brick.mass() * c.norm() * u.norm() + 0.25;
    let k_size = 0.5 * brick.mass() * u.norm_squared() + 0.6;
    let drift = |row: Integrator| {
        let (p0, l0, k0) = body_momenta(&model, &c, &initial);
        let mut workspace = StepWorkspace::new(&model);
        let forces = StepForces::new(&[0.0; 6], false);
        let (mut q, mut v) = (initial.q.clone(), initial.v.clone());
        let mut worst = [0.0f64; 3];
        let mut lowest = f64::INFINITY;
        for done in 1..=steps {
            step(&model, row, &mut workspace, &forces, 0.01, &mut q, &mut v).unwrap();
            lowest = lowest.min(v[4]);
            if done % 100 == 0 {
                let now = State { q: q.clone(), v: v.clone() };
                let (p, l, k) = body_momenta(&model, &c, &now);
                let defects = [(p - p0).norm() / p_size, (l - l0).norm() / l_size, (k - k0).abs() / k_size];
                worst = core::array::from_fn(|i| worst[i].max(defects[i]));
            }
        }
        println!(
            "{row:22} c {:.2}: drift of P {:.1e}, L {:.1e}, K {:.1e}",
            c.norm(),
            worst[0],
            worst[1],
            worst[2]
        );
        assert!(lowest < -4.0, "{row}: the brick should flip, ω_y only fell to {lowest}");
        worst
    };
    for row in VARIATIONAL {
        let worst = drift(row);
        assert!(worst.iter().all(|x| *x < 6e-12), "{row}: P, L, K drift by {worst:?}");
    }
    // Runge–Kutta conserves them only to its order.
    let worst = drift(Integrator::RungeKutta4);
    assert!(worst[0] > 1e-9 && worst[2] > 1e-9, "Runge–Kutta: {worst:?}");
}

/// (P, L about the centre of mass, K) in world axes, from M v of the floating joint and the pose of the body.
fn body_momenta(model: &Model, c: &Vector3<f64>, state: &State) -> (Vector3<f64>, Vector3<f64>, f64) {
    let mut workspace = Workspace::new(model);
    let mut mass = vec![0.0; 36];
    mass_matrix(model, &mut workspace, &state.q, &mut mass);
    let p = DMatrix::from_row_slice(6, 6, &mass) * nalgebra::DVector::from_column_slice(&state.v);
    let q = &state.q;
    let turn = UnitQuaternion::new_normalize(nalgebra::Quaternion::new(q[6], q[3], q[4], q[5]));
    let linear = Vector3::new(p[0], p[1], p[2]);
    let angular = Vector3::new(p[3], p[4], p[5]) - c.cross(&linear);
    (turn * linear, turn * angular, kinetic_energy(model, &mut workspace, q, &state.v))
}

/// A floating creature without gravity, with motors and dampers at its joints. The symmetry of the discrete
/// action conserves the total P and L while all parts move, in world axes about the origin.
#[test]
fn floating_creature_conserves_total_momenta() {
    let passive = PassiveForces::default()
        .with_armature(0.0)
        .with_damping(0.1)
        .with_friction(0.02)
        .with_spring(1.0, 0.2);
    let model = without_gravity(&creature(passive));
    let mut tau: Vec<f64> = vec![0.05; model.nv()];
    tau[..6].fill(0.0);
    let forces = StepForces::new(&tau, true);
    let initial = start(&model, 8);
    let total = |state: &State| {
        let mut mass = vec![0.0; model.nv() * model.nv()];
        mass_matrix(&model, &mut Workspace::new(&model), &state.q, &mut mass);
        let mass = DMatrix::from_row_slice(model.nv(), model.nv(), &mass);
        let p = mass * nalgebra::DVector::from_column_slice(&state.v);
        let q = &state.q;
        let turn = UnitQuaternion::new_normalize(nalgebra::Quaternion::new(q[6], q[3], q[4], q[5]));
        let linear = turn * Vector3::new(p[0], p[1], p[2]);
        let x = Vector3::new(q[0], q[1], q[2]);
        (linear, turn * Vector3::new(p[3], p[4], p[5]) + x.cross(&linear))
    };
    let (p0, l0) = total(&initial);
    for row in VARIATIONAL {
        let mut state = State { q: initial.q.clone(), v: initial.v.clone() };
        for _ in 0..20 {
            state = advance(&model, &state, &forces, 2e-3, 100, row);
            let (p, l) = total(&state);
            // 2000 steps, each with a few roundings of 1e-16 of terms of size 10, at worst with one sign:
            // 1e-11.
            assert!((p - p0).norm() < 1e-11, "{row}: P moved by {:e}", (p - p0).norm());
            assert!((l - l0).norm() < 1e-11, "{row}: L moved by {:e}", (l - l0).norm());
        }
        assert!(distance(&model, &initial, &state) > 0.5, "{row}: nothing moved");
    }
    let end = advance(&model, &initial, &forces, 2e-3, 2000, Integrator::ExplicitEuler);
    assert!((total(&end).1 - l0).norm() > 1e-6, "explicit Euler should not keep L");
}

/// A double pendulum with a ball joint moves chaotically for 1e5 steps of 10 ms. For the variational methods
/// the mean energy error of the last tenth is that of the first, up to a random factor of two. For
/// Runge–Kutta it grows with time, by 19 from the first tenth to the last if the growth is steady.
///
/// The motion is chaotic on purpose: a bounded error depends on the state. A motion that changes slowly
/// between its modes would show that change instead of the error of the integrator.
#[test]
fn energy_error_stays_bounded_over_long_run() {
    long_run(100_000);
}

/// The same over ten times as many steps; slow, so it is ignored by default.
#[test]
#[ignore = "half a minute"]
fn energy_error_stays_bounded_over_million_steps() {
    long_run(1_000_000);
}

fn long_run(steps: usize) {
    let mut robot = RobotDescription::new("ball pendulum");
    let link = |name: &str| {
        let inertia = Matrix3::from_diagonal(&Vector3::new(0.02, 0.03, 0.025));
        let properties = MassProperties::new(1.0, Vector3::new(0.1, 0.0, -0.5), inertia).unwrap();
        LinkDescription::new(name, properties)
    };
    robot.links.push(LinkDescription::new("ceiling", None));
    robot.links.extend([link("upper"), link("lower")]);
    let knee = JointKind::Revolute { axis: [0.0, 1.0, 0.0] };
    let below = Pose::from_translation([0.0, 0.0, -1.0]);
    robot.joints.push(JointDescription::new("hip", JointKind::Spherical, "ceiling", "upper", Pose::IDENTITY));
    robot.joints.push(JointDescription::new("knee", knee, "upper", "lower", below));
    let model = Model::new(robot).unwrap();
    let initial =
        State { q: vec![0.1, 0.05, 0.0, (1.0f64 - 0.0125).sqrt(), 1.5], v: vec![2.0, -1.0, 3.0, 1.0] };
    let errors = |row: Integrator, h: f64| {
        let (mut workspace, mut scratch) = (StepWorkspace::new(&model), Workspace::new(&model));
        let forces = StepForces::new(&[0.0; 4], false);
        let e0 = energy(&model, &initial);
        let (mut q, mut v) = (initial.q.clone(), initial.v.clone());
        let (mut first, mut last, mut most) = (0.0, 0.0, 0.0f64);
        for done in 0..steps {
            step(&model, row, &mut workspace, &forces, h, &mut q, &mut v).unwrap();
            let kinetic = kinetic_energy(&model, &mut scratch, &q, &v);
            let error = (kinetic + potential_energy(&model, &mut scratch, &q) - e0).abs();
            if done < steps / 10 {
                first += error;
            }
            if done >= steps - steps / 10 {
                last += error;
            }
            most = most.max(error);
        }
        let count = (steps / 10) as f64;
        let (first, last) = (first / count, last / count);
        println!("{row:22} mean energy error {first:.2e} J, then {last:.2e} J, largest {most:.2e} J");
        (first, last)
    };
    for row in VARIATIONAL {
        let (first, last) = errors(row, 0.01);
        assert!(last < 2.0 * first, "{row}: {first:e} J grows to {last:e} J");
    }
    let (first, last) = errors(Integrator::RungeKutta4, 0.01);
    assert!(last > 10.0 * first, "Runge–Kutta: {first:e} J to {last:e} J does not drift");
}

/// An implicit step that is too long is an error and leaves the state unchanged.
#[test]
fn too_long_step_is_an_error() {
    let model = creature(PassiveForces::default());
    let initial = start(&model, 3);
    let tau = vec![0.0; model.nv()];
    let forces = StepForces::new(&tau, false);
    let (mut q, mut v) = (initial.q.clone(), initial.v.clone());
    for v in &mut v {
        *v *= 10.0;
    }
    let before = (q.clone(), v.clone());
    for row in VARIATIONAL {
        let result = step(&model, row, &mut StepWorkspace::new(&model), &forces, 5.0, &mut q, &mut v);
        assert!(matches!(result, Err(IntegratorError::NotConverged { .. })), "{row}: {result:?}");
        assert_eq!((&q, &v), (&before.0, &before.1));
    }
    v[2] = f64::NAN;
    let result =
        step(&model, Integrator::RungeKutta4, &mut StepWorkspace::new(&model), &forces, 0.1, &mut q, &mut v);
    let Err(IntegratorError::Input(input)) = result else { panic!("{result:?}") };
    assert_eq!(input.to_string(), "v[2] is NaN; every number must be finite");
}

/// Friction that stops a joint does not break the implicit methods: the pendulum comes to rest and oscillates
/// within the friction of one step.
#[test]
fn friction_brings_every_method_to_rest() {
    let mut robot = described_2r().description().clone();
    robot.gravity = [0.0; 3];
    robot.joints.iter_mut().for_each(|joint| joint.passive = joint.passive.with_friction(0.5));
    let model = Model::new(robot).unwrap();
    let forces = StepForces::new(&[0.0, 0.0], true);
    for row in Integrator::ALL {
        let end = advance(&model, &State { q: vec![0.1, 0.5], v: vec![1.0, -0.5] }, &forces, 1e-3, 5000, row);
        // The friction of one step on the lightest column of M⁻¹ changes v by 1e-3 · 2 · 0.5 · |M⁻¹| ≈ 0.02.
        assert!(end.v.iter().all(|v| v.abs() < 0.02), "{row}: {:?}", end.v);
    }
}

/// For a step that is far too long, or a diverging state, the implicit methods return an error with the
/// number of iterations. It is not an error about the mass matrix.
#[test]
fn diverging_iteration_is_not_singular_mass() {
    let model = creature(PassiveForces::default());
    let tau = vec![0.0; model.nv()];
    let forces = StepForces::new(&tau, false);
    for speed in [1e2, 1e8, 1e80, 1e150, 1e200] {
        let mut initial = start(&model, 3);
        // Ball joint and base at rest: turns that are too long for a step are a different error.
        initial.v.fill(0.0);
        for joint in model.joints().iter().filter(|joint| joint.nq == 1) {
            initial.v[joint.v_index] = speed;
        }
        for row in VARIATIONAL {
            let mut workspace = StepWorkspace::new(&model);
            let (mut q, mut v) = (initial.q.clone(), initial.v.clone());
            let result = step(&model, row, &mut workspace, &forces, 0.1, &mut q, &mut v);
            let Err(IntegratorError::NotConverged { iterations, step, .. }) = result else {
                panic!("{row} at {speed:e}: {result:?}, {v:?}")
            };
            assert!((1..=100).contains(&iterations) && step.abs() < 0.2, "{row}: {iterations}, {step}");
            assert!(q == initial.q && v == initial.v, "{row}: the state changed");
        }
    }
}

/// The step over any scalar type is the checked step with other formulas for quaternions: they agree to some
/// roundings of the largest number. Over dual numbers its derivatives along a change of the torques match the
/// linearised step, to κ(M) < 1e3 times that.
#[test]
fn step_over_any_scalar_matches_step_and_its_derivatives() {
    let passive = PassiveForces::default().with_damping(0.3).with_friction(0.1).with_spring(2.0, 0.1);
    for (model, seed) in [(arm(), 1), (creature(passive), 2), (creature(passive), 3)] {
        let State { q, v } = start(&model, seed);
        let (nv, h) = (model.nv(), 0.01);
        let mut random = SplitMix64::new(seed);
        let mut numbers = || -> Vec<f64> { (0..nv).map(|_| random.uniform(-3.0, 3.0)).collect() };
        let (tau, change) = (numbers(), numbers());
        for (row, dissipation) in Integrator::ALL.into_iter().flat_map(|row| [(row, true), (row, false)]) {
            let robot_dynamics_integrators::StepScheme::Explicit(stages) = row.scheme() else { continue };
            let forces = StepForces::new(&tau, dissipation);
            let (mut q_next, mut v_next) = (q.clone(), v.clone());
            step(&model, row, &mut StepWorkspace::new(&model), &forces, h, &mut q_next, &mut v_next).unwrap();
            let (mut found_q, mut found_v) = (vec![f64::NAN; model.nq()], vec![f64::NAN; nv]);
            let workspace = &mut StepStagesWorkspace::new(&model);
            let ends = (&mut found_q[..], &mut found_v[..]);
            step_stages(&model, stages, workspace, &forces, h, (&q, &v), ends);
            let pairs = found_q.iter().zip(&q_next).chain(found_v.iter().zip(&v_next));
            let size = v_next.iter().fold(1.0_f64, |size, x| size.max(x.abs()));
            let off = pairs.fold(0.0_f64, |most, (x, y)| most.max((x - y).abs()));
            assert!(off <= 100.0 * f64::EPSILON * size, "{row}, {}: {off:e}", model.name());

            let constant = |x: &[f64]| x.iter().map(|&x| Dual::<f64, 1>::constant(x)).collect::<Vec<_>>();
            let along: Vec<_> =
                tau.iter().zip(&change).map(|(&value, &by)| Dual { value, gradient: [by] }).collect();
            let (mut dual_q, mut dual_v) = (constant(&found_q), constant(&found_v));
            step_stages(
                &model,
                stages,
                &mut StepStagesWorkspace::new(&model),
                &StepForces::new(&along, dissipation),
                Dual::constant(h),
                (&constant(&q), &constant(&v)),
                (&mut dual_q, &mut dual_v),
            );
            let (mut by_state, mut by_force) = (vec![0.0; 4 * nv * nv], vec![0.0; 2 * nv * nv]);
            let workspace = &mut LinearizeStepWorkspace::new(&model);
            let out = LinearizedStep { by_state: &mut by_state, by_force: &mut by_force };
            linearize_step(&model, row, workspace, &forces, h, RobotState { q: &q, v: &v }, out).unwrap();
            for (k, v_next) in dual_v.iter().enumerate() {
                let entries = by_force[(nv + k) * nv..][..nv].iter().zip(&change);
                let (sum, size) = entries.fold((0.0, 0.0), |(sum, size): (f64, f64), (entry, by)| {
                    (sum + entry * by, size.max((entry * by).abs()))
                });
                let off = (v_next.gradient[0] - sum).abs();
                assert!(off <= 1e3 * 100.0 * f64::EPSILON * size.max(h), "{row}, entry {k}: {off:e}");
            }
        }
    }
}
