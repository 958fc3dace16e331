//! The tumbling brick: a free rigid body with an initial spin about one of its axes.

use dynamics::{FreeRotation, MassProperties, RotationalInertia, cayley_body_step, euler_body_step};
use nalgebra::{UnitQuaternion, Vector3};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::LabError;
use crate::input::{finite, positive, vector};
use crate::samples::Samples;

/// Sampling period \[s\] and the number of samples kept.
const INTERVAL: f64 = 0.02;
const KEPT: usize = 1000;

/// Relative drift of the conserved quantities since the start.
#[wasm_bindgen]
#[derive(Clone, Copy, Debug)]
pub struct BrickDrift {
    /// |L − L₀|/|L₀|.
    #[wasm_bindgen(readonly)]
    pub momentum: f64,
    /// |K − K₀|/K₀.
    #[wasm_bindgen(readonly)]
    pub energy: f64,
}

/// A solid box without torques.
#[wasm_bindgen]
#[derive(Clone, Debug)]
pub struct Brick {
    inertia: RotationalInertia,
    mass: f64,
    edges: Vector3<f64>,
    world_from_body: UnitQuaternion<f64>,
    omega: Vector3<f64>,
    exact: FreeRotation,
    momentum_at_start: Vector3<f64>,
    energy_at_start: f64,
    keeps_momentum: bool,
    h: f64,
    steps: u64,
    time: f64,
    axis: usize,
    flips: u32,
    samples: Samples<7>,
}

#[wasm_bindgen]
impl Brick {
    /// A box of three edges \[m\] and a density \[kg/m³\], at rest.
    ///
    /// # Errors
    /// Fails if an edge or the density is not positive.
    #[wasm_bindgen(constructor)]
    pub fn new(edge_x: f64, edge_y: f64, edge_z: f64, density: f64) -> Result<Self, LabError> {
        let edges = Vector3::new(edge_x, edge_y, edge_z);
        let body = MassProperties::solid_box(density, edges)?;
        let inertia = body.rotational()?;
        let (world_from_body, omega) = (UnitQuaternion::identity(), Vector3::zeros());
        Ok(Self {
            inertia,
            mass: body.mass(),
            edges,
            world_from_body,
            omega,
            exact: FreeRotation::new(&inertia, &world_from_body, &omega),
            momentum_at_start: Vector3::zeros(),
            energy_at_start: 0.0,
            keeps_momentum: true,
            h: 1e-3,
            steps: 0,
            time: 0.0,
            axis: 0,
            flips: 0,
            samples: Samples::new(INTERVAL, 1e-3, KEPT),
        })
    }

    /// Restarts with axes along the world's and ω \[rad/s\] in body axes. Flips are counted about its largest
    /// component.
    ///
    /// # Errors
    /// Fails if a number is not finite.
    pub fn spin(&mut self, omega: &[f64]) -> Result<(), LabError> {
        self.place(&[0.0, 0.0, 0.0, 1.0], omega)
    }

    /// Restarts with an orientation given as a quaternion x, y, z, w (normalised here) and ω in body axes.
    ///
    /// # Errors
    /// Fails if a number is not finite or the quaternion is zero.
    pub fn place(&mut self, xyzw: &[f64], omega: &[f64]) -> Result<(), LabError> {
        finite("the quaternion", xyzw, 4)?;
        let quaternion = nalgebra::Quaternion::new(xyzw[3], xyzw[0], xyzw[1], xyzw[2]);
        self.world_from_body = UnitQuaternion::try_new(quaternion, 1e-9)
            .ok_or_else(|| LabError::new("the quaternion must not be zero"))?;
        self.omega = vector("omega", omega)?;
        self.exact = FreeRotation::new(&self.inertia, &self.world_from_body, &self.omega);
        self.momentum_at_start = self.momentum();
        self.energy_at_start = self.inertia.kinetic_energy(&self.omega);
        (self.steps, self.time, self.flips) = (0, 0.0, 0);
        self.axis = self.omega.iamax();
        self.samples.clear();
        self.sample();
        Ok(())
    }

    /// Sets the method, `cayley` (conserves L and K) or `rk4`, and the step \[s\].
    ///
    /// # Errors
    /// Fails if the name is unknown or the step is not positive.
    #[wasm_bindgen(js_name = setMethod)]
    pub fn set_method(&mut self, name: &str, h: f64) -> Result<(), LabError> {
        self.keeps_momentum = match name {
            "cayley" => true,
            "rk4" => false,
            _ => {
                return Err(LabError::new(format!(
                    "unknown rotation step \"{name}\"; known: cayley and rk4"
                )));
            }
        };
        self.h = positive("the step", h)?;
        self.steps = 0;
        self.samples = Samples::new(INTERVAL, h, KEPT);
        Ok(())
    }

    /// Advances by whole steps.
    ///
    /// # Errors
    /// Fails if a step fails; the state before it is kept.
    pub fn advance(&mut self, steps: u32) -> Result<(), LabError> {
        let free = Vector3::zeros();
        for _ in 0..steps {
            let step = if self.keeps_momentum { cayley_body_step } else { euler_body_step };
            let (orientation, omega) =
                step(&self.world_from_body, &self.omega, &free, &self.inertia, self.h)?;
            if !omega.iter().all(|x| x.is_finite()) {
                return Err(LabError::new(format!(
                    "the spin is not finite at {:.3} s; use a smaller step",
                    self.time
                )));
            }
            self.flips += u32::from(omega[self.axis] * self.omega[self.axis] < 0.0);
            (self.world_from_body, self.omega) = (orientation, omega);
            self.steps += 1;
            self.time += self.h;
            if self.samples.due(self.steps) {
                self.sample();
            }
        }
        Ok(())
    }

