//! M̂ = M + γhD + (γh)²K, factored with the tree's zeros; where tendons join branches, with those that are left.

use dynamics::DynamicsError;

use super::joints::Joints;
use crate::actuation::Coupling;
use crate::algorithms::mass_matrix::{
    Entries, is_plain, related_end, write_mass_matrix, write_packed_mass_matrix,
};
use crate::clone_in_place::clone_in_place;
use crate::factor::paths::Paths;
use crate::factor::sparse::{self, coordinate_carriers};
use crate::{Model, Workspace, integrate, mass_rank, neutral};

/// Where M is regular elsewhere but not here, as where hinges come to have one axis, each joint is taken to have this part of the inertia
/// that it moves as armature: without it no pivot is above its rounding, and with it the motion that has no inertia stays finite.
const ARMATURE: f64 = 1e-9;

/// With more coordinates than this M takes no room for what is always zero, if no joint follows another and no slide carries a point along.
const LARGE: usize = 512;

/// Below this part of M's diagonal a pivot is nearly none.
const NEARLY: f64 = 1e-10;

clone_in_place! {
    /// M as it is, and M̂ = LᵀDL.
    #[derive(Debug)]
    pub(super) struct StiffFactor {
        paths: Paths,
        /// Whether couplings may join what M does not.
        is_coupled: bool,
        /// M, or of its upper triangle what is not always zero, and of many coordinates where possible nothing else; M, and M̂'s factor, packed.
        mass: Vec<f64>,
        /// Where each row of `mass` begins, and where the next one does, if nothing else is there.
        begins: Option<Vec<usize>>,
        packed: Vec<f64>,
        entries: Vec<f64>,
        /// Whether M is regular in some pose.
        is_regular: bool,
        /// The tree of each coordinate, and of the last factor the armature of each tree, in parts of M's diagonal.
        trees: Vec<usize>,
        armature: Vec<f64>,
    }
}

impl StiffFactor {
    pub(super) fn new(model: &Model) -> Self {
        let n = model.nv;
        let mut paths = Paths::new(n);
        paths.choose(&coordinate_carriers(model));
        let (packed, entries) = (vec![0.0; paths.size()], vec![0.0; paths.size()]);
        let begins = (n > LARGE && is_plain(model)).then(|| row_begins(model));
        let size = begins.as_ref().and_then(|begins| begins.last().copied()).unwrap_or(n * n);
        let (mass, is_regular) = (vec![0.0; size], is_regular_somewhere(model));
        let trees = sparse::trees(paths.carrier()).0;
        let armature = vec![0.0; n];
        Self { paths, is_coupled: false, mass, begins, packed, entries, is_regular, trees, armature }
    }

    /// With room for what these couplings add: what carries one of their coordinates counts as carrying the others.
    pub(super) fn couple(&mut self, couplings: &[Coupling]) {
        let mut carrier = self.paths.carrier().to_vec();
        for pair in couplings.iter().flat_map(|coupling| coupling.row.windows(2)) {
            sparse::couple(&mut carrier, [pair[0].0, pair[1].0]);
        }
        self.is_coupled |= carrier != self.paths.carrier();
        self.paths.choose(&carrier);
        self.trees = sparse::trees(&carrier).0;
        for entries in [&mut self.packed, &mut self.entries] {
            entries.resize(self.paths.size(), 0.0);
        }
    }

