//! Pullbacks over dual numbers with four directions, and the Hessian from their tangents.

use robot_dynamics_description::check_length;
use robot_dynamics_number::dispatch::{Call, Hardware, Kernel, run_here};
use robot_dynamics_number::{Dual, Scalar};

use crate::configuration::configuration_rate::configuration_rate;
use crate::derivatives::pullback::{
    ArticulatedBodiesPullback, ForwardPullbackInputs, ForwardPullbackMut, NewtonEulerPullback,
    forward_dynamics_pullback_with_parameters,
};
use crate::kinematics::wrench::FrameWrench;
use crate::workspace::tree::{TreeMemory, TreeStorage};
use crate::{Model, Workspace};

/// The directions of one call. Four gradients fill a register of AVX2.
pub(super) const LANES: usize = 4;

/// A number with its derivatives along the directions.
pub(super) type Tangent = Dual<f64, LANES>;

/// Memory for second derivatives of one model. Use one per thread.
///
/// Products and contracted Hessians do not allocate. The first call of a function that returns tensors
/// allocates its matrices of nv² numbers.
///
/// ```
/// use robot_dynamics::derivatives::{InversePullbackInputs, SecondOrderWorkspace, inverse_dynamics_hessian};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let (workspace, mut hessian) = (&mut SecondOrderWorkspace::new(&model), [0.0; 9]);
/// let inputs = InversePullbackInputs { q: &[0.3], v: &[1.0], a: &[2.0], wrenches: &[], cotangent: &[1.0] };
/// inverse_dynamics_hessian(&model, workspace, inputs, &mut hessian);
/// assert!((hessian[0] - 2.0 * 9.81 * 0.5 * 0.3_f64.cos()).abs() < 1e-13); // τ = m l² a − m g l cos q
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SecondOrderWorkspace {
    pub(super) lanes: Workspace<Tangent>,
    pub(super) q: Vec<Tangent>,
    pub(super) v: Vec<Tangent>,
    /// a of inverse dynamics, τ of forward dynamics.
    pub(super) input: Vec<Tangent>,
    cotangent: Vec<Tangent>,
    /// The pullback: by q, by v, by the input.
    pub(super) gradient: [Vec<Tangent>; 3],
    acceleration: Vec<Tangent>,
    pub(super) wrenches: Vec<FrameWrench<Tangent>>,
    /// q̇ of a direction, nq numbers.
    rate: Vec<f64>,
    /// A vector of nv numbers: a unit displacement, or the gradient by q.
    pub(super) vector: Vec<f64>,
    /// Matrices over dual numbers: 6×nv for frames, nv×nv for tensors.
    pub(super) matrices: [Vec<Tangent>; 3],
}

