//! The spatial tendons of a compiled robot.

use robot_dynamics_core::kinematics::body_placement::Placement;
use robot_dynamics_core::kinematics::tendon_path::TendonPath;
use robot_dynamics_core::{Model, Workspace};

use super::tendon_law::TendonLaw;

/// All spatial tendons, with the robot that they belong to.
#[derive(Clone, Debug)]
pub(super) struct SpatialTendons {
    model: Model,
    tendons: Vec<(TendonPath, TendonLaw)>,
}

/// The lengths of all spatial tendons in one configuration, and the rows ∂ℓ̇/∂v.
#[derive(Clone, Debug)]
pub(super) struct SpatialTendonMemory {
    placement: Placement,
    dynamics: Workspace,
    lengths: Vec<f64>,
    /// Rows of nv entries.
    rows: Vec<f64>,
}

impl SpatialTendons {
    /// `None` without spatial tendons.
    pub(super) fn new(model: &Model) -> Option<Self> {
        let described = &model.description().spatial_tendons;
        let laws = described.iter().map(TendonLaw::of_path);
        let tendons: Vec<_> = TendonPath::all(model).into_iter().zip(laws).collect();
        (!tendons.is_empty()).then(|| Self { model: model.clone(), tendons })
    }

    pub(super) fn memory(&self) -> SpatialTendonMemory {
        let (model, count) = (&self.model, self.tendons.len());
        SpatialTendonMemory {
            placement: Placement::new(model),
            dynamics: Workspace::new(model),
            lengths: vec![0.0; count],
            rows: vec![0.0; count * model.nv()],
        }
    }

    /// Computes lengths and rows at q, unless the memory has them.
    pub(super) fn place(&self, memory: &mut SpatialTendonMemory, q: &[f64]) {
        let SpatialTendonMemory { placement, dynamics, lengths, rows } = memory;
        if placement.is_at(q) {
            return;
        }
        placement.set(&self.model, dynamics, q);
        let nv = self.model.nv();
        for (k, (path, _)) in self.tendons.iter().enumerate() {
            let row = &mut rows[k * nv..(k + 1) * nv];
            lengths[k] = path.length_and_row(&self.model, placement, row);
        }
    }

    pub(super) fn law(&self, tendon: usize) -> &TendonLaw {
        &self.tendons[tendon].1
    }

    pub(super) fn laws_mut(&mut self) -> impl Iterator<Item = &mut TendonLaw> {
        self.tendons.iter_mut().map(|(_, law)| law)
    }

    pub(super) fn count(&self) -> usize {
        self.tendons.len()
    }

    /// Adds the forces of springs, dampers and friction at the placed configuration.
    pub(super) fn add_passive(&self, memory: &SpatialTendonMemory, v: &[f64], tau: &mut [f64]) {
        for (k, (_, law)) in self.tendons.iter().enumerate() {
            let force = law.spring_force(memory.length(k)) + law.dissipative_force(memory.rate(k, v));
            memory.spread(k, force, tau);
        }
    }

    /// Lets the springs yield that are stretched too far at the placed configuration. Returns the energy that
    /// they lose \[J\].
    pub(super) fn yield_springs(&mut self, memory: &SpatialTendonMemory) -> f64 {
        self.tendons.iter_mut().enumerate().map(|(k, (_, law))| law.yield_at(memory.length(k))).sum()
    }

    /// The energy of the springs at the placed configuration \[J\].
    pub(super) fn energy(&self, memory: &SpatialTendonMemory) -> f64 {
        self.tendons.iter().enumerate().map(|(k, (_, law))| law.energy(memory.length(k))).sum()
    }

    /// −Σ f(ℓ̇ at `rate`)·(ℓ̇ at `mean`) of dampers and friction, each at least 0 \[W\].
    pub(super) fn lost_power(&self, memory: &SpatialTendonMemory, rate: &[f64], mean: &[f64]) -> f64 {
        let lost = |k: usize, law: &TendonLaw| {
            (-law.dissipative_force(memory.rate(k, rate)) * memory.rate(k, mean)).max(0.0)
        };
        self.tendons.iter().enumerate().map(|(k, (_, law))| lost(k, law)).sum()
    }
}

impl SpatialTendonMemory {
    /// ℓ \[m\].
    pub(super) fn length(&self, tendon: usize) -> f64 {
        self.lengths[tendon]
    }

    /// ∂ℓ̇/∂v.
    pub(super) fn row(&self, tendon: usize) -> &[f64] {
        let nv = self.rows.len() / self.lengths.len();
        &self.rows[tendon * nv..(tendon + 1) * nv]
    }

    /// ℓ̇ \[m/s\].
    pub(super) fn rate(&self, tendon: usize, v: &[f64]) -> f64 {
        self.row(tendon).iter().zip(v).map(|(entry, v)| entry * v).sum()
    }

    /// τ += (∂ℓ̇/∂v)ᵀ f.
    pub(super) fn spread(&self, tendon: usize, force: f64, tau: &mut [f64]) {
        tau.iter_mut().zip(self.row(tendon)).for_each(|(tau, entry)| *tau += entry * force);
    }
}
