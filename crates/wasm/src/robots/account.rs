//! Named numbers for the page.

use robot_dynamics::description::LoadCounts;
use robot_dynamics::simulation::Losses;
use wasm_bindgen::prelude::wasm_bindgen;

use super::robot::Robot;

/// A robot's energy since its placement \[J\].
#[wasm_bindgen]
#[derive(Clone, Copy, Debug)]
pub struct RobotEnergyAccount {
    /// K.
    #[wasm_bindgen(readonly)]
    pub kinetic: f64,
    /// V, with joint springs.
    #[wasm_bindgen(readonly)]
    pub potential: f64,
    /// K + V.
    #[wasm_bindgen(readonly)]
    pub energy: f64,
    /// K + V at the start.
    #[wasm_bindgen(readonly)]
    pub start: f64,
    /// Work of the motors and of the pulling hand.
    #[wasm_bindgen(readonly)]
    pub work: f64,
    /// Sum of all losses.
    #[wasm_bindgen(readonly)]
    pub dissipated: f64,
    /// Loss by viscous damping, with friction if the method does not separate them.
    #[wasm_bindgen(readonly)]
    pub damping: f64,
    /// Loss by dry friction.
    #[wasm_bindgen(readonly)]
    pub friction: f64,
    /// Loss by stops.
    #[wasm_bindgen(readonly)]
    pub stops: f64,
    /// Loss by the correction of penetration at the start of a step; negative for a gain.
    #[wasm_bindgen(readonly)]
    pub corrections: f64,
    /// Loss by sliding friction.
    #[wasm_bindgen(readonly)]
    pub sliding: f64,
    /// Loss by impacts.
    #[wasm_bindgen(readonly)]
    pub impacts: f64,
    /// The residual: the method's own error.
    #[wasm_bindgen(readonly)]
    pub unaccounted: f64,
}

/// The size of a robot from a file, and the disposition of the file's values.
#[wasm_bindgen]
#[derive(Clone, Copy, Debug)]
pub struct RobotCounts {
    /// Links.
    #[wasm_bindgen(readonly)]
    pub links: usize,
    /// Joints of every kind.
    #[wasm_bindgen(readonly)]
    pub joints: usize,
    /// Degrees of freedom.
    #[wasm_bindgen(readonly)]
    pub dofs: usize,
    /// Values that were defaulted.
    #[wasm_bindgen(readonly)]
    pub defaulted: usize,
    /// Inertias that were repaired.
    #[wasm_bindgen(readonly)]
    pub repaired: usize,
    /// Suspicious values that were taken as written.
    #[wasm_bindgen(readonly)]
    pub suspicious: usize,
    /// Ignored values without physics.
    #[wasm_bindgen(readonly)]
    pub ignored: usize,
    /// Ignored physics.
    #[wasm_bindgen(readonly, js_name = ignoredPhysics)]
    pub ignored_physics: usize,
    /// Closed loops and joint couplings.
    #[wasm_bindgen(readonly)]
    pub equalities: usize,
    /// Tendons.
    #[wasm_bindgen(readonly)]
    pub tendons: usize,
    /// Actuators of the file.
    #[wasm_bindgen(readonly)]
    pub actuators: usize,
}

#[wasm_bindgen]
impl Robot {
    /// The energy balance.
    #[wasm_bindgen(getter, js_name = energyAccount)]
    pub fn energy_account(&self) -> RobotEnergyAccount {
        let (energy_account, losses) = (self.simulation.energy_account(), self.simulation.losses());
        let Losses { damping, friction, stops, corrections, sliding, impacts, .. } =
            losses.unwrap_or_else(|| everything_to_damping(energy_account.dissipated()));
        RobotEnergyAccount {
            kinetic: energy_account.kinetic(),
            potential: energy_account.potential(),
            energy: energy_account.now(),
            start: energy_account.start(),
            work: energy_account.work(),
            dissipated: energy_account.dissipated(),
            damping,
            friction,
            stops,
            corrections,
            sliding,
            impacts,
            unaccounted: energy_account.imbalance(),
        }
    }

    /// Numbers of links, joints and degrees of freedom, and the disposition of the file's values.
    #[wasm_bindgen(getter)]
    pub fn counts(&self) -> RobotCounts {
        let description = self.model.description();
        let LoadCounts {
            links,
            joints,
            degrees_of_freedom,
            defaulted,
            repaired,
            ignored,
            ignored_physics,
            as_written,
            ..
        } = self.report.counts;
        RobotCounts {
            links,
            joints,
            dofs: degrees_of_freedom,
            defaulted,
            repaired,
            suspicious: as_written,
            ignored,
            ignored_physics,
            equalities: description.equalities.iter().filter(|equality| equality.active).count(),
            tendons: description.tendon_names().count(),
            actuators: description.actuators.len(),
        }
    }
}

fn everything_to_damping(dissipated: f64) -> Losses {
    let mut losses = Losses::default();
    losses.damping = dissipated;
    losses
}
