//! The conditions of Karush, Kuhn and Tucker, from rows that the test computes by inverse dynamics and
//! differences of linear functions.

use nalgebra::{DMatrix, DVector};
use robot_dynamics::algorithms::{
    ReferenceFrame, center_of_mass, center_of_mass_velocity, centroidal_momentum, centroidal_momentum_rate,
    frame_acceleration, frame_pose, frame_velocity,
};
use robot_dynamics::control::whole_body::{ALL_AXES, Limit, Objective, PdGains};
use robot_dynamics::control::{PoseReference, TaskReference};
use robot_dynamics::description::Pose;
use robot_dynamics::model::{FrameId, Model, Workspace, difference};

use super::*;

/// One state with its references; functions of x = (q̈, forces along the world's axes).
struct Case<'a> {
    model: &'a Model,
    q: Vec<f64>,
    v: Vec<f64>,
    feet: Vec<FrameId>,
    home: Vec<f64>,
    trunk: FrameId,
    friction: f64,
}

const GAINS: PdGains = PdGains { stiffness: 80.0, damping: 15.0 };
const POINT: [f64; 3] = [0.03, -0.02, 0.33];
const TWIST: [f64; 6] = [0.2, 0.0, -0.1, 0.3, 0.1, 0.0];
const WEIGHTS: [f64; 6] = [10.0, 5.0, 0.1, 2.0, 1e-4, 1e-3];
/// The rate of the limits and the damping of the contacts.
const RATE: f64 = 20.0;
const DAMPING: f64 = 10.0;

impl<'a> Case<'a> {
    fn nv(&self) -> usize {
        self.model.nv()
    }

