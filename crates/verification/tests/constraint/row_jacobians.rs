//! Rows by the placement and the motion of bodies equal those by Jacobians and bias accelerations of frames.

use nalgebra::{Matrix3, RowDVector, Vector3};
use robot_dynamics::algorithms::{
    ReferenceFrame, frame_bias_acceleration, frame_jacobian, frame_pose, frame_velocity,
};
use robot_dynamics::constraints::{
    Anchor, Constraint, ConstraintSet, Coupling, FrameConstraint, NoSlip, Plane, PolynomialCoupling,
    RollingDisc, RollingRow, SpatialAxis,
};
use robot_dynamics::description::{Pose, RandomRobotOptions, random_robot};
use robot_dynamics::model::{FrameId, Model, Workspace, random_state};
use robot_dynamics::number::SplitMix64;

/// A row of A, its Ȧv, and its φ.
type Row = (RowDVector<f64>, f64, Option<f64>);

/// A frame at a state, in world axes.
struct FrameMotion {
    position: Vector3<f64>,
    rotation: Matrix3<f64>,
    velocity: Vector3<f64>,
    spin: Vector3<f64>,
    acceleration: Vector3<f64>,
    spin_rate: Vector3<f64>,
    jacobian: Vec<f64>,
    nv: usize,
}

impl FrameMotion {
    fn new(model: &Model, q: &[f64], v: &[f64], anchor: &Anchor) -> Self {
        let (nv, zero) = (model.nv(), Vector3::zeros());
        let of_pose = |pose: &Pose| Self {
            position: pose.translation.into(),
            rotation: Matrix3::from_fn(|i, j| pose.rotation[i][j]),
            velocity: zero,
            spin: zero,
            acceleration: zero,
            spin_rate: zero,
            jacobian: vec![0.0; 6 * nv],
            nv,
        };
        let frame = match anchor {
            Anchor::World(pose) => return of_pose(pose),
            Anchor::Frame(frame) => *frame,
        };
        let (w, axes) = (&mut Workspace::new(model), ReferenceFrame::LocalWorldAligned);
        let mut motion = of_pose(&frame_pose(model, w, q, frame));
        frame_jacobian(model, w, q, frame, axes, &mut motion.jacobian);
        let velocity = frame_velocity(model, w, q, v, frame, axes);
        let bias = frame_bias_acceleration(model, w, q, v, frame, axes);
        (motion.velocity, motion.spin) = (velocity.linear.into(), velocity.angular.into());
        (motion.acceleration, motion.spin_rate) = (bias.linear.into(), bias.angular.into());
        motion
    }

    /// The row of v ↦ l·ṗ + n·ω.
    fn row(&self, l: &Vector3<f64>, n: &Vector3<f64>) -> RowDVector<f64> {
        let entry = |k, row: usize| self.jacobian[row * self.nv + k];
        RowDVector::from_fn(self.nv, |_, k| (0..3).map(|i| l[i] * entry(k, i) + n[i] * entry(k, 3 + i)).sum())
    }

    fn axis(&self, k: usize) -> Vector3<f64> {
        self.rotation.column(k).into()
    }
}

/// φ = a_k·d.
fn shift(a: &FrameMotion, b: &FrameMotion, k: usize) -> Row {
    let (e, d, rate) = (a.axis(k), b.position - a.position, b.velocity - a.velocity);
    let row = b.row(&e, &Vector3::zeros()) - a.row(&e, &d.cross(&e));
    let relative = b.acceleration - a.acceleration - a.spin_rate.cross(&d) - a.spin.cross(&rate) * 2.0
        + a.spin.cross(&a.spin.cross(&d));
    (row, e.dot(&relative), Some(e.dot(&d)))
}

