//! The Christoffel symbols of the mass matrix, from Coriolis matrices of single freedoms.

use dynamics::Scalar;

use crate::algorithms::coriolis::Branch;
use crate::model::length::check_length;
use crate::model::{Body, WORLD};
use crate::scratch::tree::TreeMemory;
use crate::spatial::screw::{Composite, Flow, Force, Screw};
use crate::stages::screws::{composites_in_world, motion_cross, place_screws, shifted};
use crate::stages::shifts::{lever_between, pass_flow, pass_inertia};
use crate::{Model, Workspace};

/// Γⁱⱼₖ as a table of nv³ numbers, `symbols[(i nv + j) nv + k]`: C_ij = Σₖ Γⁱⱼₖ vₖ, O(n depth²) beside
/// clearing the table. **(PRM 10.9)**
///
/// Symmetric in j and k where q is plain numbers. The matrix of slice k is C(q, eₖ): with freedom k alone in
/// motion, everything beyond it moves as one rigid body.
///
/// ```
/// use multibody::{Workspace, christoffel_symbols};
/// # use multibody::*;
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut dynamics::SplitMix64::new(1));
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
    workspace.admit(model, q);
    let nv = model.nv;
    check_length("the table of Christoffel symbols", symbols.len(), nv * nv * nv);
    place_screws(model, &mut workspace.tree, q);
    composites_in_world(model, &mut workspace.tree);
    symbols.fill(S::zero());
    for (moving, body) in model.bodies.iter().enumerate() {
        let end = subtree_end(model, moving);
        for k in body.dof..body.dof + body.motion.nv() {
            let mut table = SymbolTable { model, symbols, k, moving };
            // Freedoms that ride on k: what lies beyond them moves with S_k.
            for i in moving..end {
                let inertia = workspace.tree.inertias.composite[i];
                let flow = Flow::of(&inertia, &table.moving_screw(&workspace.tree, i));
                table.add_body(&workspace.tree, i, &inertia, &flow);
            }
            // Freedoms that carry k: of what lies beyond them, only the part beyond k moves.
            let mut inertia = workspace.tree.inertias.composite[moving];
            let mut flow = Flow::of(&inertia, &workspace.tree.screws.column[k]);
            let mut below = body;
            while below.parent != WORLD {
                pass_inertia(below, &workspace.tree.screws.levers, &mut inertia);
                pass_flow(below, &workspace.tree.screws.levers, &mut flow);
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
    /// The one freedom that moves, and its body.
    k: usize,
    moving: usize,
}

impl<S: Scalar> SymbolTable<'_, S> {
    /// The entries of C(q, eₖ) between the freedoms of body `i` and those on its way to the root.
    #[inline(always)]
    fn add_body(&mut self, tree: &TreeMemory<S>, i: usize, inertia: &Composite<S>, flow: &Flow<S>) {
        let model = self.model;
        let body = &model.bodies[i];
        for dof in body.dof..body.dof + body.motion.nv() {
            let s = &tree.screws.column[dof];
            let mut branch = Branch::new(inertia, flow, s, &self.rate(tree, i, s));
            for other in body.dof..body.dof + body.motion.nv() {
                self.add(other, dof, branch.above(&tree.screws.column[other]));
            }
            branch.pass_inward(body, &tree.screws.levers);
            let mut at = body.parent;
            while at != WORLD {
                let ancestor = &model.bodies[at];
                for other in ancestor.dof..ancestor.dof + ancestor.motion.nv() {
                    let s = &tree.screws.column[other];
                    self.add(other, dof, branch.above(s));
                    self.add(dof, other, branch.beyond(s, &self.rate(tree, at, s)));
                }
                branch.pass_inward(ancestor, &tree.screws.levers);
                at = ancestor.parent;
            }
        }
    }

    /// S_k from the reference point of a body that rides on k.
    #[inline(always)]
    fn moving_screw(&self, tree: &TreeMemory<S>, body: usize) -> Screw<S> {
        shifted(&tree.screws.column[self.k], lever_between(self.model, tree, self.moving, body))
    }

    /// Ṡ = S_k × S for a freedom that rides on k, else 0. Called for bodies on one branch with k only.
    #[inline(always)]
    fn rate(&self, tree: &TreeMemory<S>, body: usize, s: &Screw<S>) -> Screw<S> {
        if body >= self.moving { motion_cross(&self.moving_screw(tree, body), s) } else { Force::zero() }
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
