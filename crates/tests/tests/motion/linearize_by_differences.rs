//! A and B by differences, against the exact derivatives of explicit methods and, through contact, against
//! closed forms.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use robot_dynamics::contact::{ContactSet, Ground};
use robot_dynamics::derivatives::{
    LinearizationMethod, LinearizeStepWorkspace, LinearizedStep, RobotState, linearize_by_differences,
    linearize_step, linearize_stepper,
};
use robot_dynamics::description::{
    Base, LinkDescription, LinkShape, MassProperties, Pose, RobotDescription, Shape, ShapeRole, pendulum,
};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{
    Integrator, SimulationStepper, StepError, StepForces, StepWorkspace, Stepper,
};

use crate::common::{Robot, families};
use crate::free_body::{body, implicit_on, soft_on, stepper};

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
    let out = LinearizedStep { by_state: &mut a, by_force: &mut b };
    linearize_by_differences(model, stepper, w, &forces, H, RobotState { q, v }, out).unwrap();
    (DMatrix::from_row_slice(2 * nv, 2 * nv, &a), DMatrix::from_row_slice(2 * nv, nv, &b))
}

/// Every kind of joint: the derivatives of `linearize_step`, to the error of the differences.
#[test]
fn explicit_methods_have_exact_derivatives() {
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
                let out = LinearizedStep { by_state: &mut a, by_force: &mut b };
                linearize_step(model, row, w, &forces, H, RobotState { q: &state.q, v: &state.v }, out)
                    .unwrap();
                let (found_a, found_b) = by_differences(model, &row, &state.tau, (&state.q, &state.v));
                // 1e-10 of truncation, and the rounding of q and v, 1e-16/1e-5, times κ from M⁻¹. A force
                // moves v by less than 1e-5 where other coordinates carry its body: by κ at most.
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
fn brick(v: [f64; 6]) -> (Model, SimulationStepper, [f64; 7], [f64; 6]) {
    let mut robot = RobotDescription::new("brick");
    robot.base = Base::Floating;
    let mass = MassProperties::new(1.0, Vector3::zeros(), Matrix3::identity() * 5e-3).unwrap();
    robot.links.push(LinkDescription::new("brick", mass));
    let shape = Shape::Box { size: [0.4, 0.4, 0.1] };
    robot.shapes.push(LinkShape::new("brick", ShapeRole::Collision, Pose::IDENTITY, shape));
    let model = Model::new(robot).unwrap();
    let ground = ContactSet::new(&model, &[Ground::level(0.0).with_friction(0.5)]).unwrap();
    let mut implicit = stepper(implicit_on(&model, ground));
    let (mut q, mut v) = ([0.0, 0.0, 0.05, 0.0, 0.0, 0.0, 1.0], v);
    let (w, none) = (&mut StepWorkspace::new(&model), [0.0; 6]);
    for _ in 0..5 {
        implicit.step(&model, w, &StepForces::new(&none, true), H, &mut q, &mut v).unwrap();
    }
    (model, implicit, q, v)
}

/// A resting brick stays at its position under any small push. A velocity along the ground is zero after the
/// step and moves the brick by half a step. The solution is accurate to 1e-11 of the velocities, g h among
/// them, and that error is divided by 1e-5.
#[test]
fn resting_brick_stays_at_rest() {
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
    // A lifted brick returns within 0.1 s, by h/0.1 of the distance in a step. For the half step of a
    // velocity it is half of that. This holds in one direction only, as the brick cannot enter the ground.
    let back = a[(8, 8)];
    assert!((-0.5 * H / 0.1 - 1e-6..0.0).contains(&back), "{back}");
}

/// A brick that slides along x is braked by μ g along its velocity: v_y⁺ = v_y − μ g h v_y/|v|. A force
/// across the ground changes that.
#[test]
fn sliding_brick_is_braked_along_its_velocity() {
    let (model, implicit, q, v) = brick([1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let (a, b) = by_differences(&model, &implicit, &[0.0; 6], (&q, &v));
    let across = 1.0 - 0.5 * G * H / v[0];
    // The friction of the previous step acts in the smooth part of the step, along its own direction. Its
    // turn with v is of order h.
    assert!((a[(6, 6)] - 1.0).abs() < 1e-6, "{}", a[(6, 6)]);
    assert!((a[(7, 7)] - across).abs() < 1e-5, "{} {across}", a[(7, 7)]);
    assert!((b[(6, 0)] - H).abs() < 2e-6 * H, "{}", b[(6, 0)]);
    // A lifted brick is braked less: by μ h, except for its return, h/0.1 of half the distance in one
    // direction.
    assert!((b[(6, 2)] - 0.5 * H).abs() < 0.5 * H * (0.5 * H / 0.1), "{}", b[(6, 2)]);
}

/// A block of 2 kg slides over the ground: pushed with F for 0.2 s, then released, in steps of 2 ms for 1 s.
/// Returns where it ends and, from the chain of A and B, ∂x/∂F.
fn pushed(
    push: f64,
    stepper_of: impl Fn(&Model, ContactSet) -> SimulationStepper,
    is_analytic: bool,
) -> (f64, f64) {
    let mut robot = body(8e-3, Shape::Box { size: [0.2, 0.2, 0.1] });
    robot.links[0].mass_properties =
        Some(MassProperties::new(2.0, Vector3::zeros(), Matrix3::identity() * 8e-3).unwrap());
    let model = Model::new(robot).unwrap();
    let contacts = ContactSet::new(&model, &[Ground::level(0.0).with_friction(0.3)]).unwrap();
    let mut stepper = stepper_of(&model, contacts);
    let (w, h) = (&mut StepWorkspace::new(&model), 2e-3);
    let (mut q, mut v) = ([0.0, 0.0, 0.05, 0.0, 0.0, 0.0, 1.0], [0.0; 6]);
    let mut by_push = DVector::zeros(12);
    for step in 0..500 {
        let pushes = step < 100;
        let tau = [if pushes { push } else { 0.0 }, 0.0, 0.0, 0.0, 0.0, 0.0];
        let forces = StepForces::new(&tau, true);
        let (mut a, mut b) = (vec![0.0; 144], vec![0.0; 72]);
        // Its contact memory is that of one step from this state, as in a linearisation of a single step.
        let mut here = stepper.clone();
        here.step(&model, w, &forces, h, &mut q.clone(), &mut v.clone()).unwrap();
        let out = LinearizedStep { by_state: &mut a, by_force: &mut b };
        let state = RobotState { q: &q, v: &v };
        if is_analytic {
            let method = linearize_stepper(&model, &mut here, w, &forces, h, state, out).unwrap();
            assert!(matches!(method, LinearizationMethod::Analytic { .. }), "{method:?}");
        } else {
            linearize_by_differences(&model, &here, w, &forces, h, state, out).unwrap();
        }
        by_push = DMatrix::from_row_slice(12, 12, &a) * by_push;
        if pushes {
            by_push += DMatrix::from_row_slice(12, 6, &b).column(0);
        }
        stepper.step(&model, w, &forces, h, &mut q, &mut v).unwrap();
    }
    (q[0], by_push[0])
}

/// Under both contact laws the chain of A and B is the difference between whole slides. It is close to the
/// closed form of Coulomb's law, 0.5 T²/m + v T/(m μ g) with v = (F/m − μ g) T. Under MuJoCo's law the block
/// rocks, so that its corners leave the ground and return.
#[test]
fn chain_of_steps_is_derivative_of_slide() {
    let implicit = |model: &Model, contacts| stepper(implicit_on(model, contacts));
    let soft = |model: &Model, contacts| stepper(soft_on(model, contacts, 2e-3));
    let (push, mass, friction, time) = (15.0, 2.0, 0.3, 0.2);
    let speed = (push / mass - friction * G) * time;
    let closed_form = 0.5 * time * time / mass + speed * time / (mass * friction * G);
    // 1e-7 N moves the end by 4e-9 m, which is accurate to about 1e-15 m.
    let e = 1e-7;
    let analytic = pushed(push, implicit, true);
    let chains = [analytic, pushed(push, implicit, false), pushed(push, soft, false)];
    let whole = [
        (pushed(push + e, implicit, true).0 - pushed(push - e, implicit, true).0) / (2.0 * e),
        (pushed(push + e, soft, false).0 - pushed(push - e, soft, false).0) / (2.0 * e),
    ];
    for ((_, chain), whole) in chains.into_iter().zip([whole[0], whole[0], whole[1]]) {
        assert!((chain - whole).abs() < 1e-5 * whole, "{chain} {whole}");
        // The difference is of order h: the block comes to rest in one step of 500.
        assert!((chain - closed_form).abs() < 2e-2 * closed_form, "{chain} {closed_form}");
    }
}

/// A step that jumps by `height` if q is beyond one of these edges.
#[derive(Clone)]
struct Jump {
    edges: [f64; 2],
}

impl Stepper for Jump {
    fn step(
        &mut self,
        _: &Model,
        _: &mut StepWorkspace,
        _: &StepForces<'_>,
        h: f64,
        q: &mut [f64],
        v: &mut [f64],
    ) -> Result<(), StepError> {
        let [below, above] = self.edges;
        v[0] += h * q[0] + if q[0] < below || q[0] > above { 1.0 } else { 0.0 };
        q[0] += h * v[0];
        Ok(())
    }
}

/// Next to a jump the derivative is that of the other side. At a distance it is that of both sides. With
/// jumps on both sides it does not exist.
#[test]
fn jumps_have_no_derivative() {
    let model = Model::new(pendulum(2.0, 0.5)).unwrap();
    let derivatives = |edges: [f64; 2]| {
        let (mut a, mut b) = (vec![0.0; 4], vec![0.0; 2]);
        let (w, forces) = (&mut StepWorkspace::new(&model), StepForces::new(&[0.0], true));
        let out = LinearizedStep { by_state: &mut a, by_force: &mut b };
        linearize_by_differences(
            &model,
            &Jump { edges },
            w,
            &forces,
            H,
            RobotState { q: &[0.0], v: &[0.5] },
            out,
        )
        .map(|()| a)
    };
    let (never, near, far) = (1.0, 1e-8, 4e-6);
    for edges in [[-never, never], [-never, near], [-near, never], [-far, never], [-far, far], [-far, near]] {
        let a = derivatives(edges).unwrap();
        let expected = [1.0 + H * H, H, H, 1.0];
        let off = a.iter().zip(expected).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        assert!(off < 1e-8, "{edges:?}: {a:?}");
    }
    let StepError::Discontinuous { quantity, coordinate } = derivatives([-near, near]).unwrap_err() else {
        panic!("another error");
    };
    assert_eq!((quantity, coordinate.as_str()), ("q", "hinge"));
}
