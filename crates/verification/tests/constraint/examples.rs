//! The plot of the example.

use std::error::Error;

/// The gap at the pin grows without correction, stays bounded with feedback, and is below the tolerance with
/// projection.
#[test]
fn gap_of_pin_is_drawn() -> Result<(), Box<dyn Error>> {
    let figure = crate::closed_loop::figure()?;
    let [left, pulled, projected] = &figure.panels[0].lines[..] else {
        return Err("three ways to treat the drift".into());
    };
    let largest = |line: &crate::closed_loop::plot::Line, from: f64, to: f64| {
        line.points
            .iter()
            .filter(|point| (from..=to).contains(&point.0))
            .fold(0.0f64, |most, point| most.max(point.1))
    };
    // The second half of the run: the error of a step of order 4 accumulates in one and decays in the other.
    assert!(largest(left, 5.0, 10.0) > 1.5 * largest(left, 0.0, 5.0));
    assert!(largest(pulled, 5.0, 10.0) < 1.1 * largest(pulled, 0.0, 5.0));
    assert!(largest(pulled, 0.0, 10.0) < 0.1 * largest(left, 0.0, 10.0));
    assert!(largest(projected, 0.0, 10.0) <= 1e-12);

    // Six lines with at least a hundred points each, all of them finite.
    let svg = figure.svg();
    let curves: Vec<&str> = svg.lines().filter(|line| line.contains("stroke-width=\"1.8\"")).collect();
    assert_eq!(curves.len(), 6);
    assert!(curves.iter().all(|curve| curve.matches(',').count() > 100));
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
    Ok(())
}
