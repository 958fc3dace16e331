//! Your robot: any URDF, posed, held, or let fall.

use dynamics::{EnergyLedger, Integrator, check_finite};
use multibody::{
    Controller, Finding, FramePose, GravityCompensatedPd, JointKind, Measure, Model, Simulation, StepForces,
    StepWorkspace, Workspace, ZeroTorque, check_rank, energy_ledger, frame_poses, neutral,
    normalize_quaternions, record_step, step,
};
use wasm_bindgen::prelude::wasm_bindgen;

use super::drawn_body::drawn_body;
use crate::LabError;
use crate::input::{finite, integrator, not_negative, positive};
use crate::samples::Samples;

/// Time between two samples \[s\] and the number kept.
const INTERVAL: f64 = 0.02;
const KEPT: usize = 1500;

/// A robot from a file, its state, its integrator and its books.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Robot {
    model: Model,
    report: urdf::LoadReport,
    workspace: Workspace,
    stepping: StepWorkspace,
    poses: Vec<FramePose>,
    q: Vec<f64>,
    v: Vec<f64>,
    tau: Vec<f64>,
    integrator: Integrator,
    h: f64,
    dissipation: bool,
    hold: Option<Hold>,
    ledger: EnergyLedger,
    steps: u64,
    time: f64,
    samples: Samples<4>,
}

/// The pose to hold and the gains, nv numbers each.
#[derive(Clone, Debug)]
struct Hold {
    target: Vec<f64>,
    stiffness: Vec<f64>,
    damping: Vec<f64>,
    limits: Vec<f64>,
}

#[wasm_bindgen]
impl Robot {
    /// Reads the text of a URDF file.
    ///
    /// # Errors
    /// If the file cannot be read as a robot: what is wrong, on which line, and what to do.
    pub fn load(text: &str, floating_base: bool, repair_inertia: bool) -> Result<Self, LabError> {
        let options = urdf::Options { floating_base, repair_inertia, ..urdf::Options::default() };
        let urdf::Robot { description, report, .. } = urdf::parse(text, &options)?;
        let model = Model::new(description)?;
        let (q, v) = (neutral(&model), vec![0.0; model.nv()]);
        let mut workspace = Workspace::new(&model);
        let still = FramePose { rotation: [[0.0; 3]; 3], translation: [0.0; 3] };
        Ok(Self {
            ledger: energy_ledger(&model, &mut workspace, &q, &v),
            stepping: StepWorkspace::new(&model),
            poses: vec![still; model.frames().len()],
            tau: v.clone(),
            samples: Samples::new(INTERVAL, 1e-3, KEPT),
            integrator: Integrator::RungeKutta4,
            h: 1e-3,
            dissipation: true,
            hold: None,
            steps: 0,
            time: 0.0,
            model,
            report,
            workspace,
            q,
            v,
        })
    }

    /// The robot's name.
    #[wasm_bindgen(getter)]
    pub fn name(&self) -> String {
        self.model.name().to_owned()
    }

    /// Total mass \[kg\].
    #[wasm_bindgen(getter, js_name = totalMass)]
    pub fn total_mass(&self) -> f64 {
        self.model.mass()
    }

    /// Links, joints, freedoms; findings read, defaulted, repaired, ignored, ignored physics, taken as written.
    #[wasm_bindgen(getter)]
    pub fn counts(&self) -> Vec<f64> {
        let c = self.report.counts;
        [
            c.links,
            c.joints,
            c.degrees_of_freedom,
            c.read,
            c.defaulted,
            c.repaired,
            c.ignored,
            c.ignored_physics,
            c.as_written,
        ]
        .map(|count| count as f64)
        .to_vec()
    }

    /// The load report, one entry a string: line, treatment, place, message, separated by tabs.
    pub fn report(&self) -> Vec<String> {
        let line = |finding: &Finding| {
            format!("{}\t{}\t{}\t{}", finding.line(), finding.treatment(), finding.place(), finding.message())
        };
        self.report.findings.iter().map(line).collect()
    }

    /// The coordinates' names, in the order of v.
    #[wasm_bindgen(js_name = coordinateNames)]
    pub fn coordinate_names(&self) -> Vec<String> {
        self.model.coordinate_names()
    }

