//! Integration and difference on the configuration space, against matrix power series and the group laws.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Matrix4, Rotation3, UnitQuaternion, Vector3};
use robot_dynamics::InputProblem;
use robot_dynamics::algorithms::kinetic_energy;
use robot_dynamics::conventions;
use robot_dynamics::description::{
    Base, JointDescription, JointKind, Limits, LinkDescription, Mimic, Pose, Quaternion, RandomRobotOptions,
    RobotDescription, random_robot,
};
use robot_dynamics::model::{
    Model, check_configuration, difference, integrate, interpolate, neutral, normalize_quaternions,
    random_state, random_within_limits,
};
use robot_dynamics::number::SplitMix64;

fn brick() -> LinkDescription {
    let properties =
        robot_dynamics::description::MassProperties::solid_box(1000.0, Vector3::new(0.3, 0.2, 0.1)).unwrap();
    LinkDescription::new("brick", properties)
}

fn floating_brick() -> Model {
    let mut robot = RobotDescription::new("brick");
    robot.base = Base::Floating;
    robot.links.push(brick());
    Model::new(robot).unwrap()
}

/// Floating trees with every kind of joint.
fn trees() -> impl Iterator<Item = (u64, Model)> {
    let options = RandomRobotOptions { base: Base::Floating, mimic: 0.2, ..Default::default() };
    (0..20).map(move |seed| (seed, Model::new(random_robot(seed, &options)).unwrap()))
}

/// The exponential of the 4×4 matrix of a twist by its power series with scaling and squaring, without a
/// closed form.
fn series_exp(linear: Vector3<f64>, angular: Vector3<f64>) -> Matrix4<f64> {
    let mut x = Matrix4::zeros();
    x.fixed_view_mut::<3, 3>(0, 0).copy_from(&angular.cross_matrix());
    x.fixed_view_mut::<3, 1>(0, 3).copy_from(&linear);
    x /= 64.0;
    let (mut term, mut sum) = (Matrix4::identity(), Matrix4::identity());
    for k in 1..20 {
        term = term * x / f64::from(k);
        sum += term;
    }
    for _ in 0..6 {
        sum *= sum;
    }
    sum
}

/// The exponential against the series at angles from 1e-12 to a full turn. Squaring six times multiplies
/// rounding by 64: 64 ε times entries up to 5 is 7e-14.
#[test]
fn integrate_of_floating_joint_is_matrix_exponential() {
    let model = floating_brick();
    let mut random = SplitMix64::new(3);
    for angle in [0.0, 1e-160, 1e-12, 1e-8, 1e-4, 0.1, 0.9999, 1.0, 1.0001, 2.0, PI - 1e-9, PI, 4.0, 6.2] {
        for _ in 0..20 {
            let mut vector = || Vector3::from_fn(|_, _| random.uniform(-1.0, 1.0));
            let (u, phi) = (vector() * 3.0, vector().normalize() * angle);
            let mut q = neutral(&model);
            integrate(&model, &neutral(&model), &[u.x, u.y, u.z, phi.x, phi.y, phi.z], &mut q);
            let expected = series_exp(u, phi);
            let rotation = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(q[6], q[3], q[4], q[5]))
                .to_rotation_matrix();
            let expected_rotation = expected.fixed_view::<3, 3>(0, 0).into_owned();
            let turn = (rotation.matrix() - expected_rotation).amax();
            let shift = (Vector3::new(q[0], q[1], q[2]) - expected.fixed_view::<3, 1>(0, 3)).amax();
            assert!(turn < 1e-13 && shift < 1e-13, "angle {angle}: {turn:e} {shift:e}, twist {u} {phi}");
        }
    }
}