impl SecondOrderWorkspace {
    /// Memory for this model.
    ///
    /// ```
    /// use robot_dynamics::derivatives::SecondOrderWorkspace;
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let workspace = SecondOrderWorkspace::new(&Model::new(pendulum(2.0, 0.5))?);
    /// # let _ = workspace;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(model: &Model) -> Self {
        let zeros = |count: usize| vec![Tangent::zero(); count];
        let (nq, nv) = (model.nq, model.nv);
        Self {
            lanes: Workspace::new(model),
            q: zeros(nq),
            v: zeros(nv),
            input: zeros(nv),
            cotangent: zeros(nv),
            gradient: [zeros(nv), zeros(nv), zeros(nv)],
            acceleration: zeros(nv),
            wrenches: Vec::new(),
            rate: vec![0.0; nq],
            vector: vec![0.0; nv],
            matrices: [zeros(6 * nv), zeros(6 * nv), Vec::new()],
        }
    }

    /// Copies a point, without directions.
    pub(super) fn load(&mut self, point: &Point<'_>) {
        let Point { q, v, input, wrenches, cotangent, .. } = *point;
        for (to, from) in
            [(&mut self.q, q), (&mut self.v, v), (&mut self.input, input), (&mut self.cotangent, cotangent)]
        {
            for (to, &x) in to.iter_mut().zip(from) {
                *to = Dual::constant(x);
            }
        }
        self.wrenches.clear();
        self.wrenches.extend(wrenches.iter().map(|wrench| FrameWrench {
            frame: wrench.frame,
            force_in_frame: wrench.force_in_frame.map(Dual::constant),
            moment_in_frame: wrench.moment_in_frame.map(Dual::constant),
        }));
    }

    /// Points one lane along a displacement of q, and along changes of v and of the input.
    pub(super) fn set_lane(&mut self, model: &Model, q: &[f64], lane: usize, direction: [&[f64]; 3]) {
        let [position, velocity, input] = direction;
        configuration_rate(model, q, position, &mut self.rate);
        for (to, from) in [(&mut self.q, &self.rate[..]), (&mut self.v, velocity), (&mut self.input, input)] {
            for (to, &x) in to.iter_mut().zip(from) {
                to.gradient[lane] = x;
            }
        }
    }

    /// Points the lanes along unit displacements of q, from this coordinate on, with v and the input
    /// constant; returns how many there are.
    pub(super) fn set_position_lanes(&mut self, model: &Model, q: &[f64], first: usize) -> usize {
        let mut unit = core::mem::take(&mut self.vector);
        let count = LANES.min(model.nv - first);
        for lane in 0..LANES {
            unit.fill(0.0);
            if lane < count {
                unit[first + lane] = 1.0;
            }
            self.set_lane(model, q, lane, [&unit, &[], &[]]);
        }
        self.vector = unit;
        count
    }

    /// The same for unit changes of v; the lanes of q and of the input become zero.
    pub(super) fn set_velocity_lanes(&mut self, nv: usize, first: usize) -> usize {
        self.q.iter_mut().chain(&mut self.input).for_each(|x| x.gradient = [0.0; LANES]);
        let count = LANES.min(nv - first);
        for (k, v) in self.v.iter_mut().enumerate() {
            v.gradient = core::array::from_fn(|lane| if first + lane == k { 1.0 } else { 0.0 });
        }
        count
    }

    /// The pullback along the lanes.
    pub(super) fn pull(&mut self, model: &Model, map: Map) {
        let [by_position, by_velocity, by_input] = &mut self.gradient;
        let (q, v, wrenches, cotangent) = (&self.q[..], &self.v[..], &self.wrenches[..], &self.cotangent[..]);
        let tree = &mut self.lanes.tree;
        match map {
            Map::Inverse => {
                let (a, by_acceleration, parameters) = (&self.input[..], by_input, &mut [][..]);
                run_lanes(
                    tree,
                    NewtonEulerPullback {
                        model,
                        q,
                        v,
                        a,
                        wrenches,
                        cotangent,
                        by_position,
                        by_velocity,
                        by_acceleration,
                        parameters,
                    },
                );
            }
            Map::Forward if model.needs_dense_factor => {
                let inputs = ForwardPullbackInputs { q, v, tau: &self.input, wrenches, cotangent };
                let (acceleration, parameters) = (&mut self.acceleration[..], &mut [][..]);
                let by_force = by_input;
                let results =
                    ForwardPullbackMut { acceleration, by_position, by_velocity, by_force, parameters };
                forward_dynamics_pullback_with_parameters(model, &mut self.lanes, inputs, results);
            }
            Map::Forward => {
                let (tau, by_force, parameters) = (&self.input[..], by_input, &mut [][..]);
                let acceleration = &mut self.acceleration[..];
                run_lanes(
                    tree,
                    ArticulatedBodiesPullback {
                        model,
                        q,
                        v,
                        tau,
                        wrenches,
                        cotangent,
                        acceleration,
                        by_position,
                        by_velocity,
                        by_force,
                        parameters,
                    },
                );
            }
        }
    }
}

/// Runs a kernel over the lanes, compiled for this machine's vector registers.
pub(super) fn run_lanes<K: Kernel<TreeStorage, Tangent>>(tree: &mut TreeMemory<Tangent>, kernel: K) {
    run_here(OnTree { tree, kernel });
}

struct OnTree<'a, K> {
    tree: &'a mut TreeMemory<Tangent>,
    kernel: K,
}

impl<K: Kernel<TreeStorage, Tangent>> Call for OnTree<'_, K> {
    #[inline(always)]
    fn call<H: Hardware>(self) {
        self.kernel.run::<Tangent, H>(self.tree);
    }
}

/// The function whose second derivatives are computed.
#[derive(Clone, Copy, Debug)]
pub(super) enum Map {
    /// τ(q, v, a); the input is a.
    Inverse,
    /// a(q, v, τ); the input is τ.
    Forward,
}

/// The arguments of a Hessian.
pub(super) struct Point<'a> {
    pub map: Map,
    pub q: &'a [f64],
    pub v: &'a [f64],
    pub input: &'a [f64],
    pub wrenches: &'a [FrameWrench],
    /// Empty for tensors.
    pub cotangent: &'a [f64],
}

impl Point<'_> {
    /// Rejects slices of the wrong length.
    #[track_caller]
    pub(super) fn check(&self, model: &Model, workspace: &SecondOrderWorkspace) {
        model.check_identity(&workspace.lanes.robot, "the workspace");
        let input = if matches!(self.map, Map::Inverse) { "a" } else { "tau" };
        check_length("q", self.q.len(), model.nq);
        check_length("v", self.v.len(), model.nv);
        check_length(input, self.input.len(), model.nv);
    }
}
