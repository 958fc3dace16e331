//! A robot from a URDF or MJCF file: posed, pulled, held, or falling.

use std::collections::HashMap;
use std::sync::Arc;

use robot_dynamics::constraints::ConstraintSet;
use robot_dynamics::description::{Base, Finding, LoadReport};
use robot_dynamics::model::{Model, Workspace, lock_massless};
use robot_dynamics::simulation::{Effect, RunOptions, Simulation, SimulationBuilder};
use robot_dynamics::text::file_stem;
use robot_dynamics::{
    LoadOptions, LoadedDescription, load_description_from_files, load_description_from_text,
};
use wasm_bindgen::prelude::wasm_bindgen;

use super::choice::Choice;
use super::control_line::ControlLine;
use super::files::RobotFiles;
use super::hand::Hand;
use super::step::CompletedStep;
use super::text::shown;
use crate::LabError;
use crate::samples::Samples;
use robot_dynamics::description::Pose;

/// Sampling period \[s\] and the number of samples kept.
pub(crate) const INTERVAL: f64 = 0.02;
pub(crate) const KEPT: usize = 1500;

/// A robot from a file, with its simulation.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Robot {
    pub(crate) model: Arc<Model>,
    pub(crate) report: LoadReport,
    pub(crate) locked: Vec<String>,
    pub(crate) workspace: Workspace,
    pub(crate) poses: Vec<Pose>,
    pub(crate) choice: Choice,
    pub(crate) simulation: Simulation,
    /// The effects that act with nothing switched off.
    pub(crate) file_effects: Vec<Effect>,
    /// Reasons for leaving out the page's ground.
    pub(crate) notes: Vec<String>,
    /// The time when the simulation was built \[s\].
    pub(crate) since: f64,
    /// Corners of convex hulls by shape index, in the shape's frame \[m\].
    pub(crate) meshes: HashMap<usize, Vec<[f64; 3]>>,
    /// The closed loops and couplings of the file.
    pub(crate) loops: ConstraintSet,
    /// The reason why they cannot be satisfied.
    pub(crate) loose: Option<String>,
    pub(crate) controls: ControlLine,
    pub(crate) hold: Option<Hold>,
    pub(crate) hand: Option<Hand>,
    /// The generalised forces of the hand, nv numbers.
    pub(crate) pull: Vec<f64>,
    pub(crate) last: Option<CompletedStep>,
    pub(crate) samples: Samples<4>,
}

/// The pose to hold and the gains, nv numbers each.
#[derive(Clone, Debug)]
pub(crate) struct Hold {
    pub(crate) target: Vec<f64>,
    pub(crate) stiffness: Vec<f64>,
    pub(crate) damping: Vec<f64>,
}

#[wasm_bindgen]
impl Robot {
    /// Reads the text of a URDF or an MJCF file, told apart by the outermost element. Joints that move no
    /// mass in any pose have no defined acceleration and are locked.
    ///
    /// # Errors
    /// Fails if the file is invalid; the error names the problem, the line, and a remedy.
    pub fn load(text: &str, floating_base: bool, repair_inertia: bool) -> Result<Self, LabError> {
        Self::of(load_description_from_text(text, &options(floating_base, repair_inertia))?)
    }

    /// Reads one file of a set, which it may include or take inertia of meshes from.
    ///
    /// # Errors
    /// Fails as [`load`](Self::load) does.
    #[wasm_bindgen(js_name = loadAmong)]
    pub fn load_from_files(
        files: &RobotFiles,
        path: &str,
        floating_base: bool,
        repair_inertia: bool,
    ) -> Result<Self, LabError> {
        Self::of(load_description_from_files(&files.0, path, &options(floating_base, repair_inertia))?)
    }

    /// The robot's name, on one line.
    #[wasm_bindgen(getter)]
    pub fn name(&self) -> String {
        shown(self.model.name())
    }

    /// The robot's name as a file name without an extension.
    #[wasm_bindgen(getter, js_name = fileName)]
    pub fn file_name(&self) -> String {
        file_stem(self.model.name())
    }

