//! The mass matrix by the composite-rigid-body algorithm, O(n depth).
//!
//! The bodies beyond a joint move as one rigid body when that joint alone accelerates. The momentum that this
//! takes is I^c S. Its component along each ancestor's motion gives that joint's column of M: M_ij = S_iᵀ
//! I^c_j S_j.
//!
//! All motions are expressed in one inertial frame ([`screws`](crate::kinematics::screws)), so no vector is
//! rotated on the way. The columns of a subtree are contiguous: a row of M is the sum of six products of a
//! number with a contiguous array. **(RBDA §6.2)**

mod in_body_frames;

use robot_dynamics_description::check_length;
use robot_dynamics_number::algebra::M3;
use robot_dynamics_number::dispatch::{Hardware, Kernel};
use robot_dynamics_number::{Scalar, View};

use crate::kinematics::screws::{composites_in_world, momentum_of, place_screws};
use crate::kinematics::shifts::pass_inward;
use crate::model::WORLD;
use crate::model::native::NativeFunction;
use crate::model::robot::Dof;
use crate::spatial::screw::{Force, Transform};
use crate::workspace::compiled_once::{OverNumber, compiled_once, run};
use crate::workspace::native::computed_natively;
use crate::workspace::tree::TreeMemory;
use crate::{Model, Workspace};

/// M(q), nv×nv symmetric, row-major, both triangles, with K = ½ vᵀM v \[kg·m², kg·m, kg\]. Armature adds to
/// the diagonal. **(RBDA §6.2)**
///
/// ```
/// use robot_dynamics::algorithms::{kinetic_energy, mass_matrix};
/// use robot_dynamics::model::Workspace;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// let (w, nv) = (&mut Workspace::new(&model), model.nv());
/// let mut mass = vec![0.0; nv * nv];
/// mass_matrix(&model, w, &q, &mut mass);
/// let half: f64 = (0..nv * nv).map(|at| 0.5 * v[at / nv] * mass[at] * v[at % nv]).sum(); // ½ vᵀM v
/// assert!((half / kinetic_energy(&model, w, &q, &v) - 1.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[doc(alias = "CRBA")]
#[inline]
#[track_caller]
pub fn mass_matrix<S: Scalar>(model: &Model, workspace: &mut Workspace<S>, q: &[S], mass: &mut [S]) {
    workspace.check_inputs(model, q);
    check_length("the mass matrix", mass.len(), model.nv * model.nv);
    let native = &mut workspace.tree.native;
    if !computed_natively(model, native, NativeFunction::MassMatrix, &[q], &mut [&mut *mass]) {
        write_mass_matrix(model, workspace, q, mass, Entries::All);
    }
}

/// Writes the selected entries of M. The other entries of `mass` are not read; their values afterwards are
/// unspecified.
#[inline]
#[track_caller]
pub fn write_mass_matrix<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    mass: &mut [S],
    entries: Entries,
) {
    workspace.check_inputs(model, q);
    check_length("the mass matrix", mass.len(), model.nv * model.nv);
    run(&mut workspace.tree, CompositeBodies { model, q, mass, entries });
}

/// Writes the entries of M in the upper triangle that are not always zero, row by row without gaps. Requires
/// [`is_plain`].
pub fn write_packed_mass_matrix(model: &Model, workspace: &mut Workspace, q: &[f64], mass: &mut [f64]) {
    workspace.check_inputs(model, q);
    run(&mut workspace.tree, CompositeBodies { model, q, mass, entries: Entries::Packed });
}

/// Row and column of the entries of M on and above the diagonal that are not always zero. The order is that
/// of `batch::mass_matrix_related`: row by row, and by column within a row; row ≤ column.
///
/// Row i has columns i, i + 1, … to the last DoF in the subtree of i. All other entries above the diagonal
/// are zero in every configuration. A robot with mimic joints, or with armature on tendons over several
/// joints, has the whole triangle.
///
/// ```
/// use robot_dynamics::algorithms::mass_matrix_related_entries;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// // One DoF, one entry.
/// assert_eq!(mass_matrix_related_entries(&Model::new(pendulum(1.0, 1.0))?), [(0, 0)]);
/// # Ok::<(), robot_dynamics::description::ModelError>(())
/// ```
pub fn mass_matrix_related_entries(model: &Model) -> Vec<(usize, usize)> {
    (0..model.nv).flat_map(|i| (i..related_end(model, i)).map(move |j| (i, j))).collect()
}

