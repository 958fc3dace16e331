//! The effects that act, and the method that they require.

use robot_dynamics_core::{Model, Workspace, inverse_mass_matrix, neutral};
use robot_dynamics_description::RobotDescription;
use robot_dynamics_integrators::Integrator;

use super::method::{SimulationStepper, StepperKind};
use super::{Effect, Method, SimulationBuilder};
use crate::Actuation;

/// Implicit steps are chosen if (rate of a damped or elastic mode) × (step) exceeds this. Explicit steps of
/// order 4 diverge at 2.8. Below this threshold their relative error of a damped mode is under 1e-3 a step.
const STIFF: f64 = 0.5;

/// The kinds of forces that act; they determine the default method.
#[allow(clippy::struct_excessive_bools)] // one flag for each kind of force
pub(super) struct Kinds {
    friction: bool,
    limits: bool,
    /// Actuators that pull at contacts.
    adhesion: bool,
    /// Springs that yield.
    #[cfg(feature = "adaptive")]
    yielding: bool,
    contacts: bool,
    equalities: bool,
    actuators: bool,
    springs: bool,
    fluid: bool,
    dissipates: bool,
    /// Whether damping or friction is present.
    losses: bool,
    link_contacts: bool,
    stiffest: Option<(String, f64)>,
    /// The rate of the fastest current of a motor \[1/s\], if the steps do not resolve it.
    current: Option<f64>,
}

impl Kinds {
    pub(super) fn of(
        builder: &SimulationBuilder<'_>,
        (contacts, link_contacts): (bool, bool),
        equalities: bool,
        actuation: Option<&Actuation>,
    ) -> Self {
        let model = &*builder.model;
        let RobotDescription { tendons, spatial_tendons: paths, .. } = model.description();
        let dissipates = builder.acts(Effect::Dissipation);
        let has_friction = model.dofs.iter().any(|dof| dof.passive.friction != 0.0)
            || tendons.iter().any(|tendon| tendon.passive.friction != 0.0)
            || paths.iter().any(|tendon| tendon.passive.friction != 0.0);
        let is_bound = |limits: &robot_dynamics_description::Limits| {
            limits.lower.is_finite() || limits.upper.is_finite()
        };
        let has_limits = model.joints().iter().any(|joint| joint.nv > 0 && is_bound(&joint.limits))
            || tendons.iter().any(|tendon| is_bound(&tendon.limits))
            || paths.iter().any(|tendon| is_bound(&tendon.limits));
        let actuators = actuation.is_some_and(|actuation| actuation.control_count() > 0);
        Self {
            friction: dissipates && has_friction,
            limits: builder.acts(Effect::Limits) && has_limits,
            adhesion: actuation.is_some_and(Actuation::has_adhesion),
            #[cfg(feature = "adaptive")]
            yielding: actuation.is_some_and(Actuation::has_yielding_springs),
            contacts,
            equalities,
            actuators,
            springs: actuation.is_some_and(|all| !all.clone().without_actuators().without_fluid().is_empty()),
            fluid: actuation.is_some_and(Actuation::has_fluid),
            dissipates,
            losses: has_friction
                || has_damping(model)
                || tendons.iter().any(|tendon| tendon.passive.damping != 0.0)
                || paths.iter().any(|tendon| tendon.passive.damping != 0.0),
            link_contacts,
            stiffest: stiffest(model, actuation, dissipates, builder.dt),
            current: actuation.map(Actuation::fastest_current).filter(|rate| rate * builder.dt > STIFF),
        }
    }

    /// Chooses `rk4` if every force is smooth and not stiff, otherwise `implicit`, and returns the reason.
    pub(super) fn method(&self, model: &Model) -> (Method, String) {
        let found =
            [(self.friction, "dry friction"), (self.limits, "position limits"), (self.contacts, "contacts")];
        let mut causes: Vec<String> =
            found.into_iter().filter(|(acts, _)| *acts).map(|(_, cause)| cause.to_owned()).collect();
        if let Some((coordinate, rate)) = &self.stiffest {
            causes.push(format!("stiff forces at `{coordinate}` ({rate:.0}/s)"));
        }
        if let Some(rate) = self.current {
            causes.push(format!("the current of a motor ({rate:.0}/s)"));
        }
        let has_forces = self.actuators || self.springs || self.fluid;
        if self.equalities && (has_forces || self.dissipates && has_damping(model)) {
            let fluid = if self.fluid { ", a fluid" } else { "" };
            causes.push(format!("equalities beside damping, springs{fluid} or actuators"));
        }
        if causes.is_empty() {
            return (Method::Fixed(Integrator::RungeKutta4), "everything that acts is smooth".into());
        }
        (Method::Implicit, format!("needed for {}", joined(&causes)))
    }