/// q ⊕ δ ⊖ q = δ for turns up to just below half a turn, where the logarithm is still unique.
#[test]
fn difference_inverts_integrate() {
    let mut random = SplitMix64::new(5);
    for (seed, model) in trees() {
        let q = random_state(&model, &mut random).q;
        for angle in [1e-14, 1e-9, 1e-5, 0.5, 1.0, 2.0, 3.0, PI - 1e-3, PI - 1e-6] {
            let mut delta: Vec<f64> = (0..model.nv()).map(|_| random.uniform(-1.0, 1.0)).collect();
            for joint in model.joints().iter().filter(|joint| joint.nq > joint.nv) {
                let end = joint.v_index + joint.nv;
                let angular = &mut delta[end - 3..end];
                let length = Vector3::from_column_slice(angular).norm();
                for x in angular.iter_mut() {
                    *x *= angle / length;
                }
            }
            let (mut moved, mut back) = (vec![0.0; model.nq()], vec![0.0; model.nv()]);
            integrate(&model, &q, &delta, &mut moved);
            check_configuration(&model, &moved).unwrap();
            difference(&model, &q, &moved, &mut back);
            let defect = delta.iter().zip(&back).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(defect < 1e-12, "robot {seed}, angle {angle}: {defect:e}");
        }
    }
}

/// Small turns keep their digits. The difference of a move by 1e-9 is exact to 1e-15 of 1e-9, up to the
/// rounding of the two quaternions, 1e-16.
#[test]
fn tiny_moves_keep_their_digits() {
    let model = floating_brick();
    let delta = [1e-9, -2e-9, 3e-9, 2e-9, 1e-9, -1e-9];
    let (mut moved, mut back) = (neutral(&model), [0.0; 6]);
    integrate(&model, &neutral(&model), &delta, &mut moved);
    difference(&model, &neutral(&model), &moved, &mut back);
    // From the identity only the numbers themselves are rounded.
    for (a, b) in delta.iter().zip(&back) {
        assert!((a - b).abs() < 1e-23, "{a:e} {b:e}");
    }
}

/// (q ⊕ sδ) ⊕ tδ = q ⊕ (s+t)δ, and interpolation passes through both ends with constant velocity.
#[test]
fn moves_along_one_displacement_add_up() {
    let mut random = SplitMix64::new(7);
    for (seed, model) in trees() {
        let (q, v) = (random_state(&model, &mut random).q, random_state(&model, &mut random).v);
        let scaled = |k: f64| v.iter().map(|v| k * v).collect::<Vec<_>>();
        let moved = |q: &[f64], d: &[f64]| {
            let mut to = vec![0.0; model.nq()];
            integrate(&model, q, d, &mut to);
            to
        };
        let twice = moved(&moved(&q, &scaled(0.3)), &scaled(0.4));
        let once = moved(&q, &scaled(0.7));
        assert_close(&twice, &once, 1e-14, &format!("robot {seed}"));

        let end = moved(&q, &scaled(0.5));
        let between = |s: f64| {
            let mut to = vec![0.0; model.nq()];
            interpolate(&model, &q, &end, s, &mut to);
            to
        };
        assert_close(&between(0.0), &q, 1e-14, "start");
        assert_close(&between(1.0), &end, 1e-14, "end");
        assert_close(&between(0.5), &moved(&q, &scaled(0.25)), 1e-14, "middle");
    }
}

/// Compares quaternions up to their common sign.
fn assert_close(a: &[f64], b: &[f64], tolerance: f64, what: &str) {
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        assert!((a - b).abs() <= tolerance * (1.0 + b.abs()), "{what}: entry {i}: {a} {b}");
    }
}

/// q̇ by nalgebra's quaternions: ½ Q ω for a rotation, R u for a position.
fn rate_of_q(model: &Model, q: &[f64], v: &[f64], rate: &mut [f64]) {
    for joint in model.joints().iter().filter(|joint| joint.nq > 0) {
        let (i, k) = (joint.q_index, joint.v_index);
        if joint.nq == joint.nv {
            rate[i..i + joint.nq].copy_from_slice(&v[k..k + joint.nv]);
            continue;
        }
        let (at, omega) = (i + joint.nq - 4, k + joint.nv - 3);
        let turn = nalgebra::Quaternion::new(q[at + 3], q[at], q[at + 1], q[at + 2]);
        let half = nalgebra::Quaternion::new(0.0, v[omega], v[omega + 1], v[omega + 2]) * 0.5;
        rate[at..at + 4].copy_from_slice((turn * half).coords.as_slice());
        if joint.nq == 7 {
            let linear = UnitQuaternion::from_quaternion(turn) * Vector3::new(v[k], v[k + 1], v[k + 2]);
            rate[i..i + 3].copy_from_slice(linear.as_slice());
        }
    }
}

