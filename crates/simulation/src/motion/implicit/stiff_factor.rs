//! M̂ = M + γhD + (γh)²K and its sparse factor. The sparsity is that of the tree, minus the zeros that
//! tendons between branches fill.

use robot_dynamics_core::algorithms::mass_matrix::{
    Entries, is_plain, related_end, write_mass_matrix, write_packed_mass_matrix,
};
use robot_dynamics_core::clone_in_place::clone_in_place;
use robot_dynamics_core::factorization::paths::Paths;
use robot_dynamics_core::factorization::sparse;
use robot_dynamics_core::factorization::sparse::coordinate_parents;
use robot_dynamics_core::{Model, Workspace, integrate, mass_rank, neutral};
use robot_dynamics_integrators::IntegratorError;

use super::joints::Joints;
use crate::actuation::Coupling;

/// Armature of each joint, relative to the inertia that it moves. It is added if M is singular here but
/// regular in general, as when hinges become coaxial. It keeps the pivots above rounding and the motion
/// without inertia finite.
const ARMATURE: f64 = 1e-9;

/// With more coordinates than this, M is stored without its structural zeros. Robots with mimic joints, or
/// with slides that shift their reference point, are excepted.
const LARGE: usize = 512;

/// A pivot below this fraction of M's diagonal counts as nearly zero.
const NEARLY: f64 = 1e-10;

clone_in_place! {
    /// The matrix M, and the factorization M̂ = LᵀDL.
    #[derive(Debug)]
    pub(super) struct StiffFactor {
        paths: Paths,
        /// Whether couplings may add entries to the sparsity of M.
        is_coupled: bool,
        /// The upper triangle of M, for many coordinates without its structural zeros if possible; then M and
        /// the factor of M̂, packed.
        mass: Vec<f64>,
        /// The start of each row of `mass` and of the row after it, if structural zeros are not stored.
        begins: Option<Vec<usize>>,
        packed: Vec<f64>,
        entries: Vec<f64>,
        /// The damping matrix of a fluid, packed; empty without a fluid.
        fluid: Vec<f64>,
        /// Whether M is regular in some pose.
        is_regular: bool,
        /// The tree of each coordinate, and the armature of each tree in the last factor, relative to M's
        /// diagonal.
        trees: Vec<usize>,
        armature: Vec<f64>,
    }
}

impl StiffFactor {
    pub(super) fn new(model: &Model) -> Self {
        let n = model.nv;
        let mut paths = Paths::new(n);
        paths.choose(&coordinate_parents(model));
        let (packed, entries) = (vec![0.0; paths.size()], vec![0.0; paths.size()]);
        let begins = (n > LARGE && is_plain(model)).then(|| row_begins(model));
        let size = begins.as_ref().and_then(|begins| begins.last().copied()).unwrap_or(n * n);
        let (mass, is_regular) = (vec![0.0; size], is_regular_somewhere(model));
        let trees = sparse::trees(paths.dof_parent()).0;
        let armature = vec![0.0; n];
        let fluid = Vec::new();
        Self { paths, is_coupled: false, mass, begins, packed, entries, fluid, is_regular, trees, armature }
    }

    /// Extends the sparsity for these couplings: an ancestor of one of their coordinates counts as an
    /// ancestor of the others.
    pub(super) fn couple(&mut self, couplings: &[Coupling]) {
        let mut dof_parent = self.paths.dof_parent().to_vec();
        for pair in couplings.iter().flat_map(|coupling| coupling.row.windows(2)) {
            sparse::couple(&mut dof_parent, [pair[0].0, pair[1].0]);
        }
        self.is_coupled |= dof_parent != self.paths.dof_parent();
        self.paths.choose(&dof_parent);
        self.trees = sparse::trees(&dof_parent).0;
        for entries in [&mut self.packed, &mut self.entries] {
            entries.resize(self.paths.size(), 0.0);
        }
    }

