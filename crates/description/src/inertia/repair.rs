//! Repair of inertias that no rigid body has.

use nalgebra::{Matrix3, Vector3};

use super::MassProperties;

impl MassProperties {
    /// The same properties with each invalid principal moment changed to the nearest bound of the law. The
    /// axes and all other moments stay.
    ///
    /// Moments a ≤ b ≤ c are valid if a ≥ 0 and c ≤ a + b. If a + b > 0 and a ≥ 0, c is reduced to a + b.
    /// That is the smallest relative change of one moment: c/(a + b) ≤ (c − b)/a for c ≥ a + b. A negative a
    /// becomes c − b, the least valid value; two negative moments share c. Without any positive moment the
    /// body becomes a point. Inertia without mass is dropped.
    ///
    /// ```
    /// use nalgebra::{Matrix3, Vector3};
    /// use robot_dynamics::description::MassProperties;
    /// // The first moment is too small by a factor of a thousand.
    /// let typo = Matrix3::from_diagonal(&Vector3::new(4.766, 0.0041, 0.0037));
    /// let mended = MassProperties::as_written(0.64, Vector3::zeros(), typo)?.repaired();
    /// assert!(mended.flaw().is_none());
    /// let moments = mended.inertia_about_center_of_mass().diagonal();
    /// assert!((moments - Vector3::new(0.0078, 0.0041, 0.0037)).norm() < 1e-15);
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    pub fn repaired(&self) -> Self {
        if self.mass() == 0.0 {
            return self.with_inertia(Matrix3::zeros());
        }
        if self.moment_violation() == 0.0 {
            return *self;
        }
        let principal = self.principal();
        let [a, b, c]: [f64; 3] = principal.moments.into();
        let moments = if c <= 0.0 {
            [0.0; 3]
        } else if b < 0.0 {
            [0.5 * c, 0.5 * c, c]
        } else if a < 0.0 {
            [c - b, b, c]
        } else {
            [a, b, a + b]
        };
        let axes = principal.body_from_principal.matrix();
        let inertia = axes * Matrix3::from_diagonal(&Vector3::from(moments)) * axes.transpose();
        self.with_inertia((inertia + inertia.transpose()) * 0.5)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation3;

    use super::*;

    /// Valid moments stay, and invalid ones move to the bound of the law, in rotated axes too.
    #[test]
    fn only_the_moment_at_fault_changes() {
        let turn = Rotation3::from_euler_angles(0.3, -0.2, 0.9);
        for (given, expected) in [
            ([1.0, 1.0, 10.0], [1.0, 1.0, 2.0]),
            ([-1.0, 1.0, 1.0], [0.0, 1.0, 1.0]),
            ([-0.1, 1.0, 1.5], [0.5, 1.0, 1.5]),
            ([-1.0, -2.0, 4.0], [2.0, 2.0, 4.0]),
            ([-1.0, -2.0, -3.0], [0.0, 0.0, 0.0]),
            ([1.0, 2.0, 2.5], [1.0, 2.0, 2.5]),
        ] {
            let inertia = |moments: [f64; 3]| {
                turn.matrix() * Matrix3::from_diagonal(&moments.into()) * turn.matrix().transpose()
            };
            let written = MassProperties::as_written(2.0, Vector3::new(1.0, 2.0, 3.0), inertia(given));
            let mended = written.expect("finite").repaired();
            let off = (mended.inertia_about_center_of_mass() - inertia(expected)).amax();
            // The rounding of an eigendecomposition of numbers up to 10.
            assert!(off < 1e-14, "{given:?}: off by {off}");
            assert!(mended.flaw().is_none(), "{given:?}: {:?}", mended.flaw());
            assert_eq!(mended.center_of_mass(), Vector3::new(1.0, 2.0, 3.0));
        }
    }

    #[test]
    fn inertia_without_mass_is_dropped() {
        let ghost = MassProperties::as_written(0.0, Vector3::zeros(), Matrix3::identity()).expect("finite");
        assert!(ghost.flaw().is_some());
        assert_eq!(ghost.repaired().inertia_about_center_of_mass(), Matrix3::zeros());
    }
}