/// φ = Σ c aᵢ·bⱼ, by the rates of the axes themselves: ȧ = ω × a and ä = ω̇ × a + ω × (ω × a).
fn turn(a: &FrameMotion, b: &FrameMotion, products: &[(f64, usize, usize)]) -> Row {
    let (mut row, mut bias, mut error) = (RowDVector::zeros(a.nv), 0.0, 0.0);
    for &(c, i, j) in products {
        let (alpha, beta, zero) = (a.axis(i), b.axis(j), Vector3::zeros());
        let rates = |side: &FrameMotion, axis: &Vector3<f64>| {
            let rate = side.spin.cross(axis);
            (rate, side.spin_rate.cross(axis) + side.spin.cross(&rate))
        };
        let ((alpha_rate, alpha_second), (beta_rate, beta_second)) = (rates(a, &alpha), rates(b, &beta));
        row += (a.row(&zero, &alpha.cross(&beta)) + b.row(&zero, &beta.cross(&alpha))) * c;
        bias += c * (alpha_second.dot(&beta) + 2.0 * alpha_rate.dot(&beta_rate) + alpha.dot(&beta_second));
        error += c * alpha.dot(&beta);
    }
    (row, bias, Some(error))
}

/// The rows of [`FrameConstraint`]'s table.
fn frame_rows(model: &Model, q: &[f64], v: &[f64], constraint: &FrameConstraint) -> Vec<Row> {
    let [a, b] = [&constraint.a, &constraint.b].map(|anchor| FrameMotion::new(model, q, v, anchor));
    let turns: Vec<usize> =
        constraint.rows.iter().filter(|row| row.is_turn()).map(|row| *row as usize - 3).collect();
    let row = |row: &SpatialAxis| {
        if !row.is_turn() {
            return shift(&a, &b, *row as usize);
        }
        let (k, next, last) = (*row as usize - 3, (*row as usize - 2) % 3, (*row as usize - 1) % 3);
        let products = match (turns.len(), (0..3).find(|m| !turns.contains(m))) {
            (2, Some(m)) if k == (m + 1) % 3 => vec![(-1.0, (m + 2) % 3, m)],
            (2, Some(m)) => vec![(1.0, (m + 1) % 3, m)],
            (1, _) => vec![(-1.0, next, last)],
            _ => vec![(0.5, last, next), (-0.5, next, last)],
        };
        turn(&a, &b, &products)
    };
    constraint.rows.iter().map(row).collect()
}

/// Rows of the Jacobian in the frame's own axes.
fn slip_rows(model: &Model, q: &[f64], v: &[f64], constraint: &NoSlip) -> Vec<Row> {
    let (w, nv) = (&mut Workspace::new(model), model.nv());
    let mut jacobian = vec![0.0; 6 * nv];
    frame_jacobian(model, w, q, constraint.frame, ReferenceFrame::Local, &mut jacobian);
    let bias = frame_bias_acceleration(model, w, q, v, constraint.frame, ReferenceFrame::Local);
    let bias = [bias.linear, bias.angular].concat();
    let row = |row: &SpatialAxis| {
        let k = *row as usize;
        (RowDVector::from_row_slice(&jacobian[k * nv..][..nv]), bias[k], None)
    };
    constraint.rows.iter().map(row).collect()
}

