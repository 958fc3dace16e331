//! Inverse dynamics on unilateral supports: forces against their laws and against another method.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use robot_dynamics::algorithms::{
    ReferenceFrame, forward_dynamics, frame_jacobian, frame_pose, inverse_dynamics,
};
use robot_dynamics::constraints::{
    ConstraintError, ConstraintSet, ContactSupport, FrameConstraint, SupportProblem, SupportedTorque,
    constrained_inverse_dynamics, supported_inverse_dynamics,
};
use robot_dynamics::description::{
    Base, FrameDescription, LinkDescription, MassProperties, Pose, RandomRobotOptions, RobotDescription,
    random_robot,
};
use robot_dynamics::model::{Model, Workspace, neutral};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::{InputProblem, InvalidInput};

const G: f64 = 9.81;

const FEET: [(f64, f64); 4] = [(0.4, 0.4), (-0.4, 0.4), (-0.4, -0.4), (0.4, -0.4)];

/// A plate of 1 kg with its center of mass at (x, 0, 0), on four feet at (±0.4, ±0.4, −0.5).
fn table(x: f64, friction: f64) -> (Model, Vec<ContactSupport>) {
    let mut robot = RobotDescription::new("table");
    robot.base = Base::Floating;
    let mass = MassProperties::new(1.0, Vector3::new(x, 0.0, 0.0), Matrix3::identity() * 0.1).unwrap();
    robot.links.push(LinkDescription::new("top", mass));
    for (k, (x, y)) in FEET.into_iter().enumerate() {
        let at = Pose::from_translation([x, y, -0.5]);
        robot.frames.push(FrameDescription::new(format!("foot {k}"), "top", at));
    }
    let model = Model::new(robot).unwrap();
    let foot = |(x, y)| {
        ContactSupport::new(model.frame_named("top").unwrap(), [x, y, -0.5], [0.0, 0.0, 1.0], friction)
    };
    let feet = FEET.into_iter().map(foot).collect();
    (model, feet)
}

fn stands(model: &Model, feet: &[ContactSupport], a: &[f64; 6]) -> SupportedTorque {
    let (q, rest) = (neutral(model), [0.0; 6]);
    let supports = SupportProblem::new(feet);
    supported_inverse_dynamics(model, &mut Workspace::new(model), &supports, &q, &rest, a, &[false; 6])
        .unwrap()
}

/// The feet share the weight by their levers, and none pulls; with the mass beyond the last foot the table
/// tips.
#[test]
fn table_stands_while_mass_is_above_feet() {
    for x in [0.0, 0.1, 0.39, 0.4] {
        let (model, feet) = table(x, 0.5);
        let found = stands(&model, &feet, &[0.0; 6]);
        assert!(found.missing.amax() < 1e-10, "{x}: {}", found.missing);
        for (foot, force) in feet.iter().zip(&found.forces) {
            let expected = 0.25 * G * (1.0 + x * foot.point[0] / 0.16);
            assert!((force[2] - expected).abs() < 1e-9, "{x}: {force:?}, {expected}");
        }
    }
    // The moment beyond the feet is missing, up to what a stronger sideways push holds: the nearest forces.
    let (model, feet) = table(0.6, 0.5);
    let found = stands(&model, &feet, &[0.0; 6]);
    assert!(found.missing.amax() > 0.1);
    assert!(found.forces.iter().all(|force| force[2] >= 0.0));
    // With contacts that may pull, the same table stands.
    let ball = |k: usize| {
        let frame = model.frame_named(&format!("foot {k}")).unwrap();
        (format!("foot {k}"), FrameConstraint::point_contact(frame, feet[k].point).into())
    };
    let set = ConstraintSet::new(&model, (0..4).map(ball)).unwrap();
    let (q, rest) = (neutral(&model), [0.0; 6]);
    let w = &mut Workspace::new(&model);
    let pulled = constrained_inverse_dynamics(&model, w, &set, &q, &rest, &rest, &[false; 6]).unwrap();
    assert!(pulled.residual < 1e-10 && (0..4).any(|k| pulled.multipliers[3 * k + 2] < -0.1));
}