    /// Sets the damping matrix of a fluid to 0.
    pub(super) fn clear_damping(&mut self) {
        self.fluid.clear();
        self.fluid.resize(self.paths.size(), 0.0);
    }

    /// Adds an entry on or below the diagonal to the damping matrix of a fluid.
    pub(super) fn add_damping(&mut self, row: usize, column: usize, entry: f64) {
        *self.paths.entry_of(row, column, &mut self.fluid) += entry;
    }

    /// `product` = D x with the damping matrix of a fluid; `false` without a fluid.
    pub(super) fn multiply_damping(&self, x: &[f64], product: &mut [f64]) -> bool {
        let has_fluid = !self.fluid.is_empty();
        if has_fluid {
            self.paths.multiply(&self.fluid, x, product);
        }
        has_fluid
    }

    /// Evaluates M at q and factors M̂ with g = γh.
    ///
    /// # Errors
    /// [`IntegratorError::SingularMass`] with the degree of freedom whose pivot is not above the rounding of
    /// its row.
    pub(super) fn factor(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        q: &[f64],
        joints: &Joints,
        g: f64,
    ) -> Result<(), IntegratorError> {
        let Self { mass, packed, paths, begins, .. } = self;
        if let Some(begins) = begins {
            write_packed_mass_matrix(model, workspace, q, mass);
            paths.pack_rows(mass, begins, packed);
        } else {
            let entries = if self.is_coupled { Entries::All } else { Entries::RelatedAbove };
            write_mass_matrix(model, workspace, q, mass, entries);
            paths.pack_upper(mass, packed);
        }
        self.stiffen(joints, g)
    }

    /// Factors M̂ with another g and the current M.
    ///
    /// # Errors
    /// As [`factor`](Self::factor).
    pub(super) fn stiffen(&mut self, joints: &Joints, g: f64) -> Result<(), IntegratorError> {
        self.armature.fill(0.0);
        let watched = self.watched(joints, g);
        if !self.is_regular {
            return watched;
        }
        let pivots = self.paths.diagonal(&self.entries).zip(self.paths.diagonal(&self.packed));
        for ((pivot, mass), tree) in pivots.zip(&self.trees) {
            // NaN fails this test as well.
            if !(pivot / mass > NEARLY && pivot.is_finite()) {
                self.armature[*tree] = ARMATURE;
            }
        }
        if self.armature.iter().all(|armature| *armature == 0.0) {
            return watched;
        }
        self.watched(joints, g)
    }

    fn watched(&mut self, joints: &Joints, g: f64) -> Result<(), IntegratorError> {
        self.entries.copy_from_slice(&self.packed);
        let Self { paths, entries, fluid, trees, armature, .. } = self;
        stiffen_entries(paths, joints, fluid, (g, trees, armature), entries);
        self.paths.factor_by_division(&mut self.entries);
        let pivots = self.paths.diagonal(&self.entries).zip(self.paths.diagonal(&self.packed));
        sparse::check_pivots(pivots)
    }

    /// Whether the last factor contains armature, because M is singular in this configuration.
    pub(super) fn has_armature(&self) -> bool {
        self.armature.iter().any(|armature| *armature != 0.0)
    }

    /// The sum of M's diagonal over these coordinates.
    pub(super) fn mass_trace(&self, is_own: impl Fn(usize) -> bool) -> f64 {
        let diagonal = self.paths.diagonal(&self.packed).enumerate();
        diagonal.filter(|(k, _)| is_own(*k)).map(|(_, mass)| mass).sum()
    }

    /// The pivots relative to M's diagonal.
    pub(super) fn pivots(&self) -> impl Iterator<Item = f64> {
        let pivots = self.paths.diagonal(&self.entries).zip(self.paths.diagonal(&self.packed));
        pivots.map(|(pivot, mass)| pivot / mass)
    }

    /// x ← M̂⁻¹x.
    pub(super) fn solve(&self, x: &mut [f64]) {
        self.paths.solve(&self.entries, x);
    }

