//! Whether machine code computes a robot's functions.

use multibody::{InstructionSet, Model};
use serde::Serialize;

/// The instructions of the code, or the reason why the recursions compute.
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
                format!("machine code for {instructions}, made when each is first called")
            }
            (None, reason) => format!("recursions alone: {}", reason.as_deref().unwrap_or_default()),
        };
        format!("Functions: {how}\n")
    }
}