/// The axes d of the rows and the point p − r u, each with its rate by a central difference along the motion
/// of the frame.
fn rolling_rows(
    model: &Model,
    q: &[f64],
    v: &[f64],
    disc: &RollingDisc,
    n: Vector3<f64>,
    offset: f64,
) -> Vec<Row> {
    let motion = FrameMotion::new(model, q, v, &Anchor::Frame(disc.frame));
    let axle = motion.rotation * Vector3::from(disc.axle).normalize();
    // [u, h, n × h] and |w| for this axle.
    let directions = |s: &Vector3<f64>| {
        let w = n - s * n.dot(s);
        let h = s.cross(&n).normalize();
        ([w.normalize(), h, n.cross(&h)], w.norm())
    };
    let ([u, h, side], length) = directions(&axle);
    let t = 1e-5;
    let axle_rate = motion.spin.cross(&axle);
    let [(ahead, _), (behind, _)] = [t, -t].map(|t| directions(&(axle + axle_rate * t)));
    let rate = |k: usize| (ahead[k] - behind[k]) / (2.0 * t);
    let velocity = motion.velocity - motion.spin.cross(&u) * disc.radius;
    let acceleration =
        motion.acceleration - (motion.spin_rate.cross(&u) + motion.spin.cross(&rate(0))) * disc.radius;
    let row = |row: &RollingRow| {
        let (d, d_rate, error) = match row {
            RollingRow::Forward => (h, rate(1), None),
            RollingRow::Side => (side, rate(2), None),
            RollingRow::Normal => {
                (n, Vector3::zeros(), Some(n.dot(&motion.position) - disc.radius * length - offset))
            }
        };
        (motion.row(&d, &(d.cross(&u) * disc.radius)), d.dot(&acceleration) + d_rate.dot(&velocity), error)
    };
    disc.rows.iter().map(row).collect()
}

/// Every kind of constraint between links, on trees with ball, floating and mimic joints.
#[test]
fn rows_by_bodies_equal_rows_by_jacobians() {
    for seed in 0..40 {
        let model = Model::new(random_robot(seed, &RandomRobotOptions::default())).expect("a valid robot");
        let mut random = SplitMix64::new(seed);
        let links: Vec<FrameId> =
            model.links().iter().map(|link| model.frame(&link.name).expect("a link")).collect();
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // below the number of links
        let [a, b, c, d, e] =
            core::array::from_fn(|_| links[random.uniform(0.0, links.len() as f64 - 1e-9) as usize]);
        let place = Pose::from_xyz_rpy([0.1, -0.2, 0.3], [0.4, 0.5, -0.6]);
        let normal = Vector3::new(0.1, 0.2, 1.0);
        let rolls = RollingDisc {
            frame: e,
            axle: [0.3, 2.0, -0.5],
            radius: 0.3,
            plane: Plane::new(normal.into(), [0.0, 0.0, 0.4]),
            rows: vec![RollingRow::Normal, RollingRow::Forward, RollingRow::Side],
        };
        let normal = normal.normalize();
        let universal = [SpatialAxis::Y, SpatialAxis::Rz];
        let slide = [SpatialAxis::Rz, SpatialAxis::Rx, SpatialAxis::Z];
        let all: Vec<(&str, Constraint)> = vec![
            ("weld", FrameConstraint::between(a, b, &FrameConstraint::WELD).into()),
            ("hinge", FrameConstraint::between(c, a, &FrameConstraint::HINGE).into()),
            ("universal", FrameConstraint::between(b, d, &universal).into()),
            ("slide", FrameConstraint::between(d, e, &slide).into()),
            ("held", FrameConstraint::contact(c, place, &FrameConstraint::WELD).into()),
            (
                "slips",
                NoSlip { frame: d, rows: vec![SpatialAxis::Y, SpatialAxis::Rx, SpatialAxis::Z] }.into(),
            ),
            ("rolls", rolls.into()),
        ];
        let set = ConstraintSet::new(&model, all.clone()).expect("a valid set");
        for _ in 0..3 {
            let state = random_state(&model, &mut random);
            let (q, v) = (&state.q[..], &state.v[..]);
            let rows = set.rows(&model, &mut Workspace::new(&model), q, v);
            let expected = all.iter().flat_map(|(_, constraint)| match constraint {
                Constraint::FrameConstraint(joined) => frame_rows(&model, q, v, joined),
                Constraint::NoSlip(no_slip) => slip_rows(&model, q, v, no_slip),
                Constraint::RollingDisc(disc) => {
                    rolling_rows(&model, q, v, disc, normal, normal.dot(&Vector3::new(0.0, 0.0, 0.4)))
                }
                _ => unreachable!("only constraints between frames"),
            });
            let mut count = 0;
            let speed = v.iter().map(|v| v.abs()).fold(1.0, f64::max);
            for (i, (row, bias, error)) in expected.enumerate() {
                let name = &set.row_names()[i];
                count += 1;
                let scale = 1.0 + row.amax();
                let off = (row - rows.matrix.row(i)).amax();
                assert!(off < 1e-12 * scale, "robot {seed}, {name}: A is off by {off}");
                assert_eq!(error.is_some(), rows.holonomic[i], "{name}");
                let off = (error.unwrap_or(0.0) - rows.position_error[i]).abs();
                assert!(off < 1e-12 * scale, "robot {seed}, {name}: φ is off by {off}");
                // The rates of a disc's axes are differences, with errors of t² and ε/t.
                let digits = if name.starts_with("rolls") { 1e-8 } else { 1e-12 };
                let allowed = digits * (scale * speed + bias.abs() + 1.0) * speed * model.nv() as f64;
                let off = (bias - rows.bias[i]).abs();
                assert!(off < allowed, "robot {seed}, {name}: Ȧv = {bias} is off by {off}");
            }
            assert_eq!(count, set.len());
        }
    }
}

