//! Second derivatives against nested dual numbers through the plain recursions, against closed forms, and
//! against differences of first derivatives.
//!
//! Tolerances: a second derivative sums terms like those of a first one, times a few axes; 1e-12 of the
//! largest term allows several thousand roundings. Solving with M twice adds κ(M) ε of the terms.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use robot_dynamics::algorithms::{
    FrameWrench, ReferenceFrame, forward_dynamics_with_wrenches, frame_jacobian, frame_pose, frame_velocity,
    inverse_dynamics_with_wrenches,
};
use robot_dynamics::derivatives::{
    ForwardDirections, ForwardDynamicsDerivativesMut, ForwardHessianProductMut, ForwardPullbackInputs,
    ForwardSecondDerivativesMut, FramePoseInputs, FrameVelocityHessianProductMut, FrameVelocityInputs,
    InverseDirections, InverseHessianProductMut, InversePullbackInputs, InversePullbackMut,
    InverseSecondDerivativesMut, SecondOrderWorkspace, forward_dynamics_derivatives_with_wrenches,
    forward_dynamics_hessian, forward_dynamics_hessian_product, forward_dynamics_second_derivatives,
    frame_jacobian_derivative, frame_pose_hessian, frame_pose_hessian_product, frame_velocity_hessian,
    frame_velocity_hessian_product, inverse_dynamics_hessian, inverse_dynamics_hessian_product,
    inverse_dynamics_pullback, inverse_dynamics_second_derivatives,
};
use robot_dynamics::description::RobotDescription;
use robot_dynamics::description::{JointDescription, JointKind, LinkDescription, MassProperties, Pose};
use robot_dynamics::model::{Model, Workspace, integrate};
use robot_dynamics::number::{Dual, Scalar, SplitMix64};

use crate::common::{Robot, dot, families, max_difference, moved_along, size, times};

/// x + s α + t β, with s²= t² = 0: the outer gradient is by t, the inner one by s.
type Second = Dual<Dual<f64, 1>, 1>;

fn second(value: f64, by_s: f64, by_t: f64, by_both: f64) -> Second {
    Dual { value: Dual { value, gradient: [by_s] }, gradient: [Dual { value: by_t, gradient: [by_both] }] }
}

fn along(x: &[f64], s: &[f64], t: &[f64]) -> Vec<Second> {
    (0..x.len()).map(|k| second(x[k], s[k], t[k], 0.0)).collect()
}

fn constant(x: f64) -> Second {
    second(x, 0.0, 0.0, 0.0)
}

/// q ⊕ (s α + t β) up to the term in s t, from the power series of the exponential: a quaternion is
/// q ⊗ (1 − |φ|²/8, φ/2), and a position p + R (ρ + ½ φ × ρ).
fn moved(model: &Model, q: &[f64], s: &[f64], t: &[f64]) -> Vec<Second> {
    let mut moved: Vec<Second> = q.iter().map(|&q| constant(q)).collect();
    for joint in model.joints().iter().filter(|joint| joint.nv > 0) {
        let (s, t) = (&s[joint.v()], &t[joint.v()]);
        if joint.nq == joint.nv {
            (0..joint.nq).for_each(|i| {
                moved[joint.q_index + i] = second(q[joint.q_index + i], s[i], t[i], 0.0);
            });
            continue;
        }
        let at = joint.q_index + joint.nq - 4;
        let turn = Quaternion::new(q[at + 3], q[at], q[at + 1], q[at + 2]);
        let part = |x: &[f64], from: usize| Vector3::from_column_slice(&x[from..from + 3]);
        let (ws, wt) = (part(s, joint.nv - 3), part(t, joint.nv - 3));
        if joint.nq == 7 {
            let (us, ut) = (part(s, 0), part(t, 0));
            let rotation = UnitQuaternion::from_quaternion(turn);
            let bend = (ws.cross(&ut) + wt.cross(&us)) * 0.5;
            let [a, b, c] = [us, ut, bend].map(|x| rotation * x);
            (0..3).for_each(|i| {
                moved[joint.q_index + i] = second(q[joint.q_index + i], a[i], b[i], c[i]);
            });
        }
        let [a, b] = [ws, wt].map(|w| turn * Quaternion::from_imag(w) * 0.5);
        let c = turn * (-0.25 * ws.dot(&wt));
        (0..4).for_each(|i| {
            moved[at + i] = second(q[at + i], a.coords[i], b.coords[i], c.coords[i]);
        });
    }
    moved
}

