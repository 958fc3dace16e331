//! Names and units of the entries of q, v and τ.

use robot_dynamics::description::CoordinateKind;
use robot_dynamics::model::Model;
use robot_dynamics::text::one_line;

/// One entry of q, v or τ, with its name on one line.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Column {
    pub name: String,
    pub unit: &'static str,
}

/// The entries of q.
pub(crate) fn configuration(model: &Model) -> Vec<Column> {
    let columns = model.joints().iter().filter(|joint| joint.nq > 0).flat_map(|joint| {
        joint.kind.positions().iter().map(|position| Column {
            name: one_line(&position.of_joint(&joint.name)).into_owned(),
            unit: match position.kind {
                CoordinateKind::Length => "m",
                CoordinateKind::Quaternion => "1",
                _ => "rad",
            },
        })
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

/// Names in the order of v, with a unit for translation or rotation.
fn along_v(model: &Model, [slide, turn]: [&'static str; 2]) -> Vec<Column> {
    let moving = model.joints().iter().filter(|joint| joint.nv > 0);
    let units = moving.flat_map(|joint| joint.kind.velocities()).map(|velocity| match velocity.kind {
        CoordinateKind::Length => slide,
        _ => turn,
    });
    let names = model.coordinate_names().into_iter().map(|name| one_line(&name).into_owned());
    names.zip(units).map(|(name, unit)| Column { name, unit }).collect()
}