    fn split<'x>(&self, x: &'x [f64]) -> (&'x [f64], Vec<(FrameId, [f64; 3])>) {
        let (a, f) = x.split_at(self.nv());
        let forces = f.chunks_exact(3).zip(&self.feet).map(|(f, foot)| (*foot, [f[0], f[1], f[2]]));
        (a, forces.collect())
    }

    fn torque(&self, x: &[f64]) -> Vec<f64> {
        let (a, forces) = self.split(x);
        torque_of(self.model, (&self.q, &self.v, a), &forces)
    }

    /// The equations E x − e: the base's forces, and the accelerations of the feet.
    fn equations(&self, x: &[f64]) -> Vec<f64> {
        let mut rest = self.torque(x)[..6].to_vec();
        for foot in &self.feet {
            let (rate, velocity) = rolling(self.model, (&self.q, &self.v, &x[..self.nv()]), *foot);
            rest.extend((0..3).map(|k| rate[k] + DAMPING * velocity[k]));
        }
        rest
    }

    /// The limits as values that are ≤ 0, with their names in the order of the solution.
    fn limits(&self, x: &[f64]) -> Vec<(f64, (char, usize))> {
        let (tau, limits) = (self.torque(x), self.model.coordinate_limits());
        let mut values = Vec::new();
        for k in 6..self.nv() {
            let q = self.q[k + 1];
            for sign in [1.0, -1.0] {
                let name = 2 * k + usize::from(sign > 0.0);
                values.push((sign * tau[k] - limits[k].effort, ('t', name)));
                let bound = if sign > 0.0 { limits[k].upper } else { -limits[k].lower };
                let by_position = RATE * RATE * (bound - sign * q) - 2.0 * RATE * sign * self.v[k];
                let by_velocity = RATE * (limits[k].velocity - sign * self.v[k]);
                // The velocity wins over the position.
                let other = -RATE * (limits[k].velocity + sign * self.v[k]);
                values.push((sign * x[k] - by_position.clamp(other, by_velocity), ('a', name)));
            }
        }
        // Four sides: |f| ≤ μ cos(π/4) f_n along each direction of the tangents.
        let slope = self.friction * std::f64::consts::FRAC_1_SQRT_2;
        for (foot, f) in x[self.nv()..].chunks_exact(3).enumerate() {
            values.push((-f[2], ('n', foot)));
            for (side, along) in [f[0], f[1], -f[0], -f[1]].into_iter().enumerate() {
                values.push((along - slope * f[2], ('f', 4 * foot + side)));
            }
        }
        values
    }

    /// √w r of all tasks.
    fn residuals(&self, x: &[f64]) -> Vec<f64> {
        let (model, w, nv) = (self.model, &mut Workspace::new(self.model), self.nv());
        let (q, v, a) = (&self.q[..], &self.v[..], &x[..nv]);
        let aligned = ReferenceFrame::LocalWorldAligned;
        let rate = frame_acceleration(model, w, q, v, a, self.trunk, aligned);
        let twist = frame_velocity(model, w, q, v, self.trunk, aligned);
        let pose = frame_pose(model, w, q, self.trunk);
        let mut rest = Vec::new();
        let mut push = |weight: f64, r: f64| rest.push(weight.sqrt() * r);
        let momentum = centroidal_momentum_rate(model, w, q, v, a);
        let c = center_of_mass(model, w, q);
        let c_rate = center_of_mass_velocity(model, w, q, v);
        for k in 0..3 {
            let command = GAINS.stiffness * (POINT[k] - c[k]) - GAINS.damping * c_rate[k];
            push(WEIGHTS[0], momentum.linear[k] / model.moving_mass() - command);
        }
        let rotation =
            nalgebra::Rotation3::from_matrix(&nalgebra::Matrix3::from_fn(|i, j| pose.rotation[i][j]));
        let turn = rotation.inverse().scaled_axis();
        for k in 0..3 {
            let command = GAINS.stiffness * turn[k] - GAINS.damping * twist.angular[k];
            push(WEIGHTS[1], rate.angular[k] - command);
        }
        let mut error = vec![0.0; nv];
        difference(model, q, &self.home, &mut error);
        for k in 6..nv {
            push(WEIGHTS[2], a[k] - GAINS.stiffness * error[k] + GAINS.damping * v[k]);
        }
        let spin = centroidal_momentum(model, w, q, v).angular;
        for k in 0..3 {
            push(WEIGHTS[3], momentum.angular[k] + 5.0 * spin[k]);
        }
        self.torque(x)[6..].iter().for_each(|tau| push(WEIGHTS[4], *tau));
        x[nv..].iter().for_each(|f| push(WEIGHTS[5], *f));
        for (k, wanted) in TWIST.into_iter().enumerate() {
            let found = if k < 3 { twist.linear[k] } else { twist.angular[k - 3] };
            let r = if k < 3 { rate.linear[k] } else { rate.angular[k - 3] };
            push(0.3, r - 4.0 * (wanted - found));
        }
        rest
    }

    fn control(&self) -> WholeBodyControl<&'a Model> {
        let mut control = on_feet(self.model, self.friction);
        let rest = [0.0; 3];
        let reference = TaskReference { position: POINT, velocity: rest, acceleration: rest };
        let level = Pose::from_translation(rest);
        let twist = |x: [f64; 6]| robot_dynamics::algorithms::Twist {
            linear: [x[0], x[1], x[2]],
            angular: [x[3], x[4], x[5]],
        };
        let tasks = [
            (Objective::CenterOfMass { reference, gains: GAINS }, WEIGHTS[0]),
            (
                Objective::FramePose {
                    frame: self.trunk,
                    axes: ALL_AXES[3..].to_vec(),
                    reference: PoseReference::at_rest(level),
                    gains: GAINS,
                },
                WEIGHTS[1],
            ),
            (
                match posture(self.model, &self.home, 1.0) {
                    Objective::Posture { reference, .. } => Objective::Posture { reference, gains: GAINS },
                    other => other,
                },
                WEIGHTS[2],
            ),
            (Objective::AngularMomentum { momentum: rest, rate: rest, damping: 5.0 }, WEIGHTS[3]),
            (Objective::Torque { torque: vec![0.0; self.nv()] }, WEIGHTS[4]),
            (Objective::ContactForces, WEIGHTS[5]),
            (
                Objective::FrameVelocity {
                    frame: self.trunk,
                    axes: ALL_AXES.to_vec(),
                    velocity: twist(TWIST),
                    acceleration: robot_dynamics::algorithms::SpatialAcceleration {
                        linear: rest,
                        angular: rest,
                    },
                    damping: 4.0,
                },
                0.3,
            ),
        ];
        for (objective, weight) in tasks {
            control.add_task(objective, weight).expect("a task");
        }
        control
    }
}

/// The columns of a function that is linear up to a constant, and its value at zero.
fn linear(size: usize, function: impl Fn(&[f64]) -> Vec<f64>) -> (DMatrix<f64>, DVector<f64>) {
    let origin = function(&vec![0.0; size]);
    let columns: Vec<DVector<f64>> = (0..size)
        .map(|k| {
            let mut x = vec![0.0; size];
            x[k] = 1.0;
            DVector::from_vec(function(&x).iter().zip(&origin).map(|(a, b)| a - b).collect())
        })
        .collect();
    (DMatrix::from_columns(&columns), DVector::from_vec(origin))
}