/// d/dt (q ⊕ tv) at 0 is v, ½ Q ω or R u; these formulas share no code with the exponential. The central
/// difference with step 1e-5 has an error of 1e-10 |v|³/6 with |v| ≤ 5, and a rounding of 1e-11.
#[test]
fn integrate_starts_at_the_rate_of_q() {
    let mut random = SplitMix64::new(9);
    for (seed, model) in trees() {
        let state = random_state(&model, &mut random);
        let mut rate = vec![0.0; model.nq()];
        rate_of_q(&model, &state.q, &state.v, &mut rate);
        let at = |t: f64| {
            let mut q = vec![0.0; model.nq()];
            let d: Vec<f64> = state.v.iter().map(|v| t * v).collect();
            integrate(&model, &state.q, &d, &mut q);
            q
        };
        let (after, before) = (at(1e-5), at(-1e-5));
        let slope: Vec<f64> = after.iter().zip(&before).map(|(a, b)| (a - b) / 2e-5).collect();
        assert_close(&slope, &rate, 3e-9, &format!("robot {seed}"));
    }
}

/// Sum and logarithm of quaternions against nalgebra.
#[test]
fn quaternions_agree_with_nalgebra() {
    let mut random = SplitMix64::new(11);
    for _ in 0..200 {
        let mut vector = || Vector3::from_fn(|_, _| random.uniform(-1.8, 1.8));
        let (a, b, x) = (vector(), vector(), vector());
        let ours = Quaternion::exp(a.into()).times(Quaternion::exp(b.into()).conjugate());
        let theirs = Rotation3::new(a) * Rotation3::new(b).inverse();
        assert!((Vector3::from(ours.rotate(x.into())) - theirs * x).amax() < 1e-14, "{a} {b}");
        assert!((Vector3::from(ours.rotate_back(theirs.transform_vector(&x).into())) - x).amax() < 1e-14);
        // Near half a turn nalgebra's logarithm of a matrix is the less accurate of the two.
        let log = Rotation3::new(Vector3::from(ours.log()));
        assert!((log.matrix() - theirs.matrix()).amax() < 1e-14, "{a} {b}");
        let [w, i, j, k] = ours.to_wxyz();
        assert_eq!(Quaternion::from_wxyz([w, i, j, k]).to_xyzw(), [i, j, k, w]);
        let negative = Quaternion::from_wxyz([-w, -i, -j, -k]);
        assert_eq!(negative.log(), ours.log(), "q and −q are one rotation");
    }
}