fn constant_wrenches(wrenches: &[FrameWrench]) -> Vec<FrameWrench<Second>> {
    let held = |wrench: &FrameWrench| FrameWrench {
        frame: wrench.frame,
        force_in_frame: wrench.force_in_frame.map(constant),
        moment_in_frame: wrench.moment_in_frame.map(constant),
    };
    wrenches.iter().map(held).collect()
}

/// A robot with two random directions in (q, v, a) or (q, v, τ), a cotangent, and wrenches on every other
/// robot.
struct Case {
    robot: Robot,
    first: [Vec<f64>; 3],
    second: [Vec<f64>; 3],
    cotangent: Vec<f64>,
    wrenches: Vec<FrameWrench>,
}

impl Case {
    fn of(robot: Robot) -> Self {
        let (n, random) = (robot.model.nv(), &mut SplitMix64::new(robot.seed ^ 0x2d));
        let mut vector = || -> Vec<f64> { (0..n).map(|_| random.uniform(-1.0, 1.0)).collect() };
        let [first, second] = [(); 2].map(|()| [(); 3].map(|()| vector()));
        let cotangent = vector();
        let wrenches = if robot.seed.is_multiple_of(2) { vec![] } else { robot.wrenches() };
        Self { robot, first, second, cotangent, wrenches }
    }

    /// Some robots of each family: nested dual numbers compute each number four times.
    fn all() -> impl Iterator<Item = Self> {
        families().into_iter().flat_map(|family| family.robots().take(12).collect::<Vec<_>>()).map(Self::of)
    }

    fn inverse(&self) -> InversePullbackInputs<'_, f64> {
        let state = &self.robot.state;
        let (q, v, a) = (&state.q[..], &state.v[..], &state.a[..]);
        InversePullbackInputs { q, v, a, wrenches: &self.wrenches, cotangent: &self.cotangent }
    }

    fn forward(&self) -> ForwardPullbackInputs<'_, f64> {
        let state = &self.robot.state;
        let (q, v, tau) = (&state.q[..], &state.v[..], &state.tau[..]);
        ForwardPullbackInputs { q, v, tau, wrenches: &self.wrenches, cotangent: &self.cotangent }
    }

    /// The largest term of a second derivative of λᵀτ, up to the count of bodies.
    fn force_size(&self) -> f64 {
        let wrenches = 10.0 * self.wrenches.len() as f64;
        (self.robot.force_size(&self.robot.state.a) + wrenches) * self.robot.model.nv() as f64
    }
}

/// H α of inverse dynamics for these rows of directions.
fn inverse_product(
    case: &Case,
    workspace: &mut SecondOrderWorkspace,
    rows: &[&[Vec<f64>; 3]],
) -> [Vec<f64>; 3] {
    let stacked = [0, 1, 2].map(|k| rows.iter().flat_map(|row| row[k].clone()).collect::<Vec<f64>>());
    let [mut x, mut y, mut z] = [(); 3].map(|()| vec![7.0; stacked[0].len()]);
    let results =
        InverseHessianProductMut { by_position: &mut x, by_velocity: &mut y, by_acceleration: &mut z };
    let [position, velocity, acceleration] = &stacked;
    let directions = InverseDirections { position, velocity, acceleration };
    inverse_dynamics_hessian_product(&case.robot.model, workspace, case.inverse(), directions, results);
    [x, y, z]
}