/// At random states with many active limits, the equations hold and no limit is exceeded. The equations and
/// the solution's multipliers balance the gradient. Multipliers are nonnegative and belong to limits at their
/// bounds.
#[test]
fn solutions_satisfy_the_optimality_conditions() {
    let model = quadruped();
    let home = standing(&model);
    let (mut active_count, mut kinds) = (0, std::collections::BTreeSet::new());
    for (seed, size) in (0..30).zip([0.02, 0.1, 0.2].into_iter().cycle()) {
        let (q, v) = near(&model, &home, size, seed);
        let trunk = model.frame_named("trunk").expect("a trunk");
        let feet = frames(&model, &FEET);
        let case = Case { model: &model, q, v, feet, home: home.clone(), trunk, friction: 0.6 };
        let mut control = case.control();
        let Ok(solution) = control.solve(&case.q, &case.v) else { continue };
        let mut x = solution.acceleration.clone();
        x.extend(solution.forces.iter().flat_map(|point| point.force));
        // Rounding: accelerations of 100, forces of 100 N, products with masses of 20 kg.
        assert!(largest(case.equations(&x)) < 1e-8, "{seed}");
        let tau = case.torque(&x);
        assert!(largest((6..18).map(|k| tau[k] - solution.torque[k])) < 1e-8, "{seed}");
        assert_eq!(solution.torque[..6], [0.0; 6]);

        let values = case.limits(&x);
        assert!(values.iter().all(|(value, _)| *value < 1e-7), "{seed}: {values:?}");
        let n = x.len();
        let (rows, constant) = linear(n, |x| case.residuals(x));
        let gradient = rows.transpose() * (&rows * DVector::from_column_slice(&x) + constant);
        let (equations, _) = linear(n, |x| case.equations(x));
        let (limits, _) = linear(n, |x| case.limits(x).into_iter().map(|(value, _)| value).collect());
        // The forces of the limits with the multipliers of the solution; the equations balance the rest.
        let mut rest = gradient.clone();
        for own in &solution.active_limits {
            let name = match own.limit {
                Limit::Torque { dof } => ('t', 2 * dof + usize::from(own.is_upper)),
                Limit::Acceleration { dof } => ('a', 2 * dof + usize::from(own.is_upper)),
                Limit::NormalForce { contact, .. } => ('n', contact.index()),
                Limit::Friction { contact, side, .. } => ('f', 4 * contact.index() + side),
                _ => unreachable!("a limit of another kind"),
            };
            kinds.insert(name.0);
            active_count += 1;
            let row = values.iter().position(|(_, other)| *other == name).expect("a row of the test");
            assert!(values[row].0 > -1e-7, "{seed}: {own:?} is not at its bound");
            assert!(own.multiplier >= 0.0, "{seed}: {own:?}");
            rest += own.multiplier * limits.row(row).transpose();
        }
        let scale = 1.0 + gradient.amax();
        let balance = equations.transpose().svd(true, true).solve(&-&rest, 1e-12).expect("singular values");
        let off = (equations.transpose() * balance + rest).amax() / scale;
        assert!(off < 1e-8, "{seed}: the gradient is off by {off}");
    }
    assert!(active_count > 30, "{active_count}");
    assert!(kinds.len() >= 3, "{kinds:?}");
}

/// The task errors that the solution states are those of the test's residuals.
#[test]
fn task_errors_are_the_norms_of_residuals() {
    let model = quadruped();
    let home = standing(&model);
    let (q, v) = near(&model, &home, 0.05, 3);
    let trunk = model.frame_named("trunk").expect("a trunk");
    let case = Case { model: &model, q, v, feet: frames(&model, &FEET), home, trunk, friction: 0.8 };
    let mut control = case.control();
    let solution = control.solve(&case.q, &case.v).expect("a solution");
    let mut x = solution.acceleration.clone();
    x.extend(solution.forces.iter().flat_map(|point| point.force));
    let residuals = case.residuals(&x);
    let counts = [3, 3, 12, 3, 12, 12, 6];
    let mut first = 0;
    for (task, count) in counts.into_iter().enumerate() {
        let weight = if task == 6 { 0.3 } else { WEIGHTS[task] };
        let norm = DVector::from_column_slice(&residuals[first..first + count]).norm() / weight.sqrt();
        let stated = solution.task_errors[task];
        assert!((norm - stated).abs() < 1e-8 * (1.0 + norm), "{task}: {norm} {stated}");
        first += count;
    }
}

/// Solutions from the working set of another state and from none are the same.
#[test]
fn warm_starts_do_not_change_solutions() {
    let model = quadruped();
    let home = standing(&model);
    let trunk = model.frame_named("trunk").expect("a trunk");
    let mut warm = None;
    let mut compared = 0;
    for seed in 0..12 {
        let (q, v) = near(&model, &home, 0.1, seed);
        let feet = frames(&model, &FEET);
        let case = Case { model: &model, q, v, feet, home: home.clone(), trunk, friction: 0.6 };
        let warm = warm.get_or_insert_with(|| case.control());
        let Ok(cold) = case.control().solve(&case.q, &case.v).cloned() else { continue };
        let again = warm.solve(&case.q, &case.v).expect("a solution");
        let off = largest(cold.torque.iter().zip(&again.torque).map(|(a, b)| a - b));
        // The objective's curvature is 1e-4 in the flattest direction.
        assert!(off < 1e-6, "{seed}: {off}");
        compared += 1;
    }
    assert!(compared > 6);
}
