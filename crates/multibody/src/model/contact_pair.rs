//! Two shapes that touch each other whatever else is said of them: data beside the dynamics.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::{Softness, Surface};

/// Two shapes by name that touch each other whatever `contype`, `conaffinity` and the pairs that never touch say, with a surface of their
/// own: `<pair>` of MJCF. See [`ContactSet::with_links`](crate::ContactSet::with_links).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct ContactPairDescription {
    /// Its own name; empty where the file gives none.
    pub name: String,
    /// The names of the two shapes.
    pub shapes: [String; 2],
    /// Dimensions of the contact's force: 1 normal, 3 and sliding, 4 and torsional, 6 and rolling friction.
    pub condim: u8,
    /// Coefficients of friction: two directions of sliding, torsional \[m\], two of rolling \[m\]. Contacts take the first of sliding
    /// and the first of rolling for both directions.
    pub friction: [f64; 5],
    /// Time constant \[s\] and damping ratio of the contact: [`Softness`].
    pub solref: [f64; 2],
    /// The same of its friction, where it has numbers of its own.
    #[cfg_attr(feature = "serde", serde(default))]
    pub solreffriction: Option<[f64; 2]>,
    /// Its impedance: [`Softness`].
    pub solimp: [f64; 5],
    /// Distance within which a contact is found \[m\].
    pub margin: f64,
    /// Part of the margin within which a contact has no force yet \[m\].
    pub gap: f64,
}

impl ContactPairDescription {
    /// Of these two shapes, with the surface that MJCF gives a pair that says nothing else; it is not that of the shapes.
    ///
    /// ```
    /// let pair = multibody::ContactPairDescription::new(["thumb", "finger"]);
    /// assert_eq!((pair.condim, pair.friction), (3, [1.0, 1.0, 0.005, 1e-4, 1e-4]));
    /// ```
    pub fn new<N: Into<String>>(shapes: [N; 2]) -> Self {
        let Softness { solref, solimp } = Softness::default();
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

    /// The surface of both shapes together.
    ///
    /// ```
    /// let mut pair = multibody::ContactPairDescription::new(["thumb", "finger"]);
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
