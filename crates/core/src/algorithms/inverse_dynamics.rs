//! Inverse dynamics by the recursive Newton–Euler algorithm, O(n).
//!
//! The outward pass finds each body's motion. The inward pass sums the forces that this motion needs and
//! projects them on the DoFs. Gravity enters as an upward acceleration of the world.
//!
//! There are two forms. The form in body frames takes the fewest operations and suits several states side by
//! side. The form along the world's axes has the shortest chain of dependent operations and suits one state
//! in vector registers. Source: RBDA §5.3; Luh, Walker, Paul, *On-line computational scheme for mechanical
//! manipulators*, J. Dyn. Sys. Meas. Control 102 (1980).

mod body_frames;
mod world_axes;

use robot_dynamics_description::check_length;
use robot_dynamics_number::algebra::M3;
use robot_dynamics_number::dispatch::{Hardware, Kernel};
use robot_dynamics_number::{Scalar, View};

use crate::kinematics::placement::{evaluate_angles, gather, spread};
use crate::kinematics::wrench::{FrameWrench, subtract_wrenches};
use crate::model::native::NativeFunction;
use crate::workspace::compiled_once::{compiled_once, run};
use crate::workspace::native::computed_natively;
use crate::workspace::tree::{TreeMemory, TreeStorage};
use crate::{Model, Workspace};

pub(crate) use self::body_frames::accelerate_bodies;
pub(crate) use self::world_axes::accelerate_bodies as accelerate_along_world_axes;

/// The arguments of a Newton–Euler recursion. If `v` or `a` is absent, it is zero.
pub struct NewtonEuler<'a, S> {
    pub model: &'a Model,
    pub q: &'a [S],
    pub v: Option<&'a [S]>,
    pub a: Option<&'a [S]>,
    /// The world's acceleration: −gravity, or zero.
    pub ground: [f64; 3],
    pub with_springs: bool,
    pub wrenches: &'a [FrameWrench<S>],
    pub tau: &'a mut [S],
}

compiled_once!(NewtonEuler);

impl<'a, S: Scalar> NewtonEuler<'a, S> {
    /// C v + g and the springs' forces.
    #[inline(always)]
    pub fn bias(model: &'a Model, q: &'a [S], v: &'a [S], tau: &'a mut [S]) -> Self {
        let ground = upward(model);
        Self { model, q, v: Some(v), a: None, ground, with_springs: true, wrenches: &[], tau }
    }
}

impl<S: Scalar> Kernel<TreeStorage, S> for NewtonEuler<'_, S> {
    #[inline(always)]
    fn run<N: View<S>, H: Hardware>(self, tree: &mut TreeMemory<N>) {
        let Self { model, q, v, a, ground, with_springs, wrenches, tau } = self;
        let q = N::view(q);
        evaluate_angles(model, tree, q);
        match v {
            Some(v) => spread(model, N::view(v), &mut tree.dofs.v),
            None => tree.dofs.v.fill(Scalar::zero()),
        }
        match a {
            Some(a) => spread(model, N::view(a), &mut tree.dofs.a),
            None => tree.dofs.a.fill(Scalar::zero()),
        }
        if M3::<N>::KEEPS_TRANSPOSE {
            world_axes::accelerate_bodies(model, tree, q, ground);
            world_axes::subtract_external(model, tree, wrenches);
            world_axes::collect_forces(model, tree);
        } else {
            accelerate_bodies(model, tree, q, ground);
            subtract_wrenches(model, &mut tree.bodies.force, wrenches);
            body_frames::collect_forces(model, tree);
        }
        if model.has_armature {
            for ((tau, a), dof) in tree.dofs.tau.iter_mut().zip(&tree.dofs.a).zip(&model.dofs) {
                *tau += a.scale(dof.passive.armature);
            }
            for rotor in &model.rotors {
                rotor.add_force(&tree.dofs.a, &mut tree.dofs.tau);
            }
        }
        if with_springs && model.has_springs {
            for (tau, dof) in tree.dofs.tau.iter_mut().zip(&model.dofs) {
                let stretch = tree.angles.angle[dof.body] - N::from_f64(dof.passive.rest);
                *tau += stretch.scale(dof.passive.stiffness);
            }
        }
        gather(model, &tree.dofs.tau, N::view_mut(tau));
    }
}

/// The gravitational acceleration with opposite sign.
pub fn upward(model: &Model) -> [f64; 3] {
    model.gravity().map(|g| -g)
}

/// τ = M(q) a + C(q,v) v + g(q): the generalized forces that produce the acceleration a. **(RBDA §5.3)**
///
/// q has `nq` entries; v, a and tau have `nv`. τ is in N·m or N. M includes armature, and g includes springs.
/// Damping and friction are separate, in [`dissipation`](crate::dissipation).
///
/// ```
/// use robot_dynamics::algorithms::inverse_dynamics;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let mut tau = [0.0];
/// inverse_dynamics(&model, &mut Workspace::new(&model), &[0.3], &[1.0], &[2.0], &mut tau);
/// // m l² a − m g l cos q
/// assert!((tau[0] - (2.0 * 0.25 * 2.0 - 2.0 * 9.81 * 0.5 * 0.3_f64.cos())).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[doc(alias = "RNEA")]
#[inline]
#[track_caller]
pub fn inverse_dynamics<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    a: &[S],
    tau: &mut [S],
) {
    inverse_dynamics_with_wrenches(model, workspace, q, v, a, &[], tau);
}

