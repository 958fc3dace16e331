//! Growth of the cost with the degrees of freedom.

use plotters::prelude::RGBColor;

use crate::canvas::{BLUE, Canvas, GREEN, GREY, Hold, INK, ORANGE, svg};
use crate::panel::{Axis, Panel, apart, decades, labelled};
use crate::records::{Records, Route, Trouble};

/// Algorithms with their labels and colours.
const DRAWN: [(&str, &str, RGBColor); 3] = [
    ("mass_matrix", "mass matrix", GREEN),
    ("forward_dynamics", "forward dynamics", ORANGE),
    ("inverse_dynamics", "inverse dynamics", BLUE),
];

pub(crate) fn draw(records: &Records) -> Result<String, Trouble> {
    svg((1320, 660), |canvas| {
        let high = records.time("chain_256", "mass_matrix", Route::ONE)? * 1.6;
        let left = panel("one state at a time, f64", 100.0, ([1.6, 300.0], [36.0, high]), "ns per state");
        let right = panel("batch on one core: f64 ○, f32 ●", 770.0, ([3.2, 300.0], [10.0, high]), "");
        left.draw(canvas)?;
        right.draw(canvas)?;
        guides(canvas, &left)?;
        curves(canvas, records, &left, Route::ONE, true, false)?;
        names(canvas, records, &left)?;
        curves(canvas, records, &right, Route::DOUBLES, true, false)?;
        curves(canvas, records, &right, Route::SINGLES, false, true)
    })
}

fn panel<'a>(title: &'a str, left: f64, (degrees, y): ([f64; 2], [f64; 2]), y_title: &'a str) -> Panel<'a> {
    let mut ticks = vec![2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0, 256.0];
    ticks.retain(|&n| n > degrees[0]);
    Panel {
        title,
        x: Axis { numbers: degrees, pixels: [left, left + 400.0], is_logarithmic: true },
        y: Axis { numbers: y, pixels: [590.0, 60.0], is_logarithmic: true },
        x_title: "degrees of freedom",
        y_title,
        x_ticks: labelled(&ticks),
        y_ticks: labelled(&decades(y)),
    }
}

/// Lines of chains with their names at the end, and robots as small rings.
fn curves(
    canvas: &Canvas<'_>,
    records: &Records,
    panel: &Panel<'_>,
    route: Route,
    has_labels: bool,
    is_filled: bool,
) -> Result<(), Trouble> {
    let mut ends = Vec::new();
    for (algorithm, _, color) in DRAWN {
        let mut points = Vec::new();
        for (robot, nv) in records.robots(true) {
            points.push(panel.at(nv, records.time(&robot, algorithm, route)?));
        }
        canvas.line(&points, color, 2)?;
        for &point in &points {
            canvas.dot(point, 4, color, route.form == "one state" || is_filled)?;
        }
        ends.push(points.last().map_or(0.0, |point| point.1));
        if route.form == "one state" {
            for (robot, nv) in records.robots(false) {
                canvas.dot(panel.at(nv, records.time(&robot, algorithm, route)?), 4, color, false)?;
            }
        }
    }
    if has_labels {
        for ((_, label, color), y) in DRAWN.into_iter().zip(apart(&ends, 20.0)) {
            canvas.text(label, (panel.x.pixels[1] + 8.0, y), Hold::Left, 16, color)?;
        }
    }
    Ok(())
}

/// The robots' names above the axis, at their degrees of freedom.
fn names(canvas: &Canvas<'_>, records: &Records, panel: &Panel<'_>) -> Result<(), Trouble> {
    for (robot, nv) in records.robots(false) {
        // The humanoid has almost as many degrees of freedom as Talos.
        if robot == "humanoid" || robot == "ur5" {
            continue;
        }
        let lowest = records.time(&robot, "inverse_dynamics", Route::ONE)?;
        let at = panel.at(nv, lowest);
        let shown = match robot.as_str() {
            "two_r" => "2R arm",
            "panda" => "Panda",
            "talos" => "Talos",
            other => other,
        };
        canvas.text(shown, (at.0 + 8.0, at.1 + 15.0), Hold::Left, 13, GREY)?;
    }
    canvas.text(
        "● chains of n links    ○ robots",
        (panel.x.pixels[0] + 12.0, panel.y.pixels[1] + 14.0),
        Hold::Left,
        14,
        INK,
    )
}

/// Reference lines for n and n².
fn guides(canvas: &Canvas<'_>, panel: &Panel<'_>) -> Result<(), Trouble> {
    for (power, label, end) in [(1.0, "∝ n", 250.0), (2.0, "∝ n²", 120.0)] {
        let at = |n: f64| panel.at(n, 70.0 * (n / 36.0_f64).powf(power));
        canvas.dashes(at(36.0), at(end), GREY)?;
        canvas.text(label, (at(end).0 + 6.0, at(end).1 - 4.0), Hold::Left, 14, GREY)?;
    }
    Ok(())
}
