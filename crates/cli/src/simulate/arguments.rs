//! The arguments of the command.

use std::path::PathBuf;

use robot_dynamics::simulation::{AdaptiveOptions, Effect, Method, SimulationBuilder, steps_in};

use super::hold::Gains;
use super::option_values::{GroundOption, friction, tolerance};
use super::plot::path;
use crate::arguments::positive;
use crate::joint_values::{JointValues, NameOrValues};
use crate::robot_file::RobotFile;

/// Simulate a robot from a pose, passively or with a controller, and check the energy balance.
///
/// Integrates M a + C v + g = τ. Everything in the robot's file acts: damping, friction, position limits as
/// stops, springs, actuators, equalities, and contact with the world and between links. --without switches
/// effects off by name. With --conservative no effect adds or removes energy. E = K + V is then constant, and
/// its drift is the integrator's error. With --ground the robot falls on ground.
///
/// Ctrl-C ends the run early and keeps the results so far (exit code 130; 143 after SIGTERM, 129 after
/// SIGHUP). Files of a run that ended early, or that do not fit on the disk, are named
/// NAME.partial.EXTENSION. An older NAME.EXTENSION then stays. No output replaces a file that the robot is
/// read from.
#[derive(clap::Args)]
#[allow(clippy::struct_excessive_bools)] // one for each option without a value
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(super) robot: RobotFile,
    /// Initial configuration by joint name, as in joint1=0.5,joint4=-1.2 [rad, m], or the name of a pose in
    /// the robot's file. A joint of several numbers takes them in a row: floating_base=x,y,z,qx,qy,qz,qw.
    #[arg(long, value_name = "JOINT=NUMBER,…")]
    pub(super) pose: Vec<NameOrValues>,
    /// Initial velocity by joint name [rad/s, m/s].
    #[arg(long, value_name = "JOINT=NUMBER,…")]
    pub(super) velocity: Vec<JointValues>,
    /// Simulated time in s, rounded to the nearest whole number of steps, at least one.
    #[arg(long, default_value_t = 10.0, value_name = "SECONDS", value_parser = positive)]
    #[arg(allow_negative_numbers = true)]
    pub(super) duration: f64,
    /// Time step and control period in s.
    #[arg(long, alias = "step", default_value_t = SimulationBuilder::DEFAULT_DT, value_name = "SECONDS", value_parser = positive)]
    #[arg(allow_negative_numbers = true)]
    pub(super) dt: f64,
    /// Integrator. Fixed steps of --dt: explicit-euler, semi-implicit-euler, rk4, variational-midpoint,
    /// variational-yoshida4, implicit, mujoco. Only implicit and mujoco support limits and contact: implicit
    /// with rigid contact, stiction and stops, mujoco with MuJoCo's soft constraints. Variable steps within
    /// --tolerance: adaptive, of order 9, or implicit of order 5 for stiff damping. [default: rk4 if all
    /// forces are smooth and not stiff, else implicit].
    #[arg(long, value_name = "NAME")]
    pub(super) integrator: Option<Method>,
    /// Simulate without damping, friction, limits, actuators and contact.
    #[arg(long, conflicts_with_all = ["controls", "ground"])]
    pub(super) conservative: bool,
    /// Switch off effects of the file: dissipation, limits, effort-limits, springs, actuators, equalities,
    /// contacts, link-contacts.
    #[arg(long, value_name = "EFFECT,…", value_delimiter = ',')]
    pub(super) without: Vec<Effect>,
    /// Allowed error of each step of --integrator adaptive, relative and absolute, 1e-13 to 1e-2 [default:
    /// 1e-9].
    #[arg(long, value_name = "ERROR", value_parser = tolerance, allow_negative_numbers = true)]
    pub(super) tolerance: Option<f64>,
    /// End the run when a joint reaches a position limit.
    #[arg(long)]
    pub(super) stop_at_limits: bool,
    /// Constant controls of the file's actuators by name. Actuators that are not named keep the control of
    /// the named pose, or 0.
    #[arg(long, value_name = "ACTUATOR=NUMBER,…", num_args = 0..=1, default_missing_value = "", conflicts_with_all = ["hold", "goal"])]
    pub(super) controls: Option<String>,
    /// Add ground with rigid frictional contact. z is its height in m, slope its angle along x in rad. With
    /// `file` the command fails unless the MJCF file has a ground plane or a height field, which act in any
    /// case.
    #[arg(long, value_name = "z=NUMBER,slope=NUMBER|file", num_args = 0..=1)]
    #[allow(clippy::option_option)] // given, and with a value
    pub(super) ground: Option<Option<GroundOption>>,
    /// Friction coefficient of all contacts, instead of that of the shapes.
    #[arg(long, value_name = "NUMBER", value_parser = friction, allow_negative_numbers = true)]
    pub(super) friction: Option<f64>,
    /// Place the lowest point of a floating robot on the ground at the start.
    #[arg(long)]
    pub(super) standing: bool,
    /// Hold the initial pose by motors: PD control with gravity compensation, within the effort limits.
    #[arg(long)]
    pub(super) hold: bool,
    /// Move to this pose and hold it, by joint name. Joints that are not named keep their position.
    #[arg(long, value_name = "JOINT=NUMBER,…")]
    pub(super) goal: Vec<JointValues>,
    #[command(flatten)]
    pub(super) gains: Gains,
    /// Write time, q, v, τ and energies as comma-separated values with a header. With - they go to standard
    /// output, and the summary to standard error.
    #[arg(long, value_name = "FILE")]
    pub(super) csv: Option<PathBuf>,
    /// Time between rows of the CSV file in s, rounded to the nearest whole number of steps, at least one
    /// [default: each step]. The first and the last state always get a row.
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_negative_numbers = true)]
    pub(super) sample_period: Option<f64>,
    /// Plot joint coordinates, energies, the energy error, energy losses and ground forces to FILE.svg or
    /// FILE.png.
    #[arg(long, value_name = "FILE", value_parser = path)]
    pub(super) plot: Option<PathBuf>,
}

impl Arguments {
    /// The tolerance of adaptive steps.
    pub(super) fn adaptive_tolerance(&self) -> f64 {
        self.tolerance.unwrap_or(AdaptiveOptions::DEFAULT_TOLERANCE)
    }

    /// The number of steps between rows of the CSV file, at least one.
    pub(super) fn steps_between_rows(&self) -> Result<usize, String> {
        let steps = steps_in(self.sample_period.unwrap_or(self.dt), self.dt)
            .map_err(|error| format!("--sample-period: {error}"))?;
        Ok(steps.max(1))
    }
}
