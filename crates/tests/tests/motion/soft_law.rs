//! Surfaces under MuJoCo's law: friction as under the rigid law; restitution is an error.

use robot_dynamics::contact::{ContactSet, Ground, HeightField, SoftConstraints};
use robot_dynamics::description::Shape;
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{RunOptions, SimulationBuilder};

use crate::free_body::{body, implicit_on, soft_on};

const G: f64 = 9.81;

/// The speed of a block with this friction after 0.1 s on level ground, from 0.5 m/s.
fn speed_after(
    own: f64,
    ground: Ground,
    builder_of: impl Fn(&Model, ContactSet) -> SimulationBuilder<'static>,
) -> f64 {
    let mut robot = body(2e-3, Shape::Box { size: [0.2, 0.2, 0.1] });
    robot.shapes[0].surface.friction = [own, 0.0, 0.0];
    let model = Model::new(robot).unwrap();
    let contacts = ContactSet::new(&model, &[ground]).unwrap();
    let start = [0.0, 0.0, 0.0495, 0.0, 0.0, 0.0, 1.0];
    let run = builder_of(&model, contacts)
        .build()
        .unwrap()
        .run_steps_from(&start, &[0.5, 0.0, 0.0, 0.0, 0.0, 0.0], 100, RunOptions::new())
        .unwrap();
    run.v[0]
}

/// On a ground without a coefficient of friction the coefficient of each shape applies, under both laws. A
/// coefficient of the ground replaces all of them.
#[test]
fn friction_agrees_under_both_laws() {
    let soft = |model: &Model, contacts| soft_on(model, contacts, 1e-3);
    let bare = Ground::level(0.0);
    for (own, ground, friction) in [
        (0.1, bare, 0.1),
        (0.3, bare, 0.3),
        (0.1, bare.with_friction(0.2), 0.2),
        (0.4, bare.with_friction(0.05), 0.05),
    ] {
        let expected = 0.5 - friction * G * 0.1;
        let (by_rigid, by_soft) = (speed_after(own, ground, implicit_on), speed_after(own, ground, soft));
        // The block starts half a millimetre deep; the rigid law lifts it out meanwhile, without additional
        // pressure.
        assert!((by_rigid - expected).abs() < 1e-9, "{own}: {by_rigid} {expected}");
        // The soft law lets it oscillate by the initial imbalance: a few per cent of its weight.
        assert!((by_soft - expected).abs() < 0.1 * friction * G * 0.1, "{own}: {by_soft} {expected}");
    }
}

/// Restitution of planes and of height fields.
#[test]
fn restitution_is_an_error() {
    let model = Model::new(body(2e-3, Shape::Sphere { radius: 0.1 })).unwrap();
    let refused = |contacts: ContactSet| {
        let law = SoftConstraints::new(&model, 1e-3).unwrap().with_ground(&model, contacts);
        law.err()
    };
    let level =
        |restitution| ContactSet::new(&model, &[Ground::level(0.0).with_restitution(restitution)]).unwrap();
    assert_eq!(refused(level(0.0)), None);
    let error = refused(level(0.9));
    assert_eq!(error.as_ref().unwrap().quantity, "a coefficient of restitution of 0.9");
    let field = HeightField::new(2, 2, [1.0, 1.0], vec![0.0; 4]).unwrap().with_restitution(0.9);
    let contacts = ContactSet::new(&model, &[]).unwrap().with_height_field(&field).unwrap();
    assert_eq!(refused(contacts), error);
}
