//! What a page needs to draw a link without meshes: where its mass sits and how it is spread.

use dynamics::MassProperties;

/// Mass, centre of mass, semi-axes of the uniform ellipsoid of the same mass and inertia, and its axes by
/// rows (link frame from principal frame): 1 + 3 + 3 + 9 numbers.
///
/// An ellipsoid of semi-axes a, b, c has moments m(b²+c²)/5 and so on, so a² = 5(I₂ + I₃ − I₁)/(2m).
pub(crate) fn drawn_body(body: &MassProperties) -> [f64; 16] {
    let principal = body.principal();
    let i = principal.moments;
    let semi_axis = |k: usize| {
        let surplus = i.sum() - 2.0 * i[k];
        // The triangle inequality holds but for rounding.
        (2.5 * surplus.max(0.0) / body.mass()).sqrt()
    };
    let c = body.center_of_mass();
    let r = principal.body_from_principal;
    let mut numbers = [0.0; 16];
    numbers[0] = body.mass();
    numbers[1..4].copy_from_slice(c.as_slice());
    numbers[4..7].copy_from_slice(&[semi_axis(0), semi_axis(1), semi_axis(2)]);
    numbers[7..].copy_from_slice(r.matrix().transpose().as_slice());
    numbers
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    /// An ellipsoid is drawn as itself.
    #[test]
    fn an_ellipsoid_is_its_own_picture() -> Result<(), dynamics::InertiaError> {
        let body = MassProperties::solid_ellipsoid(700.0, Vector3::new(0.3, 0.2, 0.1))?;
        let drawn = drawn_body(&body);
        // Ascending moments mean descending semi-axes.
        for (found, expected) in drawn[4..7].iter().zip([0.3, 0.2, 0.1]) {
            assert!((found - expected).abs() < 1e-14, "{drawn:?}");
        }
        Ok(())
    }
}
