use robot_dynamics::description::{PassiveForces, pendulum};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{AdaptiveOptions, ControlTiming, Method, SimulationBuilder, StepError};

use crate::Section;

pub(crate) fn options() -> Section {
    let mut section = Section::new("InvalidInput of AdaptiveOptions");
    let model = Model::new(pendulum(2.0, 0.5)).expect("a robot");
    let options = AdaptiveOptions { tolerance: 1e-20, ..AdaptiveOptions::default() };
    let error = SimulationBuilder::new(&model).adaptive(options).build().expect_err("a tolerance");
    section.row("a tolerance of 1e-20", error);
    let control = ControlTiming::Held { period: -1.0 };
    let options = AdaptiveOptions { control, ..AdaptiveOptions::default() };
    let error = SimulationBuilder::new(&model).adaptive(options).build().expect_err("a period");
    section.row("a control period of -1 s", error);
    section
}

pub(crate) fn steps() -> Section {
    let mut section = Section::new("StepError of adaptive steps");
    let coordinate = || "hinge".to_owned();
    section.row("steps below rounding", StepError::StepTooSmall { step: 1e-12, coordinate: coordinate() });
    section.row(
        "more steps than allowed",
        StepError::TooManySteps { steps: 5, step: 0.25, coordinate: coordinate() },
    );
    section.row("growth", StepError::Diverged { coordinate: coordinate(), speed: 1e12, step: 1e-3 });
    section
}

/// The method's name among the others, and the effects that it leaves out.
pub(crate) fn names() -> Section {
    let mut section = Section::new("UnknownMethod, and Simulation::left_out");
    section.row("rk5", "rk5".parse::<Method>().expect_err("no method"));
    let mut robot = pendulum(2.0, 0.5);
    robot.joints[0].passive = PassiveForces::default().with_friction(0.1).with_damping(0.1);
    let model = Model::new(robot).expect("a robot");
    let builder = SimulationBuilder::new(&model).adaptive(AdaptiveOptions::default());
    let simulation = builder.build().expect("a simulation");
    section.row("friction and damping", simulation.left_out().join("\n    "));
    section
}
