//! Identification of the base parameters of an arm.
//!
//! A seven-joint arm moves every joint for ten seconds by sines of incommensurable rates. Torques, with
//! damping and friction, are sampled at 50 Hz. The base parameters are identified from them and compared with
//! those of the file, and the torques of another motion are predicted.
//!
//! `cargo run --release --example 04_identification -p robot-dynamics-urdf`
#![allow(dead_code)] // the tests do not call `main`

#[path = "plot/mod.rs"]
mod plot;

use std::error::Error;

use nalgebra::{DMatrix, DVector};
use plot::{Axis, Figure, Line, Panel};
use robot_dynamics::algorithms::{
    dissipation, inertial_parameters, inverse_dynamics, joint_torque_regressor,
};
use robot_dynamics::control::{BaseParameters, MotionRecord, physical_consistency};
use robot_dynamics::model::{Model, Workspace};

const ROBOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf");
const MIDDLE: [f64; 7] = [0.0, 0.0, 0.0, -1.6, 0.0, 1.9, 0.0];

/// The results that the example prints and draws.
pub(crate) struct Numbers {
    /// The numbers of inertial parameters, of base parameters, and of parameters that affect no torque.
    pub(crate) counts: [usize; 3],
    /// Three of the base parameters, as groups of inertial parameters.
    pub(crate) names: Vec<String>,
    /// The condition number of the scaled regressor.
    pub(crate) condition: f64,
    /// max |β − β_file| / max |β_file|.
    pub(crate) error: f64,
    /// The largest error of a predicted torque \[N·m\].
    pub(crate) prediction: f64,
    /// Links whose identified parameters are physically inconsistent, with a prior that is 10 % too heavy.
    pub(crate) impossible: Vec<String>,
    /// Time, the torques of the other motion, and the largest errors of the torques with the prior that is 10
    /// % too heavy and with the identified parameters \[N·m\].
    pub(crate) moments: Vec<(f64, Vec<f64>, [f64; 2])>,
}

/// q, v and a of the sines at time t, with rates scaled by `tempo`.
fn sines(t: f64, tempo: f64) -> [Vec<f64>; 3] {
    let rate = |k: usize, h: usize| tempo * (0.9 + 0.37 * k as f64) * [1.0, 2.618][h];
    let sum = |f: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
        let joint = |k: usize| (0..2).map(|h| f(rate(k, h), [0.5, 0.15][h] * (1.0 + 0.3 * h as f64))).sum();
        (0..7).map(joint).collect()
    };
    let mut q = sum(&|w, amplitude| amplitude * (w * t + w).sin());
    q.iter_mut().zip(MIDDLE).for_each(|(q, middle)| *q += middle);
    let v = sum(&|w, amplitude| amplitude * w * (w * t + w).cos());
    let a = sum(&|w, amplitude| -amplitude * w * w * (w * t + w).sin());
    [q, v, a]
}

pub(crate) fn numbers() -> Result<Numbers, Box<dyn Error>> {
    let model = Model::new(
        robot_dynamics::urdf::load(ROBOT, &robot_dynamics::urdf::LoadOptions::default())?.description,
    )?;
    let workspace = &mut Workspace::new(&model);
    let mut record = MotionRecord::new(&model, true);
    let (mut tau, mut friction) = (vec![0.0; 7], vec![0.0; 7]);
    for i in 0..500 {
        let [q, v, a] = sines(f64::from(i) * 0.02, 1.0);
        inverse_dynamics(&model, workspace, &q, &v, &a, &mut tau);
        dissipation(&model, &v, &mut friction);
        tau.iter_mut().zip(&friction).for_each(|(tau, b)| *tau += b);
        record.push(&q, &v, &a, &tau)?;
    }
    let base = BaseParameters::of(&model, 100, 1);
    let found = base.identify(&record)?;
    let truth = inertial_parameters(&model);
    let expected = base.values(&truth)?;

    let indices: Vec<usize> = base.parameters.iter().map(|parameter| parameter.index).collect();
    let heavier: Vec<f64> = truth.iter().map(|p| 1.1 * p).collect();
    let (mut moments, mut regressor) = (Vec::new(), vec![0.0; 7 * truth.len()]);
    for i in 0..200 {
        let t = 0.033 * f64::from(i);
        let [q, v, a] = sines(t, 1.3);
        joint_torque_regressor(&model, workspace, &q, &v, &a, &mut regressor);
        let y = DMatrix::from_row_slice(7, truth.len(), &regressor);
        let right = &y * DVector::from_column_slice(&truth);
        let prior = (&y * DVector::from_column_slice(&heavier) - &right).amax();
        let predicted = (y.select_columns(&indices) * &found.values - &right).amax();
        moments.push((t, right.as_slice().to_vec(), [prior, predicted]));
    }
    let nearest = base.nearest_parameters(&found.values, &heavier)?;
    let links = physical_consistency(&model, nearest.as_slice())?;
    Ok(Numbers {
        counts: [truth.len(), base.len(), base.invisible.len()],
        names: base.parameters.iter().take(3).map(ToString::to_string).collect(),
        condition: found.condition,
        error: (&found.values - &expected).amax() / expected.amax(),
        prediction: moments.iter().map(|moment| moment.2[1]).fold(0.0, f64::max),
        moments,
        impossible: links.into_iter().filter(|link| !link.is_consistent()).map(|link| link.link).collect(),
    })
}

impl Numbers {
    pub(crate) fn figure(&self) -> Figure {
        let torque = |joint: usize| self.moments.iter().map(|(t, tau, _)| (*t, tau[joint])).collect();
        let error = |which: usize| self.moments.iter().map(|(t, _, off)| (*t, off[which])).collect();
        Figure {
            title: "Torques of a motion that the identification has not seen".into(),
            across: "t [s]".into(),
            panels: vec![
                Panel {
                    name: "Torque [N·m]".into(),
                    axis: Axis::Linear,
                    lines: (0..7).map(|i| Line::new(format!("joint {}", i + 1), torque(i))).collect(),
                    limits: vec![],
                },
                Panel {
                    name: "Largest error of a predicted torque [N·m]".into(),
                    axis: Axis::Logarithmic,
                    lines: vec![
                        Line::new("prior, 10 % heavier", error(0)),
                        Line::new("identified", error(1)),
                    ],
                    limits: vec![],
                },
            ],
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let numbers = numbers()?;
    let Numbers { counts: [all, base, invisible], names, condition, error, prediction, impossible, .. } =
        &numbers;
    println!("inertial parameters       {all}, of which {invisible} show in no torque");
    println!("base parameters           {base}, for example");
    for name in names {
        println!("                          {name}");
    }
    println!("condition of the data     {condition:.1}");
    println!("error of the parameters   {error:.1e} of the largest");
    println!("error of predicted torque {prediction:.1e} N·m");
    println!("impossible links          {impossible:?}");
    numbers.figure().save("04_identification")
}
