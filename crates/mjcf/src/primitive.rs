//! Volume or area of a primitive shape, and its principal moments at mass 1. **(PRM 10.42)**

use core::f64::consts::PI;

use crate::geom::GeomType;

/// A solid of uniform density, or a shell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PrimitiveSolid {
    /// Volume \[m³\], or area \[m²\] of a shell.
    pub(crate) measure: f64,
    /// Principal moments for 1 kg, about x, y, z \[m²\].
    pub(crate) moments: [f64; 3],
}

/// The extent of a primitive; `None` for other types. `size`: radius and half length, or half edges, or
/// semi-axes.
pub(crate) fn extent(form: GeomType, size: [f64; 3], shell: bool) -> Option<PrimitiveSolid> {
    let [a, b, c] = size;
    Some(match (form, shell) {
        (GeomType::Sphere, false) => {
            PrimitiveSolid { measure: 4.0 / 3.0 * PI * a.powi(3), moments: [0.4 * a * a; 3] }
        }
        (GeomType::Sphere, true) => {
            PrimitiveSolid { measure: 4.0 * PI * a * a, moments: [2.0 / 3.0 * a * a; 3] }
        }
        (GeomType::Cylinder, false) => {
            let measure = 2.0 * PI * a * a * b;
            PrimitiveSolid { measure, moments: symmetric_moments(a * a / 4.0 + b * b / 3.0, a * a / 2.0) }
        }
        (GeomType::Cylinder, true) => {
            // A tube and two discs.
            let tube = (4.0 * PI * a * b, a * a / 2.0 + b * b / 3.0, a * a);
            let discs = (2.0 * PI * a * a, a * a / 4.0 + b * b, a * a / 2.0);
            combine_parts([tube, discs])
        }
        (GeomType::Capsule, false) => {
            // A cylinder, and two half balls whose centres of mass are 3/8 of the radius beyond its ends.
            let cylinder = (2.0 * PI * a * a * b, a * a / 4.0 + b * b / 3.0, a * a / 2.0);
            let ends = 0.4 * a * a;
            let balls = (4.0 / 3.0 * PI * a.powi(3), ends + b * b + 0.75 * a * b, ends);
            combine_parts([cylinder, balls])
        }
        (GeomType::Capsule, true) => {
            // A tube, and two half spheres whose centres of mass are half the radius beyond its ends.
            let tube = (4.0 * PI * a * b, a * a / 2.0 + b * b / 3.0, a * a);
            let ends = 2.0 / 3.0 * a * a;
            let spheres = (4.0 * PI * a * a, ends + b * b + a * b, ends);
            combine_parts([tube, spheres])
        }
        (GeomType::Ellipsoid, false) => PrimitiveSolid {
            measure: 4.0 / 3.0 * PI * a * b * c,
            moments: moments_from_squares(size.map(|x| x * x / 5.0)),
        },
        (GeomType::Ellipsoid, true) => {
            // There is no closed form. As in MuJoCo, the area is that of Thomsen's formula, and the moments
            // are those of a layer between ellipsoids whose semi-axes differ by 1 µm.
            const P: f64 = 1.6075;
            const LAYER: f64 = 1e-6;
            let mean = ((a * b).powf(P) + (b * c).powf(P) + (c * a).powf(P)) / 3.0;
            let outer = size.map(|x| x + LAYER);
            let volume = |[a, b, c]: [f64; 3]| 4.0 / 3.0 * PI * a * b * c;
            let (inside, outside) = (volume(size), volume(outer));
            let moments =
                |size: [f64; 3], volume: f64| moments_from_squares(size.map(|x| volume * x * x / 5.0));
            let (inner, whole) = (moments(size, inside), moments(outer, outside));
            let layer = core::array::from_fn(|k| (whole[k] - inner[k]) / (outside - inside));
            PrimitiveSolid { measure: 4.0 * PI * mean.powf(1.0 / P), moments: layer }
        }
        (GeomType::Box, false) => PrimitiveSolid {
            measure: 8.0 * a * b * c,
            moments: moments_from_squares(size.map(|x| x * x / 3.0)),
        },
        (GeomType::Box, true) => {
            // Three pairs of plates: a plate normal to x is at x = ±a and uniform over y and z.
            let areas = [8.0 * b * c, 8.0 * c * a, 8.0 * a * b];
            let total: f64 = areas.iter().sum();
            let mean_square = core::array::from_fn(|axis| {
                let square = size[axis] * size[axis];
                (0..3)
                    .map(|plate| areas[plate] * if plate == axis { square } else { square / 3.0 })
                    .sum::<f64>()
                    / total
            });
            PrimitiveSolid { measure: total, moments: moments_from_squares(mean_square) }
        }
        _ => return None,
    })
}