/// The same of forward dynamics.
fn forward_product(
    case: &Case,
    workspace: &mut SecondOrderWorkspace,
    rows: &[&[Vec<f64>; 3]],
) -> [Vec<f64>; 3] {
    let stacked = [0, 1, 2].map(|k| rows.iter().flat_map(|row| row[k].clone()).collect::<Vec<f64>>());
    let [mut x, mut y, mut z] = [(); 3].map(|()| vec![7.0; stacked[0].len()]);
    let results = ForwardHessianProductMut { by_position: &mut x, by_velocity: &mut y, by_force: &mut z };
    let [position, velocity, force] = &stacked;
    let directions = ForwardDirections { position, velocity, force };
    forward_dynamics_hessian_product(&case.robot.model, workspace, case.forward(), directions, results);
    [x, y, z]
}

fn paired(direction: &[Vec<f64>; 3], product: &[Vec<f64>; 3]) -> f64 {
    (0..3).map(|k| dot(&direction[k], &product[k])).sum()
}

fn sizes(parts: &[Vec<f64>; 3]) -> f64 {
    parts.iter().map(|part| size(part)).fold(0.0, f64::max)
}

/// βᵀH α is the term in s t of λᵀτ at the moved point.
#[test]
fn inverse_dynamics_products_match_nested_duals() {
    for case in Case::all() {
        let Robot { model, state, .. } = &case.robot;
        let (n, workspace) = (model.nv(), &mut SecondOrderWorkspace::new(model));
        let product = inverse_product(&case, workspace, &[&case.first]);
        let found = paired(&case.second, &product);
        let [q, v, a] = [0, 1, 2].map(|k| (&case.first[k], &case.second[k]));
        let mut tau = vec![constant(0.0); n];
        inverse_dynamics_with_wrenches(
            model,
            &mut Workspace::<Second>::new(model),
            &moved(model, &state.q, q.0, q.1),
            &along(&state.v, v.0, v.1),
            &along(&state.a, a.0, a.1),
            &constant_wrenches(&case.wrenches),
            &mut tau,
        );
        let expected: f64 = (0..n).map(|i| case.cotangent[i] * tau[i].gradient[0].gradient[0]).sum();
        case.robot.require("βᵀH α", (found - expected).abs(), 1e-12 * case.force_size() * n as f64);
    }
}

#[test]
fn forward_dynamics_products_match_nested_duals() {
    for case in Case::all() {
        let Robot { model, state, .. } = &case.robot;
        let (n, workspace) = (model.nv(), &mut SecondOrderWorkspace::new(model));
        let product = forward_product(&case, workspace, &[&case.first]);
        let found = paired(&case.second, &product);
        let [q, v, tau] = [0, 1, 2].map(|k| (&case.first[k], &case.second[k]));
        let mut a = vec![constant(0.0); n];
        forward_dynamics_with_wrenches(
            model,
            &mut Workspace::<Second>::new(model),
            &moved(model, &state.q, q.0, q.1),
            &along(&state.v, v.0, v.1),
            &along(&state.tau, tau.0, tau.1),
            &constant_wrenches(&case.wrenches),
            &mut a,
        );
        let changes: Vec<f64> = a.iter().map(|a| a.gradient[0].gradient[0]).collect();
        let terms = sizes(&product) + size(&changes) * size(&case.cotangent);
        let allowed = 1e2 * f64::EPSILON * case.robot.condition() * terms * n as f64;
        case.robot.require("βᵀH α", (found - dot(&case.cotangent, &changes)).abs(), allowed);
    }
}

