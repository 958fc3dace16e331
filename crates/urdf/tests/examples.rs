//! The numbers that the examples print.

use std::error::Error;

#[path = "../examples/03_fastest_motion.rs"]
mod fastest_motion;
#[path = "../examples/04_identification.rs"]
mod identification;
#[path = "../examples/02_task_control.rs"]
mod task_control;

#[test]
fn hand_follows_the_circle() -> Result<(), Box<dyn Error>> {
    let numbers = task_control::numbers()?;
    println!("{:?} kg, {:e} m", numbers.inertia, numbers.error);
    // No direction is lighter than nothing or heavier than the whole arm.
    assert!(numbers.inertia.iter().all(|m| (0.5..16.06).contains(m)), "{:?}", numbers.inertia);
    // The torque is held for 1 ms, half of which it lags: ½ h ẍ/kp-sized errors, far below a millimetre.
    assert!(numbers.error < 2e-4, "{}", numbers.error);
    Ok(())
}

#[test]
fn fastest_motion_uses_the_limits() -> Result<(), Box<dyn Error>> {
    let numbers = fastest_motion::numbers()?;
    println!("{} s, {} s, {:?}", numbers.duration, numbers.coarse, numbers.used);
    assert!(numbers.used.at_grid_points <= 1.0 + 1e-6, "{:?}", numbers.used);
    // Halving the grid spacing changes the time by the order of that spacing.
    assert!((numbers.duration / numbers.coarse - 1.0).abs() < 5e-3);
    assert!(numbers.used.saturated > 0.98, "{:?}", numbers.used);
    Ok(())
}

#[test]
fn arm_is_identified() -> Result<(), Box<dyn Error>> {
    let numbers = identification::numbers()?;
    println!("{:?} {:?} {:e} {:e}", numbers.counts, numbers.names, numbers.error, numbers.prediction);
    // Seven joints with a vertical first axis: 43 base parameters, as for this arm's kinematics in the literature.
    // Invisible: all of link 1 but its Izz, and m and hz of link 2, whose origin stays on the vertical axis.
    assert_eq!(numbers.counts, [70, 43, 11]);
    assert!(numbers.error < 1e-6, "{}", numbers.error);
    assert!(numbers.prediction < 1e-9, "{}", numbers.prediction);
    Ok(())
}
