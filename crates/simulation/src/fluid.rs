//! The forces of the fluid around a robot.
//!
//! The recursion passes velocities relative to the fluid outward and forces inward, O(n). The fluid moves
//! with one velocity w everywhere. In the frame that moves with it, the base has the velocity −w, and each
//! shape's velocity is the one that its law needs. So the wind needs no other term, also in the derivatives.

mod derivatives;
mod law;
mod pair;

use nalgebra::{Matrix6, Vector3};
use robot_dynamics_core::kinematics::placement::{gather, motion_in_body, place_bodies, spread};
use robot_dynamics_core::model::WORLD;
use robot_dynamics_core::model::identity::Identity;
use robot_dynamics_core::spatial::force::ForceVector;
use robot_dynamics_core::spatial::motion::MotionVector;
use robot_dynamics_core::spatial::transform::Transform;
use robot_dynamics_core::{Model, Workspace};
use robot_dynamics_description::{Pose, check_length};
use robot_dynamics_number::algebra::{M3, V3};

use self::law::ShapeLaw;
use self::pair::Pair;

/// The forces of the fluid on one robot, ready to be evaluated: those of the description's
/// [`medium`](robot_dynamics_description::RobotDescription::medium) on its
/// [`fluid_shapes`](robot_dynamics_description::RobotDescription::fluid_shapes). Simulations include them
/// with the other dissipative forces.
///
/// ```
/// use robot_dynamics::description::{Medium, pendulum};
/// use robot_dynamics::model::Model;
/// use robot_dynamics::simulation::FluidForces;
/// let mut robot = pendulum(2.0, 0.5);
/// robot.immerse(Medium::still(1000.0, 9e-4)); // water
/// let model = Model::new(robot)?;
/// let fluid = FluidForces::new(&model);
/// let (memory, mut tau) = (&mut fluid.workspace(&model), [0.0]);
/// fluid.forces(&model, memory, &[0.3], &[2.0], &mut tau);
/// assert!(tau[0] < 0.0); // it opposes the motion
/// # Ok::<(), robot_dynamics::description::ModelError>(())
/// ```
#[derive(Clone, Debug)]
pub struct FluidForces {
    robot: Identity,
    /// Sorted by body.
    shapes: Vec<PlacedShape>,
    wind: [f64; 3],
}

/// A shape on a moving body.
#[derive(Clone, Debug)]
struct PlacedShape {
    body: usize,
    body_from_shape: Pose,
    law: ShapeLaw,
}

impl PlacedShape {
    fn place(&self) -> Transform<f64> {
        let Pose { rotation, translation } = self.body_from_shape;
        Transform { rotation: M3::from_f64(rotation), translation: V3::from_f64(translation) }
    }
}

/// The memory of the calls of [`FluidForces`].
#[derive(Clone, Debug)]
pub struct FluidWorkspace {
    dynamics: Workspace,
    /// The velocity of each body relative to the fluid, and the force on its subtree, in its frame.
    velocity: Vec<MotionVector<f64>>,
    force: Vec<ForceVector<f64>>,
    /// The generalized forces of the tree's DoFs, and of the coordinates.
    tau: Vec<f64>,
    gathered: Vec<f64>,
    /// The derivative of the force on each body's subtree by a common velocity; empty until it is needed.
    composite: Vec<Matrix6<f64>>,
}

impl FluidWorkspace {
    /// The forces of the last evaluation.
    pub(crate) fn last_forces(&self) -> &[f64] {
        &self.gathered
    }
}

impl FluidForces {
    /// Resolves the shapes of the robot's description. Shapes of links that are fixed to the world have no
    /// effect.
    pub fn new(model: &Model) -> Self {
        let description = model.description();
        let mut shapes = Vec::new();
        if description.medium.acts() {
            for shape in &description.fluid_shapes {
                let Some(frame) = model.frame(&shape.link) else { continue };
                let frame = model.frame_of(frame);
                let Some(body) = frame.body else { continue };
                let body_from_shape = frame.body_from_frame.compose(&shape.link_from_shape);
                let law = ShapeLaw::new(&shape.form, &description.medium);
                shapes.push(PlacedShape { body, body_from_shape, law });
            }
        }
        shapes.sort_by_key(|shape| shape.body);
        Self { robot: model.identity.clone(), shapes, wind: description.medium.wind }
    }

    /// Whether the fluid exerts no forces.
    pub fn is_empty(&self) -> bool {
        self.shapes.is_empty()
    }