/// H, its products for several directions at once, and the contracted tensors agree. H is symmetric.
#[test]
fn hessians_products_and_tensors_agree() {
    for case in Case::all() {
        let model = &case.robot.model;
        let (n, workspace) = (model.nv(), &mut SecondOrderWorkspace::new(model));
        let rows = [&case.first, &case.second, &case.first, &case.first, &case.second];
        for forward in [false, true] {
            let mut hessian = vec![7.0; 9 * n * n];
            let mut tensors = [(); 4].map(|()| vec![7.0; n * n * n]);
            let [qq, qv, vv, qx] = &mut tensors;
            let (products, allowed);
            let state = &case.robot.state;
            if forward {
                products = forward_product(&case, workspace, &rows);
                forward_dynamics_hessian(model, workspace, case.forward(), &mut hessian);
                let results = ForwardSecondDerivativesMut {
                    position_position: qq,
                    position_velocity: qv,
                    velocity_velocity: vv,
                    position_force: qx,
                };
                let (q, v, tau) = (&state.q, &state.v, &state.tau);
                forward_dynamics_second_derivatives(model, workspace, q, v, tau, &case.wrenches, results);
                let terms = tensors.iter().map(|x| size(x)).fold(size(&hessian), f64::max);
                allowed = 1e2 * f64::EPSILON * case.robot.condition() * terms * n as f64;
            } else {
                products = inverse_product(&case, workspace, &rows);
                inverse_dynamics_hessian(model, workspace, case.inverse(), &mut hessian);
                let results = InverseSecondDerivativesMut {
                    position_position: qq,
                    position_velocity: qv,
                    velocity_velocity: vv,
                    position_acceleration: qx,
                };
                let (q, v, a) = (&state.q, &state.v, &state.a);
                inverse_dynamics_second_derivatives(model, workspace, q, v, a, &case.wrenches, results);
                allowed = 1e-12 * case.force_size();
            }
            let symmetric =
                (0..9 * n * n).all(|at| hessian[at] == hessian[at % (3 * n) * 3 * n + at / (3 * n)]);
            assert!(symmetric, "{} seed {}", case.robot.family, case.robot.seed);
            for (row, direction) in rows.iter().enumerate() {
                let expected = times(&hessian, &direction.concat());
                for k in 0..3 {
                    let found = &products[k][row * n..(row + 1) * n];
                    let difference = max_difference(found, &expected[k * n..(k + 1) * n]);
                    case.robot.require("H α", difference, allowed * 10.0);
                }
            }
            for (tensor, (first, second)) in tensors.iter().zip([(0, 0), (0, 1), (1, 1), (0, 2)]) {
                for at in 0..n * n {
                    let (j, k) = (first * n + at / n, second * n + at % n);
                    let sum: f64 = (0..n).map(|i| case.cotangent[i] * tensor[i * n * n + at]).sum();
                    case.robot.require("Σ λᵢ ∂²fᵢ", (sum - hessian[j * 3 * n + k]).abs(), allowed);
                }
            }
        }
    }
}