/// τ = M(q) a + C(q,v) v + g(q) − Σ Jᵀw: inverse dynamics under external wrenches w that act on frames.
///
/// ```
/// use robot_dynamics::algorithms::{FrameWrench, inverse_dynamics_with_wrenches};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // A thruster at the tip cancels the weight, so the motor's torque is zero.
/// let (frame, mut tau) = (model.frame_named("tip")?, [1.0]);
/// let lift = FrameWrench { frame, force_in_frame: [0.0, 0.0, 2.0 * 9.81], moment_in_frame: [0.0; 3] };
/// let w = &mut Workspace::<f64>::new(&model);
/// inverse_dynamics_with_wrenches(&model, w, &[0.0], &[0.0], &[0.0], &[lift], &mut tau);
/// assert!(tau[0].abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
#[track_caller]
pub fn inverse_dynamics_with_wrenches<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    a: &[S],
    wrenches: &[FrameWrench<S>],
    tau: &mut [S],
) {
    workspace.check_inputs(model, q);
    check_length("v", v.len(), model.nv);
    check_length("a", a.len(), model.nv);
    check_length("tau", tau.len(), model.nv);
    let native = &mut workspace.tree.native;
    let function = NativeFunction::InverseDynamics;
    if wrenches.is_empty() && computed_natively(model, native, function, &[q, v, a], &mut [&mut *tau]) {
        return;
    }
    let ground = upward(model);
    run(
        &mut workspace.tree,
        NewtonEuler { model, q, v: Some(v), a: Some(a), ground, with_springs: true, wrenches, tau },
    );
}

/// C(q,v) v + g(q), the result of inverse dynamics at a = 0 \[N·m, N\].
///
/// ```
/// use robot_dynamics::algorithms::bias;
/// use robot_dynamics::model::Workspace;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// let mut forces = vec![0.0; model.nv()];
/// bias(&model, &mut Workspace::new(&model), &q, &v, &mut forces);
/// let sum = model.velocity_product(&q, &v)? + model.gravity_forces(&q)?;
/// assert!(forces.iter().zip(&sum).all(|(force, sum)| (force - sum).abs() < 1e-11));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[doc(alias = "nonlinear effects")]
#[track_caller]
pub fn bias<S: Scalar>(model: &Model, workspace: &mut Workspace<S>, q: &[S], v: &[S], bias: &mut [S]) {
    workspace.check_inputs(model, q);
    check_length("v", v.len(), model.nv);
    check_length("bias", bias.len(), model.nv);
    let native = &mut workspace.tree.native;
    if computed_natively(model, native, NativeFunction::Bias, &[q, v], &mut [&mut *bias]) {
        return;
    }
    bias_by_recursion(model, workspace, q, v, bias);
}

/// C(q,v) v + g(q) by the recursion, even if machine code is available.
pub fn bias_by_recursion<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    bias: &mut [S],
) {
    run(&mut workspace.tree, NewtonEuler::bias(model, q, v, bias));
}

/// C(q,v) v: the Coriolis and centrifugal forces alone \[N·m, N\].
///
/// ```
/// use robot_dynamics::algorithms::velocity_product;
/// use robot_dynamics::model::Workspace;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// // Twice the speed gives four times the forces.
/// let (w, twice) = (&mut Workspace::new(&model), v.iter().map(|v| 2.0 * v).collect::<Vec<f64>>());
/// let (mut slow, mut fast) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
/// velocity_product(&model, w, &q, &v, &mut slow);
/// velocity_product(&model, w, &q, &twice, &mut fast);
/// assert!(slow.iter().zip(&fast).all(|(slow, fast)| (fast - 4.0 * slow).abs() < 1e-12 * (1.0 + fast.abs())));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn velocity_product<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    product: &mut [S],
) {
    workspace.check_inputs(model, q);
    check_length("v", v.len(), model.nv);
    check_length("product", product.len(), model.nv);
    let native = &mut workspace.tree.native;
    if computed_natively(model, native, NativeFunction::VelocityProduct, &[q, v], &mut [&mut *product]) {
        return;
    }
    let ground = [0.0; 3];
    let task = NewtonEuler {
        model,
        q,
        v: Some(v),
        a: None,
        ground,
        with_springs: false,
        wrenches: &[],
        tau: product,
    };
    run(&mut workspace.tree, task);
}

/// g(q) = ∂V/∂q: the forces that hold the robot at rest against gravity and its springs \[N·m, N\].
///
/// ```
/// use robot_dynamics::algorithms::gravity;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let mut g = [0.0];
/// gravity(&model, &mut Workspace::new(&model), &[0.3], &mut g);
/// assert!((g[0] + 2.0 * 9.81 * 0.5 * 0.3_f64.cos()).abs() < 1e-14); // −m g l cos q: gravity acts towards larger q
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn gravity<S: Scalar>(model: &Model, workspace: &mut Workspace<S>, q: &[S], gravity: &mut [S]) {
    workspace.check_inputs(model, q);
    check_length("gravity", gravity.len(), model.nv);
    let native = &mut workspace.tree.native;
    if computed_natively(model, native, NativeFunction::Gravity, &[q], &mut [&mut *gravity]) {
        return;
    }
    let ground = upward(model);
    let task =
        NewtonEuler { model, q, v: None, a: None, ground, with_springs: true, wrenches: &[], tau: gravity };
    run(&mut workspace.tree, task);
}
