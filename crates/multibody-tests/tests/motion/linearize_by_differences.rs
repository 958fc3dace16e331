//! A and B by differences against the exact ones of explicit rows, and, through contact, against closed forms.

use crate::common::{Robot, families};
use dynamics::{Integrator, MassProperties};
use multibody::{
    Base, ContactSet, Ground, Implicit, LinearizeStepWorkspace, LinkDescription, LinkShape, Model, Pose,
    RobotDescription, Shape, ShapeRole, StepForces, StepWorkspace, Stepper, linearize_by_differences,
    linearize_step,
};
use nalgebra::{DMatrix, Matrix3, Vector3};

const G: f64 = 9.81;
const H: f64 = 1e-3;

fn by_differences<S: Stepper + Clone>(
    model: &Model,
    stepper: &S,
    tau: &[f64],
    (q, v): (&[f64], &[f64]),
) -> (DMatrix<f64>, DMatrix<f64>) {
    let nv = model.nv();
    let (mut a, mut b) = (vec![0.0; 4 * nv * nv], vec![0.0; 2 * nv * nv]);
    let (w, forces) = (&mut StepWorkspace::new(model), StepForces::new(tau, true));
    linearize_by_differences(model, stepper, w, &forces, H, q, v, &mut a, &mut b).unwrap();
    (DMatrix::from_row_slice(2 * nv, 2 * nv, &a), DMatrix::from_row_slice(2 * nv, nv, &b))
}

/// Every kind of joint: the slopes that `linearize_step` has, to the error of the differences.
#[test]
fn explicit_rows_have_the_exact_slopes() {
    let mut tested = 0;
    for family in families() {
        if family.name.contains("thin") || family.name == "large" {
            continue;
        }
        for robot in family.robots().take(4).filter(|robot| robot.condition() < 1e3) {
            let Robot { model, state, .. } = &robot;
            let nv = model.nv();
            for row in [Integrator::SemiImplicitEuler, Integrator::RungeKutta4] {
                let (mut a, mut b) = (vec![0.0; 4 * nv * nv], vec![0.0; 2 * nv * nv]);
                let (w, forces) =
                    (&mut LinearizeStepWorkspace::new(model), StepForces::new(&state.tau, true));
                linearize_step(model, row, w, &forces, H, &state.q, &state.v, &mut a, &mut b).unwrap();
                let (found_a, found_b) = by_differences(model, &row, &state.tau, (&state.q, &state.v));
                // 1e-10 of truncation, and the rounding of q and v, 1e-16/1e-5, which M⁻¹ makes κ times as large. A force moves v by
                // less than 1e-5 where other coordinates carry its body: by κ at most.
                for (name, found, exact) in [("A", found_a.transpose(), &a), ("B", found_b.transpose(), &b)] {
                    let size = exact.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
                    let off = found.iter().zip(exact).fold(0.0_f64, |most, (x, y)| most.max((x - y).abs()));
                    assert!(
                        off < 1e-8 * robot.condition() * size,
                        "{} {row} {name}: {off:e} of {size:e}",
                        family.name
                    );
                }
                tested += 1;
            }
        }
    }
    assert!(tested >= 30, "{tested} robots");
}

/// A brick of 1 kg that lies on the ground or slides over it.
fn brick(v: [f64; 6]) -> (Model, Implicit, [f64; 7], [f64; 6]) {
    let mut robot = RobotDescription::new("brick");
    robot.base = Base::Floating;
    let mass = MassProperties::new(1.0, Vector3::zeros(), Matrix3::identity() * 5e-3).unwrap();
    robot.links.push(LinkDescription::new("brick", mass));
    let shape = Shape::Box { size: [0.4, 0.4, 0.1] };
    robot.shapes.push(LinkShape::new("brick", ShapeRole::Collision, Pose::IDENTITY, shape));
    let model = Model::new(robot).unwrap();
    let ground = ContactSet::new(&model, &[Ground::level(0.0).with_friction(0.5)]).unwrap();
    let mut implicit = Implicit::new(&model).with_contacts(&model, ground);
    let (mut q, mut v) = ([0.0, 0.0, 0.05, 0.0, 0.0, 0.0, 1.0], v);
    let (w, none) = (&mut StepWorkspace::new(&model), [0.0; 6]);
    for _ in 0..5 {
        implicit.step(&model, w, &StepForces::new(&none, true), H, &mut q, &mut v).unwrap();
    }
    (model, implicit, q, v)
}

/// What lies still stays where it is put, whatever pushes it a little; a velocity along the ground is gone after the step, and has moved
/// the brick by half of it. The solution is known to 1e-11 of the speeds, g h among them, and that is divided by 1e-5.
#[test]
fn a_lying_brick_has_no_velocity_afterwards() {
    let (model, implicit, q, v) = brick([0.0; 6]);
    let (a, b) = by_differences(&model, &implicit, &[0.0; 6], (&q, &v));
    // Along the ground, and about its normal.
    let free = [0, 1, 5];
    for i in free {
        for j in free {
            let same = if i == j { 1.0 } else { 0.0 };
            assert!((a[(i, j)] - same).abs() < 1e-6, "q by q, {i} {j}: {}", a[(i, j)]);
            assert!((a[(i, 6 + j)] - same * 0.5 * H).abs() < 1e-7, "q by v, {i} {j}: {}", a[(i, 6 + j)]);
            assert!(a[(6 + i, 6 + j)].abs() < 1e-6, "v by v, {i} {j}: {}", a[(6 + i, 6 + j)]);
        }
    }
    for j in free {
        assert!(b.column(j).rows(6, 6).amax() < 1e-6 * H, "v by τ {j}: {b}");
    }
    // What is lifted off comes back within 0.1 s: h/0.1 of the way in a step, half of that for the half of it that a velocity goes. To one side
    // only, as nothing goes into the ground.
    let back = a[(8, 8)];
    assert!((-0.5 * H / 0.1 - 1e-6..0.0).contains(&back), "{back}");
}

/// What slides along x is braked by μ g along its velocity: v_y⁺ = v_y − μ g h v_y/|v|, and a force across the ground changes that.
#[test]
fn a_sliding_brick_is_braked_along_its_velocity() {
    let (model, implicit, q, v) = brick([1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let (a, b) = by_differences(&model, &implicit, &[0.0; 6], (&q, &v));
    let across = 1.0 - 0.5 * G * H / v[0];
    // The friction of the step before acts in the step's smooth part, along its own direction: turning with v is of order h.
    assert!((a[(6, 6)] - 1.0).abs() < 1e-6, "{}", a[(6, 6)]);
    assert!((a[(7, 7)] - across).abs() < 1e-5, "{} {across}", a[(7, 7)]);
    assert!((b[(6, 0)] - H).abs() < 2e-6 * H, "{}", b[(6, 0)]);
    // Lifted, it is braked less: μ h, but for the way back of what a pull lifts off, h/0.1 of half a way to one side.
    assert!((b[(6, 2)] - 0.5 * H).abs() < 0.5 * H * (0.5 * H / 0.1), "{}", b[(6, 2)]);
}
