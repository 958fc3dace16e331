//! Validity of the links' moments of inertia.

use robot_dynamics_core::Model;
use robot_dynamics_description::MassProperties;

use super::check::Check;

/// The allowed violation of the triangle inequality for moments printed with seven digits.
const PRINTED: f64 = 1e-6;

/// I₃ ≤ I₁ + I₂ for every link with mass that is not a point mass.
pub(super) fn triangle(model: &Model) -> Option<Check> {
    let links = model.description().links.iter();
    let defects = links.filter_map(|link| {
        Some((triangle_defect(link.mass_properties.as_ref()?)?, format!("link {}", link.name)))
    });
    let (found, place) = defects.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let law = "inertia: (I₃ − I₁ − I₂)/I₃ of a link";
    Some(Check::new("inertia_triangle", law, (found, PRINTED), place))
}

/// The excess of the largest moment over the sum of the others, negative for a body of positive thickness.
/// `None` for a point mass.
fn triangle_defect(properties: &MassProperties) -> Option<f64> {
    let [a, b, c] = properties.principal().moments.into();
    (c > 0.0).then(|| (c - a - b) / c)
}
