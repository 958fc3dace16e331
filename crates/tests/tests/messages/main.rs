//! The full text of the errors and panics of the library. Other tests match variants and fields.
//!
//! Each section lists invalid inputs and the message that the library gives for each. Messages with numbers
//! that depend on the processor come from constructed errors.
//!
//! After a change of wording, run this and read the difference of `snapshots/`:
//!
//!     INSTA_UPDATE=always cargo test -p robot-dynamics-tests --all-features --test messages

#[cfg(feature = "adaptive")]
mod adaptive;
mod control;
mod descriptions;
mod motion;
mod panics;
mod robots;
mod runs;

use std::fmt::{Display, Write as _};

/// The messages of one error type.
struct Section(String);

impl Section {
    fn new(error_type: &str) -> Self {
        Self(format!("== {error_type}\n"))
    }

    #[allow(clippy::needless_pass_by_value)] // errors are passed as calls return them
    fn row(&mut self, input: &str, message: impl Display) {
        writeln!(self.0, "{input}\n    {message}").expect("writes to a string succeed");
    }
}

fn joined(sections: Vec<Section>) -> String {
    sections.into_iter().map(|section| section.0).collect::<Vec<_>>().join("\n")
}

#[test]
fn errors_of_descriptions_and_models() {
    insta::assert_snapshot!(joined(vec![
        descriptions::model_error(),
        descriptions::sensors(),
        descriptions::surgery_error(),
        descriptions::fixed_size_error(),
        descriptions::parameter_error(),
        descriptions::joint_map_error(),
    ]));
}

#[test]
fn errors_of_states_and_motions() {
    insta::assert_snapshot!(joined(vec![
        motion::configuration_error(),
        motion::motion_error(),
        motion::constraint_set_error(),
        motion::constrained_motion_error(),
        motion::operational_space_error(),
        motion::integrator_error(),
        motion::pullback_error(),
        motion::rollout_error(),
    ]));
}

#[test]
fn errors_of_runs_and_contacts() {
    insta::assert_snapshot!(joined(vec![
        runs::run_error(),
        runs::contact_error(),
        runs::unknown_effect(),
        runs::left_out(),
    ]));
}

#[test]
fn errors_of_control() {
    insta::assert_snapshot!(joined(vec![
        control::controller_error(),
        control::inverse_kinematics_error(),
        control::spline_error(),
        control::parameterization_error(),
        control::online_motion_error(),
        control::identification_error(),
    ]));
}

#[test]
fn panics_of_wrong_arguments() {
    insta::assert_snapshot!(joined(vec![
        panics::foreign_objects(),
        panics::wrong_lengths(),
        panics::batches(),
    ]));
}

#[test]
#[cfg(feature = "adaptive")]
fn errors_of_adaptive_runs() {
    insta::assert_snapshot!(joined(vec![adaptive::options(), adaptive::steps(), adaptive::names()]));
}