    /// Rows of five, one a coordinate: its place in q, whether it slides (1) or turns (0), lower, upper, effort.
    ///
    /// The place is −1 for a coordinate of a quaternion joint, which no slider sets. Limits may be infinite.
    pub fn coordinates(&self) -> Vec<f64> {
        let limits = self.model.coordinate_limits();
        let mut rows = Vec::with_capacity(5 * limits.len());
        for joint in self.model.joints().iter().filter(|joint| joint.nv > 0) {
            for k in 0..joint.nv {
                let limits = limits[joint.v_index + k];
                let place = if joint.nq == joint.nv { (joint.q_index + k) as f64 } else { -1.0 };
                let slides = joint.kind.velocities()[k].measure == Measure::Length;
                rows.extend([place, f64::from(u8::from(slides)), limits.lower, limits.upper, limits.effort]);
            }
        }
        rows
    }

    /// Pairs of link numbers, parent and child, one pair a joint.
    pub fn joints(&self) -> Vec<u32> {
        let description = self.model.description();
        let number = |name: &str| description.links.iter().position(|link| link.name == name);
        let pairs = description.joints.iter().filter_map(|j| number(&j.parent).zip(number(&j.child)));
        pairs.flat_map(|(parent, child)| [parent, child]).filter_map(|n| u32::try_from(n).ok()).collect()
    }

    /// Per joint of the file: the number of the first coordinate it moves (−1 if none), and its axis in the
    /// child's frame (zero if it has none).
    #[wasm_bindgen(js_name = jointAxes)]
    pub fn joint_axes(&self) -> Vec<f64> {
        let description = self.model.description();
        let mut rows = Vec::new();
        for joint in &description.joints {
            let axis = match joint.kind {
                JointKind::Revolute { axis }
                | JointKind::Continuous { axis }
                | JointKind::Prismatic { axis } => axis,
                _ => [0.0; 3],
            };
            let place =
                self.model.joint(&joint.name).filter(|j| j.nv == 1).map_or(-1.0, |j| j.v_index as f64);
            rows.push(place);
            rows.extend(axis);
        }
        rows
    }

    /// Link names, in the order of [`poses`](Self::poses).
    #[wasm_bindgen(js_name = linkNames)]
    pub fn link_names(&self) -> Vec<String> {
        self.model.description().links.iter().map(|link| link.name.clone()).collect()
    }

    /// Rows of sixteen, one a link: see `drawn_body.rs`; the mass is 0 for a link without.
    pub fn bodies(&self) -> Vec<f64> {
        let links = &self.model.description().links;
        links.iter().flat_map(|link| link.mass_properties.as_ref().map_or([0.0; 16], drawn_body)).collect()
    }

