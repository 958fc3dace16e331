//! The picture that the example draws.

use std::error::Error;

/// The pin's gap grows when left alone, stays bounded when pulled back, and below the tolerance when projected.
#[test]
fn gap_of_the_pin_is_drawn() -> Result<(), Box<dyn Error>> {
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
    // Second halves of the run: the error of a step of order 4 adds up in one, and is forgotten in the other.
    assert!(largest(left, 5.0, 10.0) > 1.5 * largest(left, 0.0, 5.0));
    assert!(largest(pulled, 5.0, 10.0) < 1.1 * largest(pulled, 0.0, 5.0));
    assert!(largest(pulled, 0.0, 10.0) < 0.1 * largest(left, 0.0, 10.0));
    assert!(largest(projected, 0.0, 10.0) <= 1e-12);

    // Six lines, each of at least a hundred points, and no number that is none.
    let svg = figure.svg();
    let curves: Vec<&str> = svg.lines().filter(|line| line.contains("stroke-width=\"1.8\"")).collect();
    assert_eq!(curves.len(), 6);
    assert!(curves.iter().all(|curve| curve.matches(',').count() > 100));
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
    Ok(())
}
