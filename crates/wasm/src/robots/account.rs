//! What the page is told in numbers with names.

use multibody::{Counts, Losses};
use wasm_bindgen::prelude::wasm_bindgen;

use super::robot::Robot;

/// A robot's energy since it was placed \[J\].
#[wasm_bindgen]
#[derive(Clone, Copy, Debug)]
pub struct RobotBooks {
    /// K.
    #[wasm_bindgen(readonly)]
    pub kinetic: f64,
    /// V, springs of joints among it.
    #[wasm_bindgen(readonly)]
    pub potential: f64,
    /// K + V.
    #[wasm_bindgen(readonly)]
    pub energy: f64,
    /// K + V at the start.
    #[wasm_bindgen(readonly)]
    pub start: f64,
    /// Work of the motors and of the hand that pulls.
    #[wasm_bindgen(readonly)]
    pub work: f64,
    /// All that was taken out.
    #[wasm_bindgen(readonly)]
    pub dissipated: f64,
    /// Of it by viscous damping; with friction, where the method does not tell them apart.
    #[wasm_bindgen(readonly)]
    pub damping: f64,
    /// By dry friction.
    #[wasm_bindgen(readonly)]
    pub friction: f64,
    /// By stops.
    #[wasm_bindgen(readonly)]
    pub stops: f64,
    /// By moving back what began a step beyond a stop or within another shape; negative where that put energy in.
    #[wasm_bindgen(readonly)]
    pub corrections: f64,
    /// By friction where it slides.
    #[wasm_bindgen(readonly)]
    pub sliding: f64,
    /// By impacts.
    #[wasm_bindgen(readonly)]
    pub impacts: f64,
    /// What nothing accounts for: the method's own error.
    #[wasm_bindgen(readonly)]
    pub unaccounted: f64,
}

/// How much of a file's robot there is, and what became of it.
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
    pub freedoms: usize,
    /// Values left to their defaults.
    #[wasm_bindgen(readonly)]
    pub defaulted: usize,
    /// Inertias mended.
    #[wasm_bindgen(readonly)]
    pub repaired: usize,
    /// Taken as written though suspicious.
    #[wasm_bindgen(readonly)]
    pub suspicious: usize,
    /// Ignored, none of it physics.
    #[wasm_bindgen(readonly)]
    pub ignored: usize,
    /// Physics that was ignored.
    #[wasm_bindgen(readonly, js_name = ignoredPhysics)]
    pub ignored_physics: usize,
    /// Closed loops and couplings beside the tree.
    #[wasm_bindgen(readonly)]
    pub equalities: usize,
    /// Tendons.
    #[wasm_bindgen(readonly)]
    pub tendons: usize,
    /// Motors that the file describes.
    #[wasm_bindgen(readonly)]
    pub actuators: usize,
}

#[wasm_bindgen]
impl Robot {
    /// The energy books.
    #[wasm_bindgen(getter)]
    pub fn books(&self) -> RobotBooks {
        let (ledger, losses) = (self.simulation.ledger(), self.simulation.losses());
        let Losses { damping, friction, stops, corrections, sliding, impacts, .. } =
            losses.unwrap_or_else(|| everything_to_damping(ledger.dissipated()));
        RobotBooks {
            kinetic: ledger.kinetic(),
            potential: ledger.potential(),
            energy: ledger.now(),
            start: ledger.start(),
            work: ledger.work(),
            dissipated: ledger.dissipated(),
            damping,
            friction,
            stops,
            corrections,
            sliding,
            impacts,
            unaccounted: ledger.imbalance(),
        }
    }

    /// Links, joints, freedoms, and what became of the file's values.
    #[wasm_bindgen(getter)]
    pub fn counts(&self) -> RobotCounts {
        let description = self.model.description();
        let Counts {
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
            freedoms: degrees_of_freedom,
            defaulted,
            repaired,
            suspicious: as_written,
            ignored,
            ignored_physics,
            equalities: description.equalities.iter().filter(|equality| equality.active).count(),
            tendons: description.tendons.len(),
            actuators: description.actuators.len(),
        }
    }
}

fn everything_to_damping(dissipated: f64) -> Losses {
    let mut losses = Losses::default();
    losses.damping = dissipated;
    losses
}