/// M ∂²a/∂x∂y + ∂²τ/∂x∂y + (∂M/∂x) ∂a/∂y + (∂M/∂y) ∂a/∂x = 0 at the acceleration of the state.
#[test]
fn forward_tensors_solve_the_differentiated_equation() {
    for case in Case::all().filter(|case| case.robot.model.nv() < 20) {
        let Robot { model, state, .. } = &case.robot;
        let (n, workspace, w) =
            (model.nv(), &mut SecondOrderWorkspace::new(model), &mut Workspace::new(model));
        let mut a = vec![0.0; n];
        forward_dynamics_with_wrenches(model, w, &state.q, &state.v, &state.tau, &case.wrenches, &mut a);
        let [mut a_q, mut a_v, mut a_tau] = [(); 3].map(|()| vec![0.0; n * n]);
        let first = ForwardDynamicsDerivativesMut {
            by_position: &mut a_q,
            by_velocity: &mut a_v,
            by_force: &mut a_tau,
        };
        let (q, v, tau, wrenches) = (&state.q, &state.v, &state.tau, &case.wrenches);
        forward_dynamics_derivatives_with_wrenches(model, w, q, v, tau, wrenches, first);
        let mut forward = [(); 4].map(|()| vec![0.0; n * n * n]);
        let [qq, qv, vv, qx] = &mut forward;
        let results = ForwardSecondDerivativesMut {
            position_position: qq,
            position_velocity: qv,
            velocity_velocity: vv,
            position_force: qx,
        };
        forward_dynamics_second_derivatives(model, workspace, q, v, tau, wrenches, results);
        let mut inverse = [(); 4].map(|()| vec![0.0; n * n * n]);
        let [qq, qv, vv, qx] = &mut inverse;
        let results = InverseSecondDerivativesMut {
            position_position: qq,
            position_velocity: qv,
            velocity_velocity: vv,
            position_acceleration: qx,
        };
        inverse_dynamics_second_derivatives(model, workspace, q, v, &a, wrenches, results);
        let mass = case.robot.mass();
        let by_mass = &inverse[3];
        let zeros = vec![0.0; n * n * n];
        for (tensor, known, by_first, by_second) in [
            (&forward[0], &inverse[0], Some(&a_q), Some(&a_q)),
            (&forward[1], &inverse[1], None, Some(&a_v)),
            (&forward[2], &inverse[2], None, None),
            (&forward[3], &zeros, None, Some(&a_tau)),
        ] {
            for (i, j, k) in (0..n * n * n).map(|at| (at / (n * n), at / n % n, at % n)) {
                // (∂M/∂qⱼ) ∂a/∂yₖ, and the same with the places exchanged.
                let carried = |rate: Option<&Vec<f64>>, along: usize, by: usize| -> f64 {
                    rate.map_or(0.0, |rate| {
                        (0..n).map(|l| by_mass[(i * n + along) * n + l] * rate[l * n + by]).sum()
                    })
                };
                let products: Vec<f64> =
                    (0..n).map(|l| mass[i * n + l] * tensor[(l * n + j) * n + k]).collect();
                let rest = [known[(i * n + j) * n + k], carried(by_second, j, k), carried(by_first, k, j)];
                let sum = products.iter().chain(&rest).sum::<f64>();
                let rates = [by_first, by_second].into_iter().flatten().map(|rate| size(rate)).sum::<f64>();
                let terms = size(&mass) * size(tensor) + size(by_mass) * rates + case.force_size();
                let allowed = 1e2 * f64::EPSILON * case.robot.condition() * terms * n as f64;
                case.robot.require("the differentiated equation", sum.abs(), allowed);
            }
        }
    }
}

/// ½ (D_i g_j + D_j g_i) by central differences of the pullback along `integrate`. The step of 1e-5 leaves
/// truncation and rounding below 1e-7 of the terms.
#[test]
fn hessians_match_differences_of_pullbacks() {
    for case in Case::all().filter(|case| case.robot.model.nv() < 20).step_by(5) {
        let Robot { model, state, .. } = &case.robot;
        let (n, w, h) = (model.nv(), &mut Workspace::<f64>::new(model), 1e-5);
        let inputs = InversePullbackInputs { wrenches: &[], ..case.inverse() };
        let mut hessian = vec![0.0; 9 * n * n];
        inverse_dynamics_hessian(model, &mut SecondOrderWorkspace::new(model), inputs, &mut hessian);
        let mut gradient = |along: usize, step: f64| {
            let (mut q, mut v) = (state.q.clone(), state.v.clone());
            let mut displacement = vec![0.0; n];
            if along < n {
                displacement[along] = step;
                integrate(model, &state.q, &displacement, &mut q);
            } else {
                v[along - n] += step;
            }
            let [mut x, mut y, mut z] = [(); 3].map(|()| vec![0.0; n]);
            let results = InversePullbackMut {
                by_position: &mut x,
                by_velocity: &mut y,
                by_acceleration: &mut z,
                parameters: &mut [],
            };
            inverse_dynamics_pullback(model, w, &q, &v, &state.a, &case.cotangent, results);
            [x, y, z].concat()
        };
        let rate: Vec<Vec<f64>> = (0..2 * n)
            .map(|along| {
                let (ahead, behind) = (gradient(along, h), gradient(along, -h));
                ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * h)).collect()
            })
            .collect();
        for (i, j) in (0..4 * n * n).map(|at| (at / (2 * n), at % (2 * n))) {
            let expected = 0.5 * (rate[i][j] + rate[j][i]);
            let difference = (hessian[i * 3 * n + j] - expected).abs();
            case.robot.require("differences", difference, 1e-7 * case.force_size());
        }
    }
}