/// Every coordinate is within its limits, every quaternion has unit length, equal seeds give equal results,
/// and rotations are uniform.
#[test]
fn random_configurations_lie_within_limits() {
    let mut robot = RobotDescription::new("limited");
    robot.base = Base::Floating;
    let link = |name: &str| LinkDescription::new(name, brick().mass_properties);
    robot.links.extend(["base", "a", "b", "c", "d"].map(link));
    let limits = |lower, upper| Limits::new(lower, upper);
    let hinge = JointKind::Revolute { axis: [0.0, 0.0, 1.0] };
    let slide = JointKind::Prismatic { axis: [0.0, 0.0, 1.0] };
    let joints = [
        ("first", hinge, "base", "a", limits(0.2, 0.3)),
        ("second", slide, "a", "b", limits(5.0, f64::INFINITY)),
        ("third", hinge, "b", "c", limits(f64::NEG_INFINITY, -10.0)),
        ("fourth", JointKind::Spherical, "c", "d", Limits::default()),
    ];
    for (name, kind, parent, child, limits) in joints {
        let joint = JointDescription::new(name, kind, parent, child, Pose::IDENTITY);
        robot.joints.push(joint.with_limits(limits));
    }
    let model = Model::new(robot).unwrap();
    let mut random = SplitMix64::new(13);
    let first = random_within_limits(&model, &mut random.clone());
    assert_eq!(first, random_within_limits(&model, &mut random.clone()));
    let mut mean = Matrix3::zeros();
    let count = 4000;
    for _ in 0..count {
        let q = random_within_limits(&model, &mut random);
        check_configuration(&model, &q).unwrap();
        let ranges = [(0.2, 0.3), (5.0, 6.0), (-10.0 - PI, -10.0)];
        for (x, (low, high)) in q[7..10].iter().zip(ranges) {
            assert!((low..=high).contains(x), "{q:?}");
        }
        let r = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(q[6], q[3], q[4], q[5]));
        mean += r.to_rotation_matrix().matrix() / f64::from(count);
    }
    // Each entry of a uniform rotation has mean 0 and variance 1/3: four deviations of 4000 are 0.037.
    assert!(mean.amax() < 0.037, "{mean}");
}

/// Some files write the largest float where there is no limit, so that the range is not finite.
#[test]
fn largest_floats_mean_no_limit() {
    let mut robot = RobotDescription::new("unlimited");
    robot.links.extend(["base", "a"].map(|name| LinkDescription::new(name, brick().mass_properties)));
    let hinge = JointKind::Revolute { axis: [0.0, 0.0, 1.0] };
    let limits = Limits::new(f64::MIN, f64::MAX);
    let joint = JointDescription::new("hinge", hinge, "base", "a", Pose::IDENTITY);
    robot.joints.push(joint.with_limits(limits));
    let q = random_within_limits(&Model::new(robot).unwrap(), &mut SplitMix64::new(1));
    assert!((-PI..PI).contains(&q[0]), "{q:?}");
}

#[test]
fn invalid_configurations_are_errors() {
    let model = floating_brick();
    let mut q = neutral(&model);
    check_configuration(&model, &q).unwrap();
    let error = check_configuration(&model, &q[..6]).unwrap_err();
    assert!(matches!(error.problem, InputProblem::WrongLength { found: 6, expected: 7, .. }), "{error}");

    q[6] = 1.0 + 2e-6;
    let error = check_configuration(&model, &q).unwrap_err();
    let InputProblem::NotAUnitQuaternion { first: 3, joint, .. } = &error.problem else { panic!("{error}") };
    assert_eq!(joint, "floating_base");
    normalize_quaternions(&model, &mut q);
    check_configuration(&model, &q).unwrap();

    q[3..].fill(0.0);
    assert!(check_configuration(&model, &q).is_err());
    normalize_quaternions(&model, &mut q);
    let error = check_configuration(&model, &q).unwrap_err();
    assert!(matches!(error.problem, InputProblem::NotFinite { index: Some(3), .. }), "{error}");
}

/// A mimic joint has no coordinate of its own in q.
#[test]
fn mimic_joints_have_no_coordinates() {
    let mut robot = RobotDescription::new("gears");
    robot.links.extend(["base", "a", "b"].map(|name| LinkDescription::new(name, brick().mass_properties)));
    let hinge = JointKind::Revolute { axis: [0.0, 0.0, 1.0] };
    robot.joints.push(JointDescription::new("leader", hinge, "base", "a", Pose::IDENTITY));
    let follower = JointDescription::new("follower", hinge, "a", "b", Pose::IDENTITY);
    let mimic = Mimic::new("leader", -2.0, 0.1);
    robot.joints.push(follower.with_mimic(mimic));
    let model = Model::new(robot).unwrap();
    let mut q = [0.0];
    integrate(&model, &[0.5], &[0.25], &mut q);
    assert_eq!(q, [0.75]);
}