/// Couplings of coordinates are read off their definition: Σ cᵢvᵢ, and ẏ − p′(x)ẋ with Ȧv = −p″(x)ẋ².
#[test]
fn rows_of_couplings_are_their_definition() {
    for seed in 0..40 {
        let model = Model::new(random_robot(seed, &RandomRobotOptions::default())).expect("a valid robot");
        let names = model.coordinate_names();
        let single: Vec<_> = model.joints().iter().filter(|joint| joint.nv == 1).collect();
        let (Some(first), Some(last)) = (single.first(), single.last()) else { continue };
        let terms = [(names[0].as_str(), 0.7), (names[names.len() - 1].as_str(), -1.3)];
        let cam = PolynomialCoupling::new(
            &model,
            (&last.name, 0.3),
            Some((&first.name, -0.1)),
            [0.3, -0.7, 0.2, 0.1, -0.4],
        );
        let set = ConstraintSet::new(
            &model,
            [
                ("sum", Coupling::new(&model, &terms, 0.2).expect("coordinates").into()),
                ("cam", Constraint::from(cam.expect("joints"))),
            ],
        )
        .expect("a valid set");
        let state = random_state(&model, &mut SplitMix64::new(seed));
        let rows = set.rows(&model, &mut Workspace::new(&model), &state.q, &state.v);
        let mut sum = RowDVector::<f64>::zeros(model.nv());
        sum[0] += 0.7;
        sum[names.len() - 1] -= 1.3;
        assert_eq!((rows.matrix.row(0).into_owned(), rows.bias[0]), (sum, 0.0), "robot {seed}");

        let (x, rate) = (state.q[first.q().start] + 0.1, state.v[first.v().start]);
        let p = 0.3 - 0.7 * x + 0.2 * x.powi(2) + 0.1 * x.powi(3) - 0.4 * x.powi(4);
        let slope = -0.7 + 0.4 * x + 0.3 * x.powi(2) - 1.6 * x.powi(3);
        let curvature = 0.4 + 0.6 * x - 4.8 * x.powi(2);
        let mut cam = RowDVector::<f64>::zeros(model.nv());
        cam[last.v().start] += 1.0;
        cam[first.v().start] -= slope;
        let scale = 1e-13 * (1.0 + x.abs()).powi(4) * (1.0 + rate.powi(2));
        assert!((cam - rows.matrix.row(1)).amax() < scale, "robot {seed}");
        assert!((rows.bias[1] + curvature * rate.powi(2)).abs() < scale, "robot {seed}");
        let error = state.q[last.q().start] - 0.3 - p;
        assert!((rows.position_error[1] - error).abs() < scale, "robot {seed}");
    }
}