/// Two point masses on rods in a horizontal plane: τ₂ = m l₁l₂ (c₂ a₁ + s₂ v₁²) + m l₂² (a₁ + a₂).
#[test]
fn a_planar_arm_has_its_closed_form() -> Result<(), Box<dyn std::error::Error>> {
    let (m, l1, l2) = (1.5, 0.7, 0.4);
    let mut robot = RobotDescription::new("arm");
    robot.links.push(LinkDescription::new("base", None));
    let about_z = JointKind::Revolute { axis: [0.0, 0.0, 1.0] };
    for (name, parent, at, length) in [("upper", "base", 0.0, l1), ("lower", "upper", l1, l2)] {
        let mass = MassProperties::new(m, [length, 0.0, 0.0].into(), Matrix3::zeros())?;
        robot.links.push(LinkDescription::new(name, mass));
        let place = Pose { translation: [at, 0.0, 0.0], ..Pose::IDENTITY };
        robot.joints.push(JointDescription::new(name, about_z, parent, name, place));
    }
    let model = Model::new(robot)?;
    let (q, v, a) = ([0.4, 0.9], [1.2, -0.7], [2.0, 0.5]);
    let (sine, cosine) = q[1].sin_cos();
    let inputs = InversePullbackInputs { q: &q, v: &v, a: &a, wrenches: &[], cotangent: &[0.0, 1.0] };
    let mut hessian = vec![0.0; 36];
    inverse_dynamics_hessian(&model, &mut SecondOrderWorkspace::new(&model), inputs, &mut hessian);
    let mut expected = vec![0.0; 36];
    let arm = m * l1 * l2;
    let mut set = |i: usize, j: usize, x: f64| (expected[6 * i + j], expected[6 * j + i]) = (x, x);
    set(1, 1, -arm * (cosine * a[0] + sine * v[0] * v[0]));
    set(1, 2, 2.0 * arm * cosine * v[0]);
    set(2, 2, 2.0 * arm * sine);
    set(1, 4, -arm * sine);
    assert!(max_difference(&hessian, &expected) < 1e-14, "{hessian:?}");
    Ok(())
}

/// The Jacobian's derivative against dual numbers, in each reference frame.
#[test]
fn jacobian_derivatives_match_duals() {
    for case in Case::all() {
        let Robot { model, state, .. } = &case.robot;
        let (n, frames) = (model.nv(), model.frames());
        let frame = model
            .frame(&frames[usize::try_from(case.robot.seed).unwrap() % frames.len()].name)
            .expect("its own frame");
        let dual = &mut Workspace::<Dual<f64, 1>>::new(model);
        let w = &mut Workspace::new(model);
        for seen in ReferenceFrame::ALL {
            let (mut found, mut rate) = (vec![7.0; 6 * n * n], vec![Dual::constant(0.0); 6 * n]);
            frame_jacobian_derivative(model, w, &state.q, frame, seen, &mut found);
            for k in 0..n {
                let mut unit = vec![0.0; n];
                unit[k] = 1.0;
                frame_jacobian(model, dual, &moved_along(model, &state.q, &unit), frame, seen, &mut rate);
                for (at, rate) in rate.iter().enumerate() {
                    let difference = (found[at * n + k] - rate.gradient[0]).abs();
                    let arms = size(&state.q) + n as f64;
                    case.robot.require("∂J/∂q", difference, 1e-13 * arms);
                }
            }
        }
    }
}