    /// Rows of twelve, one a link: the rotation world from link row by row, then the origin \[m\].
    pub fn poses(&mut self) -> Vec<f64> {
        frame_poses(&self.model, &mut self.workspace, &self.q, &mut self.poses);
        let links = self.model.description().links.len();
        self.poses[..links]
            .iter()
            .flat_map(|pose| pose.rotation.iter().flatten().chain(&pose.translation).copied())
            .collect()
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

    /// Puts the robot at rest at q (quaternions are normalised), sets time to zero, opens new books.
    ///
    /// # Errors
    /// If q has the wrong length or is not finite.
    pub fn place(&mut self, q: &[f64]) -> Result<(), LabError> {
        finite("q", q, self.model.nq())?;
        self.q.copy_from_slice(q);
        normalize_quaternions(&self.model, &mut self.q);
        self.v.fill(0.0);
        (self.steps, self.time) = (0, 0.0);
        self.ledger = energy_ledger(&self.model, &mut self.workspace, &self.q, &self.v);
        self.samples.clear();
        self.sample();
        Ok(())
    }

    /// The neutral configuration.
    pub fn neutral(&self) -> Vec<f64> {
        neutral(&self.model)
    }

    /// Chooses integrator, step \[s\], and whether damping and friction act.
    ///
    /// # Errors
    /// If the name is unknown or the step not positive.
    #[wasm_bindgen(js_name = setMethod)]
    pub fn set_method(&mut self, name: &str, h: f64, dissipation: bool) -> Result<(), LabError> {
        (self.integrator, self.h) = (integrator(name)?, positive("the step", h)?);
        self.dissipation = dissipation;
        self.steps = 0;
        self.samples = Samples::new(INTERVAL, h, KEPT);
        Ok(())
    }

    /// Holds the present pose with gravity compensation, each coordinate as an oscillator of this natural
    /// frequency \[rad/s\] and damping ratio: Kp = ω²/(M⁻¹)ᵢᵢ, Kd = 2ζω/(M⁻¹)ᵢᵢ at the pose.
    ///
    /// 1/(M⁻¹)ᵢᵢ is the inertia that a torque at coordinate i alone feels. All eigenvalues of M⁻¹Kd are then at
    /// most nv·2ζω, so that a light joint is not shaken by a gain meant for a heavy one. A floating base has no
    /// motors.
    ///
    /// # Errors
    /// If the frequency or the ratio is negative.
    pub fn hold(&mut self, frequency: f64, damping_ratio: f64) -> Result<(), LabError> {
        let (frequency, ratio) =
            (not_negative("the frequency", frequency)?, not_negative("ζ", damping_ratio)?);
        let nv = self.model.nv();
        let mut inverse = vec![0.0; nv * nv];
        multibody::inverse_mass_matrix(&self.model, &mut self.workspace, &self.q, &mut inverse);
        let inertia: Vec<f64> = (0..nv).map(|i| 1.0 / inverse[i * nv + i]).collect();
        let mut limits: Vec<f64> =
            self.model.coordinate_limits().iter().map(|limits| limits.effort).collect();
        for joint in self.model.joints().iter().filter(|joint| joint.kind == JointKind::Floating) {
            limits[joint.v_index..joint.v_index + joint.nv].fill(0.0);
        }
        self.hold = Some(Hold {
            target: self.q.clone(),
            stiffness: inertia.iter().map(|i| frequency * frequency * i).collect(),
            damping: inertia.iter().map(|i| 2.0 * ratio * frequency * i).collect(),
            limits,
        });
        Ok(())
    }

    /// Lets go.
    pub fn release(&mut self) {
        self.hold = None;
    }

    /// Advances by whole steps.
    ///
    /// # Errors
    /// Where a step fails or blows up; the state before it is kept.
    pub fn advance(&mut self, steps: u32) -> Result<(), LabError> {
        let Self { model, hold, stepping, tau, .. } = self;
        let mut holding = match hold {
            Some(Hold { target, stiffness, damping, limits }) => {
                Some(GravityCompensatedPd::new(model, target, stiffness, damping)?.with_limits(limits))
            }
            None => None,
        };
        for _ in 0..steps {
            match &mut holding {
                Some(controller) => controller.torque(self.time, &self.q, &self.v, tau)?,
                None => ZeroTorque.torque(self.time, &self.q, &self.v, tau)?,
            }
            let (mut q, mut v) = (self.q.clone(), self.v.clone());
            let forces = StepForces::new(tau, self.dissipation);
            check_rank(model, &mut self.workspace, &self.q)?;
            step(model, self.integrator, stepping, &forces, self.h, &mut q, &mut v)?;
            check_finite("q", &q)?;
            check_finite("v", &v)?;
            record_step(model, stepping, &mut self.ledger, (&self.q, &self.v), (&q, &v), &forces, self.h);
            (self.q, self.v) = (q, v);
            self.steps += 1;
            self.time += self.h;
            if self.samples.due(self.steps) {
                let row =
                    [self.time, self.ledger.kinetic(), self.ledger.potential(), self.ledger.imbalance()];
                self.samples.push(row);
            }
        }
        Ok(())
    }

    /// K, V, E, E at the start, work of the motors, dissipated, unaccounted for \[J\].
    #[wasm_bindgen(getter)]
    pub fn books(&self) -> Vec<f64> {
        let l = &self.ledger;
        vec![l.kinetic(), l.potential(), l.now(), l.start(), l.work(), l.dissipated(), l.imbalance()]
    }

    /// g(q): what the motors must give to hold the present pose, nv numbers \[N·m or N\].
    #[wasm_bindgen(js_name = holdTorques)]
    pub fn hold_torques(&mut self) -> Vec<f64> {
        let mut torques = vec![0.0; self.model.nv()];
        multibody::gravity(&self.model, &mut self.workspace, &self.q, &mut torques);
        torques
    }

    /// Rows of four: t, K, V, unaccounted for.
    pub fn samples(&self) -> Vec<f64> {
        self.samples.flat()
    }

    fn sample(&mut self) {
        self.samples.push([
            self.time,
            self.ledger.kinetic(),
            self.ledger.potential(),
            self.ledger.imbalance(),
        ]);
    }
}

impl Robot {
    /// The same fall as a whole run of the library, for tests: q after so many steps without torque.
    ///
    /// # Errors
    /// Where the run fails.
    pub fn reference_fall(&self, steps: usize) -> Result<Vec<f64>, LabError> {
        let simulation = Simulation::new(&self.model, self.integrator, self.h)
            .with_dissipation(self.dissipation)
            .with_samples_every(0);
        let run = simulation
            .run(&self.q, &self.v, steps, &mut ZeroTorque, |_| core::ops::ControlFlow::Continue(()))
            .map_err(|failure| LabError::new(failure.error.to_string()))?;
        Ok(run.q)
    }
}
