//! Pairs of shapes whose contact is declared explicitly.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::{SolverImpedance, Surface};

/// Two shapes that always collide, regardless of `contype`, `conaffinity` and excluded pairs, with their own
/// contact parameters: `<pair>` of MJCF. See `ContactSet::with_links`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct ContactPairDescription {
    /// Its own name; empty if the file gives none.
    pub name: String,
    /// The names of the two shapes.
    pub shapes: [String; 2],
    /// The dimension of the contact's force: 1 for normal, 3 with sliding, 4 with torsional, 6 with rolling
    /// friction.
    pub condim: u8,
    /// Coefficients of friction: two directions of sliding, torsional \[m\], two of rolling \[m\]. Contacts
    /// use the first of sliding and the first of rolling for both directions.
    pub friction: [f64; 5],
    /// Time constant \[s\] and damping ratio of the contact: [`SolverImpedance`].
    pub solref: [f64; 2],
    /// The same for its friction, if given separately.
    #[cfg_attr(feature = "serde", serde(default))]
    pub solreffriction: Option<[f64; 2]>,
    /// Its impedance: [`SolverImpedance`].
    pub solimp: [f64; 5],
    /// The distance within which a contact is detected \[m\].
    pub margin: f64,
    /// The part of the margin within which a contact has no force \[m\].
    pub gap: f64,
}

impl ContactPairDescription {
    /// A pair of these two shapes with MJCF's default parameters, which are not those of the shapes.
    ///
    /// ```
    /// let pair = robot_dynamics::description::ContactPairDescription::new(["thumb", "finger"]);
    /// assert_eq!((pair.condim, pair.friction), (3, [1.0, 1.0, 0.005, 1e-4, 1e-4]));
    /// ```
    pub fn new<N: Into<String>>(shapes: [N; 2]) -> Self {
        let SolverImpedance { solref, solimp } = SolverImpedance::default();
        let [slide, spin, roll] = Surface::default().friction;
        Self {
            name: String::new(),
            shapes: shapes.map(Into::into),
            condim: 3,
            friction: [slide, slide, spin, roll, roll],
            solref,
            solreffriction: None,
            solimp,
            margin: 0.0,
            gap: 0.0,
        }
    }

    /// The contact parameters of the pair.
    ///
    /// ```
    /// let mut pair = robot_dynamics::description::ContactPairDescription::new(["thumb", "finger"]);
    /// pair.friction[0] = 0.3;
    /// assert_eq!(pair.surface().friction, [0.3, 0.005, 1e-4]);
    /// ```
    pub fn surface(&self) -> Surface {
        let [slide, _, spin, roll, _] = self.friction;
        let Self { condim, solref, solreffriction, solimp, margin, gap, .. } = *self;
        let friction = [slide, spin, roll];
        Surface { friction, condim, solref, solreffriction, solimp, margin, gap, ..Surface::default() }
    }
}