/// One past the last column of row i among [`mass_matrix_related_entries`].
#[inline(always)]
pub fn related_end(model: &Model, i: usize) -> usize {
    // A mimic joint adds to its leader's coordinate from any place in the tree, and a tendon can span any
    // joints.
    if model.needs_dense_factor { model.nv } else { model.dofs[i].end }
}

/// The arguments of the composite-rigid-body algorithm.
pub struct CompositeBodies<'a, S> {
    pub model: &'a Model,
    pub q: &'a [S],
    pub mass: &'a mut [S],
    pub entries: Entries,
}

/// The entries of M to write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entries {
    All,
    /// Those of two DoFs on one path to the root, in both triangles. With mimic joints, all.
    Related,
    /// The entries of `Related` in the upper triangle. With mimic joints, the whole triangle.
    RelatedAbove,
    /// The same, row after row without gaps. Requires [`is_plain`].
    Packed,
}

/// Whether M is written row by row: no mimic joints, and no reference points that move with slides.
#[inline(always)]
pub fn is_plain(model: &Model) -> bool {
    !model.needs_dense_factor && !model.points.carried
}

compiled_once!(pub CompositeBodiesKind, CompositeBodies);

impl<S: Scalar> Kernel<OverNumber, S> for CompositeBodies<'_, S> {
    #[inline(always)]
    fn run<N: View<S>, H: Hardware>(self, tree: &mut TreeMemory<N>) {
        let Self { model, q, mass, entries } = self;
        let (q, mass) = (N::view(q), N::view_mut(mass));
        if M3::<N>::FOLDS_ZEROS {
            in_body_frames::write_matrix(model, tree, q, mass);
            add_armature(model, mass);
            return;
        }
        place_screws(model, tree, q);
        composites_in_world(model, tree);
        if model.points.carried {
            write_from_point_to_point(model, tree, mass);
            add_armature(model, mass);
            return;
        }
        let (nv, dofs) = (model.nv, model.dofs.len());
        let (composites, columns) = (&tree.inertias.composite[..], &tree.screws.column[..dofs]);
        let rows = &mut tree.blocks.rows[..];
        for (index, dof) in model.dofs.iter().enumerate() {
            write_column(rows, dofs, index, &momentum_of(&composites[dof.body], &columns[index]));
        }
        if entries == Entries::All || model.needs_dense_factor {
            mass.fill(N::zero());
        }
        if model.needs_dense_factor {
            for (i, dof) in model.dofs.iter().enumerate() {
                for j in i..dof.end {
                    add_reduced(model, mass, i, j, project_column(rows, dofs, j, &columns[i]));
                }
            }
        } else {
            let mut packed = 0;
            for (i, dof) in model.dofs.iter().enumerate() {
                let start = if entries == Entries::Packed { packed } else { i * (nv + 1) };
                packed += dof.end - i;
                let (row, below) = mass[start..].split_at_mut(dof.end - i);
                project_columns(rows, dofs, i..dof.end, &columns[i], row);
                if entries == Entries::Packed {
                    if model.has_armature {
                        row[0] += N::from_f64(armature(dof));
                    }
                } else if entries != Entries::RelatedAbove {
                    for (mirror, &entry) in below[nv - dof.end..].chunks_exact_mut(nv).zip(&row[1..]) {
                        mirror[i] = entry;
                    }
                }
            }
            if entries == Entries::Packed {
                return;
            }
        }
        add_armature(model, mass);
    }
}

/// All entries: projects each DoF's momentum on its ancestors, moving the reference point from body to body.
#[inline(always)]
fn write_from_point_to_point<N: Scalar>(model: &Model, tree: &TreeMemory<N>, mass: &mut [N]) {
    mass.fill(N::zero());
    for (j, dof) in model.dofs.iter().enumerate() {
        let mut momentum = momentum_of(&tree.inertias.composite[dof.body], &tree.screws.column[j]);
        let mut at = dof.body;
        while at != WORLD {
            let body = &model.bodies[at];
            for i in body.dof..(body.dof + body.motion.nv()).min(j + 1) {
                add_reduced(model, mass, i, j, tree.screws.column[i].dot(&momentum));
            }
            pass_inward(body, &tree.screws.levers, &mut momentum);
            at = body.parent;
        }
    }
}

