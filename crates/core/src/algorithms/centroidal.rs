//! Momentum about the centre of mass, and its rate. Cost: O(n).
//!
//! h_G = \[linear; angular about the centre of mass\], along the world's axes, and h_G = A_G(q) v. Only
//! external forces change it: ḣ_G = \[m g; 0\] for a robot in free flight. Links fixed to the world do not
//! contribute. Source: Orin, Goswami, Lee, *Centroidal dynamics of a humanoid robot*, Auton. Robots
//! 35 (2013).

use robot_dynamics_description::check_length;
use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::V3;

use crate::algorithms::center_of_mass::{center, computed_by_mass, whole_momentum, whole_momentum_rate};
use crate::algorithms::jacobian::add_entries;
use crate::kinematics::shifts::from_main;
use crate::kinematics::world_frame::{
    composites_in_world, compute_column_rates, compute_columns, compute_twist_rates, compute_twists,
    inertia_in_world, momentum_of,
};
use crate::model::WORLD;
use crate::model::native::NativeFunction;
use crate::model::reference_point::only_slides;
use crate::spatial::force::ForceVector;
use crate::spatial::inertia::SpatialInertia;
use crate::workspace::tree::TreeMemory;
use crate::{Model, Workspace};

/// A momentum of the whole robot about its centre of mass \[kg·m/s, kg·m²/s\], or its rate \[N, N·m\], along
/// the world's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct CentroidalMomentum<S = f64> {
    /// Linear momentum, m ċ.
    pub linear: [S; 3],
    /// Angular momentum about the centre of mass.
    pub angular: [S; 3],
}

/// h_G: linear momentum, and angular momentum about the centre of mass, along the world's axes.
///
/// ```
/// use robot_dynamics::algorithms::centroidal_momentum;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let momentum = centroidal_momentum(&model, &mut Workspace::<f64>::new(&model), &[0.0], &[3.0]);
/// assert!((momentum.linear[2] + 2.0 * 0.5 * 3.0).abs() < 1e-14); // m l v, downwards
/// assert!(momentum.angular[1].abs() < 1e-14); // zero for a point mass about itself
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
#[track_caller]
pub fn centroidal_momentum<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
) -> CentroidalMomentum<S> {
    workspace.check_inputs(model, q);
    check_length("v", v.len(), model.nv);
    compute_columns(model, &mut workspace.tree, q);
    compute_twists(model, &mut workspace.tree, v);
    let center = center(model, &workspace.tree);
    about(&whole_momentum(model, &workspace.tree), center)
}

/// A_G with h_G = A_G v, 6×nv, row-major: rows linear, then angular about the centre of mass.
///
/// ```
/// use nalgebra::{DMatrix, DVector};
/// use robot_dynamics::algorithms::{centroidal_momentum, centroidal_momentum_matrix};
/// use robot_dynamics::model::Workspace;
/// # use robot_dynamics::algorithms::momentum;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// let (w, mut matrix) = (&mut Workspace::new(&model), vec![0.0; 6 * model.nv()]);
/// centroidal_momentum_matrix(&model, w, &q, &mut matrix);
/// let from_matrix = DMatrix::from_row_slice(6, model.nv(), &matrix) * DVector::from_column_slice(&v);
/// let momentum = centroidal_momentum(&model, w, &q, &v);
/// assert!((0..3).all(|i| (momentum.linear[i] - from_matrix[i]).abs() < 1e-11));
/// assert!((0..3).all(|i| (momentum.angular[i] - from_matrix[3 + i]).abs() < 1e-11));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
#[track_caller]
pub fn centroidal_momentum_matrix<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    matrix: &mut [S],
) {
    workspace.check_inputs(model, q);
    check_length("the centroidal momentum matrix", matrix.len(), 6 * model.nv);
    let native = &mut workspace.tree.native;
    if computed_by_mass(model, native, NativeFunction::CentroidalMomentumMatrix, q, matrix) {
        return;
    }
    compute_columns(model, &mut workspace.tree, q);
    composites_in_world(model, &mut workspace.tree);
    if model.points.several {
        complete_sliding(model, &mut workspace.tree);
    }
    let center = center(model, &workspace.tree);
    matrix.fill(S::zero());
    for (index, dof) in model.dofs.iter().enumerate() {
        // I^c S: the momentum of the DoF's subtree when the DoF moves alone.
        let ForceVector { linear, angular } =
            momentum_of(&workspace.tree.inertias.composite[dof.body], &workspace.tree.world.column[index]);
        let mut center = center;
        if model.points.several {
            center -= from_main(model, &workspace.tree, dof.body);
        }
        add_entries(model, matrix, index, linear, angular - center.cross(linear));
    }
}

