//! Your robot: any URDF or MJCF file, posed, pulled, held, or let fall.

use dynamics::EnergyLedger;
use multibody::{
    ConstraintSet, Finding, FramePose, LoadReport, Model, Simulation, StepWorkspace, Workspace, ZeroTorque,
    energy_ledger, neutral,
};
use robot_dynamics::{Described, Options, describe_among, describe_text};
use wasm_bindgen::prelude::wasm_bindgen;

use super::files::RobotFiles;
use super::floor::Floor;
use super::hand::Hand;
use super::method::Method;
use super::torques::Step;
use crate::LabError;
use crate::samples::Samples;

/// Time between two samples \[s\] and the number kept.
pub(crate) const INTERVAL: f64 = 0.02;
pub(crate) const KEPT: usize = 1500;

/// A robot from a file, its state, its method and its books.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Robot {
    pub(crate) model: Model,
    pub(crate) report: LoadReport,
    pub(crate) locked: Vec<String>,
    pub(crate) workspace: Workspace,
    pub(crate) stepping: StepWorkspace,
    pub(crate) poses: Vec<FramePose>,
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
    pub(crate) tau: Vec<f64>,
    pub(crate) method: Method,
    pub(crate) floor: Floor,
    /// The closed loops and couplings of the file.
    pub(crate) loops: ConstraintSet,
    /// Why they cannot be held.
    pub(crate) loose: Option<String>,
    pub(crate) h: f64,
    pub(crate) dissipation: bool,
    pub(crate) hold: Option<Hold>,
    pub(crate) hand: Option<Hand>,
    pub(crate) ledger: EnergyLedger,
    pub(crate) steps: u64,
    pub(crate) time: f64,
    pub(crate) last: Option<Step>,
    pub(crate) samples: Samples<4>,
}

/// The pose to hold and the gains, nv numbers each.
#[derive(Clone, Debug)]
pub(crate) struct Hold {
    pub(crate) target: Vec<f64>,
    pub(crate) stiffness: Vec<f64>,
    pub(crate) damping: Vec<f64>,
    pub(crate) limits: Vec<f64>,
}

#[wasm_bindgen]
impl Robot {
    /// Reads the text of a URDF or an MJCF file; which of the two, its outermost element says. Joints that move no mass
    /// in any pose, and so would have no acceleration, are held still.
    ///
    /// # Errors
    /// If the file cannot be read as a robot: what is wrong, on which line, and what to do.
    pub fn load(text: &str, floating_base: bool, repair_inertia: bool) -> Result<Self, LabError> {
        Self::of(describe_text(text, &options(floating_base, repair_inertia))?)
    }

    /// The same of one file among others, which it may include and take meshes' inertia from.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    #[wasm_bindgen(js_name = loadAmong)]
    pub fn load_among(
        files: &RobotFiles,
        path: &str,
        floating_base: bool,
        repair_inertia: bool,
    ) -> Result<Self, LabError> {
        Self::of(describe_among(&files.0, path, &options(floating_base, repair_inertia))?)
    }

    /// The robot's name.
    #[wasm_bindgen(getter)]
    pub fn name(&self) -> String {
        self.model.name().to_owned()
    }

    /// Total mass \[kg\].
    #[wasm_bindgen(getter, js_name = totalMass)]
    pub fn total_mass(&self) -> f64 {
        self.model.total_mass()
    }

    /// Whether anything of it floats, and so can fall.
    #[wasm_bindgen(getter)]
    pub fn floats(&self) -> bool {
        self.model.joints().iter().any(|joint| joint.kind == multibody::JointKind::Floating)
    }

    /// The joints that move no mass and are held still.
    pub fn locked(&self) -> Vec<String> {
        self.locked.clone()
    }

    /// The load report, one entry a string: line, treatment, place, message, separated by tabs.
    pub fn report(&self) -> Vec<String> {
        let line = |finding: &Finding| {
            format!("{}\t{}\t{}\t{}", finding.line(), finding.treatment(), finding.place(), finding.message())
        };
        self.report.findings.iter().map(line).collect()
    }

    /// q.
    #[wasm_bindgen(getter)]
    pub fn q(&self) -> Vec<f64> {
        self.q.clone()
    }

    /// v.
    #[wasm_bindgen(getter)]
    pub fn v(&self) -> Vec<f64> {
        self.v.clone()
    }

    /// Time since the last placing \[s\].
    #[wasm_bindgen(getter)]
    pub fn time(&self) -> f64 {
        self.time
    }
}

impl Robot {
    fn of(mut described: Described) -> Result<Self, LabError> {
        let locked = described.description.lock_massless()?;
        let model = Model::new(described.description)?;
        let (q, v) = (neutral(&model), vec![0.0; model.nv()]);
        let (loops, loose) = match ConstraintSet::from_equalities(&model) {
            Ok(loops) => (loops, None),
            Err(error) => (ConstraintSet::default(), Some(error.to_string())),
        };
        let mut workspace = Workspace::new(&model);
        let still = FramePose { rotation: [[0.0; 3]; 3], translation: [0.0; 3] };
        Ok(Self {
            ledger: energy_ledger(&model, &mut workspace, &q, &v),
            stepping: StepWorkspace::new(&model),
            poses: vec![still; model.frames().len()],
            tau: v.clone(),
            samples: Samples::new(INTERVAL, 1e-3, KEPT),
            method: Method::implicit(&model, (None, &loops)),
            loops,
            loose,
            floor: Floor::default(),
            h: 1e-3,
            dissipation: true,
            hold: None,
            hand: None,
            steps: 0,
            time: 0.0,
            last: None,
            model,
            report: described.report,
            locked,
            workspace,
            q,
            v,
        })
    }

    /// The same fall as a whole run of the library, for tests: q after so many steps without torque.
    ///
    /// # Errors
    /// Where the run fails.
    pub fn reference_fall(&self, steps: usize) -> Result<Vec<f64>, LabError> {
        match &self.method {
            Method::Implicit(implicit) => self.run((**implicit).clone(), steps),
            Method::Row(row) => self.run(*row, steps),
        }
    }

    fn run<T: multibody::Stepper + Clone>(&self, stepper: T, steps: usize) -> Result<Vec<f64>, LabError>
    where
        T::Error: 'static,
    {
        let simulation = Simulation::new(&self.model, stepper, self.h)
            .with_dissipation(self.dissipation)
            .with_samples_every(0);
        let run = simulation
            .run(&self.q, &self.v, steps, &mut ZeroTorque, |_| core::ops::ControlFlow::Continue(()))
            .map_err(|failure| LabError::new(failure.error.to_string()))?;
        Ok(run.q)
    }
}

fn options(floating_base: bool, repair_inertia: bool) -> Options {
    Options { floating_base, repair_inertia, ..Options::default() }
}
