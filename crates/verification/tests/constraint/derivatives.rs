//! Derivatives of constrained motions against differences, their definitions and their pullbacks.

use nalgebra::{DMatrix, DVector};
use robot_dynamics::constraints::{
    Baumgarte, Constraint, ConstraintOptions, ConstraintSet, Coupling, FrameConstraint, NoSlip, Plane,
    PolynomialCoupling, RedundantRows, RollingDisc, RollingRow, SpatialAxis, constrained_forward_dynamics,
    constrained_inverse_dynamics, contact_impulse,
};
use robot_dynamics::derivatives::{
    ConstrainedPullbackInputs, ConstrainedTorquePullbackInputs, ImpulsePullbackInputs,
    constrained_forward_dynamics_derivatives, constrained_forward_dynamics_pullback,
    constrained_inverse_dynamics_derivatives, constrained_inverse_dynamics_pullback,
    contact_impulse_derivatives, contact_impulse_pullback, parameter_values, with_parameters,
};
use robot_dynamics::description::{Pose, RandomRobotOptions, random_robot};
use robot_dynamics::model::{FrameId, Model, RandomState, Workspace, integrate, random_state};
use robot_dynamics::number::SplitMix64;

use crate::closed_loop::{PIN, linkage, start};

/// The derivative of a function along each coordinate, by differences of fourth order.
///
/// The truncation is h⁴ of the fifth derivative, which is large where Λ is nearly singular, and the rounding
/// is ε/h of the value. Several steps are tried, and the result that differs least from that of the next
/// smaller one counts.
fn differences(nv: usize, mut at: impl FnMut(usize, f64) -> DVector<f64>) -> DMatrix<f64> {
    let mut column = |k: usize| {
        let mut slope = |h: f64| {
            let mut along = |h: f64| at(k, h);
            ((along(h) - along(-h)) * 8.0 - (along(2.0 * h) - along(-2.0 * h))) / (12.0 * h)
        };
        let slopes = [4e-3, 1e-3, 2.5e-4, 6e-5, 1.5e-5, 4e-6].map(&mut slope);
        let off = |i: &usize| (&slopes[*i] - &slopes[i + 1]).amax();
        let best = (0..5).min_by(|i, j| off(i).total_cmp(&off(j))).expect("a step");
        slopes[best + 1].clone()
    };
    DMatrix::from_columns(&(0..nv).map(&mut column).collect::<Vec<_>>())
}

/// q ⊕ h e_k.
fn moved(model: &Model, q: &[f64], k: usize, h: f64) -> Vec<f64> {
    let (mut way, mut to) = (vec![0.0; model.nv()], q.to_vec());
    way[k] = h;
    integrate(model, q, &way, &mut to);
    to
}

/// x + h e_k.
fn shifted(x: &[f64], k: usize, h: f64) -> Vec<f64> {
    let mut to = x.to_vec();
    to[k] += h;
    to
}

/// The two agree to 1e-6 of the largest entry: differences lose half of the digits where Λ is nearly
/// singular.
#[track_caller]
fn assert_close(name: &str, found: &DMatrix<f64>, expected: &DMatrix<f64>) {
    assert_eq!(found.shape(), expected.shape(), "{name}");
    let (off, scale) = (largest(&(found - expected)), 1.0 + largest(expected));
    assert!(off < 1e-6 * scale, "{name} is off by {off}, of {scale}");
}

fn largest(matrix: &DMatrix<f64>) -> f64 {
    matrix.iter().fold(0.0, |most, x| if x.is_nan() { f64::INFINITY } else { x.abs().max(most) })
}

