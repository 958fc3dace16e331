//! Whether machine code computes a robot's functions.

use robot_dynamics::model::{InstructionSet, Model};
use serde::Serialize;

/// The instruction set of the code, or the reason for using the recursions.
#[derive(Serialize)]
pub(crate) struct MachineCode {
    instructions: Option<String>,
    reason: Option<String>,
}

impl MachineCode {
    pub(crate) fn of(model: &Model) -> Self {
        let reason = model.native().reason;
        let instructions = reason.is_none().then(|| InstructionSet::best().to_string());
        Self { instructions, reason }
    }

    pub(super) fn text(&self) -> String {
        let how = match (&self.instructions, &self.reason) {
            (Some(instructions), _) => {
                format!("machine code for {instructions}, compiled at the first call of each")
            }
            (None, reason) => {
                format!("recursions without machine code: {}", reason.as_deref().unwrap_or_default())
            }
        };
        format!("Functions: {how}\n")
    }
}
