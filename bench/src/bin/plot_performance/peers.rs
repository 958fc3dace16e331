//! This library beside Pinocchio's best build, with the targets.

use crate::canvas::{BLUE, Canvas, GREY, Hold, INK, ORANGE, svg};
use crate::panel::{Axis, Panel, labelled};
use crate::records::{Records, Trouble};

/// An algorithm, its label, and the target ratio of speeds.
pub(crate) struct Aim {
    pub(crate) algorithm: &'static str,
    pub(crate) label: &'static str,
    pub(crate) aim: Option<f64>,
}

const fn aim(algorithm: &'static str, label: &'static str, aim: Option<f64>) -> Aim {
    Aim { algorithm, label, aim }
}

/// One state at a time.
pub(crate) const SINGLE: [Aim; 8] = [
    aim("inverse_dynamics", "inverse dynamics", Some(7.0)),
    aim("forward_dynamics", "forward dynamics", Some(6.0)),
    aim("mass_matrix", "mass matrix", Some(5.0)),
    aim("coriolis_matrix", "Coriolis matrix", Some(6.0)),
    aim("frame_poses", "poses of all frames", Some(2.5)),
    aim("jacobian", "Jacobian of the tip", Some(2.5)),
    aim("inverse_dynamics_derivatives", "∂τ/∂q, ∂τ/∂v", Some(3.0)),
    aim("forward_dynamics_derivatives", "∂a/∂q, ∂a/∂v", Some(3.0)),
];

/// Batches on one core.
pub(crate) const BATCH: [Aim; 8] = [
    aim("inverse_dynamics_batch_f64", "inverse dynamics, f64", Some(27.5)),
    aim("forward_dynamics_batch_f64", "forward dynamics, f64", Some(22.4)),
    aim("mass_matrix_batch_f64", "mass matrix, f64", Some(13.0)),
    aim("inverse_dynamics_batch_f32", "inverse dynamics, f32", Some(55.0)),
    aim("forward_dynamics_batch_f32", "forward dynamics, f32", Some(44.7)),
    aim("mass_matrix_batch_f32", "mass matrix, f32", Some(26.0)),
    aim("inverse_dynamics_derivatives_batch_f64", "∂τ/∂q, ∂τ/∂v, f64", None),
    aim("forward_dynamics_derivatives_batch_f64", "∂a/∂q, ∂a/∂v, f64", None),
];

pub(crate) const PEER: &str = "pinocchio native";

pub(crate) fn draw(records: &Records) -> Result<String, Trouble> {
    svg((1320, 560), |canvas| {
        let left =
            panel("one state at a time", 210.0, [1.0, 20.0], &[1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 20.0]);
        let right = panel("batch on one core", 860.0, [2.0, 60.0], &[2.0, 3.0, 5.0, 10.0, 20.0, 30.0, 50.0]);
        rows(canvas, records, &left, &SINGLE)?;
        rows(canvas, records, &right, &BATCH)?;
        key(canvas)
    })
}

fn panel<'a>(title: &'a str, left: f64, numbers: [f64; 2], ticks: &[f64]) -> Panel<'a> {
    Panel {
        title,
        x: Axis { numbers, pixels: [left, left + 430.0], is_logarithmic: true },
        y: Axis { numbers: [0.0, 8.5], pixels: [445.0, 60.0], is_logarithmic: false },
        x_title: "times faster than Pinocchio 4.1, clang++ -O3 -march=native",
        y_title: "",
        x_ticks: labelled(ticks),
        y_ticks: Vec::new(),
    }
}

fn rows(canvas: &Canvas<'_>, records: &Records, panel: &Panel<'_>, aims: &[Aim]) -> Result<(), Trouble> {
    panel.draw(canvas)?;
    for (row, Aim { algorithm, label, aim }) in aims.iter().enumerate() {
        let y = panel.y.at(8.0 - row as f64);
        canvas.text(label, (panel.x.pixels[0] - 12.0, y), Hold::Right, 16, INK)?;
        if let Some(aim) = aim {
            let x = panel.x.at(*aim);
            canvas.line(&[(x, y - 15.0), (x, y + 15.0)], GREY, 4)?;
        }
        for (robot, color, shift) in [("panda", BLUE, -6.0), ("talos", ORANGE, 6.0)] {
            let found = records.ratio(robot, algorithm, PEER)?;
            let ends = found
                .spread
                .map(|x| (panel.x.at(x.clamp(panel.x.numbers[0], panel.x.numbers[1])), y + shift));
            canvas.line(&ends, color, 2)?;
            canvas.dot((panel.x.at(found.ratio), y + shift), 5, color, true)?;
        }
    }
    Ok(())
}

fn key(canvas: &Canvas<'_>) -> Result<(), Trouble> {
    let y = 530.0;
    let mut x = 210.0;
    for (label, color) in [("Panda", BLUE), ("Talos", ORANGE)] {
        canvas.line(&[(x - 14.0, y), (x + 14.0, y)], color, 2)?;
        canvas.dot((x, y), 5, color, true)?;
        canvas.text(label, (x + 22.0, y), Hold::Left, 15, INK)?;
        x += 110.0;
    }
    canvas.text("median and range over the rounds", (x - 10.0, y), Hold::Left, 15, INK)?;
    canvas.line(&[(x + 280.0, y - 11.0), (x + 280.0, y + 11.0)], GREY, 4)?;
    canvas.text("aimed at, as the mean of both", (x + 292.0, y), Hold::Left, 15, INK)
}