    /// Writes the packed M̂ to `matrix`.
    pub(super) fn write(&self, joints: &Joints, g: f64, matrix: &mut Vec<f64>) {
        matrix.clone_from(&self.packed);
        stiffen_entries(&self.paths, joints, &self.fluid, (g, &self.trees, &self.armature), matrix);
    }

    /// The sparsity of the entries.
    pub(super) fn paths(&self) -> &Paths {
        &self.paths
    }

    /// `product` = M x.
    pub(super) fn multiply_mass(&self, x: &[f64], product: &mut [f64]) {
        self.paths.multiply(&self.packed, x, product);
    }
}

/// M + gD + g²K for a packed M, with the armature of each tree relative to its diagonal. D includes the
/// damping matrix of a fluid, unless that is empty.
fn stiffen_entries(
    paths: &Paths,
    joints: &Joints,
    fluid: &[f64],
    (g, trees, armature): (f64, &[usize], &[f64]),
    entries: &mut [f64],
) {
    for k in 0..paths.dof_parent().len() {
        let (diagonal, (stiffness, damping)) = (paths.diagonal_of(k, entries), joints.derivatives(k));
        let mass = *diagonal;
        *diagonal = mass + g * (damping + g * stiffness) + armature[trees[k]] * mass;
    }
    for (row, column, entry) in joints.couplings().iter().flat_map(|coupling| coupling.entries(g)) {
        *paths.entry_of(row, column, entries) += entry;
    }
    entries.iter_mut().zip(fluid).for_each(|(entry, damping)| *entry += g * damping);
}

/// The start of each row of M's upper triangle without structural zeros, and the end of the last row.
fn row_begins(model: &Model) -> Vec<usize> {
    let mut end = 0;
    let ends = (0..model.nv).map(|row| {
        end += related_end(model, row) - row;
        end
    });
    core::iter::once(0).chain(ends).collect()
}

/// Whether M is regular in a pose without symmetry.
fn is_regular_somewhere(model: &Model) -> bool {
    let way: Vec<f64> = (0..model.nv).map(|k| (1.0 + k as f64).sqrt().fract() + 0.1).collect();
    let mut q = neutral(model);
    integrate(model, &q.clone(), &way, &mut q);
    mass_rank(model, &mut Workspace::new(model), &q) == model.nv
}

#[cfg(test)]
mod tests {
    use robot_dynamics_core::algorithms::mass_matrix::is_plain;
    use robot_dynamics_core::{Model, Workspace, random_state};
    use robot_dynamics_description::{Base, JointKinds, RandomRobotOptions, random_robot};
    use robot_dynamics_number::SplitMix64;

    use super::{StiffFactor, row_begins};
    use crate::motion::implicit::joints::Joints;

    /// M without storage for structural zeros is the same bit for bit.
    #[test]
    fn packed_rows_are_the_same_matrix() {
        for seed in 0..40 {
            let base = if seed % 2 == 0 { Base::Floating } else { Base::Fixed };
            let options = RandomRobotOptions { base, kinds: JointKinds::Turning, ..Default::default() };
            let model = Model::new(random_robot(seed, &options)).unwrap();
            assert!(is_plain(&model));
            let (joints, mut workspace) = (Joints::new(&model), Workspace::new(&model));
            let q = random_state(&model, &mut SplitMix64::new(seed)).q;
            let mut factors = [StiffFactor::new(&model), StiffFactor::new(&model)];
            let begins = row_begins(&model);
            factors[1].mass = vec![f64::NAN; *begins.last().unwrap()];
            factors[1].begins = Some(begins);
            let taken = factors.each_mut().map(|factor| {
                factor.factor(&model, &mut workspace, &q, &joints, 1e-3).map(|()| factor.packed.clone())
            });
            assert_eq!(taken[0], taken[1], "seed {seed}");
        }
    }
}