/// MuJoCo's coordinates map there and back. Power, kinetic energy and a rotation computed by hand define the
/// meaning of each number.
#[test]
fn mujoco_coordinates_map_there_and_back() {
    let mut random = SplitMix64::new(17);
    for (seed, model) in trees() {
        let state = random_state(&model, &mut random);
        let (mut qpos, mut q) = (vec![0.0; model.nq()], vec![0.0; model.nq()]);
        conventions::configuration_to_mujoco(&model, &state.q, &mut qpos);
        conventions::configuration_from_mujoco(&model, &qpos, &mut q);
        assert_eq!(q, state.q, "robot {seed}");
        assert_eq!(qpos[3..7], [q[6], q[3], q[4], q[5]]);

        let (mut there, mut back) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
        conventions::velocity_to_mujoco(&model, &q, &state.v, &mut there);
        conventions::velocity_from_mujoco(&model, &q, &there, &mut back);
        assert_close(&back, &state.v, 1e-14, "v");
        let mut rate = vec![0.0; model.nq()];
        rate_of_q(&model, &q, &state.v, &mut rate);
        assert_close(&there[..3], &rate[..3], 1e-14, "the linear velocity is the rate of the position");
        assert_eq!(there[3..6], state.v[3..6]);

        let mut force = vec![0.0; model.nv()];
        conventions::force_to_mujoco(&model, &q, &state.tau, &mut force);
        let power = |f: &[f64], v: &[f64]| f.iter().zip(v).map(|(f, v)| f * v).sum::<f64>();
        let difference = power(&force, &there) - power(&state.tau, &state.v);
        assert!(difference.abs() < 1e-12, "robot {seed}: power differs by {difference:e}");
        conventions::force_from_mujoco(&model, &q, &force, &mut back);
        assert_close(&back, &state.tau, 1e-14, "tau");

        let mut acceleration = vec![0.0; model.nv()];
        conventions::acceleration_to_mujoco(&model, &q, &state.v, &state.a, &mut acceleration);
        conventions::acceleration_from_mujoco(&model, &q, &state.v, &acceleration, &mut back);
        assert_close(&back, &state.a, 1e-14, "a");
        // The rate of q along the motion by central differences: an error of 1e-8 times third derivatives.
        let world_velocity = |t: f64| {
            let d: Vec<f64> = state.v.iter().zip(&state.a).map(|(v, a)| t * v + 0.5 * t * t * a).collect();
            let v: Vec<f64> = state.v.iter().zip(&state.a).map(|(v, a)| v + t * a).collect();
            let (mut q, mut qvel) = (vec![0.0; model.nq()], vec![0.0; model.nv()]);
            integrate(&model, &state.q, &d, &mut q);
            conventions::velocity_to_mujoco(&model, &q, &v, &mut qvel);
            qvel
        };
        let (after, before) = (world_velocity(1e-4), world_velocity(-1e-4));
        for k in 0..3 {
            let slope = (after[k] - before[k]) / 2e-4;
            assert!((slope - acceleration[k]).abs() < 1e-5, "robot {seed}: {slope} {}", acceleration[k]);
        }
    }
    // The brick lies on its side: a quarter turn about z maps the body's x axis to the world's y axis.
    let model = floating_brick();
    let half = 0.5f64.sqrt();
    let q = [0.0, 0.0, 0.0, 0.0, 0.0, half, half];
    let mut qvel = [0.0; 6];
    conventions::velocity_to_mujoco(&model, &q, &[1.0, 0.0, 0.0, 0.1, 0.2, 0.3], &mut qvel);
    assert!((qvel[1] - 1.0).abs() < 1e-15 && qvel[0].abs() < 1e-15);
    assert_eq!(qvel[3..], [0.1, 0.2, 0.3]);
    let mut workspace = robot_dynamics::model::Workspace::new(&model);
    assert!(kinetic_energy(&model, &mut workspace, &q, &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]) > 0.0);
}