/// Sets of every kind of constraint on a random robot with ball, floating and mimic joints.
fn sets(model: &Model, random: &mut SplitMix64) -> Vec<(&'static str, ConstraintSet)> {
    use SpatialAxis::{Rx, Ry, Rz, X, Y, Z};
    let links: Vec<FrameId> =
        model.links().iter().map(|link| model.frame(&link.name).expect("a link")).collect();
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // below the number of links
    let [a, b, c, d] =
        core::array::from_fn(|_| links[random.uniform(0.0, links.len() as f64 - 1e-9) as usize]);
    let place = Pose::from_xyz_rpy([0.1, -0.2, 0.3], [0.4, 0.5, -0.6]);
    let disc = |rows: &[RollingRow]| RollingDisc {
        frame: c,
        axle: [0.3, 2.0, -0.5],
        radius: 0.3,
        plane: Plane::new([0.1, 0.2, 1.0], [0.0, 0.0, 0.4]),
        rows: rows.to_vec(),
    };
    let joined = |one, other, rows: &[SpatialAxis]| FrameConstraint::between(one, other, rows);
    let mut all: Vec<(&'static str, Vec<(&str, Constraint)>)> = vec![
        ("ball", vec![("ball", joined(a, b, &FrameConstraint::BALL).into())]),
        ("turns", vec![("turns", joined(a, c, &[Rx, Ry, Rz]).into())]),
        ("hinge", vec![("hinge", joined(c, a, &[Rx, Rz]).into())]),
        ("universal", vec![("universal", joined(b, d, &[Ry, X]).into())]),
        ("held", vec![("held", FrameConstraint::contact(c, place, &[X, Y, Rz]).into())]),
        ("weld", vec![("weld", FrameConstraint::contact(d, place, &FrameConstraint::WELD).into())]),
        ("slips", vec![("slips", NoSlip { frame: d, rows: vec![Y, Rx, Z] }.into())]),
        ("rolls", vec![("rolls", disc(&[RollingRow::Forward, RollingRow::Normal]).into())]),
        ("side", vec![("side", disc(&[RollingRow::Side]).into())]),
        (
            "several",
            vec![
                ("pin", joined(a, d, &[X, Z]).into()),
                ("held", FrameConstraint::contact(b, place, &[Y]).into()),
                ("rolls", disc(&[RollingRow::Side]).into()),
            ],
        ),
        ("twice", vec![("one", joined(a, d, &[X, Z]).into()), ("other", joined(a, d, &[X, Z]).into())]),
    ];
    let names = model.coordinate_names();
    let terms = [(names[0].as_str(), 0.7), (names[names.len() - 1].as_str(), -1.3)];
    all.push(("sum", vec![("sum", Coupling::new(model, &terms, 0.2).expect("coordinates").into())]));
    let single: Vec<_> = model.joints().iter().filter(|joint| joint.nv == 1).collect();
    if let [first, .., last] = single[..] {
        let leader = Some((first.name.as_str(), -0.1));
        let cam = PolynomialCoupling::new(model, (&last.name, 0.3), leader, [0.3, -0.7, 0.2, 0.1, -0.4]);
        all.push(("cam", vec![("cam", cam.expect("joints").into())]));
    }
    all.into_iter()
        .map(|(name, constraints)| (name, ConstraintSet::new(model, constraints).expect("a valid set")))
        .collect()
}

/// Random robots with their sets and a state whose velocities are of order 1.
fn each_case(mut run: impl FnMut(&str, &Model, &ConstraintSet, &RandomState, &mut SplitMix64)) {
    for seed in 0..8 {
        let model = Model::new(random_robot(seed, &RandomRobotOptions::default())).expect("a valid robot");
        let mut random = SplitMix64::new(seed);
        for (name, set) in sets(&model, &mut random) {
            let state = random_state(&model, &mut random);
            run(&format!("robot {seed}, {name}"), &model, &set, &state, &mut random);
        }
    }
}

/// The options of a case: with and without feedback, and both treatments of dependent rows. The rounding of
/// the shortest multipliers is ε over the damping.
fn options(random: &mut SplitMix64) -> ConstraintOptions {
    let stabilization = (random.uniform(0.0, 1.0) < 0.5).then_some(Baumgarte { rate: 3.0 });
    let redundant = if random.uniform(0.0, 1.0) < 0.5 {
        RedundantRows::Proximal { damping: 1e-4 }
    } else {
        RedundantRows::Drop
    };
    ConstraintOptions { stabilization, redundant, ..ConstraintOptions::default() }
}

fn random_vector(random: &mut SplitMix64, length: usize) -> DVector<f64> {
    DVector::from_fn(length, |_, _| random.uniform(-1.0, 1.0))
}

