//! What a page needs to draw a link without meshes: where its mass sits and how it is spread.

use dynamics::MassProperties;

/// Mass, centre of mass, the spread of the mass along each principal axis, and those axes by rows (link
/// frame from principal frame): 1 + 3 + 3 + 9 numbers.
///
/// The spread is the root mean square distance from the centre along an axis: with moments I₁ = m(σ₂² + σ₃²)
/// and so on, σ₁² = (I₂ + I₃ − I₁)/(2m). The uniform ellipsoid of this mass and inertia is √5 times as large.
pub(crate) fn drawn_body(body: &MassProperties) -> [f64; 16] {
    let principal = body.principal();
    let i = principal.moments;
    let spread = |k: usize| {
        let surplus = i.sum() - 2.0 * i[k];
        // The triangle inequality holds but for rounding.
        (0.5 * surplus.max(0.0) / body.mass()).sqrt()
    };
    let c = body.center_of_mass();
    let r = principal.body_from_principal;
    let mut numbers = [0.0; 16];
    numbers[0] = body.mass();
    numbers[1..4].copy_from_slice(c.as_slice());
    numbers[4..7].copy_from_slice(&[spread(0), spread(1), spread(2)]);
    numbers[7..].copy_from_slice(r.matrix().transpose().as_slice());
    numbers
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    /// ⟨x²⟩ over an ellipsoid of semi-axis a is a²/5.
    #[test]
    fn the_spread_of_an_ellipsoid() -> Result<(), dynamics::InertiaError> {
        let body = MassProperties::solid_ellipsoid(700.0, Vector3::new(0.3, 0.2, 0.1))?;
        let drawn = drawn_body(&body);
        // Ascending moments mean descending semi-axes.
        for (found, expected) in drawn[4..7].iter().zip([0.3, 0.2, 0.1]) {
            assert!((found - expected / 5_f64.sqrt()).abs() < 1e-14, "{drawn:?}");
        }
        Ok(())
    }
}
