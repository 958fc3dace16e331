//! What the entries of q, v and τ are called, and their units.

use multibody::{Joint, Model};

/// One entry of q, v or τ.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Column {
    pub name: String,
    pub unit: &'static str,
}

/// The entries of q.
pub(crate) fn configuration(model: &Model) -> Vec<Column> {
    let parts: fn(&Joint) -> &'static [(&'static str, &'static str)] = |joint| match joint.kind {
        "floating" => {
            &[(".x", "m"), (".y", "m"), (".z", "m"), (".qx", "1"), (".qy", "1"), (".qz", "1"), (".qw", "1")]
        }
        "spherical" => &[(".qx", "1"), (".qy", "1"), (".qz", "1"), (".qw", "1")],
        "planar" => &[(".x", "m"), (".y", "m"), (".theta", "rad")],
        "universal" => &[(".1", "rad"), (".2", "rad")],
        "prismatic" => &[("", "m")],
        _ => &[("", "rad")],
    };
    let columns = model.joints().iter().filter(|joint| joint.nq > 0).flat_map(|joint| {
        parts(joint).iter().map(|(suffix, unit)| Column { name: format!("{}{suffix}", joint.name), unit })
    });
    columns.collect()
}

/// The entries of v.
pub(crate) fn velocity(model: &Model) -> Vec<Column> {
    along_v(model, ["m/s", "rad/s"])
}

/// The entries of τ.
pub(crate) fn effort(model: &Model) -> Vec<Column> {
    along_v(model, ["N", "N m"])
}

/// Names in the order of v, with the unit for a slide or that for a turn.
fn along_v(model: &Model, [slide, turn]: [&'static str; 2]) -> Vec<Column> {
    let units = model.joints().iter().flat_map(|joint| {
        let slides = match joint.kind {
            "floating" => 3,
            "planar" => 2,
            "prismatic" => 1,
            _ => 0,
        };
        (0..joint.nv).map(move |k| if k < slides { slide } else { turn })
    });
    model.coordinate_names().into_iter().zip(units).map(|(name, unit)| Column { name, unit }).collect()
}
