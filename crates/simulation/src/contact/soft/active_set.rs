//! The limits and contacts that act at a state, and their choice for other states.
//!
//! When a constraint of this law becomes active, its damping force B ṙ appears at once. So v̇ jumps where the
//! active set changes, and is differentiable only with a fixed active set.

use robot_dynamics_core::clone_in_place::clone_in_place;

clone_in_place! {
    /// The limits and contacts that act in a step: see [`Stepper::active_set`](crate::Stepper::active_set).
    #[derive(Debug, Default, PartialEq, Eq)]
    pub struct ActiveSet {
        /// Numbers of points of the contact set.
        pub(super) contacts: Vec<usize>,
        /// Numbers of limits of joints and tendons.
        pub(super) limits: Vec<usize>,
    }
}

impl ActiveSet {
    /// The number of active limits and contact points.
    ///
    /// ```
    /// use robot_dynamics::contact::SoftConstraints;
    /// use robot_dynamics::description::{Limits, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::{MujocoEuler, StepForces, StepWorkspace, Stepper};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.joints[0].limits = Limits::new(-0.2, 0.3);
    /// let model = Model::new(robot)?;
    /// let mut stepper = MujocoEuler::new(&model, SoftConstraints::new(&model, 1e-3)?);
    /// let (mut w, forces) = (StepWorkspace::new(&model), StepForces::new(&[0.0], true));
    /// stepper.step(&model, &mut w, &forces, 1e-3, &mut [0.301], &mut [0.0])?; // beyond its limit
    /// assert_eq!(stepper.active_set().map(|set| set.len()), Some(1));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn len(&self) -> usize {
        self.contacts.len() + self.limits.len()
    }

    /// Whether the set is empty.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The limits that act at a state.
pub(super) struct ActiveLimits<'a> {
    /// Those found so far.
    now: &'a mut Vec<usize>,
    /// The given active set, if any.
    fixed: Option<&'a [usize]>,
}

impl<'a> ActiveLimits<'a> {
    /// Starts a new set of limits; those of `fixed` act if it is given.
    pub(super) fn new(active: &'a mut ActiveSet, fixed: Option<&'a ActiveSet>) -> Self {
        active.limits.clear();
        Self { now: &mut active.limits, fixed: fixed.map(|fixed| &fixed.limits[..]) }
    }

    /// Whether the limit with this number acts.
    pub(super) fn admits(&mut self, number: usize, is_near: bool) -> bool {
        let acts = self.fixed.map_or(is_near, |fixed| fixed.contains(&number));
        if acts {
            self.now.push(number);
        }
        acts
    }
}
