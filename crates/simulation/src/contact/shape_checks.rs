//! Checks and descriptions of shapes and surfaces.

use robot_dynamics_description::{LinkShape, Shape};

/// The number of rows of a contact: normal, two of sliding, torsion, two of rolling.
pub(super) fn rows_of(condim: u8) -> usize {
    match condim {
        0..=2 => 1,
        3 => 3,
        4 | 5 => 4,
        _ => 6,
    }
}

/// The first size of a shape that is not finite.
pub(super) fn size_not_finite(shape: &Shape) -> Option<&'static str> {
    let (quantity, sizes): (&'static str, &[f64]) = match shape {
        Shape::Sphere { radius } => ("radius", &[*radius]),
        Shape::Capsule { radius, length } | Shape::Cylinder { radius, length } => {
            ("radius or length", &[*radius, *length])
        }
        Shape::Box { size } => ("size", size),
        Shape::Ellipsoid { half_axes } => ("half axis", half_axes),
        Shape::Plane { .. } | Shape::HeightField { .. } | Shape::Mesh { .. } => return None,
    };
    sizes.iter().any(|x| !x.is_finite()).then_some(quantity)
}

/// A description of a shape for messages.
pub(super) fn described(shape: &LinkShape) -> String {
    let what = match &shape.shape {
        Shape::Mesh { name, .. } => format!("mesh `{name}`"),
        Shape::HeightField { name, .. } => format!("height field `{name}`"),
        other => format!("{other:?}"),
    };
    format!("{what} of link `{}`", shape.link)
}
