//! The Christoffel symbols of the mass matrix, from Coriolis matrices of single DoFs.
//!
//! Γⁱⱼₖ = ½(∂M_ij/∂qₖ + ∂M_ik/∂qⱼ − ∂M_jk/∂qᵢ) if q̇ = v for every joint. Slice k is the Coriolis matrix C(q,
//! eₖ) of unit motion of DoF k alone. Cost: O(n depth²). **(PRM 10.9)**

use robot_dynamics_description::check_length;
use robot_dynamics_number::Scalar;

use crate::algorithms::coriolis::Branch;
use crate::kinematics::shifts::{lever_between, pass_flow, pass_inertia};
use crate::kinematics::world_frame::{composites_in_world, compute_columns, motion_cross, shifted};
use crate::model::{Body, WORLD};
use crate::spatial::inertia::{MassFlux, SpatialInertia};
use crate::spatial::motion::MotionVector;
use crate::workspace::tree::TreeMemory;
use crate::{Model, Workspace};

/// Γⁱⱼₖ as a table of nv³ numbers, `symbols[(i nv + j) nv + k]`, with C_ij = Σₖ Γⁱⱼₖ vₖ. O(n depth²), and
/// O(n³) to clear the table. **(PRM 10.9)**
///
/// The symbols are symmetric in j and k if q̇ = v for every joint. Slice k is the matrix C(q, eₖ): with DoF k
/// alone in motion, its subtree moves as one rigid body.
///
/// ```
/// use robot_dynamics::algorithms::christoffel_symbols;
/// use robot_dynamics::model::Workspace;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// let nv = model.nv();
/// let mut symbols = vec![0.0; nv * nv * nv];
/// christoffel_symbols(&model, &mut Workspace::new(&model), &q, &mut symbols);
/// let c = model.coriolis_matrix(&q, &v)?;
/// let entry = |i, j| (0..nv).map(|k| symbols[(i * nv + j) * nv + k] * v[k]).sum::<f64>();
/// assert!((0..nv * nv).all(|at| (entry(at / nv, at % nv) - c[(at / nv, at % nv)]).abs() < 1e-11));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
#[track_caller]
pub fn christoffel_symbols<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    symbols: &mut [S],
) {
    workspace.check_inputs(model, q);
    let nv = model.nv;
    check_length("the table of Christoffel symbols", symbols.len(), nv * nv * nv);
    compute_columns(model, &mut workspace.tree, q);
    composites_in_world(model, &mut workspace.tree);
    symbols.fill(S::zero());
    for (moving, body) in model.bodies.iter().enumerate() {
        let end = subtree_end(model, moving);
        for k in body.dof..body.dof + body.motion.nv() {
            let mut table = SymbolTable { model, symbols, k, moving };
            // Descendants i of k: the whole subtree of i moves with S_k.
            for i in moving..end {
                let inertia = workspace.tree.inertias.composite[i];
                let flow = MassFlux::of(&inertia, &table.moving_screw(&workspace.tree, i));
                table.add_body(&workspace.tree, i, &inertia, &flow);
            }
            // Ancestors i of k: only the part of the subtree of i beyond k moves.
            let mut inertia = workspace.tree.inertias.composite[moving];
            let mut flow = MassFlux::of(&inertia, &workspace.tree.world.column[k]);
            let mut below = body;
            while below.parent != WORLD {
                pass_inertia(below, &workspace.tree.world.levers, &mut inertia);
                pass_flow(below, &workspace.tree.world.levers, &mut flow);
                table.add_body(&workspace.tree, below.parent, &inertia, &flow);
                below = &model.bodies[below.parent];
            }
        }
    }
}

/// One past the last body of a subtree: bodies are numbered depth first.
fn subtree_end(model: &Model, root: usize) -> usize {
    let outside = |body: &Body| body.parent == WORLD || body.parent < root;
    let beyond = &model.bodies[root + 1..];
    root + 1 + beyond.iter().position(outside).unwrap_or(beyond.len())
}

struct SymbolTable<'a, S> {
    model: &'a Model,
    symbols: &'a mut [S],
    /// The one DoF that moves, and its body.
    k: usize,
    moving: usize,
}

impl<S: Scalar> SymbolTable<'_, S> {
    /// Adds the entries of C(q, eₖ) between the DoFs of body `i` and its ancestors.
    #[inline(always)]
    fn add_body(&mut self, tree: &TreeMemory<S>, i: usize, inertia: &SpatialInertia<S>, flow: &MassFlux<S>) {
        let model = self.model;
        let body = &model.bodies[i];
        for dof in body.dof..body.dof + body.motion.nv() {
            let s = &tree.world.column[dof];
            let mut branch = Branch::new(inertia, flow, s, &self.rate(tree, i, s));
            for other in body.dof..body.dof + body.motion.nv() {
                self.add(other, dof, branch.above(&tree.world.column[other]));
            }
            branch.pass_inward(body, &tree.world.levers);
            let mut at = body.parent;
            while at != WORLD {
                let ancestor = &model.bodies[at];
                for other in ancestor.dof..ancestor.dof + ancestor.motion.nv() {
                    let s = &tree.world.column[other];
                    self.add(other, dof, branch.above(s));
                    self.add(dof, other, branch.beyond(s, &self.rate(tree, at, s)));
                }
                branch.pass_inward(ancestor, &tree.world.levers);
                at = ancestor.parent;
            }
        }
    }

    /// S_k about the reference point of a descendant of k.
    #[inline(always)]
    fn moving_screw(&self, tree: &TreeMemory<S>, body: usize) -> MotionVector<S> {
        shifted(&tree.world.column[self.k], lever_between(self.model, tree, self.moving, body))
    }

    /// Ṡ = S_k × S for a descendant of k, else 0. Called only for bodies on one branch with k.
    #[inline(always)]
    fn rate(&self, tree: &TreeMemory<S>, body: usize, s: &MotionVector<S>) -> MotionVector<S> {
        if body >= self.moving {
            motion_cross(&self.moving_screw(tree, body), s)
        } else {
            MotionVector::zero()
        }
    }

    #[inline(always)]
    fn add(&mut self, i: usize, j: usize, entry: S) {
        let dof = |index: usize| &self.model.dofs[index];
        let (a, b, c) = (dof(i), dof(j), dof(self.k));
        let nv = self.model.nv;
        let at = (a.coordinate * nv + b.coordinate) * nv + c.coordinate;
        self.symbols[at] += entry.scale(a.ratio * b.ratio * c.ratio);
    }
}
