//! The space of the states x of a problem: numbers, or the configurations and velocities of a robot.

use std::sync::Arc;

use robot_dynamics_core::configuration::manifold::{CoordinateRange, coordinate_ranges, quaternion_at};
use robot_dynamics_core::joint::Chart;
use robot_dynamics_core::{Model, check_configuration, difference, integrate};
use robot_dynamics_description::{Pose, check_length};
use robot_dynamics_number::{InputProblem, InvalidInput, check_finite};

/// The space of states: x has `coordinates` numbers, a difference δx has `tangent` numbers.
///
/// A state of a robot is x = (q, v) with nq + nv numbers, and δx = (δq, δv) has 2nv. x ⊕ δx is q ⊕ δq of
/// [`integrate`] and v + δv.
///
/// ```
/// use robot_dynamics::control::optimal::StateSpace;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let space = StateSpace::robot(Model::new(pendulum(2.0, 0.5))?);
/// assert_eq!((space.coordinates(), space.tangent()), (2, 2));
/// let mut displacement = [0.0; 2];
/// space.difference(&[0.1, 1.0], &[0.3, 0.5], &mut displacement);
/// assert!((displacement[0] - 0.2).abs() < 1e-15 && displacement[1] == -0.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct StateSpace(Kind);

#[derive(Clone, Debug)]
enum Kind {
    Vector(usize),
    Robot(Arc<Model>),
}

impl StateSpace {
    /// The space of `n` plain numbers.
    pub fn vector(n: usize) -> Self {
        Self(Kind::Vector(n))
    }

    /// The space of (q, v) of a robot.
    pub fn robot(model: impl Into<Arc<Model>>) -> Self {
        Self(Kind::Robot(model.into()))
    }

    /// The robot; `None` for plain numbers.
    pub fn model(&self) -> Option<&Arc<Model>> {
        match &self.0 {
            Kind::Vector(_) => None,
            Kind::Robot(model) => Some(model),
        }
    }

    /// The number of coordinates of x: nq + nv.
    pub fn coordinates(&self) -> usize {
        match &self.0 {
            Kind::Vector(n) => *n,
            Kind::Robot(model) => model.nq() + model.nv(),
        }
    }

    /// The number of entries of δx: 2nv.
    pub fn tangent(&self) -> usize {
        match &self.0 {
            Kind::Vector(n) => *n,
            Kind::Robot(model) => 2 * model.nv(),
        }
    }

    /// Whether both are the same space.
    pub(crate) fn equals(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (Kind::Vector(a), Kind::Vector(b)) => a == b,
            (Kind::Robot(a), Kind::Robot(b)) => a.fingerprint() == b.fingerprint(),
            _ => false,
        }
    }

    /// `moved` = x ⊕ δx.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    #[track_caller]
    pub fn integrate(&self, x: &[f64], displacement: &[f64], moved: &mut [f64]) {
        self.check_lengths(x, moved, displacement);
        let (nq, nv) = self.split();
        if let Kind::Robot(model) = &self.0 {
            integrate(model, &x[..nq], &displacement[..nv], &mut moved[..nq]);
        }
        for ((moved, x), d) in moved[nq..].iter_mut().zip(&x[nq..]).zip(&displacement[nv..]) {
            *moved = x + d;
        }
    }

    /// `displacement` = x₁ ⊖ x₀, with x₀ ⊕ (x₁ ⊖ x₀) = x₁.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    #[track_caller]
    pub fn difference(&self, x0: &[f64], x1: &[f64], displacement: &mut [f64]) {
        self.check_lengths(x0, x1, displacement);
        let (nq, nv) = self.split();
        if let Kind::Robot(model) = &self.0 {
            difference(model, &x0[..nq], &x1[..nq], &mut displacement[..nv]);
        }
        for ((d, x0), x1) in displacement[nv..].iter_mut().zip(&x0[nq..]).zip(&x1[nq..]) {
            *d = x1 - x0;
        }
    }

    /// ∂(x₁ ⊖ x₀)/∂x₁, `tangent` × `tangent`, row-major: the identity except for the blocks of quaternions,
    /// where it is the inverse of the right Jacobian of the exponential.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    #[track_caller]
    pub fn difference_derivative(&self, x0: &[f64], x1: &[f64], derivative: &mut [f64]) {
        let n = self.tangent();
        check_length("the derivative of the difference", derivative.len(), n * n);
        derivative.fill(0.0);
        for i in 0..n {
            derivative[i * n + i] = 1.0;
        }
        let Kind::Robot(model) = &self.0 else { return };
        each_quaternion_block(model, [x0, x1], |k, size, block| {
            for row in 0..size {
                let own = &block[row + 6 - size][6 - size..];
                derivative[(k + row) * n + k..][..size].copy_from_slice(own);
            }
        });
    }

    /// The lengths of q and δq: (nq, nv), (0, 0) for plain numbers.
    fn split(&self) -> (usize, usize) {
        self.model().map_or((0, 0), |model| (model.nq(), model.nv()))
    }

    #[track_caller]
    fn check_lengths(&self, x0: &[f64], x1: &[f64], displacement: &[f64]) {
        check_length("a state", x0.len(), self.coordinates());
        check_length("a state", x1.len(), self.coordinates());
        check_length("a difference of states", displacement.len(), self.tangent());
    }

    /// Checks the length of a state, that it is finite, and that its quaternions have unit length.
    ///
    /// # Errors
    /// [`InvalidInput`] with the entry.
    pub fn check(&self, quantity: &str, x: &[f64]) -> Result<(), InvalidInput> {
        if x.len() != self.coordinates() {
            let owner = match &self.0 {
                Kind::Vector(_) => "the state space".to_owned(),
                Kind::Robot(model) => format!("a state (q, v) of robot `{}`", model.name()),
            };
            let (found, expected) = (x.len(), self.coordinates());
            let problem = InputProblem::WrongLength { found, expected, owner, hint: "" };
            return Err(InvalidInput::new(quantity, problem));
        }
        check_finite(quantity, x)?;
        match &self.0 {
            Kind::Vector(_) => Ok(()),
            Kind::Robot(model) => {
                check_configuration(model, &x[..model.nq()]).map_err(|error| error.of(quantity))
            }
        }
    }
}

/// Calls `visit` with the blocks of ∂(q₁ ⊖ q₀)/∂q₁ that differ from the identity: the first index in v, the
/// size, and a derivative of the logarithm, of which the last rows and columns count.
pub(crate) fn each_quaternion_block(
    model: &Model,
    [q0, q1]: [&[f64]; 2],
    mut visit: impl FnMut(usize, usize, &[[f64; 6]; 6]),
) {
    for CoordinateRange { chart, q: i, v: k } in coordinate_ranges(model) {
        let (turn, size) = match chart {
            Chart::Line => continue,
            Chart::Rotation => (i, 3),
            Chart::Placement => (i + 3, 6),
        };
        let start = quaternion_at(q0, turn);
        let shift = match chart {
            Chart::Placement => start.rotate_back(core::array::from_fn(|j| q1[i + j] - q0[i + j])),
            _ => [0.0; 3],
        };
        let relative = start.conjugate().times(quaternion_at(q1, turn)).to_xyzw();
        // A rotation alone is the angular block.
        visit(k, size, &Pose::from_translation_quaternion_xyzw(shift, relative).log_derivative());
    }
}
