//! `dynamics numbers`: the worked example, a two-link arm at one pose.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use std::process::ExitCode;

use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use robot_dynamics::description::{
    JointDescription, JointKind, LinkDescription, MassProperties, Pose, RobotDescription,
};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{Integrator, Method, SimulationBuilder};

use crate::failure::{CommandResult, Failure};
use crate::output::print;

pub(crate) fn run() -> CommandResult {
    print(&text().map_err(Failure::new)?)?;
    Ok(ExitCode::SUCCESS)
}

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Uniform thin rods of 1 m, 2 kg and 1 m, 1 kg in the vertical x-z plane. **(PRM 10.7)**
fn arm() -> Result<Model> {
    let rod = |mass: f64| {
        let across = mass / 12.0;
        let inertia = Matrix3::from_diagonal(&Vector3::new(0.0, across, across));
        MassProperties::new(mass, Vector3::new(0.5, 0.0, 0.0), inertia)
    };
    let mut robot = RobotDescription::new("two_r");
    robot.links.push(LinkDescription::new("base", None));
    let rods = [("shoulder", "base", "upper", 2.0, 0.0), ("elbow", "upper", "fore", 1.0, 1.0)];
    for (joint, parent, link, mass, along) in rods {
        let kind = JointKind::Revolute { axis: [0.0, -1.0, 0.0] };
        let parent_from_joint = Pose::from_translation([along, 0.0, 0.0]);
        robot.links.push(LinkDescription::new(link, rod(mass)?));
        robot.joints.push(JointDescription::new(joint, kind, parent, link, parent_from_joint));
    }
    Ok(Model::new(robot)?)
}

/// The table of the example, every number computed.
fn text() -> Result<String> {
    let arm = arm()?;
    let (q, qd) = ([FRAC_PI_4, FRAC_PI_2], [1.0, 0.0]);
    let mass = arm.mass_matrix(&q)?;
    let eigenvalues = SymmetricEigen::new(mass.clone()).eigenvalues;
    let gravity = arm.gravity_forces(&q)?;
    let product = arm.velocity_product(&q, &qd)?;
    let (kinetic, potential) = (arm.kinetic_energy(&q, &qd)?, arm.potential_energy(&q)?);
    let m11 = |q2: f64| Ok::<f64, Box<dyn std::error::Error>>(arm.mass_matrix(&[q[0], q2])?[(0, 0)]);
    let drift = |integrator: Integrator| -> Result<f64> {
        let builder = SimulationBuilder::new(&arm).conservative().method(Method::Fixed(integrator)).dt(1e-3);
        let mut simulation = builder.build()?;
        simulation.reset(&q, &[0.0, 0.0])?;
        simulation.run_for(10.0)?;
        Ok(simulation.energy_account().drift())
    };
    // Adding zero turns −0 into 0.
    Ok(format!(
        "M   = [[{:.4}, {:.4}], [{:.4}, {:.4}]]      det {:.4}   eig {:.4} {:.4}\n\
         g   = [{:.4}, {:.4}]\n\
         Cq̇  = [{:.4}, {:.4}]        for q̇ = (1, 0)\n\
         K   = {kinetic:.4} J    V = {potential:.4} J    E = {:.4} J\n\
         M11 sweep over q2 ∈ {{0, π/2, π}}:  {:.4}  {:.4}  {:.4}\n\
         energy drift, τ = 0, h = 1 ms, 10 s:  rk4 {:.1e}   semi-implicit Euler {:.1e}   explicit Euler {:.1e}\n",
        mass[(0, 0)],
        mass[(0, 1)],
        mass[(1, 0)],
        mass[(1, 1)],
        mass.determinant(),
        eigenvalues.max(),
        eigenvalues.min(),
        gravity[0],
        gravity[1],
        product[0] + 0.0,
        product[1],
        kinetic + potential,
        m11(0.0)?,
        m11(FRAC_PI_2)?,
        m11(PI)?,
        drift(Integrator::RungeKutta4)?,
        drift(Integrator::SemiImplicitEuler)?,
        drift(Integrator::ExplicitEuler)?,
    ))
}