/// ∂a and ∂λ by q, v and τ. A set is left out where its rows contradict each other, as six rows of a body
/// with two degrees of freedom.
#[test]
fn forward_derivatives_are_limits_of_differences() {
    let (mut checked, mut kinds) = (0, std::collections::BTreeSet::new());
    each_case(|name, model, set, RandomState { q, v, tau, .. }, random| {
        let (w, options) = (&mut Workspace::new(model), options(random));
        let Ok(by) = constrained_forward_dynamics_derivatives(model, w, set, &options, q, v, tau) else {
            return;
        };
        let nv = model.nv();
        let mut at = |q: &[f64], v: &[f64], tau: &[f64]| {
            let motion = constrained_forward_dynamics(model, w, set, &options, q, v, tau).expect("a motion");
            assert_eq!(motion.rank, by.motion.rank, "{name}");
            DVector::from_iterator(
                nv + set.len(),
                motion.acceleration.iter().chain(&motion.multipliers).copied(),
            )
        };
        let by_position = differences(nv, |k, h| at(&moved(model, q, k, h), v, tau));
        let by_velocity = differences(nv, |k, h| at(q, &shifted(v, k, h), tau));
        let by_force = differences(nv, |k, h| at(q, v, &shifted(tau, k, h)));
        for (of, expected, a, lambda) in [
            ("q", by_position, &by.acceleration_by_position, &by.multipliers_by_position),
            ("v", by_velocity, &by.acceleration_by_velocity, &by.multipliers_by_velocity),
            ("τ", by_force, &by.acceleration_by_force, &by.multipliers_by_force),
        ] {
            assert_close(&format!("{name}: ∂a/∂{of}"), a, &expected.rows(0, nv).into_owned());
            assert_close(&format!("{name}: ∂λ/∂{of}"), lambda, &expected.rows(nv, set.len()).into_owned());
        }
        checked += 1;
        kinds.insert(name.split(", ").nth(1).expect("a kind").to_owned());
    });
    assert!(checked > 60, "{checked} cases");
    assert_eq!(kinds.len(), 13, "{kinds:?}");
}

/// ∂a/∂τ is symmetric and positive semi-definite, and no force moves a constrained direction. Rounding is
/// that of M⁻¹, a few hundred ε of its largest entry.
#[test]
fn response_to_forces_is_symmetric_and_allowed() {
    each_case(|name, model, set, RandomState { q, v, tau, .. }, _| {
        let (w, options) = (&mut Workspace::new(model), ConstraintOptions::default());
        let Ok(by) = constrained_forward_dynamics_derivatives(model, w, set, &options, q, v, tau) else {
            return;
        };
        let response = &by.acceleration_by_force;
        let free = model.inverse_mass_matrix(q).expect("M⁻¹");
        let allowed = 1e-11 * largest(&free);
        assert!(largest(&(response - response.transpose())) < allowed, "{name}");
        let least = response.clone().symmetric_eigenvalues().min();
        assert!(least > -allowed, "{name}: {least}");
        let rows = set.rows(model, w, q, v).matrix;
        assert!(
            largest(&(&rows * response)) < allowed * (1.0 + largest(&rows)) * model.nv() as f64,
            "{name}"
        );
    });
}

/// The pullback is the product of the cotangents and the derivatives. That by parameters agrees with
/// differences.
#[test]
fn forward_pullback_is_the_transposed_derivative() {
    let mut checked = 0;
    each_case(|name, model, set, RandomState { q, v, tau, .. }, random| {
        let (w, options) = (&mut Workspace::new(model), options(random));
        let Ok(by) = constrained_forward_dynamics_derivatives(model, w, set, &options, q, v, tau) else {
            return;
        };
        let (a, lambda) = (random_vector(random, model.nv()), random_vector(random, set.len()));
        let inputs = ConstrainedPullbackInputs {
            q,
            v,
            tau,
            acceleration: a.as_slice(),
            multipliers: lambda.as_slice(),
        };
        let pulled =
            constrained_forward_dynamics_pullback(model, w, set, &options, inputs).expect("a gradient");
        assert_eq!(pulled.motion, by.motion, "{name}");
        for (of, found, over_a, over_lambda) in [
            ("q", &pulled.by_position, &by.acceleration_by_position, &by.multipliers_by_position),
            ("v", &pulled.by_velocity, &by.acceleration_by_velocity, &by.multipliers_by_velocity),
            ("τ", &pulled.by_force, &by.acceleration_by_force, &by.multipliers_by_force),
        ] {
            let expected = over_a.tr_mul(&a) + over_lambda.tr_mul(&lambda);
            let scale = 1.0 + largest(over_a) + largest(over_lambda);
            // Rounding of the products, where Λ is nearly singular.
            assert!((found - &expected).amax() < 1e-9 * scale, "{name} by {of}: {found}{expected}");
        }
        checked += 1;
    });
    assert!(checked > 60, "{checked} cases");
}