    /// The effects that act with this stepper.
    pub(super) fn acting(&self, stepper: &SimulationStepper, effort: Option<&[f64]>) -> Vec<Effect> {
        let holds_all = matches!(stepper.kind, StepperKind::Implicit(_) | StepperKind::Mujoco(_));
        let drives = stepper.drives();
        let holds_equalities = holds_all || matches!(stepper.kind, StepperKind::Constrained(_));
        let is_limited = effort.is_some_and(|effort| effort.iter().any(|limit| limit.is_finite()));
        let all = [
            (Effect::Dissipation, self.dissipates && self.losses || drives && self.fluid),
            (Effect::Limits, holds_all && self.limits),
            (Effect::EffortLimits, is_limited),
            (Effect::Springs, drives && self.springs),
            (Effect::Actuators, drives && self.actuators),
            (Effect::Equalities, holds_equalities && self.equalities),
            (Effect::Contacts, holds_all && self.contacts),
            (Effect::LinkContacts, holds_all && self.link_contacts),
        ];
        all.into_iter().filter(|(_, acts)| *acts).map(|(effect, _)| effect).collect()
    }

    /// Whether dry friction acts.
    #[cfg(feature = "adaptive")]
    pub(super) fn has_friction(&self) -> bool {
        self.friction
    }

    /// The same effects without damping and friction.
    #[cfg(feature = "adaptive")]
    pub(super) fn without_dissipation(self) -> Self {
        Self { dissipates: false, friction: false, fluid: false, ..self }
    }

    /// Lists adhesion, which MuJoCo's law alone supports.
    pub(super) fn list_left_out_beside_mujoco(&self, method: Method, left_out: &mut Vec<String>) {
        let name = method.name();
        if self.adhesion && method != Method::Mujoco {
            left_out
                .push(format!("actuators that pull at contacts: `{name}` does not know them, `mujoco` does"));
        }
    }

    /// Lists the effects that adaptive steps do not support.
    #[cfg(feature = "adaptive")]
    pub(super) fn list_left_out_by_adaptive(&self, left_out: &mut Vec<String>) {
        let all = [
            (self.friction && !self.fluid, "damping and dry friction"),
            (self.friction && self.fluid, "damping, dry friction and the fluid"),
            (self.limits, "position limits"),
            (self.contacts, "contacts"),
            (self.equalities, "equalities"),
            (self.yielding, "the yield of springs"),
        ];
        let found = all.into_iter().filter(|(is_there, _)| *is_there);
        left_out
            .extend(found.map(|(_, what)| format!("{what}: `adaptive` does not know them, `implicit` does")));
    }

    /// Lists the effects that a row of the table of integrators does not support.
    pub(super) fn list_left_out(&self, row: Integrator, left_out: &mut Vec<String>) {
        let name = row.name();
        let mut leave = |is_there: bool, what: &str| {
            if is_there {
                left_out.push(format!("{what}: `{name}` does not know them, `implicit` does"));
            }
        };
        leave(self.limits, "position limits");
        leave(self.contacts, "contacts");
        let drives = row.is_explicit() && !self.equalities;
        leave(self.actuators && !drives, "actuators");
        leave(self.springs && !drives, "tendons, springs of ball and free joints and compensated weight");
        leave(self.fluid && !drives, "forces of the fluid");
    }
}

/// Joins names with commas, and with `and` before the last.
fn joined(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

fn has_damping(model: &Model) -> bool {
    model.dofs.iter().any(|dof| dof.passive.damping != 0.0)
}

/// The coordinate with the fastest damping or spring in the neutral configuration, and its rate \[1/s\], if
/// steps of h do not resolve it. The rate is the larger of D_kk (M⁻¹)_kk and √(K_kk (M⁻¹)_kk).
fn stiffest(model: &Model, actuation: Option<&Actuation>, dissipates: bool, h: f64) -> Option<(String, f64)> {
    let n = model.nv;
    let (mut stiffness, mut damping) = (vec![0.0; n], vec![0.0; n]);
    for dof in &model.dofs {
        let square = dof.ratio * dof.ratio;
        stiffness[dof.coordinate] += square * dof.passive.stiffness;
        if dissipates {
            damping[dof.coordinate] += square * dof.passive.damping;
        }
    }
    if let Some(actuation) = actuation {
        let mut couplings = Vec::new();
        actuation.add_gains(&mut stiffness, &mut damping, &mut couplings);
        for coupling in &couplings {
            for &(k, factor) in &coupling.row {
                stiffness[k] += factor * factor * coupling.stiffness;
                damping[k] += factor * factor * coupling.damping;
            }
        }
    }
    let q = neutral(model);
    if let Some(fluid) = actuation.and_then(Actuation::fluid).filter(|_| dissipates) {
        // The linear drag, which acts at rest.
        let state = (&q[..], &vec![0.0; n][..]);
        fluid.for_each_damping(model, &mut fluid.workspace(model), state, |row, column, entry| {
            if row == column {
                damping[row] += entry;
            }
        });
    }
    if stiffness.iter().chain(&damping).all(|gain| *gain == 0.0) {
        return None;
    }
    let workspace = &mut Workspace::new(model);
    let mut inverse = vec![0.0; n * n];
    inverse_mass_matrix(model, workspace, &q, &mut inverse);
    let rate = |k: usize| {
        let mobility = inverse[k * n + k];
        (damping[k].max(0.0) * mobility).max((stiffness[k].max(0.0) * mobility).sqrt())
    };
    let fastest = (0..n).max_by(|a, b| rate(*a).total_cmp(&rate(*b)))?;
    // If M is singular, the rate is NaN, and only implicit steps can continue.
    let is_resolved = rate(fastest) * h <= STIFF;
    (!is_resolved).then(|| (model.coordinate_names()[fastest].clone(), rate(fastest)))
}
