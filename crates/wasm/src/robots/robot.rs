//! Your robot: any URDF or MJCF file, posed, pulled, held, or let fall.

use std::collections::HashMap;
use std::sync::Arc;

use multibody::simulator::{Effect, RunOptions, Simulation, SimulationBuilder};
use multibody::text::{file_stem, one_line};
use multibody::{Base, ConstraintSet, Finding, FramePose, LoadReport, Model, Workspace};
use robot_dynamics::{Described, Options, describe_among, describe_text};
use wasm_bindgen::prelude::wasm_bindgen;

use super::choice::Choice;
use super::controls::ControlLine;
use super::files::RobotFiles;
use super::hand::Hand;
use super::torques::Step;
use crate::LabError;
use crate::samples::Samples;

/// Time between two samples \[s\] and the number kept.
pub(crate) const INTERVAL: f64 = 0.02;
pub(crate) const KEPT: usize = 1500;

/// A robot from a file, in the library's simulation.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Robot {
    pub(crate) model: Arc<Model>,
    pub(crate) report: LoadReport,
    pub(crate) locked: Vec<String>,
    pub(crate) workspace: Workspace,
    pub(crate) poses: Vec<FramePose>,
    pub(crate) choice: Choice,
    pub(crate) simulation: Simulation,
    /// The effects that act with everything on.
    pub(crate) stated: Vec<Effect>,
    /// Why something that the page lays is left out.
    pub(crate) notes: Vec<String>,
    /// When the simulation was set up, after the robot was placed \[s\].
    pub(crate) since: f64,
    /// Corners of convex hulls by the number of their shape, in the shape's frame \[m\].
    pub(crate) meshes: HashMap<usize, Vec<[f64; 3]>>,
    /// The closed loops and couplings of the file.
    pub(crate) loops: ConstraintSet,
    /// Why they cannot be held.
    pub(crate) loose: Option<String>,
    pub(crate) controls: ControlLine,
    pub(crate) hold: Option<Hold>,
    pub(crate) hand: Option<Hand>,
    /// The generalised forces of the hand, nv entries.
    pub(crate) pull: Vec<f64>,
    pub(crate) last: Option<Step>,
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

    /// The robot's name, on one line.
    #[wasm_bindgen(getter)]
    pub fn name(&self) -> String {
        shown(self.model.name())
    }

    /// The robot's name as that of a file, without an ending.
    #[wasm_bindgen(getter, js_name = fileName)]
    pub fn file_name(&self) -> String {
        file_stem(self.model.name())
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

    /// Whether its root link floats; a world that carries something which floats does not.
    #[wasm_bindgen(getter, js_name = baseFloats)]
    pub fn base_floats(&self) -> bool {
        self.model.description().base == Base::Floating
    }

    /// The joints that move no mass and are held still.
    pub fn locked(&self) -> Vec<String> {
        self.locked.iter().map(|joint| shown(joint)).collect()
    }

    /// The load report, one entry a string: line, treatment, place, message, separated by tabs.
    pub fn report(&self) -> Vec<String> {
        let line = |finding: &Finding| {
            let (place, message) = (shown(finding.place()), shown(finding.message()));
            format!("{}\t{}\t{place}\t{message}", finding.line(), finding.treatment())
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

    /// Time since the last placing \[s\].
    #[wasm_bindgen(getter)]
    pub fn time(&self) -> f64 {
        self.since + self.simulation.time()
    }
}

impl Robot {
    fn of(mut described: Described) -> Result<Self, LabError> {
        let locked = described.description.lock_massless()?;
        let model = Arc::new(Model::new(described.description)?);
        let (loops, loose) = match ConstraintSet::from_equalities(&model) {
            Ok(loops) => (loops, None),
            Err(error) => (ConstraintSet::default(), Some(error.to_string())),
        };
        let still = FramePose { rotation: [[0.0; 3]; 3], translation: [0.0; 3] };
        // Nothing acts in this one; the robot's own is set up once all that it needs is there.
        let mut bare = SimulationBuilder::shared(Arc::clone(&model));
        for effect in Effect::ALL {
            bare = bare.without(effect);
        }
        let mut robot = Self {
            workspace: Workspace::new(&model),
            poses: vec![still; model.frames().len()],
            choice: Choice::default(),
            simulation: bare.build()?,
            stated: Vec::new(),
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
        (robot.stated, robot.simulation, robot.notes) = (robot.everything()?, simulation, notes);
        Ok(robot)
    }

    /// The same fall as a whole run of the library, for tests: q after so many steps without motors and hand.
    ///
    /// # Errors
    /// Where the run fails.
    pub fn reference_fall(&self, steps: usize) -> Result<Vec<f64>, LabError> {
        let (mut simulation, _) = self.build(&self.choice)?;
        simulation.reset(self.simulation.q(), self.simulation.v())?;
        let run =
            simulation.run(steps, RunOptions::new().sample_every(0)).map_err(|failure| failure.error)?;
        Ok(run.q)
    }
}

/// A name of the file as text on the page, on one line.
pub(crate) fn shown(name: &str) -> String {
    one_line(name).into_owned()
}

/// Any text on one line, what cannot be seen in it as escapes: for names of files that a person gave.
#[wasm_bindgen(js_name = oneLine)]
pub fn one_line_text(text: &str) -> String {
    shown(text)
}

fn options(floating_base: bool, repair_inertia: bool) -> Options {
    Options { floating_base, repair_inertia, ..Options::default() }
}
