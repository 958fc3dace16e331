//! Whether the links' masses and inertias could be those of real bodies.

use std::f64::consts::PI;

use dynamics::MassProperties;
use multibody::Model;

use super::check::{Check, Relation};
use super::probe::reach;

/// Air at sea level \[kg/m³\]: no link is lighter than what it displaces. An inertia in kg·mm² read as kg·m²
/// makes a link a billion times lighter.
const LIGHTEST: f64 = 1.2;

/// Osmium \[kg/m³\].
const HEAVIEST: f64 = 22_590.0;

/// Moments printed with seven digits may miss the triangle inequality by this; the reader refuses more.
const PRINTED: f64 = 1e-6;

/// The checks of all links that have mass.
pub(crate) fn checks(model: &Model) -> Vec<Check> {
    let links: Vec<(&str, &MassProperties)> = model
        .description()
        .links
        .iter()
        .filter_map(|link| Some((link.name.as_str(), link.mass_properties.as_ref()?)))
        .collect();
    let mut checks = Vec::new();
    let worst = |value: &dyn Fn(&MassProperties) -> Option<f64>, sign: f64| {
        let values = links.iter().filter_map(|(name, p)| Some((value(p)?, format!("link {name}"))));
        values.max_by(|a, b| (sign * a.0).total_cmp(&(sign * b.0)))
    };
    if let Some((found, place)) = worst(&triangle_defect, 1.0) {
        let law = "inertia: (I₃ − I₁ − I₂)/I₃ of a link";
        checks.push(Check::new("inertia_triangle", law, (found, Relation::AtMost, PRINTED), place));
    }
    let size = reach(model);
    if let Some((found, place)) = worst(&|p| Some(gyration(p)), 1.0)
        && size > 0.0
    {
        let law = "inertia: radius of gyration of a link, against the robot's reach [m]";
        checks.push(Check::new("inertia_gyration", law, (found, Relation::AtMost, size), place));
    }
    if let Some((found, place)) = worst(&density, -1.0) {
        let law = "inertia: density of the lightest link's ellipsoid [kg/m³]";
        checks.push(Check::new("inertia_density_low", law, (found, Relation::AtLeast, LIGHTEST), place));
    }
    // Point masses and thin rods are idealisations, no mistakes; a note will do.
    if let Some((found, place)) = worst(&density, 1.0) {
        let law = "inertia: density of the densest link's ellipsoid [kg/m³]";
        let check = Check::new("inertia_density_high", law, (found, Relation::AtMost, HEAVIEST), place);
        checks.push(check.or_note());
    }
    checks
}

/// Principal moments about the centre of mass, ascending.
fn moments(properties: &MassProperties) -> [f64; 3] {
    let mut moments: [f64; 3] = properties.inertia_about_center_of_mass().symmetric_eigenvalues().into();
    moments.sort_by(f64::total_cmp);
    moments
}

/// How far the largest moment exceeds the sum of the others: negative for a body of any thickness. None for a
/// point mass.
fn triangle_defect(properties: &MassProperties) -> Option<f64> {
    let [a, b, c] = moments(properties);
    (c > 0.0).then(|| (c - a - b) / c)
}

/// √(I₃/m).
fn gyration(properties: &MassProperties) -> f64 {
    (moments(properties)[2] / properties.mass()).sqrt()
}

/// The density of the solid ellipsoid with this mass and these moments, of semi-axes with
/// a² = 5 (I₂ + I₃ − I₁)/(2 m). None for a body without volume: a point, a rod, a sheet.
fn density(properties: &MassProperties) -> Option<f64> {
    let [a, b, c] = moments(properties);
    let axes = [b + c - a, a + c - b, a + b - c].map(|x| 2.5 * x / properties.mass());
    // Thinner than a thousandth of its length is a sheet or a rod.
    let longest = axes.iter().fold(0.0_f64, |most, &x| most.max(x));
    if axes.iter().any(|&x| x <= 1e-6 * longest) {
        return None;
    }
    let volume = 4.0 / 3.0 * PI * axes.iter().product::<f64>().sqrt();
    Some(properties.mass() / volume)
}
