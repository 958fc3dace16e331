//! The algorithms as a table: inputs, results and call of each, for one state and for batches.

mod arguments;
mod table;

pub use arguments::{Input, Inputs, QuantityResult, ResultShape};
pub use table::Quantity;

use crate::{Model, Workspace};
use robot_dynamics_description::Pose;

/// Memory for the results of any quantity of one state.
#[derive(Clone, Debug)]
pub struct QuantityMemory {
    numbers: [Vec<f64>; 3],
    poses: Vec<Pose>,
    /// For each quantity the lengths of its results.
    lengths: [[usize; 3]; Quantity::ALL.len()],
}

impl QuantityMemory {
    /// Memory for every quantity of this model.
    pub fn new(model: &Model) -> Self {
        let (nv, frames) = (model.nv(), model.frames().len());
        let most = (nv * nv).max(6 * nv).max(12 * frames).max(3);
        let still = Pose { rotation: [[0.0; 3]; 3], translation: [0.0; 3] };
        let mut lengths = [[0; 3]; Quantity::ALL.len()];
        for quantity in Quantity::ALL {
            for (length, result) in lengths[quantity as usize].iter_mut().zip(quantity.results()) {
                *length = result.shape.len(model, frames);
            }
        }
        Self {
            numbers: [vec![0.0; most], vec![0.0; nv * nv], vec![0.0; nv * nv]],
            poses: vec![still; frames],
            lengths,
        }
    }

    /// The results of the last [`Quantity::compute`], which must be of this quantity, in the order of
    /// [`Quantity::results`]; unused ones are empty.
    pub fn results(&mut self, quantity: Quantity) -> [&[f64]; 3] {
        let Self { numbers: [x, y, z], poses, lengths } = self;
        let lengths = lengths[quantity as usize];
        if quantity == Quantity::FramePoses {
            for (to, pose) in x.chunks_exact_mut(12).zip(&*poses) {
                for (to, row) in to.chunks_exact_mut(3).zip(&pose.rotation) {
                    to.copy_from_slice(row);
                }
                to[9..].copy_from_slice(&pose.translation);
            }
        }
        [&x[..lengths[0]], &y[..lengths[1]], &z[..lengths[2]]]
    }
}

impl Quantity {
    /// The quantity of this name.
    ///
    /// ```
    /// use robot_dynamics::quantity::Quantity;
    /// assert_eq!(Quantity::named("mass_matrix"), Some(Quantity::MassMatrix));
    /// assert_eq!(Quantity::named("mass"), None);
    /// ```
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|quantity| quantity.name() == name)
    }

    /// Whether it depends on this input.
    pub fn reads(self, input: Input) -> bool {
        self.inputs().contains(&input)
    }

    /// Computes it for one state, into `memory`; see [`QuantityMemory::results`]. No allocation.
    ///
    /// ```
    /// use robot_dynamics::description::{RandomRobotOptions, random_robot};
    /// use robot_dynamics::model::{Model, Workspace, neutral};
    /// use robot_dynamics::quantity::{Inputs, Quantity, QuantityMemory};
    /// let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
    /// let (mut workspace, mut memory) = (Workspace::new(&model), QuantityMemory::new(&model));
    /// let q = neutral(&model);
    /// let inputs = Inputs { q: &q, ..Inputs::default() };
    /// Quantity::MassMatrix.compute(&model, &mut workspace, &inputs, &mut memory);
    /// let [mass, ..] = memory.results(Quantity::MassMatrix);
    /// assert!(mass.len() == model.nv() * model.nv() && mass[0] > 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// If an input has the wrong length, or the memory or a frame belongs to another robot.
    #[track_caller]
    pub fn compute(
        self,
        model: &Model,
        workspace: &mut Workspace,
        inputs: &Inputs<'_>,
        memory: &mut QuantityMemory,
    ) {
        let QuantityMemory { numbers: [x, y, z], poses, lengths } = memory;
        let lengths = lengths[self as usize];
        let results = [&mut x[..lengths[0]], &mut y[..lengths[1]], &mut z[..lengths[2]]];
        self.call(model, workspace, inputs, results, poses);
    }

    /// Computes it into the caller's slices without a copy, in the order of [`Quantity::results`]; unused
    /// ones are empty.
    ///
    /// ```
    /// use robot_dynamics::description::{RandomRobotOptions, random_robot};
    /// use robot_dynamics::model::{Model, Workspace, neutral};
    /// use robot_dynamics::quantity::{Inputs, Quantity};
    /// let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
    /// let (mut workspace, mut weight) = (Workspace::new(&model), vec![f64::NAN; model.nv()]);
    /// let q = neutral(&model);
    /// let inputs = Inputs { q: &q, ..Inputs::default() };
    /// Quantity::Gravity.compute_into(&model, &mut workspace, &inputs, [&mut weight, &mut [], &mut []]);
    /// assert!(weight.iter().all(|force| force.is_finite()));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// As [`Quantity::compute`]; also if a result has the wrong length, and for [`Quantity::FramePoses`],
    /// whose results are not numbers.
    #[track_caller]
    pub fn compute_into(
        self,
        model: &Model,
        workspace: &mut Workspace,
        inputs: &Inputs<'_>,
        results: [&mut [f64]; 3],
    ) {
        assert!(self != Self::FramePoses, "frame_poses has poses as its results: use `Quantity::compute`");
        self.call(model, workspace, inputs, results, &mut []);
    }

    /// Computes it for a sequence of states and calls the function with each result. The inputs hold the
    /// states' rows: q \[states\]\[nq\], the others \[states\]\[nv\], or empty if not read. All states share
    /// the frames.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::{Model, Workspace};
    /// use robot_dynamics::quantity::{Inputs, Quantity, QuantityMemory};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let (mut workspace, mut memory) = (Workspace::new(&model), QuantityMemory::new(&model));
    /// let states = Inputs { q: &[0.0, 0.5, 1.0], ..Inputs::default() };
    /// let mut held = Vec::new();
    /// Quantity::Gravity.compute_each(&model, &mut workspace, &states, &mut memory, &mut |memory| {
    ///     held.push(memory.results(Quantity::Gravity)[0][0]);
    /// });
    /// assert!((held[2] + 2.0 * 9.81 * 0.5 * f64::cos(1.0)).abs() < 1e-14);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// As [`compute`](Self::compute).
    #[track_caller]
    pub fn compute_each(
        self,
        model: &Model,
        workspace: &mut Workspace,
        states: &Inputs<'_>,
        memory: &mut QuantityMemory,
        show: &mut dyn FnMut(&mut QuantityMemory),
    ) {
        let Inputs { q, v, a, tau, frames } = *states;
        for state in 0..q.len() / model.nq().max(1) {
            let q = row(q, state, model.nq());
            let [v, a, tau] = [v, a, tau].map(|table| row(table, state, model.nv()));
            self.compute(model, workspace, &Inputs { q, v, a, tau, frames }, memory);
            show(memory);
        }
    }
}

/// A state's row of a table, which may be empty.
fn row(table: &[f64], state: usize, width: usize) -> &[f64] {
    if table.is_empty() { table } else { &table[state * width..][..width] }
}
