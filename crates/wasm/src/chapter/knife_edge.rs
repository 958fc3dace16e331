//! The knife-edge: a chassis that cannot slip sideways, driven by two wheels.

use dynamics::{
    Dynamics, EnergyAccount, KnifeEdge, Pfaffian, SystemEnergy, constrained_rk4_step, generalized_force,
};
use nalgebra::{Vector3, vector};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::LabError;
use crate::input::{number, positive, vector};
use crate::samples::Samples;

/// Sampling period \[s\], the number of samples kept, and the step \[s\].
const INTERVAL: f64 = 0.02;
const KEPT: usize = 1500;
const STEP: f64 = 1e-3;

/// The energy of the chassis \[J\].
#[wasm_bindgen]
#[derive(Clone, Copy, Debug)]
pub struct BladeEnergyAccount {
    /// K.
    #[wasm_bindgen(readonly)]
    pub kinetic: f64,
    /// Work of the wheels and of the push.
    #[wasm_bindgen(readonly)]
    pub work: f64,
    /// The residual of the energy balance.
    #[wasm_bindgen(readonly)]
    pub unaccounted: f64,
}

/// A chassis on a level floor with a forward force at each wheel and a side push.
#[wasm_bindgen]
#[derive(Clone, Debug)]
pub struct Blade {
    body: KnifeEdge,
    half_track: f64,
    q: Vector3<f64>,
    qd: Vector3<f64>,
    wheels: [f64; 2],
    side: f64,
    damping: f64,
    steps: u64,
    energy_account: EnergyAccount,
    samples: Samples<6>,
}

state_getters! {
    Blade:
    /// (x, y, θ) \[m, m, rad\].
    q,
    /// (ẋ, ẏ, θ̇).
    qd
}

#[wasm_bindgen]
impl Blade {
    /// Mass \[kg\], moment of inertia \[kg·m²\], half the distance between the wheels \[m\].
    ///
    /// # Errors
    /// Fails if one of them is not positive.
    #[wasm_bindgen(constructor)]
    pub fn new(m: f64, i_zz: f64, half_track: f64) -> Result<Self, LabError> {
        let body = KnifeEdge::new(positive("the mass", m)?, positive("the inertia", i_zz)?);
        let zero = Vector3::zeros();
        Ok(Self {
            body,
            half_track: positive("half the track", half_track)?,
            q: zero,
            qd: zero,
            wheels: [0.0; 2],
            side: 0.0,
            damping: 0.0,
            steps: 0,
            energy_account: EnergyAccount::open(&body.body, &zero, &zero),
            samples: Samples::new(INTERVAL, STEP, KEPT),
        })
    }

    /// Restarts at (x, y, θ) with a forward speed \[m/s\] and a turning rate \[rad/s\].
    ///
    /// # Errors
    /// Fails if a number is not finite.
    pub fn place(&mut self, q: &[f64], speed: f64, turning: f64) -> Result<(), LabError> {
        self.q = vector("q", q)?;
        self.qd =
            KnifeEdge::velocity(&self.q, number("the speed", speed)?, number("the turning rate", turning)?);
        self.steps = 0;
        self.energy_account = EnergyAccount::open(&self.body.body, &self.q, &self.qd);
        self.samples.clear();
        self.sample();
        Ok(())
    }

    /// Sets the forces: left wheel, right wheel, and a push to the left at the centre \[N\].
    ///
    /// # Errors
    /// Fails if a number is not finite.
    #[wasm_bindgen(js_name = setForces)]
    pub fn set_forces(&mut self, left: f64, right: f64, side: f64) -> Result<(), LabError> {
        self.wheels = [number("the left force", left)?, number("the right force", right)?];
        self.side = number("the side push", side)?;
        Ok(())
    }

    /// Sets the viscous drag of each wheel \[N·s/m\].
    ///
    /// # Errors
    /// Fails if the number is negative or not finite.
    #[wasm_bindgen(js_name = setDamping)]
    pub fn set_damping(&mut self, damping: f64) -> Result<(), LabError> {
        self.damping = crate::input::not_negative("the drag", damping)?;
        Ok(())
    }

    /// Advances by steps of a millisecond with constant forces.
    ///
    /// # Errors
    /// Fails if a step fails; the state before it is kept.
    pub fn advance(&mut self, steps: u32) -> Result<(), LabError> {
        for _ in 0..steps {
            let u = self.generalized_force();
            let next = constrained_rk4_step(&self.body.body, &self.body, &self.q, &self.qd, &u, STEP)?;
            self.energy_account.record(&self.body.body, (&self.q, &self.qd), (&next.q, &next.qd), &u, STEP);
            (self.q, self.qd) = (next.q, next.qd);
            self.steps += 1;
            if self.samples.due(self.steps) {
                self.sample();
            }
        }
        Ok(())
    }