    /// At q, with g = γh.
    ///
    /// # Errors
    /// [`DynamicsError::SingularMass`] with the freedom whose pivot is not above the rounding of its row.
    pub(super) fn factor(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        q: &[f64],
        joints: &Joints,
        g: f64,
    ) -> Result<(), DynamicsError> {
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

    /// With another g, M as it is.
    ///
    /// # Errors
    /// As [`factor`](Self::factor).
    pub(super) fn stiffen(&mut self, joints: &Joints, g: f64) -> Result<(), DynamicsError> {
        self.armature.fill(0.0);
        let watched = self.watched(joints, g);
        if !self.is_regular {
            return watched;
        }
        let pivots = self.paths.diagonal(&self.entries).zip(self.paths.diagonal(&self.packed));
        for ((pivot, mass), tree) in pivots.zip(&self.trees) {
            // NaN as well.
            if !(pivot / mass > NEARLY && pivot.is_finite()) {
                self.armature[*tree] = ARMATURE;
            }
        }
        if self.armature.iter().all(|armature| *armature == 0.0) {
            return watched;
        }
        self.watched(joints, g)
    }

    fn watched(&mut self, joints: &Joints, g: f64) -> Result<(), DynamicsError> {
        self.entries.copy_from_slice(&self.packed);
        stiffen_entries(&self.paths, joints, (g, &self.trees, &self.armature), &mut self.entries);
        self.paths.factor_by_division(&mut self.entries);
        let pivots = self.paths.diagonal(&self.entries).zip(self.paths.diagonal(&self.packed));
        sparse::check_pivots(pivots)
    }

    /// The sum of M's diagonal, of these coordinates.
    pub(super) fn mass_trace(&self, is_own: impl Fn(usize) -> bool) -> f64 {
        let diagonal = self.paths.diagonal(&self.packed).enumerate();
        diagonal.filter(|(k, _)| is_own(*k)).map(|(_, mass)| mass).sum()
    }

    /// The pivots, in parts of M's diagonal.
    pub(super) fn pivots(&self) -> impl Iterator<Item = f64> {
        let pivots = self.paths.diagonal(&self.entries).zip(self.paths.diagonal(&self.packed));
        pivots.map(|(pivot, mass)| pivot / mass)
    }

    /// x ← M̂⁻¹x.
    pub(super) fn solve(&self, x: &mut [f64]) {
        self.paths.solve(&self.entries, x);
    }

    /// M̂ as it is, packed, to `matrix`.
    pub(super) fn write(&self, joints: &Joints, g: f64, matrix: &mut Vec<f64>) {
        matrix.clone_from(&self.packed);
        stiffen_entries(&self.paths, joints, (g, &self.trees, &self.armature), matrix);
    }

    /// Where the entries are.
    pub(super) fn paths(&self) -> &Paths {
        &self.paths
    }

    /// `product` = M x.
    pub(super) fn multiply_mass(&self, x: &[f64], product: &mut [f64]) {
        self.paths.multiply(&self.packed, x, product);
    }
}

/// M + gD + g²K of a packed M, with armature of each tree in parts of its diagonal.
fn stiffen_entries(
    paths: &Paths,
    joints: &Joints,
    (g, trees, armature): (f64, &[usize], &[f64]),
    entries: &mut [f64],
) {
    for k in 0..paths.carrier().len() {
        let (diagonal, (stiffness, damping)) = (paths.diagonal_of(k, entries), joints.slopes(k));
        let mass = *diagonal;
        *diagonal = mass + g * (damping + g * stiffness) + armature[trees[k]] * mass;
    }
    for (row, column, entry) in joints.couplings().iter().flat_map(|coupling| coupling.entries(g)) {
        *paths.entry_of(row, column, entries) += entry;
    }
}

/// Where the rows of M's upper triangle begin without what is always zero, and where the last one ends.
fn row_begins(model: &Model) -> Vec<usize> {
    let mut end = 0;
    let ends = (0..model.nv).map(|row| {
        end += related_end(model, row) - row;
        end
    });
    core::iter::once(0).chain(ends).collect()
}

/// Whether M can be inverted in a pose of no symmetry.
fn is_regular_somewhere(model: &Model) -> bool {
    let way: Vec<f64> = (0..model.nv).map(|k| (1.0 + k as f64).sqrt().fract() + 0.1).collect();
    let mut q = neutral(model);
    integrate(model, &q.clone(), &way, &mut q);
    mass_rank(model, &mut Workspace::new(model), &q) == model.nv
}

#[cfg(test)]
mod tests {
    use dynamics::SplitMix64;

    use super::{StiffFactor, row_begins};
    use crate::algorithms::mass_matrix::is_plain;
    use crate::motion::implicit::joints::Joints;
    use crate::{Base, JointKinds, Model, RandomRobotOptions, Workspace, random_robot, random_state};

    /// M without room for what is always zero is the same to the last bit.
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
