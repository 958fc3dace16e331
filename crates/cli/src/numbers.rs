//! `dynamics numbers`: the worked example.

use std::process::ExitCode;

use dynamics::WorkedExample;

use crate::failure::{Failure, Outcome};
use crate::output::print;

pub(crate) fn run() -> Outcome {
    print(&WorkedExample::compute().map_err(Failure::new)?.to_string())?;
    Ok(ExitCode::SUCCESS)
}