    /// Total mass \[kg\].
    #[wasm_bindgen(getter, js_name = totalMass)]
    pub fn total_mass(&self) -> f64 {
        self.model.total_mass()
    }

    /// Whether any part of it floats, and so can fall.
    #[wasm_bindgen(getter)]
    pub fn floats(&self) -> bool {
        self.model.joints().iter().any(|joint| joint.kind == robot_dynamics::description::JointKind::Floating)
    }

    /// Whether its root link floats. A world with a floating body does not.
    #[wasm_bindgen(getter, js_name = baseFloats)]
    pub fn base_floats(&self) -> bool {
        self.model.description().base == Base::Floating
    }

    /// The locked joints that move no mass.
    pub fn locked(&self) -> Vec<String> {
        self.locked.iter().map(|joint| shown(joint)).collect()
    }

    /// The load report, one string for each entry: line, disposition, place, message, separated by tabs.
    pub fn report(&self) -> Vec<String> {
        let line = |finding: &Finding| {
            let (place, message) = (shown(finding.place()), shown(finding.message()));
            format!("{}\t{}\t{place}\t{message}", finding.line(), finding.disposition())
        };
        self.report.findings.iter().map(line).collect()
    }

    /// q.
    #[wasm_bindgen(getter)]
    pub fn q(&self) -> Vec<f64> {
        self.simulation.q().to_vec()
    }

    /// v.
    #[wasm_bindgen(getter)]
    pub fn v(&self) -> Vec<f64> {
        self.simulation.v().to_vec()
    }

    /// Time since the last placement \[s\].
    #[wasm_bindgen(getter)]
    pub fn time(&self) -> f64 {
        self.since + self.simulation.time()
    }
}

impl Robot {
    fn of(mut described: LoadedDescription) -> Result<Self, LabError> {
        let locked = lock_massless(&mut described.description)?;
        let model = Arc::new(Model::new(described.description)?);
        let (loops, loose) = match ConstraintSet::from_equalities(&model) {
            Ok(loops) => (loops, None),
            Err(error) => (ConstraintSet::default(), Some(error.to_string())),
        };
        let still = Pose { rotation: [[0.0; 3]; 3], translation: [0.0; 3] };
        // A simulation without effects; the robot's own is built once all its parts exist.
        let mut bare = SimulationBuilder::shared(Arc::clone(&model));
        for effect in Effect::ALL {
            bare = bare.without(effect);
        }
        let mut robot = Self {
            workspace: Workspace::new(&model),
            poses: vec![still; model.frames().len()],
            choice: Choice::default(),
            simulation: bare.build()?,
            file_effects: Vec::new(),
            notes: Vec::new(),
            since: 0.0,
            meshes: HashMap::new(),
            loops,
            loose,
            controls: ControlLine::default(),
            hold: None,
            hand: None,
            pull: vec![0.0; model.nv()],
            last: None,
            samples: Samples::new(INTERVAL, 1e-3, KEPT),
            model,
            report: described.report,
            locked,
        };
        let (simulation, notes) = robot.build(&Choice::default())?;
        (robot.file_effects, robot.simulation, robot.notes) = (robot.all_effects()?, simulation, notes);
        Ok(robot)
    }

    /// The same fall by the library's run, for tests: q after that many steps without motors and hand.
    ///
    /// # Errors
    /// Fails if the run fails.
    pub fn reference_fall(&self, steps: usize) -> Result<Vec<f64>, LabError> {
        let (mut simulation, _) = self.build(&self.choice)?;
        simulation.reset(self.simulation.q(), self.simulation.v())?;
        let run =
            simulation.run_steps(steps, RunOptions::new().sample_ends()).map_err(|failure| failure.error)?;
        Ok(run.q)
    }
}

fn options(floating_base: bool, repair_inertia: bool) -> LoadOptions {
    LoadOptions { floating_base, repair_inertia, ..LoadOptions::default() }
}