    /// λ, the side force of the floor, positive to the right of the heading \[N\].
    #[wasm_bindgen(getter)]
    pub fn lambda(&self) -> f64 {
        self.body.side_force(&self.q, &self.qd, &self.generalized_force())
    }

    /// The constraint force Aᵀλ on (x, y, θ) \[N, N, N·m\].
    #[wasm_bindgen(getter, js_name = constraintForce)]
    pub fn constraint_force(&self) -> Vec<f64> {
        (self.body.rows(&self.q).transpose() * self.lambda()).as_slice().to_vec()
    }

    /// A q̇: the sideways speed, which the constraint keeps at zero \[m/s\].
    #[wasm_bindgen(getter, js_name = sideSlip)]
    pub fn side_slip(&self) -> f64 {
        (self.body.rows(&self.q) * self.qd)[0]
    }

    /// The forward speed \[m/s\].
    #[wasm_bindgen(getter)]
    pub fn speed(&self) -> f64 {
        KnifeEdge::forward_speed(&self.q, &self.qd)
    }

    /// −m v θ̇: the side force of a turn \[N\].
    #[wasm_bindgen(getter, js_name = turningForce)]
    pub fn turning_force(&self) -> f64 {
        self.body.side_force(&self.q, &self.qd, &Vector3::zeros())
    }

    /// The hubs of the left and the right wheel: x, y, x, y \[m\].
    #[wasm_bindgen(getter)]
    pub fn hubs(&self) -> Vec<f64> {
        let (s, c) = self.q[2].sin_cos();
        let (x, y, b) = (self.q[0], self.q[1], self.half_track);
        vec![x - b * s, y + b * c, x + b * s, y - b * c]
    }

    /// The energy of the chassis \[J\].
    #[wasm_bindgen(getter, js_name = energyAccount)]
    pub fn energy_account(&self) -> BladeEnergyAccount {
        let kinetic = self.body.body.kinetic_energy(&self.q, &self.qd);
        BladeEnergyAccount {
            kinetic,
            work: self.energy_account.work(),
            unaccounted: self.energy_account.imbalance(),
        }
    }

    /// Rows of six: t, x, y, θ, forward speed, λ.
    pub fn samples(&self) -> Vec<f64> {
        self.samples.flat()
    }

    /// u = T f minus the drag at the wheels, plus the side push.
    fn generalized_force(&self) -> Vector3<f64> {
        let map = KnifeEdge::wheel_map(&self.q, self.half_track);
        let hubs = dynamics::actuator_velocity(&map, &self.qd);
        let wheels =
            vector![self.wheels[0] - self.damping * hubs[0], self.wheels[1] - self.damping * hubs[1]];
        // A row of A points to the right, the push to the left.
        generalized_force(&map, &wheels) - self.body.rows(&self.q).transpose() * self.side
    }

    fn sample(&mut self) {
        let row = [self.time(), self.q[0], self.q[1], self.q[2], self.speed(), self.lambda()];
        self.samples.push(row);
    }
}

impl Blade {
    /// λ, q̈ and P of a chassis in a state, by the solver and by the closed forms. The self-checks compare
    /// them.
    ///
    /// # Errors
    /// Fails if the solver fails.
    pub fn solver_against_closed_form(
        body: &KnifeEdge,
        q: &Vector3<f64>,
        qd: &Vector3<f64>,
        u: &Vector3<f64>,
    ) -> Result<f64, LabError> {
        let (rows, rate) = (body.rows(q), body.rows_rate(q, qd));
        let (qdd, lambda) = dynamics::constrained_forward_dynamics(&body.body, q, qd, u, &rows, &rate)?;
        let mass = body.body.mass(q);
        let projection = dynamics::ConstraintProjections::new(&mass, &rows)?;
        let by_hand = (body.acceleration(q, qd, u), body.side_force(q, qd, u), KnifeEdge::projection(q));
        Ok((qdd - by_hand.0)
            .amax()
            .max((lambda[0] - by_hand.1).abs())
            .max((projection.velocity - by_hand.2).amax()))
    }
}

/// The largest difference between the constraint solver and the closed forms over seeded random states.
///
/// # Errors
/// Fails if the solver fails.
#[wasm_bindgen(js_name = knifeEdgeDefect)]
pub fn knife_edge_defect(seed: u32, states: u32) -> Result<f64, LabError> {
    let mut random = dynamics::SplitMix64::new(seed.into());
    let mut worst = 0.0_f64;
    for _ in 0..states {
        let body = KnifeEdge::new(random.uniform(0.5, 5.0), random.uniform(0.1, 2.0));
        let mut draw = || Vector3::from_fn(|_, _| random.uniform(-3.0, 3.0));
        let (q, qd, u) = (draw(), draw(), draw());
        worst = worst.max(Blade::solver_against_closed_form(&body, &q, &qd, &u)?);
    }
    Ok(worst)
}