/// The sideways acceleration is at most μ g.
#[test]
fn friction_bounds_the_acceleration() {
    for (pull, carried) in [(0.4, true), (0.499, true), (0.501, false), (3.0, false)] {
        // The height of the mass equals the distance of the feet: below 0.5 g no foot lifts.
        let (model, feet) = table(0.0, 0.5);
        let found = stands(&model, &feet, &[pull * G, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(found.missing.amax() < 1e-9, carried, "{pull}: {}", found.missing);
    }
}

/// Robots with a free base.
fn floating() -> RandomRobotOptions {
    RandomRobotOptions { base: Base::Floating, ..RandomRobotOptions::default() }
}

/// J of the point of a support in world axes, 3×nv, at q.
fn jacobian(model: &Model, q: &[f64], support: &ContactSupport) -> DMatrix<f64> {
    let (w, nv) = (&mut Workspace::new(model), model.nv());
    let mut rows = vec![0.0; 6 * nv];
    frame_jacobian(model, w, q, support.frame, ReferenceFrame::LocalWorldAligned, &mut rows);
    let pose = frame_pose(model, w, q, support.frame);
    let turn = Matrix3::from_fn(|i, j| pose.rotation[i][j]);
    let lever = (turn * Vector3::from(support.point)).cross_matrix();
    let all = DMatrix::from_row_slice(6, nv, &rows);
    all.rows(0, 3) - DMatrix::from_column_slice(3, 3, lever.as_slice()) * all.rows(3, 3)
}

/// The point of the friction cone nearest to a force whose first component is along the normal.
fn project(friction: f64, force: Vector3<f64>) -> Vector3<f64> {
    let side = force.y.hypot(force.z);
    if side <= friction * force.x {
        return force;
    }
    if friction * side <= -force.x {
        return Vector3::zeros();
    }
    let normal = (force.x + friction * side) / (1.0 + friction * friction);
    let scale = if side > 0.0 { friction * normal / side } else { 0.0 };
    Vector3::new(normal, scale * force.y, scale * force.z)
}

/// The same minimum by the alternating direction method: equations by elimination, cones by projection;
/// `None` if it does not converge.
fn by_alternating(
    h: &DMatrix<f64>,
    g: &DVector<f64>,
    b: &DMatrix<f64>,
    f: &DVector<f64>,
    frictions: &[f64],
) -> Option<DVector<f64>> {
    let (n, m) = (g.len(), f.len());
    let penalty = 0.1 * h.trace() / n as f64;
    let mut kkt = DMatrix::zeros(n + m, n + m);
    kkt.view_mut((0, 0), (n, n)).copy_from(&(h + DMatrix::identity(n, n) * penalty));
    kkt.view_mut((n, 0), (m, n)).copy_from(b);
    kkt.view_mut((0, n), (n, m)).copy_from(&b.transpose());
    // The equations of joints without a support are dependent.
    let solver = kkt.pseudo_inverse(1e-10).unwrap();
    let (mut z, mut u) = (DVector::zeros(n), DVector::zeros(n));
    for _ in 0..200_000 {
        let mut right = DVector::zeros(n + m);
        right.rows_mut(0, n).copy_from(&((&z - &u) * penalty - g));
        right.rows_mut(n, m).copy_from(f);
        let x: DVector<f64> = (&solver * right).rows(0, n).into_owned();
        let before = z.clone();
        for (k, friction) in frictions.iter().enumerate() {
            let to = Vector3::from_fn(|i, _| x[3 * k + i] + u[3 * k + i]);
            z.fixed_rows_mut::<3>(3 * k).copy_from(&project(*friction, to));
        }
        u += &x - &z;
        if (&x - &z).amax() < 1e-12 * x.amax() && (&z - before).amax() < 1e-12 * x.amax() {
            return Some(z);
        }
    }
    None
}

/// Random robots moved by random forces in the cones and motor torques. The solution is in the cones and
/// costs no more than these forces, and a second method finds the same minimum.
#[test]
fn random_robots_are_carried_by_least_forces() {
    let (mut on_a_border, mut compared) = (0, 0);
    for case in 0..40_usize {
        let seed = case as u64;
        let mut random = SplitMix64::new(seed);
        let model = Model::new(random_robot(seed, &floating())).unwrap();
        let (nv, w) = (model.nv(), &mut Workspace::new(&model));
        let mut numbers =
            |n: usize, size: f64| -> Vec<f64> { (0..n).map(|_| random.uniform(-size, size)).collect() };
        let mut q = neutral(&model);
        robot_dynamics::model::integrate(&model, &neutral(&model), &numbers(nv, 1.0), &mut q);
        let v = numbers(nv, 1.0);
        let links: Vec<_> = model.description().links.iter().map(|link| link.name.clone()).collect();
        let supports: Vec<ContactSupport> = (0..3 + case % 4)
            .map(|k| {
                let frame = model.frame_named(&links[(7 * k + case) % links.len()]).unwrap();
                let (point, tilt) = (numbers(3, 0.3), numbers(3, 0.5));
                let normal = [tilt[0], tilt[1], 2.0 + tilt[2]];
                ContactSupport::new(frame, [point[0], point[1], point[2]], normal, 0.3 + tilt[0].abs())
            })
            .collect();
        let actuated: Vec<bool> = (0..nv).map(|k| k >= 6 && k % 5 != 0).collect();
        // Forces in the cones, motor torques, and the motion that they cause.
        let mut given = DVector::from_vec(numbers(nv, 5.0));
        (0..nv).filter(|k| !actuated[*k]).for_each(|k| given[k] = 0.0);
        let mut total = given.clone();
        let (mut columns, mut pushed) = (Vec::new(), Vec::new());
        for support in &supports {
            let n = Vector3::from(support.normal).normalize();
            let s = n.cross(&Vector3::x()).normalize();
            let basis = Matrix3::from_columns(&[n, s, n.cross(&s)]);
            let raw = numbers(3, 20.0);
            let p = project(support.friction, Vector3::new(raw[0].abs(), raw[1], raw[2]));
            let rows = basis.transpose() * jacobian(&model, &q, support);
            total += rows.tr_mul(&p);
            columns.push(rows);
            pushed.push(p);
        }
        let mut a = vec![0.0; nv];
        forward_dynamics(&model, w, &q, &v, total.as_slice(), &mut a);

        let weight = [1e-3, 1.0][case % 2];
        let problem = SupportProblem::new(&supports).with_force_weight(weight);
        let found = supported_inverse_dynamics(&model, w, &problem, &q, &v, &a, &actuated).unwrap();
        let scale = total.amax();
        assert!(found.missing.amax() < 1e-9 * scale, "seed {seed}: {}", found.missing.amax());

        // In the cones; their sum is the force that the motion needs.
        let mut needed = vec![0.0; nv];
        inverse_dynamics(&model, w, &q, &v, &a, &mut needed);
        let mut sum = found.tau.clone();
        let mut own = DVector::zeros(3 * supports.len());
        for (k, (support, force)) in supports.iter().zip(&found.forces).enumerate() {
            let n = Vector3::from(support.normal).normalize();
            let force = Vector3::from(*force);
            let normal = n.dot(&force);
            let side = (force - n * normal).norm();
            assert!(normal >= 0.0 && side <= support.friction * normal * (1.0 + 1e-9) + 1e-9, "seed {seed}");
            on_a_border += usize::from(side > support.friction * normal * (1.0 - 1e-6));
            sum += jacobian(&model, &q, support).tr_mul(&force);
            let s = n.cross(&Vector3::x()).normalize();
            own.fixed_rows_mut::<3>(3 * k).copy_from(&Vector3::new(
                normal,
                s.dot(&force),
                n.cross(&s).dot(&force),
            ));
        }
        assert!((&sum - DVector::from_vec(needed.clone())).amax() < 1e-9 * scale, "seed {seed}");
        assert!((0..nv).all(|k| actuated[k] || found.tau[k] == 0.0));

        // No more expensive than the forces that caused the motion, and the minimum by the second method.
        let cost = |tau: &DVector<f64>, p: &DVector<f64>| tau.norm_squared() + weight * p.norm_squared();
        let given_forces = DVector::from_iterator(own.len(), pushed.iter().flat_map(|p| [p.x, p.y, p.z]));
        assert!(cost(&found.tau, &own) <= cost(&given, &given_forces) * (1.0 + 1e-9), "seed {seed}");
        let all = DMatrix::from_fn(own.len(), nv, |i, j| columns[i / 3][(i % 3, j)]);
        let pick = |motors: bool| -> Vec<usize> { (0..nv).filter(|&k| actuated[k] == motors).collect() };
        let (driven, free) = (all.select_columns(&pick(true)), all.select_columns(&pick(false)));
        let needed = DVector::from_vec(needed);
        let (f_driven, f_free) = (needed.select_rows(&pick(true)), needed.select_rows(&pick(false)));
        let h = &driven * driven.transpose() + DMatrix::identity(own.len(), own.len()) * weight;
        let frictions: Vec<f64> = supports.iter().map(|support| support.friction).collect();
        let other = by_alternating(&h, &-(&driven * &f_driven), &free.transpose(), &f_free, &frictions);
        let Some(other) = other else { continue };
        compared += 1;
        let off = (&other - &own).amax();
        assert!(off < 1e-5 * scale, "seed {seed}: {off}, of {scale}");
    }
    // The cones must be active in some cases.
    assert!(compared >= 36, "{compared} of 40 compared");
    assert!(on_a_border > 20, "{on_a_border} on the border of their cone");
}

/// Closed loops transmit forces in addition to supports.
#[test]
fn loops_hold_with_supports() {
    let model = Model::new(random_robot(3, &floating())).unwrap();
    let (nv, w, q) = (model.nv(), &mut Workspace::new(&model), neutral(&model));
    let frame = |name: &str| model.frame_named(name).unwrap();
    let set = ConstraintSet::new(
        &model,
        [("pin", FrameConstraint::between(frame("link4"), frame("link9"), &FrameConstraint::BALL).into())],
    )
    .unwrap();
    let foot =
        |name: &str, x: f64, y: f64| ContactSupport::new(frame(name), [x, y, 0.0], [0.0, 0.0, 1.0], 0.7);
    let feet = [
        foot("link1", 0.5, 0.5),
        foot("link2", -0.5, 0.5),
        foot("link3", -0.5, -0.5),
        foot("link1", 0.5, -0.5),
    ];
    let actuated: Vec<bool> = (0..nv).map(|k| k >= 6).collect();
    let rest = vec![0.0; nv];
    let alone = SupportProblem::new(&feet);
    let both = alone.with_constraints(&set);
    let solve = |w: &mut Workspace, supports: &SupportProblem<'_>| {
        supported_inverse_dynamics(&model, w, supports, &q, &rest, &rest, &actuated).unwrap()
    };
    let (without, with) = (solve(w, &alone), solve(w, &both));
    let mut sum =
        with.tau.clone() + set.rows(&model, w, &q, &rest).matrix.tr_mul(&with.multipliers) + &with.missing;
    for (foot, force) in feet.iter().zip(&with.forces) {
        sum += jacobian(&model, &q, foot).tr_mul(&Vector3::from(*force));
    }
    let mut needed = vec![0.0; nv];
    inverse_dynamics(&model, w, &q, &rest, &rest, &mut needed);
    assert!((sum - DVector::from_vec(needed)).amax() < 1e-8);
    // Additional constraints never need more torque, except for the cost of their own force.
    assert!(with.multipliers.amax() > 1e-3 && with.tau.norm() < without.tau.norm() * (1.0 + 1e-6));
}

#[test]
fn invalid_supports_are_errors() {
    let (model, feet) = table(0.0, 0.5);
    let (q, rest) = (neutral(&model), [0.0; 6]);
    let refused = |change: &dyn Fn(&mut ContactSupport), weight: f64| {
        let mut feet = feet.clone();
        change(&mut feet[2]);
        let supports = SupportProblem::new(&feet).with_force_weight(weight);
        let w = &mut Workspace::new(&model);
        supported_inverse_dynamics(&model, w, &supports, &q, &rest, &rest, &[false; 6]).unwrap_err()
    };
    let spoils: [&dyn Fn(&mut ContactSupport); 3] =
        [&|foot| foot.normal = [0.0; 3], &|foot| foot.point[1] = f64::NAN, &|foot| foot.friction = -1.0];
    for spoil in spoils {
        let error = refused(spoil, 1.0);
        assert!(
            matches!(&error, ConstraintError::Input(input) if input.quantity.starts_with("support 2: its ")),
            "{error}"
        );
    }
    let weight = InvalidInput::out_of_range("the weight of the forces", 0.0, "m²", "positive and finite");
    assert_eq!(refused(&|_| {}, 0.0), ConstraintError::Input(weight));
    let supports = SupportProblem::new(&feet);
    let w = &mut Workspace::new(&model);
    let nowhere = [f64::NAN, 0.0, 0.0, 0.0, 0.0, 0.0];
    let error =
        supported_inverse_dynamics(&model, w, &supports, &q, &nowhere, &rest, &[false; 6]).unwrap_err();
    let ConstraintError::Input(error) = error else { panic!("{error}") };
    assert_eq!(error.quantity, "v");
    assert!(matches!(error.problem, InputProblem::NotFinite { index: Some(0), .. }), "{error}");
}
