//! Times relative to the least time of their operations.

use plotters::prelude::RGBColor;

use crate::canvas::{BLUE, Canvas, GREEN, GREY, Hold, INK, LIGHT, ORANGE, svg};
use crate::panel::{Axis, Panel, decades, labelled, shown};
use crate::records::{Operations, Records, Route, Trouble};

/// Floating-point instructions of a sine and its cosine, counted in `dynamics/src/lanes/sincos.rs`.
const OF_SINES: [(&str, f64); 2] = [("f64", 26.0), ("f32", 15.0)];

/// Algorithms with their labels and colours.
pub(crate) const JUDGED: [(&str, &str, RGBColor); 3] = [
    ("inverse_dynamics", "inverse dynamics", BLUE),
    ("forward_dynamics", "forward dynamics", ORANGE),
    ("mass_matrix", "mass matrix", GREEN),
];

/// The least time of these operations with full registers and without waiting \[ns\]. It is for one state, or
/// for as many states of a batch as a register holds.
pub(crate) fn least(records: &Records, operations: Operations, route: Route) -> Result<f64, Trouble> {
    let sines = OF_SINES.iter().find(|(number, _)| *number == route.number).map_or(0.0, |(_, count)| *count);
    let instructions = operations.instructions + sines * operations.sines;
    Ok(match (route.form, route.number) {
        ("batch", "f32") => instructions * records.peak(8)? / 16.0,
        ("batch", _) => instructions * records.peak(8)? / 8.0,
        _ => instructions * records.peak(4)? / 3.0,
    })
}

pub(crate) fn draw(records: &Records) -> Result<String, Trouble> {
    svg((1320, 640), |canvas| {
        let routes = [
            ("one state, f64", Route::ONE),
            ("batch of f64", Route::DOUBLES),
            ("batch of f32", Route::SINGLES),
        ];
        for (k, robot) in ["panda", "talos"].into_iter().enumerate() {
            let numbers = if robot == "panda" { [5.0, 1000.0] } else { [25.0, 5000.0] };
            let left = 190.0 + 610.0 * k as f64;
            let title =
                if robot == "panda" { "Panda, 7 degrees of freedom" } else { "Talos, 38 degrees of freedom" };
            let panel = Panel {
                title,
                x: Axis { numbers, pixels: [left, left + 440.0], is_logarithmic: true },
                y: Axis { numbers: [0.0, 10.2], pixels: [530.0, 70.0], is_logarithmic: false },
                x_title: "ns per state",
                y_title: "",
                x_ticks: labelled(&decades(numbers)),
                y_ticks: Vec::new(),
            };
            panel.draw(canvas)?;
            for (group, (label, route)) in routes.into_iter().enumerate() {
                let top = 9.6 - 3.4 * group as f64;
                if k == 0 {
                    canvas.text(label, (left - 12.0, panel.y.at(top - 1.0)), Hold::Right, 16, INK)?;
                }
                for (row, (algorithm, _, color)) in JUDGED.into_iter().enumerate() {
                    let y = panel.y.at(top - row as f64);
                    bar(canvas, records, &panel, (robot, algorithm, route), y, color)?;
                }
            }
        }
        key(canvas)
    })
}

/// From the floor to the time, with their ratio.
fn bar(
    canvas: &Canvas<'_>,
    records: &Records,
    panel: &Panel<'_>,
    (robot, algorithm, route): (&str, &str, Route),
    y: f64,
    color: RGBColor,
) -> Result<(), Trouble> {
    let time = records.time(robot, algorithm, route)?;
    let done = least(records, records.operations(robot, algorithm, "done")?, route)?;
    let left = least(records, records.operations(robot, algorithm, "left")?, route)?;
    canvas.bar((panel.x.at(left), y - 2.0), (panel.x.at(done), y + 2.0), LIGHT)?;
    canvas.bar((panel.x.at(done), y - 6.0), (panel.x.at(time), y + 6.0), color)?;
    canvas.line(&[(panel.x.at(done), y - 11.0), (panel.x.at(done), y + 11.0)], INK, 2)?;
    canvas.line(&[(panel.x.at(left), y - 8.0), (panel.x.at(left), y + 8.0)], GREY, 2)?;
    let label = format!("{} ns, {:.1} ×", shown(round(time)), time / done);
    canvas.text(&label, (panel.x.at(time) + 8.0, y), Hold::Left, 14, color)
}

/// To three digits.
pub(crate) fn round(x: f64) -> f64 {
    let unit = 10_f64.powf(x.log10().floor() - 2.0);
    (x / unit).round() * unit
}

fn key(canvas: &Canvas<'_>) -> Result<(), Trouble> {
    let mut x = 190.0;
    for (_, label, color) in JUDGED {
        canvas.bar((x, 610.0), (x + 22.0, 622.0), color)?;
        canvas.text(label, (x + 30.0, 616.0), Hold::Left, 15, INK)?;
        x += 180.0;
    }
    canvas.line(&[(x, 606.0), (x, 626.0)], INK, 2)?;
    canvas.text("operations done", (x + 8.0, 616.0), Hold::Left, 15, INK)?;
    canvas.line(&[(x + 170.0, 608.0), (x + 170.0, 624.0)], GREY, 2)?;
    canvas.text("operations left to a program for this robot alone", (x + 178.0, 616.0), Hold::Left, 15, INK)
}