/// The gradient by the inertial parameters, along a random direction.
#[test]
fn forward_pullback_by_parameters_is_the_limit_of_differences() {
    for seed in 0..6 {
        let model = Model::new(random_robot(seed, &RandomRobotOptions::default())).expect("a valid robot");
        let mut random = SplitMix64::new(seed);
        let (_, set) = sets(&model, &mut random).swap_remove(7);
        let RandomState { q, v, tau, .. } = random_state(&model, &mut random);
        let options = ConstraintOptions::default();
        let (a, lambda) = (random_vector(&mut random, model.nv()), random_vector(&mut random, set.len()));
        let inputs = ConstrainedPullbackInputs {
            q: &q,
            v: &v,
            tau: &tau,
            acceleration: a.as_slice(),
            multipliers: lambda.as_slice(),
        };
        let w = &mut Workspace::new(&model);
        let Ok(pulled) = constrained_forward_dynamics_pullback(&model, w, &set, &options, inputs) else {
            continue;
        };
        let values = parameter_values(&model);
        // The last three parameters are gravity; the first ten belong to a link.
        for k in [0, 1, 4, values.len() - 1, values.len() - 2] {
            let loss = |h: f64| {
                let changed = with_parameters(&model, &shifted(&values, k, h)).expect("a valid robot");
                let changed = Model::new(changed).expect("a valid robot");
                let mut random = SplitMix64::new(seed);
                let (_, set) = sets(&changed, &mut random).swap_remove(7);
                let w = &mut Workspace::new(&changed);
                let motion = constrained_forward_dynamics(&changed, w, &set, &options, &q, &v, &tau)
                    .expect("a motion");
                motion.acceleration.dot(&a) + motion.multipliers.dot(&lambda)
            };
            let h = 1e-5;
            let slope = (loss(h) - loss(-h)) / (2.0 * h);
            let found = pulled.parameters[k];
            // The error of a central difference is h² = 1e-10 of the third derivative, and ε/h of the value.
            assert!((found - slope).abs() < 1e-6 * (1.0 + slope.abs()), "{seed}, {k}: {found}, {slope}");
        }
    }
}

/// ∂τ and ∂λ by q, v and a, and their pullback, with random motors.
#[test]
fn inverse_derivatives_are_limits_of_differences() {
    let mut checked = 0;
    each_case(|name, model, set, RandomState { q, v, a, .. }, random| {
        let (w, nv) = (&mut Workspace::new(model), model.nv());
        let actuated: Vec<bool> = (0..nv).map(|_| random.uniform(0.0, 1.0) < 0.6).collect();
        let by =
            constrained_inverse_dynamics_derivatives(model, w, set, q, v, a, &actuated).expect("a result");
        let mut at = |q: &[f64], v: &[f64], a: &[f64]| {
            let torque = constrained_inverse_dynamics(model, w, set, q, v, a, &actuated).expect("a torque");
            DVector::from_iterator(nv + set.len(), torque.tau.iter().chain(&torque.multipliers).copied())
        };
        let by_position = differences(nv, |k, h| at(&moved(model, q, k, h), v, a));
        let by_velocity = differences(nv, |k, h| at(q, &shifted(v, k, h), a));
        let by_acceleration = differences(nv, |k, h| at(q, v, &shifted(a, k, h)));
        let (weights, over) = (random_vector(random, nv), random_vector(random, set.len()));
        let inputs = ConstrainedTorquePullbackInputs {
            q,
            v,
            a,
            actuated: &actuated,
            tau: weights.as_slice(),
            multipliers: over.as_slice(),
        };
        let pulled = constrained_inverse_dynamics_pullback(model, w, set, inputs).expect("a gradient");
        for (of, expected, tau, lambda, gradient) in [
            ("q", by_position, &by.tau_by_position, &by.multipliers_by_position, &pulled.by_position),
            ("v", by_velocity, &by.tau_by_velocity, &by.multipliers_by_velocity, &pulled.by_velocity),
            (
                "a",
                by_acceleration,
                &by.tau_by_acceleration,
                &by.multipliers_by_acceleration,
                &pulled.by_acceleration,
            ),
        ] {
            assert_close(&format!("{name}: ∂τ/∂{of}"), tau, &expected.rows(0, nv).into_owned());
            assert_close(&format!("{name}: ∂λ/∂{of}"), lambda, &expected.rows(nv, set.len()).into_owned());
            let expected = tau.tr_mul(&weights) + lambda.tr_mul(&over);
            let scale = 1.0 + largest(tau) + largest(lambda);
            assert!((gradient - &expected).amax() < 1e-9 * scale, "{name} by {of}: {gradient}{expected}");
        }
        checked += 1;
    });
    assert!(checked > 60, "{checked} cases");
}