/// Equal moments about x and y.
fn symmetric_moments(across: f64, along: f64) -> [f64; 3] {
    [across, across, along]
}

/// The moments ⟨y²⟩+⟨z²⟩, ⟨x²⟩+⟨z²⟩, ⟨x²⟩+⟨y²⟩.
fn moments_from_squares([x, y, z]: [f64; 3]) -> [f64; 3] {
    [y + z, x + z, x + y]
}

/// Two parts with a common centre, each with its measure, its moment across the axis and its moment about the
/// axis.
fn combine_parts(parts: [(f64, f64, f64); 2]) -> PrimitiveSolid {
    let measure: f64 = parts.iter().map(|part| part.0).sum();
    let mean = |moment: fn(&(f64, f64, f64)) -> f64| {
        parts.iter().map(|part| part.0 * moment(part)).sum::<f64>() / measure
    };
    PrimitiveSolid { measure, moments: symmetric_moments(mean(|part| part.1), mean(|part| part.2)) }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    const SIZE: [f64; 3] = [0.3, 0.2, 0.5];

    fn moments(form: GeomType, size: [f64; 3], shell: bool) -> [f64; 3] {
        extent(form, size, shell).expect("a body").moments
    }

    fn assert_near(found: [f64; 3], expected: [f64; 3], tolerance: f64) {
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found - expected).abs() <= tolerance * expected, "{found} for {expected}");
        }
    }

    /// A shell is the derivative of the solid with respect to the thickness of a uniform layer.
    #[test]
    fn shells_are_the_growth_of_solids() {
        let h = 1e-6;
        for form in [GeomType::Sphere, GeomType::Cylinder, GeomType::Capsule, GeomType::Box] {
            // The half length of a capsule is that of its cylinder, which does not change.
            let grown = |h: f64| match form {
                GeomType::Capsule => [SIZE[0] + h, SIZE[1], SIZE[2]],
                _ => SIZE.map(|x| x + h),
            };
            let [more, less] = [h, -h].map(|h| extent(form, grown(h), false).expect("a body"));
            let shell = extent(form, SIZE, true).expect("a body");
            let area = (more.measure - less.measure) / (2.0 * h);
            assert!((shell.measure - area).abs() < 1e-8 * area, "{form:?}");
            let layer = core::array::from_fn(|k| {
                (more.moments[k] * more.measure - less.moments[k] * less.measure) / (2.0 * h * area)
            });
            assert_near(shell.moments, layer, 1e-8);
        }
    }

    #[test]
    fn solids_agree_with_those_of_the_library() {
        use robot_dynamics_description::MassProperties;
        let of = |body: Result<MassProperties, _>| {
            let body: MassProperties = body.expect("a body");
            let moments: [f64; 3] = body.inertia_about_center_of_mass().diagonal().into();
            moments.map(|moment| moment / body.mass())
        };
        let size = Vector3::from(SIZE);
        let brick = of(MassProperties::solid_box(1.0, 2.0 * size));
        assert_near(moments(GeomType::Box, SIZE, false), brick, 1e-14);
        let egg = of(MassProperties::solid_ellipsoid(1.0, size));
        assert_near(moments(GeomType::Ellipsoid, SIZE, false), egg, 1e-14);
        let can = of(MassProperties::solid_cylinder(1.0, SIZE[0], 2.0 * SIZE[1]));
        assert_near(moments(GeomType::Cylinder, SIZE, false), can, 1e-14);
    }

    /// A capsule of length zero and an ellipsoid with equal semi-axes are balls.
    #[test]
    fn degenerate_shapes_are_balls() {
        for shell in [false, true] {
            let ball = moments(GeomType::Sphere, SIZE, shell);
            assert_near(moments(GeomType::Capsule, [0.3, 0.0, 0.0], shell), ball, 1e-14);
            // The middle of the layer is 0.5 µm outside: a relative error of 5e-7/0.3 of the radius, and
            // twice that of its square.
            let tolerance = if shell { 7e-6 } else { 1e-14 };
            assert_near(moments(GeomType::Ellipsoid, [0.3; 3], shell), ball, tolerance);
        }
        assert_eq!(extent(GeomType::Plane, SIZE, false), None);
    }
}