    /// Returns memory for the calls.
    pub fn workspace(&self, model: &Model) -> FluidWorkspace {
        let (bodies, dofs) = (model.bodies.len(), model.dofs.len());
        FluidWorkspace {
            dynamics: Workspace::new(model),
            velocity: vec![MotionVector::zero(); bodies],
            force: vec![ForceVector::zero(); bodies],
            tau: vec![0.0; dofs],
            gathered: vec![0.0; model.nv],
            composite: Vec::new(),
        }
    }

    /// Whether the fluid moves, so that it can drive the robot.
    pub(crate) fn has_wind(&self) -> bool {
        self.wind != [0.0; 3]
    }

    /// Whether a motion of each coordinate moves a shape.
    pub(crate) fn moving_coordinates(&self, model: &Model) -> Vec<bool> {
        let (mut carries, mut moves) = (vec![false; model.bodies.len()], vec![false; model.nv]);
        self.shapes.iter().for_each(|shape| carries[shape.body] = true);
        for (i, body) in model.bodies.iter().enumerate().rev().filter(|(_, body)| body.parent != WORLD) {
            carries[body.parent] |= carries[i];
        }
        for dof in model.dofs.iter().filter(|dof| carries[dof.body]) {
            moves[dof.coordinate] = true;
        }
        moves
    }

    /// Writes the generalized forces of the fluid, nv entries \[N·m or N\]. Cost: O(n).
    ///
    /// # Panics
    /// If a slice has the wrong length, or the model belongs to another robot.
    #[track_caller]
    pub fn forces(
        &self,
        model: &Model,
        workspace: &mut FluidWorkspace,
        q: &[f64],
        v: &[f64],
        tau: &mut [f64],
    ) {
        model.check_identity(&self.robot, "the fluid");
        check_length("q", q.len(), model.nq);
        check_length("v", v.len(), model.nv);
        check_length("tau", tau.len(), model.nv);
        self.compute(model, workspace, q, v);
        tau.copy_from_slice(&workspace.gathered);
    }

    /// The generalized forces, also in `workspace.gathered`.
    pub(crate) fn compute<'w>(
        &self,
        model: &Model,
        workspace: &'w mut FluidWorkspace,
        q: &[f64],
        v: &[f64],
    ) -> &'w [f64] {
        self.move_bodies(model, workspace, q, v);
        self.collect(model, workspace);
        gather(model, &workspace.tau, &mut workspace.gathered);
        &workspace.gathered
    }

    /// Each body's velocity relative to the fluid.
    fn move_bodies(&self, model: &Model, workspace: &mut FluidWorkspace, q: &[f64], v: &[f64]) {
        let FluidWorkspace { dynamics, velocity, .. } = workspace;
        let tree = &mut dynamics.tree;
        place_bodies(model, tree, q);
        spread(model, v, &mut tree.dofs.v);
        for (i, body) in model.bodies.iter().enumerate() {
            let parent = if body.parent == WORLD { self.of_base() } else { velocity[body.parent] };
            velocity[i] = motion_in_body(&tree.bodies.place[i], &parent);
            velocity[i].add(&body.motion.velocity(&tree.dofs.v[body.dof..]));
        }
    }

    /// The velocity of the base relative to the fluid.
    fn of_base(&self) -> MotionVector<f64> {
        MotionVector { linear: -V3::from_f64(self.wind), angular: V3::zero() }
    }

    /// The forces on the subtrees, and their components along the DoFs.
    fn collect(&self, model: &Model, workspace: &mut FluidWorkspace) {
        let FluidWorkspace { dynamics, velocity, force, tau, .. } = workspace;
        force.fill(ForceVector::zero());
        for shape in &self.shapes {
            let place = shape.place();
            let own = shape.law.force(&pair(&motion_in_body(&place, &velocity[shape.body])));
            let [linear, angular] = own.map(|part| V3::from_f64(part.into()));
            force[shape.body].add(&place.force_in_parent(&ForceVector { linear, angular }));
        }
        for (i, body) in model.bodies.iter().enumerate().rev() {
            let own = force[i];
            for k in 0..body.motion.nv() {
                tau[body.dof + k] = body.motion.force_along(k, &own);
            }
            if body.parent != WORLD {
                force[body.parent].add(&dynamics.tree.bodies.place[i].force_in_parent(&own));
            }
        }
    }
}

fn pair(motion: &MotionVector<f64>) -> Pair {
    [motion.linear, motion.angular].map(|part| Vector3::from(part.array()))
}
