//! The contact problem of a step in the usual dense form: Delassus' operator and the free velocity.

use nalgebra::{DMatrix, DVector};

use super::cone_problem::{ConeProblem, Set};
use super::law::ContactViolation;

/// The law of a block of rows, and the set of its impulses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ContactLaw {
    /// A contact: rows (normal, tangential…) with Signorini's law, Coulomb's law and maximum dissipation.
    Contact {
        /// μ.
        friction: f64,
        /// The number of rows: 1 without friction.
        rows: usize,
    },
    /// One row of a joint's friction or stop: p between these bounds, and c = 0 if it is on neither.
    Bounds {
        /// The smallest impulse.
        lower: f64,
        /// The largest impulse.
        upper: f64,
    },
}

impl ContactLaw {
    /// The number of rows.
    ///
    /// ```
    /// assert_eq!(robot_dynamics::contact::ContactLaw::Contact { friction: 0.5, rows: 3 }.rows(), 3);
    /// ```
    pub fn rows(&self) -> usize {
        match self {
            Self::Contact { rows, .. } => *rows,
            Self::Bounds { .. } => 1,
        }
    }
}

/// The nonlinear complementarity problem of a step's contacts, and the library's solution: impulses p that
/// satisfy the laws with c = G p + g.
///
/// G = A M̂⁻¹Aᵀ is Delassus' operator, g = A v are the rows' velocities without these impulses, and A is the
/// rows' Jacobian. [`Simulation::contact_problem`](crate::simulator::Simulation::contact_problem) returns
/// that of the last step.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ContactProblem {
    /// G, symmetric and at least positive semidefinite \[1/kg\].
    pub delassus: DMatrix<f64>,
    /// g \[m/s\].
    pub free_velocity: DVector<f64>,
    /// The law of each block of rows.
    pub laws: Vec<ContactLaw>,
    /// p of the library's solution \[N·s\].
    pub impulse: DVector<f64>,
    /// c of the library's solution \[m/s\].
    pub velocity: DVector<f64>,
    /// Whether the library found a solution of Coulomb's law.
    pub is_solved: bool,
}

impl ContactProblem {
    /// An unsolved problem: p = 0, c = g.
    ///
    /// ```
    /// use nalgebra::{dmatrix, dvector};
    /// use robot_dynamics::contact::{ContactLaw, ContactProblem};
    /// // 2 kg fall on the ground at 1 m/s.
    /// let laws = vec![ContactLaw::Contact { friction: 0.0, rows: 1 }];
    /// let problem = ContactProblem::new(dmatrix![0.5], dvector![-1.0], laws);
    /// assert_eq!(problem.violation(&dvector![2.0]).worst(), 0.0); // 2 N·s stop them
    /// ```
    ///
    /// # Panics
    /// If the sizes do not agree.
    #[track_caller]
    pub fn new(delassus: DMatrix<f64>, free_velocity: DVector<f64>, laws: Vec<ContactLaw>) -> Self {
        let rows: usize = laws.iter().map(ContactLaw::rows).sum();
        assert_eq!(delassus.shape(), (rows, rows), "G has as many rows and columns as the laws have rows");
        assert_eq!(free_velocity.len(), rows, "g has as many entries as the laws have rows");
        let (impulse, velocity) = (DVector::zeros(rows), free_velocity.clone());
        Self { delassus, free_velocity, laws, impulse, velocity, is_solved: false }
    }

    /// The violation of the laws by the impulses p, with c = G p + g: the worst of all blocks. For a joint's
    /// row, |p − Π(p − c/w)| w counts as a violation of Signorini's law.
    ///
    /// # Panics
    /// If p has the wrong length.
    ///
    /// ```
    /// use nalgebra::{dmatrix, dvector};
    /// use robot_dynamics::contact::{ContactLaw, ContactProblem};
    /// let laws = vec![ContactLaw::Bounds { lower: -0.5, upper: 0.5 }];
    /// let problem = ContactProblem::new(dmatrix![1.0], dvector![-2.0], laws);
    /// assert_eq!(problem.violation(&dvector![0.5]).worst(), 0.0); // friction slides, as large as it can be
    /// assert_eq!(problem.violation(&dvector![0.0]).worst(), 0.5);
    /// ```
    #[track_caller]
    pub fn violation(&self, impulse: &DVector<f64>) -> ContactViolation {
        assert_eq!(impulse.len(), self.free_velocity.len(), "p has as many entries as g");
        let velocity = &self.delassus * impulse + &self.free_velocity;
        let (mut worst, mut row) = (ContactViolation::default(), 0);
        for law in &self.laws {
            let (mobility, rows) = (self.delassus[(row, row)], row..row + law.rows());
            let (p, c) = (&impulse.as_slice()[rows.clone()], &velocity.as_slice()[rows]);
            let own = match *law {
                ContactLaw::Contact { friction, .. } => ContactViolation::of(friction, mobility, c, p),
                ContactLaw::Bounds { lower, upper } => {
                    let target = (mobility * p[0] - c[0]).max(mobility * lower).min(mobility * upper);
                    let signorini = (mobility * p[0] - target).abs();
                    ContactViolation { signorini, ..ContactViolation::default() }
                }
            };
            worst = worst.max(&own);
            row += law.rows();
        }
        worst
    }
}

impl ConeProblem {
    /// The problem of the last solution.
    pub fn dense(&self) -> ContactProblem {
        let rows = self.start.len();
        let factor = self.factor_of_mass();
        let mut along = Vec::with_capacity(rows);
        let mut respond = |x: &mut [f64]| {
            self.solve_by(&factor, x);
            self.multiply(x, &mut along);
            DVector::from_column_slice(&along)
        };
        let mut delassus = DMatrix::zeros(rows, rows);
        for row in 0..rows {
            let (mut unit, mut x) = (vec![0.0; rows], vec![0.0; self.force.len()]);
            unit[row] = 1.0;
            self.add_forces(&unit, &mut x);
            delassus.set_column(row, &respond(&mut x));
        }
        let mut free = self.force.clone();
        self.add_forces(&self.counted, &mut free);
        for force in &mut free {
            *force = -*force;
        }
        let free_velocity = respond(&mut free) + DVector::from_column_slice(&self.start);
        let law = |(set, rows)| match set {
            Set::Cone(friction) => ContactLaw::Contact { friction, rows },
            Set::Interval(0.0, f64::INFINITY) => ContactLaw::Contact { friction: 0.0, rows },
            Set::Interval(lower, upper) => ContactLaw::Bounds { lower, upper },
        };
        let mut problem = ContactProblem::new(
            (&delassus + delassus.transpose()) * 0.5,
            free_velocity,
            self.sets().map(law).collect(),
        );
        problem.impulse.copy_from_slice(&self.multiplier);
        problem.velocity.copy_from_slice(&self.c);
        problem.is_solved = self.is_coulomb;
        problem
    }
}
