//! Every number of the worked example: the two-link arm at q = (π/4, π/2), in Earth gravity.
//!
//! The drift in the last line is max |E − E₀|/|E₀| over the 10 000 steps, from rest at that pose without
//! torque. E₀ = V there, with V = 0 at the height of the first joint.
//!
//! `cargo run --example two_r_numbers -p dynamics`

use dynamics::WorkedExample;
use robot_dynamics_integrators::IntegratorError;

fn main() -> Result<(), IntegratorError> {
    print!("{}", WorkedExample::compute()?);
    Ok(())
}