    /// Time since the start \[s\].
    #[wasm_bindgen(getter)]
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Mass \[kg\].
    #[wasm_bindgen(getter)]
    pub fn mass(&self) -> f64 {
        self.mass
    }

    /// The three edges \[m\].
    #[wasm_bindgen(getter)]
    pub fn edges(&self) -> Vec<f64> {
        self.edges.as_slice().to_vec()
    }

    /// The principal moments along the body's x, y, z \[kg·m²\].
    #[wasm_bindgen(getter)]
    pub fn moments(&self) -> Vec<f64> {
        self.inertia.matrix().diagonal().as_slice().to_vec()
    }

    /// The rotation world from body, in row-major order.
    #[wasm_bindgen(getter)]
    pub fn rotation(&self) -> Vec<f64> {
        self.world_from_body.to_rotation_matrix().matrix().transpose().as_slice().to_vec()
    }

    /// The orientation as a quaternion x, y, z, w.
    #[wasm_bindgen(getter, js_name = quaternionXyzw)]
    pub fn quaternion_xyzw(&self) -> Vec<f64> {
        self.world_from_body.coords.as_slice().to_vec()
    }

    /// ω in body axes \[rad/s\].
    #[wasm_bindgen(getter)]
    pub fn omega(&self) -> Vec<f64> {
        self.omega.as_slice().to_vec()
    }

    /// L in world axes \[kg·m²/s\].
    #[wasm_bindgen(getter, js_name = momentumInWorld)]
    pub fn momentum_in_world(&self) -> Vec<f64> {
        self.momentum().as_slice().to_vec()
    }

    /// K \[J\].
    #[wasm_bindgen(getter, js_name = kineticEnergy)]
    pub fn kinetic_energy(&self) -> f64 {
        self.inertia.kinetic_energy(&self.omega)
    }

    /// The relative drifts of L and K.
    #[wasm_bindgen(getter)]
    pub fn drift(&self) -> BrickDrift {
        if self.energy_at_start == 0.0 {
            return BrickDrift { momentum: 0.0, energy: 0.0 };
        }
        let momentum = (self.momentum() - self.momentum_at_start).norm() / self.momentum_at_start.norm();
        let energy = (self.kinetic_energy() - self.energy_at_start).abs() / self.energy_at_start;
        BrickDrift { momentum, energy }
    }

    /// The number of sign changes of the spin about the initial axis.
    #[wasm_bindgen(getter)]
    pub fn flips(&self) -> u32 {
        self.flips
    }

    /// ω in body axes by Jacobi's elliptic functions, at the current time \[rad/s\].
    #[wasm_bindgen(getter, js_name = exactOmega)]
    pub fn exact_omega(&self) -> Vec<f64> {
        self.exact.omega_in_body(self.time).as_slice().to_vec()
    }

    /// The exact period of ω \[s\]; infinite if ω is constant.
    #[wasm_bindgen(getter, js_name = exactPeriod)]
    pub fn exact_period(&self) -> f64 {
        self.exact.period()
    }

    /// The polhode: `count` points Π/|Π| of one period in body axes, x y z each, by the exact solution.
    pub fn polhode(&self, count: u32) -> Vec<f64> {
        self.points_of_period(&self.exact, count)
    }

    /// The polhode through another direction of Π.
    ///
    /// # Errors
    /// Fails if the direction does not have three finite numbers.
    #[wasm_bindgen(js_name = polhodeThrough)]
    pub fn polhode_through(&self, direction: &[f64], count: u32) -> Result<Vec<f64>, LabError> {
        let omega = self.inertia.angular_velocity(&vector("the direction", direction)?);
        let motion = FreeRotation::new(&self.inertia, &UnitQuaternion::identity(), &omega);
        Ok(self.points_of_period(&motion, count))
    }

    /// Π/|Π| in body axes, the direction of L in the body.
    #[wasm_bindgen(getter)]
    pub fn direction(&self) -> Vec<f64> {
        self.unit_momentum(&self.omega).to_vec()
    }

    /// Rows of seven: t, ω in body axes, Π/|Π| in body axes.
    pub fn samples(&self) -> Vec<f64> {
        self.samples.flat()
    }

    /// A single point, for constant ω.
    fn points_of_period(&self, motion: &FreeRotation, count: u32) -> Vec<f64> {
        let period = motion.period();
        if !period.is_finite() {
            return self.unit_momentum(&motion.omega_in_body(0.0)).to_vec();
        }
        let times = (0..=count).map(|i| period * f64::from(i) / f64::from(count.max(1)));
        times.flat_map(|t| self.unit_momentum(&motion.omega_in_body(t))).collect()
    }

    fn momentum(&self) -> Vector3<f64> {
        self.inertia.momentum_in_world(&self.world_from_body, &self.omega)
    }

    fn unit_momentum(&self, omega: &Vector3<f64>) -> [f64; 3] {
        let momentum = self.inertia.momentum(omega);
        let size = momentum.norm();
        if size > 0.0 { (momentum / size).into() } else { [0.0; 3] }
    }

    fn sample(&mut self) {
        let [x, y, z] = self.unit_momentum(&self.omega);
        self.samples.push([self.time, self.omega.x, self.omega.y, self.omega.z, x, y, z]);
    }
}
