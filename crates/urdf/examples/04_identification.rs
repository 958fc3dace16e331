//! Which inertial parameters can be measured, and are they found?
//!
//! A seven-joint arm moves every joint for ten seconds by sines of incommensurable rates; torques are sampled
//! at 50 Hz, damping and friction included. The base parameters are found from them and compared with the
//! file's, and the torques of another motion are predicted.
//!
//! `cargo run --release --example 04_identification -p robot-dynamics-urdf`
#![allow(dead_code)] // the tests use the parts and leave out `main`

#[path = "../../multibody/examples/plot/mod.rs"]
mod plot;

use std::error::Error;

use multibody::{
    BaseParameters, Model, MotionRecord, Workspace, dissipation, inertial_parameters, inverse_dynamics,
    joint_torque_regressor, physical_consistency,
};
use nalgebra::{DMatrix, DVector};

use plot::{Axis, Figure, Line, Panel};

const ROBOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf");
const MIDDLE: [f64; 7] = [0.0, 0.0, 0.0, -1.6, 0.0, 1.9, 0.0];

/// What the example prints and draws.
pub(crate) struct Numbers {
    /// Inertial parameters, base parameters, those no torque shows.
    pub(crate) counts: [usize; 3],
    /// Three of the base parameters as they are grouped.
    pub(crate) names: Vec<String>,
    /// The condition number of the scaled regressor.
    pub(crate) condition: f64,
    /// max |β − β_file| / max |β_file|.
    pub(crate) error: f64,
    /// The largest error of a predicted torque \[N·m\].
    pub(crate) prediction: f64,
    /// Links whose parameters, as identified from a prior 10 % too heavy, no body can have.
    pub(crate) impossible: Vec<String>,
    /// Time, the torques of the other motion, and how far those of the 10 % too heavy prior and those of the
    /// parameters found are off, at worst \[N·m\].
    pub(crate) moments: Vec<(f64, Vec<f64>, [f64; 2])>,
}

/// q, v, a of the sines at time t, with rates scaled by `tempo`.
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
    let model = Model::new(urdf::load(ROBOT, &urdf::Options::default())?.description)?;
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