#[inline(always)]
fn add_armature<S: Scalar>(model: &Model, mass: &mut [S]) {
    if model.has_armature {
        for dof in &model.dofs {
            mass[dof.coordinate * (model.nv + 1)] += S::from_f64(armature(dof));
        }
        for rotor in &model.rotors {
            for (i, j, entry) in rotor.entries(&model.dofs) {
                mass[i * model.nv + j] += S::from_f64(entry);
            }
        }
    }
}

#[inline(always)]
fn armature(dof: &Dof) -> f64 {
    dof.passive.armature * dof.ratio * dof.ratio
}

/// Writes a force as column `index` of a row-major 6×`width` matrix.
#[inline(always)]
pub fn write_column<S: Scalar>(rows: &mut [S], width: usize, index: usize, force: &Force<S>) {
    let ([fx, fy, fz], [nx, ny, nz]) = (force.linear.array(), force.angular.array());
    let rows = &mut rows[index..=index + 5 * width];
    rows[0] = fx;
    rows[width] = fy;
    rows[2 * width] = fz;
    rows[3 * width] = nx;
    rows[4 * width] = ny;
    rows[5 * width] = nz;
}

/// sᵀ F for the forces F in consecutive columns.
#[inline(always)]
pub fn project_columns<N: Scalar>(
    rows: &[N],
    width: usize,
    columns: core::ops::Range<usize>,
    s: &Force<N>,
    to: &mut [N],
) {
    let [lx, ly, lz] = s.linear.array();
    let [ax, ay, az] = s.angular.array();
    let count = columns.len();
    let row = |k: usize| &rows[k * width + columns.start..][..count];
    let (x0, x1, x2, x3, x4, x5) = (row(0), row(1), row(2), row(3), row(4), row(5));
    let to = &mut to[..count];
    for j in 0..count {
        let linear = lx.mul_add(x0[j], ly.mul_add(x1[j], lz * x2[j]));
        to[j] = ax.mul_add(x3[j], ay.mul_add(x4[j], az.mul_add(x5[j], linear)));
    }
}

/// sᵀ F for the force F in one column.
#[inline(always)]
pub fn project_column<S: Scalar>(rows: &[S], width: usize, column: usize, s: &Force<S>) -> S {
    let row = |k: usize| rows[k * width + column];
    let ([lx, ly, lz], [ax, ay, az]) = (s.linear.array(), s.angular.array());
    lx * row(0) + ly * row(1) + lz * row(2) + ax * row(3) + ay * row(4) + az * row(5)
}

/// Adds a tree entry M_{i j} (and its mirror image) to the reduced matrix GᵀMG.
#[inline(always)]
fn add_reduced<S: Scalar>(model: &Model, mass: &mut [S], i: usize, j: usize, entry: S) {
    let (a, b) = (&model.dofs[i], &model.dofs[j]);
    let entry = entry.scale(a.ratio * b.ratio);
    mass[a.coordinate * model.nv + b.coordinate] += entry;
    if i != j {
        mass[b.coordinate * model.nv + a.coordinate] += entry;
    }
}

/// The same force, about the parent's origin in the parent's frame.
#[inline(always)]
pub fn force_in_parent<S: Scalar>(place: &Transform<S>, force: &Force<S>) -> Force<S> {
    let linear = place.rotation * force.linear;
    Force { linear, angular: place.rotation * force.angular + place.translation.cross(linear) }
}

#[cfg(test)]
mod tests {
    use robot_dynamics_description::{RandomRobotOptions, random_robot};
    use robot_dynamics_number::SplitMix64;

    use super::{Entries, mass_matrix, mass_matrix_related_entries, write_mass_matrix};
    use crate::{Model, Workspace, random_state};

    /// The entries above the diagonal equal those of M to the last bit, on random trees.
    #[test]
    fn the_entries_above_the_diagonal_are_those_of_the_matrix() {
        for seed in 0..40 {
            let model = Model::new(random_robot(seed, &RandomRobotOptions::default())).unwrap();
            let (nv, mut workspace) = (model.nv(), Workspace::new(&model));
            let q = random_state(&model, &mut SplitMix64::new(seed)).q;
            let (mut whole, mut above) = (vec![0.0; nv * nv], vec![f64::NAN; nv * nv]);
            mass_matrix(&model, &mut workspace, &q, &mut whole);
            write_mass_matrix(&model, &mut workspace, &q, &mut above, Entries::RelatedAbove);
            for (i, j) in mass_matrix_related_entries(&model) {
                assert_eq!(above[i * nv + j], whole[i * nv + j], "seed {seed}: {i}, {j}");
            }
        }
    }
}