/// ∂v⁺ and ∂ι by q, v⁻ and e, and their pullback.
#[test]
fn impulse_derivatives_are_limits_of_differences() {
    each_case(|name, model, set, RandomState { q, v, .. }, random| {
        let (w, nv, options) = (&mut Workspace::new(model), model.nv(), ConstraintOptions::default());
        let by = contact_impulse_derivatives(model, w, set, &options, q, v, 0.4).expect("an impact");
        let mut at = |q: &[f64], v: &[f64], e: f64| {
            let hit = contact_impulse(model, w, set, &options, q, v, e).expect("an impact");
            DVector::from_iterator(nv + set.len(), hit.velocity.iter().chain(&hit.impulse).copied())
        };
        let by_position = differences(nv, |k, h| at(&moved(model, q, k, h), v, 0.4));
        let by_velocity = differences(nv, |k, h| at(q, &shifted(v, k, h), 0.4));
        let by_restitution = differences(1, |_, h| at(q, v, 0.4 + h));
        let column = |x: &DVector<f64>| DMatrix::from_column_slice(x.len(), 1, x.as_slice());
        let (weights, over) = (random_vector(random, nv), random_vector(random, set.len()));
        let inputs = ImpulsePullbackInputs {
            q,
            v,
            restitution: 0.4,
            velocity: weights.as_slice(),
            impulse: over.as_slice(),
        };
        let pulled = contact_impulse_pullback(model, w, set, &options, inputs).expect("a gradient");
        let gradient_by_restitution = DVector::from_element(1, pulled.by_restitution);
        for (of, expected, velocity, impulse, gradient) in [
            ("q", by_position, by.velocity_by_position, by.impulse_by_position, &pulled.by_position),
            ("v", by_velocity, by.velocity_by_velocity, by.impulse_by_velocity, &pulled.by_velocity),
            (
                "e",
                by_restitution,
                column(&by.velocity_by_restitution),
                column(&by.impulse_by_restitution),
                &gradient_by_restitution,
            ),
        ] {
            assert_close(&format!("{name}: ∂v⁺/∂{of}"), &velocity, &expected.rows(0, nv).into_owned());
            assert_close(&format!("{name}: ∂ι/∂{of}"), &impulse, &expected.rows(nv, set.len()).into_owned());
            let expected = velocity.tr_mul(&weights) + impulse.tr_mul(&over);
            let scale = 1.0 + largest(&velocity) + largest(&impulse);
            assert!((gradient - &expected).amax() < 1e-9 * scale, "{name} by {of}: {gradient}{expected}");
        }
    });
}

/// A planar loop closed in space: three of the five rows of a hinge are 0 or depend on the others, and the
/// derivatives are those of the two rows of the plane.
#[test]
fn redundant_rows_of_a_planar_loop_change_no_derivative() {
    let model = linkage().expect("a linkage");
    let [coupler, rocker] = ["coupler_end", "rocker_end"].map(|name| model.frame(name).expect("a frame"));
    let loops: Vec<robot_dynamics::constraints::LoopClosure> = serde_json::from_str(PIN).expect("a pin");
    let plane = ConstraintSet::from_loops(&model, &loops).expect("a set");
    let hinge = FrameConstraint::between(coupler, rocker, &FrameConstraint::HINGE);
    let space = ConstraintSet::new(&model, [("hinge", hinge.into())]).expect("a set");
    let (q, v) = start(&model, &plane).expect("a start");
    let tau = [0.3, -0.2, 0.5];
    let of = |set: &ConstraintSet, options: &ConstraintOptions| {
        let w = &mut Workspace::new(&model);
        constrained_forward_dynamics_derivatives(&model, w, set, options, &q, &v, &tau).expect("a motion")
    };
    let expected = of(&plane, &ConstraintOptions::default());
    for redundant in [RedundantRows::Drop, RedundantRows::Proximal { damping: 1e-6 }] {
        let found = of(&space, &ConstraintOptions { redundant, ..ConstraintOptions::default() });
        assert_eq!((found.motion.rank, found.motion.dependent.len()), (2, 3));
        // A few hundred roundings of numbers of order 100.
        for (found, expected) in [
            (&found.acceleration_by_position, &expected.acceleration_by_position),
            (&found.acceleration_by_velocity, &expected.acceleration_by_velocity),
            (&found.acceleration_by_force, &expected.acceleration_by_force),
        ] {
            assert!(largest(&(found - expected)) < 1e-10 * (1.0 + largest(expected)));
        }
    }
}