/// The first moments of the subtrees of sliding bodies, each about its body's reference point.
///
/// [`composites_in_world`] adds moments taken about different points. Its masses and forces are right, and
/// the equation of motion needs only those.
#[inline(always)]
fn complete_sliding<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>) {
    for (i, body) in model.bodies.iter().enumerate().filter(|(_, body)| only_slides(body)) {
        tree.inertias.composite[i].first_moment = inertia_in_world(body, &tree.world.pose[i]).first_moment;
    }
    for (i, body) in model.bodies.iter().enumerate().rev() {
        if body.parent != WORLD && only_slides(&model.bodies[body.parent]) {
            let SpatialInertia { mass, first_moment, .. } = tree.inertias.composite[i];
            let lever = tree.world.points[body.point] - tree.world.points[model.bodies[body.parent].point];
            tree.inertias.composite[body.parent].first_moment += first_moment.add_scaled(mass, lever);
        }
    }
}

/// ḣ_G at the acceleration a, A_G a + Ȧ_G v: the external force, gravity included, and its moment about the
/// centre of mass.
///
/// ```
/// use robot_dynamics::algorithms::centroidal_momentum_rate;
/// use robot_dynamics::model::Workspace;
/// # use robot_dynamics::description::{Base, RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let options = RandomRobotOptions { base: Base::Floating, ..Default::default() };
/// # let model = Model::new(random_robot(3, &options))?;
/// # let RandomState { q, v, mut tau, .. } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// // In free flight the motors move the links, but do not change the momentum of the whole robot.
/// tau[..6].fill(0.0); // no force on the base
/// let a = model.forward_dynamics(&q, &v, &tau)?;
/// let rate = centroidal_momentum_rate(&model, &mut Workspace::new(&model), &q, &v, a.as_slice());
/// assert!(rate.angular.iter().all(|moment| moment.abs() < 1e-9));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
#[track_caller]
pub fn centroidal_momentum_rate<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    a: &[S],
) -> CentroidalMomentum<S> {
    workspace.check_inputs(model, q);
    check_length("v", v.len(), model.nv);
    check_length("a", a.len(), model.nv);
    rate(model, &mut workspace.tree, q, v, Some(a))
}

/// Ȧ_G v: ḣ_G at a = 0.
///
/// ```
/// use robot_dynamics::algorithms::centroidal_momentum_bias_rate;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // The centripetal force on the mass: m l v², towards the hinge.
/// let rate = centroidal_momentum_bias_rate(&model, &mut Workspace::<f64>::new(&model), &[0.0], &[3.0]);
/// assert!((rate.linear[0] + 2.0 * 0.5 * 3.0 * 3.0).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
#[track_caller]
pub fn centroidal_momentum_bias_rate<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
) -> CentroidalMomentum<S> {
    workspace.check_inputs(model, q);
    check_length("v", v.len(), model.nv);
    rate(model, &mut workspace.tree, q, v, None)
}

/// d/dt (n − c × f) = ṅ − c × ḟ, because ċ is along f.
#[inline(always)]
fn rate<S: Scalar>(
    model: &Model,
    tree: &mut TreeMemory<S>,
    q: &[S],
    v: &[S],
    a: Option<&[S]>,
) -> CentroidalMomentum<S> {
    compute_columns(model, tree, q);
    compute_twists(model, tree, v);
    compute_column_rates(model, tree);
    compute_twist_rates(model, tree, a);
    let center = center(model, tree);
    about(&whole_momentum_rate(model, tree), center)
}

#[inline(always)]
fn about<S: Scalar>(momentum: &ForceVector<S>, center: V3<S>) -> CentroidalMomentum<S> {
    let angular = momentum.angular - center.cross(momentum.linear);
    CentroidalMomentum { linear: momentum.linear.array(), angular: angular.array() }
}
