//! The texts of errors.

use std::fmt::Write;

use robot_dynamics::description::pendulum;
use robot_dynamics::model::Model;
use robot_dynamics_expression::Arithmetic;
use robot_dynamics_functions::Function;

#[test]
fn errors() {
    let mut massless = pendulum(2.0, 0.5);
    massless.links.iter_mut().for_each(|link| link.mass_properties = None);
    let (model, massless) = (Model::new(pendulum(2.0, 0.5)).unwrap(), Model::new(massless).unwrap());
    let mut text = String::new();
    for name in
        ["inertia", "frame_pose", "gravity_derivatives_derivatives", "forward_dynamics_pullback_pullback"]
    {
        let error = name.parse::<Function>().unwrap_err();
        let _ = writeln!(text, "{name}: {error}");
    }
    let of_derivatives = Function::Gravity.derivatives().derivatives();
    for (model, function) in [
        (&model, of_derivatives),
        (&model, Function::FramePose("hand".into())),
        (&massless, Function::ForwardDynamics),
    ] {
        let error = function.trace(model, Arithmetic::default()).unwrap_err();
        let _ = writeln!(text, "{function}: {error}");
    }
    insta::assert_snapshot!(text);
}
