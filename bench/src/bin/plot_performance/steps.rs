//! The gain of each optimisation step.

use plotters::prelude::RGBColor;

use crate::canvas::{BLUE, BROWN, Canvas, GREEN, Hold, ORANGE, ROSE, VIOLET, svg};
use crate::panel::{Axis, Panel, apart, decades, labelled};
use crate::records::{Records, Trouble};

/// Algorithms with their labels and colours.
pub(crate) const FOLLOWED: [(&str, &str, RGBColor); 6] = [
    ("inverse_dynamics", "inverse dynamics", BLUE),
    ("forward_dynamics", "forward dynamics", ORANGE),
    ("mass_matrix", "mass matrix", GREEN),
    ("coriolis_matrix", "Coriolis matrix", VIOLET),
    ("frame_poses", "poses of all frames", BROWN),
    ("jacobian", "Jacobian of the tip", ROSE),
];

pub(crate) fn draw(records: &Records) -> Result<String, Trouble> {
    svg((1320, 640), |canvas| {
        for (k, robot) in ["panda", "talos"].into_iter().enumerate() {
            let (numbers, title) = if robot == "panda" {
                ([45.0, 1000.0], "Panda, 7 degrees of freedom")
            } else {
                ([160.0, 5600.0], "Talos, 38 degrees of freedom")
            };
            let left = 100.0 + 650.0 * k as f64;
            let steps = records.steps();
            let last = steps.len() as f64 - 1.0;
            let panel = Panel {
                title,
                x: Axis { numbers: [-0.2, last + 0.1], pixels: [left, left + 400.0], is_logarithmic: false },
                y: Axis { numbers, pixels: [540.0, 60.0], is_logarithmic: true },
                x_title: "",
                y_title: if k == 0 { "ns per state, one state at a time" } else { "" },
                x_ticks: Vec::new(),
                y_ticks: labelled(&decades(numbers)),
            };
            panel.draw(canvas)?;
            captions(canvas, &panel, &steps)?;
            lines(canvas, records, &panel, robot, &steps)?;
        }
        Ok(())
    })
}

/// A description of each step in a few words below the axis.
fn captions(canvas: &Canvas<'_>, panel: &Panel<'_>, steps: &[(String, String)]) -> Result<(), Trouble> {
    for (i, (_, step)) in steps.iter().enumerate() {
        let mut lines = vec![String::new()];
        for word in step.split(' ') {
            let line = lines.last_mut().expect("there is always a line");
            if line.is_empty() {
                line.push_str(word);
            } else if line.len() + word.len() < 13 {
                line.push(' ');
                line.push_str(word);
            } else {
                lines.push(word.to_owned());
            }
        }
        for (row, line) in lines.iter().enumerate() {
            let at = (panel.x.at(i as f64), panel.y.pixels[0] + 16.0 + 17.0 * row as f64);
            canvas.text(line, at, Hold::Center, 13, crate::canvas::INK)?;
        }
    }
    Ok(())
}

fn lines(
    canvas: &Canvas<'_>,
    records: &Records,
    panel: &Panel<'_>,
    robot: &str,
    steps: &[(String, String)],
) -> Result<(), Trouble> {
    let mut ends = Vec::new();
    for (algorithm, label, color) in FOLLOWED {
        let times: Result<Vec<f64>, Trouble> =
            steps.iter().map(|(commit, _)| records.step_time(robot, algorithm, commit)).collect();
        let times = times?;
        let points: Vec<(f64, f64)> =
            times.iter().enumerate().map(|(i, &time)| panel.at(i as f64, time)).collect();
        canvas.line(&points, color, 2)?;
        for &point in &points {
            canvas.dot(point, 4, color, true)?;
        }
        let gain = times[0] / times[times.len() - 1];
        ends.push((points.last().map_or(0.0, |point| point.1), format!("{label}, {gain:.1} ×"), color));
    }
    let heights: Vec<f64> = ends.iter().map(|end| end.0).collect();
    for ((_, label, color), y) in ends.iter().zip(apart(&heights, 20.0)) {
        canvas.text(label, (panel.x.pixels[1] + 6.0, y), Hold::Left, 15, *color)?;
    }
    Ok(())
}