/// λᵀV at the moved point against the product, and H against its products.
#[test]
fn frame_velocities_match_nested_duals() {
    for case in Case::all() {
        let Robot { model, state, .. } = &case.robot;
        let (n, frames) = (model.nv(), model.frames());
        let frame = model
            .frame(&frames[usize::try_from(case.robot.seed).unwrap() % frames.len()].name)
            .expect("its own frame");
        let (workspace, dual) = (&mut SecondOrderWorkspace::new(model), &mut Workspace::<Second>::new(model));
        let cotangent = [0.3, -0.8, 0.5, 0.9, 0.2, -0.6];
        for reference_frame in ReferenceFrame::ALL {
            let inputs = FrameVelocityInputs { q: &state.q, v: &state.v, frame, reference_frame, cotangent };
            let (mut x, mut y, mut hessian) = (vec![7.0; n], vec![7.0; n], vec![7.0; 4 * n * n]);
            let results = FrameVelocityHessianProductMut { by_position: &mut x, by_velocity: &mut y };
            let directions = [&case.first[0][..], &case.first[1][..]];
            frame_velocity_hessian_product(model, workspace, inputs, directions, results);
            frame_velocity_hessian(model, workspace, inputs, &mut hessian);
            let q = moved(model, &state.q, &case.first[0], &case.second[0]);
            let v = along(&state.v, &case.first[1], &case.second[1]);
            let velocity = frame_velocity(model, dual, &q, &v, frame, reference_frame);
            let parts = velocity.linear.iter().chain(&velocity.angular);
            let expected: f64 =
                parts.zip(cotangent).map(|(x, lambda)| x.gradient[0].gradient[0] * lambda).sum();
            let found = dot(&case.second[0], &x) + dot(&case.second[1], &y);
            let terms = (n as f64 + size(&state.q)) * (1.0 + size(&state.v)) * (n * n) as f64;
            case.robot.require("βᵀH α", (found - expected).abs(), 1e-13 * terms);
            let product = times(&hessian, &case.first[..2].concat());
            case.robot.require("H α", max_difference(&product, &[x, y].concat()), 1e-13 * terms);
        }
    }
}

/// The Hessian of a pose is that of p, and of the rotation vector from the pose's own second derivative.
#[test]
fn frame_poses_match_nested_duals() {
    for case in Case::all() {
        let Robot { model, state, .. } = &case.robot;
        let (n, frames) = (model.nv(), model.frames());
        let frame = model
            .frame(&frames[usize::try_from(case.robot.seed).unwrap() % frames.len()].name)
            .expect("its own frame");
        let (w, dual) = (&mut Workspace::new(model), &mut Workspace::<Second>::new(model));
        let q = moved(model, &state.q, &case.first[0], &case.second[0]);
        let pose = frame_pose(model, dual, &q, frame);
        let at = |i: usize, j: usize| pose.rotation[i][j];
        let value = Matrix3::from_fn(|i, j| at(i, j).value.value);
        let change = Matrix3::from_fn(|i, j| at(i, j).gradient[0].gradient[0]);
        // R(x) Rᵀ = 1 + \[ξ\]× + ½ \[ξ\]×²: the skew part of its second derivative is that of ξ.
        let twist = change * value.transpose();
        let skew = (twist - twist.transpose()) * 0.5;
        let moved: Vec<f64> = pose.translation.iter().map(|x| x.gradient[0].gradient[0]).collect();
        let expected = [moved, vec![skew[(2, 1)], skew[(0, 2)], skew[(1, 0)]]].concat();
        let reference_frame = ReferenceFrame::LocalWorldAligned;
        for (row, expected) in expected.iter().enumerate() {
            let cotangent = core::array::from_fn(|k| if k == row { 1.0 } else { 0.0 });
            let inputs = FramePoseInputs { q: &state.q, frame, reference_frame, cotangent };
            let (mut hessian, mut product) = (vec![7.0; n * n], vec![7.0; n]);
            frame_pose_hessian(model, w, inputs, &mut hessian);
            frame_pose_hessian_product(model, w, inputs, &case.first[0], &mut product);
            let terms = (n as f64 + size(&state.q)) * (n * n) as f64;
            let difference = (dot(&case.second[0], &product) - expected).abs();
            case.robot.require("βᵀH α", difference, 1e-13 * terms);
            let difference = max_difference(&times(&hessian, &case.first[0]), &product);
            case.robot.require("H α", difference, 1e-13 * terms);
        }
    }
}
