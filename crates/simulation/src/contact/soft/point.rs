//! A contact of MuJoCo's law: its point, normal, friction and softness.

use robot_dynamics_core::FrameId;
use robot_dynamics_description::{SolverImpedance, Surface};

/// A contact point of a link with the world, or with another link, under the law of
/// [`SoftConstraints`](crate::SoftConstraints).
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SoftContact {
    /// The link that is pushed along the normal.
    pub link: FrameId,
    /// The link that is pushed the other way; `None` for the world.
    pub other: Option<FrameId>,
    /// The contact point in the world \[m\].
    pub point: [f64; 3],
    /// Unit vector into `link`, in the world.
    pub normal: [f64; 3],
    /// The distance of the two surfaces; negative if they overlap \[m\].
    pub distance: f64,
    /// The distance below which the contact acts \[m\].
    pub margin: f64,
    /// The dimension of its force: 1, 3, 4 or 6.
    pub condim: u8,
    /// Friction: two directions of sliding, torsion \[m\], two of rolling \[m\].
    pub friction: [f64; 5],
    /// The softness.
    pub softness: SolverImpedance,
    /// `solref` of its friction, if it differs from that of `softness`.
    pub solreffriction: Option<[f64; 2]>,
    /// The motion of the surface of `link` relative to that of the other side, in addition to the motion of
    /// the links: the velocity at the point \[m/s\] and ω \[rad/s\], in world axes.
    pub surface_motion: [[f64; 3]; 2],
}

impl SoftContact {
    /// A link's contact with the world, without friction, with MuJoCo's default softness.
    ///
    /// ```
    /// use robot_dynamics::contact::SoftContact;
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let contact = SoftContact::new(model.frame("rod").unwrap(), [0.5, 0.0, 0.0], [0.0, 0.0, 1.0], -1e-3);
    /// assert_eq!((contact.condim, contact.margin), (1, 0.0));
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn new(link: FrameId, point: [f64; 3], normal: [f64; 3], distance: f64) -> Self {
        let friction = [0.0; 5];
        let softness = SolverImpedance::default();
        let solreffriction = None;
        Self {
            link,
            other: None,
            point,
            normal,
            distance,
            margin: 0.0,
            condim: 1,
            friction,
            softness,
            solreffriction,
            surface_motion: [[0.0; 3]; 2],
        }
    }

    /// Sets the friction, dimension, softness and margin to those of this surface.
    ///
    /// ```
    /// use robot_dynamics::contact::SoftContact;
    /// use robot_dynamics::description::{Surface, pendulum};
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let contact = SoftContact::new(model.frame("rod").unwrap(), [0.5, 0.0, 0.0], [0.0, 0.0, 1.0], -1e-3);
    /// assert_eq!(contact.with_surface(&Surface::default()).friction, [1.0, 1.0, 0.005, 1e-4, 1e-4]);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn with_surface(self, surface: &Surface) -> Self {
        let [slide, spin, roll] = surface.friction;
        Self {
            margin: surface.margin,
            condim: surface.condim,
            friction: [slide, slide, spin, roll, roll],
            softness: SolverImpedance { solref: surface.solref, solimp: surface.solimp },
            solreffriction: surface.solreffriction,
            ..self
        }
    }
}

/// The surface of a contact of two shapes: that of the higher priority, otherwise the larger friction and
/// dimension, and a mean of the softness.
pub(in crate::contact) fn mixed(one: &Surface, two: &Surface) -> Surface {
    let (margin, gap) = (one.margin + two.margin, one.gap + two.gap);
    if one.priority != two.priority {
        let chosen = if one.priority > two.priority { one } else { two };
        let mut chosen = *chosen;
        (chosen.margin, chosen.gap) = (margin, gap);
        return chosen;
    }
    let share = match (one.solmix >= 1e-15, two.solmix >= 1e-15) {
        (true, true) => one.solmix / (one.solmix + two.solmix),
        (false, false) => 0.5,
        (has_share, _) => f64::from(u8::from(has_share)),
    };
    let mean = |one: f64, two: f64| share * one + (1.0 - share) * two;
    let is_time = one.solref[0] > 0.0 && two.solref[0] > 0.0;
    let reference = |k: usize| {
        let (one, two) = (one.solref[k], two.solref[k]);
        if is_time { mean(one, two) } else { one.min(two) }
    };
    let mut together = *one;
    together.condim = one.condim.max(two.condim);
    together.friction = core::array::from_fn(|k| one.friction[k].max(two.friction[k]));
    together.solref = core::array::from_fn(reference);
    together.solimp = core::array::from_fn(|k| mean(one.solimp[k], two.solimp[k]));
    (together.margin, together.gap) = (margin, gap);
    together
}
