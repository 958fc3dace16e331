//! Momentum: the impulses of contacts are the change of momentum and that of gravity.

use crate::hopper::hopper;

/// ∫Σf dt = m Δv + m g T, stepped and as one run; the contact forces of a step are its mean.
#[test]
fn contact_impulses_are_the_change_of_momentum() {
    let (mut simulation, mass) = hopper();
    let h = simulation.step_size();
    let velocity = |simulation: &multibody::simulator::Simulation| {
        let model = simulation.model();
        let mut workspace = multibody::Workspace::new(model);
        multibody::center_of_mass_velocity(model, &mut workspace, simulation.q(), simulation.v())
    };
    let before = velocity(&simulation);
    let (mut impulse, mut steps) = ([0.0; 3], 0);
    for _ in 0..1500 {
        simulation.step().expect("a step");
        for force in simulation.ground_forces() {
            (0..3).for_each(|k| impulse[k] += h * force[k]);
        }
        steps += 1;
    }
    let after = velocity(&simulation);
    let time = f64::from(steps) * h;
    let gravity = [0.0, 0.0, -9.81];
    for k in 0..3 {
        let expected = mass * (after[k] - before[k]) - mass * gravity[k] * time;
        // A step's error of the momentum is of order h³ while it turns in the air, and rounding on the ground.
        assert!((impulse[k] - expected).abs() < 1e-9, "axis {k}: {} {expected}", impulse[k]);
    }
    assert!(impulse[2] > 0.5 * mass * 9.81 * time);
}
