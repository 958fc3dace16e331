//! The library's closed-form models, by name.

use dynamics::{
    Christoffel, Dynamics, InertiaEllipse, PlanarArm, PlanarBody, PlanarKinematics, PolarMass, Reach2R,
    RpArm, SystemStep, christoffel, christoffel_by_differences, energy_drift, mass_rate,
    skew_symmetry_defect, solve_mass,
};
use nalgebra::{SMatrix, SVector};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::LabError;
use crate::input::{integrator, not_negative, number, positive, vector};

/// A model of two or three coordinates: M(q) q̈ + C q̇ + g + b = u. **(PRM 10.7)**
#[wasm_bindgen]
#[derive(Clone, Copy, Debug)]
pub struct ClosedForm {
    kind: Kind,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    Reach2R(Reach2R),
    Reach3R(PlanarArm<3>),
    RpArm(RpArm),
    PolarMass(PolarMass),
    PlanarBody(PlanarBody),
}

/// The operations of a model. Integrators and other algorithms are compiled once for each number of
/// coordinates instead of once for each model, which keeps the page's download small.
#[derive(Clone, Copy)]
enum System<'a> {
    Two(&'a dyn Dynamics<2>),
    Three(&'a dyn Dynamics<3>),
}

impl ClosedForm {
    fn system(&self) -> System<'_> {
        match &self.kind {
            Kind::Reach2R(system) => System::Two(system),
            Kind::Reach3R(system) => System::Three(system),
            Kind::RpArm(system) => System::Two(system),
            Kind::PolarMass(system) => System::Two(system),
            Kind::PlanarBody(system) => System::Three(system),
        }
    }
}

/// Evaluates the same expression for two and for three coordinates.
macro_rules! on {
    ($self:expr, $system:ident => $result:expr) => {
        match $self.system() {
            System::Two($system) => $result,
            System::Three($system) => $result,
        }
    };
}

/// Evaluates the same expression on the model's own type, for formulas over other numbers than f64.
macro_rules! on_model {
    ($self:expr, $model:ident => $result:expr) => {
        match &$self.kind {
            Kind::Reach2R($model) => $result,
            Kind::Reach3R($model) => $result,
            Kind::RpArm($model) => $result,
            Kind::PolarMass($model) => $result,
            Kind::PlanarBody($model) => $result,
        }
    };
}

#[wasm_bindgen]
impl ClosedForm {
    /// Two uniform rods: lengths \[m\], masses \[kg\], gravity \[m/s²\].
    ///
    /// # Errors
    /// Fails if a length or mass is not positive, or a number is not finite.
    #[wasm_bindgen(js_name = reach2R)]
    pub fn reach_2r(l1: f64, m1: f64, l2: f64, m2: f64, a_g: f64) -> Result<Self, LabError> {
        Ok(Self { kind: Kind::Reach2R(two_rods(l1, m1, l2, m2, a_g)?) })
    }

    /// The three rods of [`PlanarArm::reach_3r`].
    #[wasm_bindgen(js_name = reach3R)]
    pub fn reach_3r() -> Self {
        Self { kind: Kind::Reach3R(PlanarArm::reach_3r()) }
    }

    /// A revolute and a prismatic link.
    ///
    /// # Errors
    /// Fails if a mass is not positive, an inertia negative, or a number not finite.
    #[wasm_bindgen(js_name = rpArm)]
    pub fn rp_arm(r1: f64, m1: f64, i1: f64, m2: f64, i2: f64, a_g: f64) -> Result<Self, LabError> {
        Ok(Self {
            kind: Kind::RpArm(RpArm {
                r1: number("r1", r1)?,
                m1: positive("m1", m1)?,
                i1: not_negative("i1", i1)?,
                m2: positive("m2", m2)?,
                i2: not_negative("i2", i2)?,
                a_g: number("gravity", a_g)?,
            }),
        })
    }

    /// A point mass in polar coordinates.
    ///
    /// # Errors
    /// Fails if the mass is not positive or gravity not finite.
    #[wasm_bindgen(js_name = polarMass)]
    pub fn polar_mass(m: f64, a_g: f64) -> Result<Self, LabError> {
        Ok(Self { kind: Kind::PolarMass(PolarMass { m: positive("m", m)?, a_g: number("gravity", a_g)? }) })
    }

    /// A free body in the plane.
    ///
    /// # Errors
    /// Fails if the mass or the inertia is not positive, or gravity not finite.
    #[wasm_bindgen(js_name = planarBody)]
    pub fn planar_body(m: f64, i_zz: f64, a_g: f64) -> Result<Self, LabError> {
        Ok(Self {
            kind: Kind::PlanarBody(PlanarBody {
                m: positive("m", m)?,
                i_zz: positive("I", i_zz)?,
                a_g: number("gravity", a_g)?,
            }),
        })
    }

    /// M(q), in row-major order.
    ///
    /// # Errors
    /// Fails if q has the wrong length or is not finite, like every method below.
    pub fn mass(&self, q: &[f64]) -> Result<Vec<f64>, LabError> {
        on!(self, s => Ok(rows(&s.mass(&vector("q", q)?))))
    }

    /// C(q,q̇) q̇.
    ///
    /// # Errors
    /// Fails as [`mass`](Self::mass) does.
    #[wasm_bindgen(js_name = velocityProduct)]
    pub fn velocity_product(&self, q: &[f64], qd: &[f64]) -> Result<Vec<f64>, LabError> {
        on!(self, s => Ok(list(&s.velocity_product(&vector("q", q)?, &vector("qd", qd)?))))
    }

    /// g(q) = ∂V/∂q.
    ///
    /// # Errors
    /// Fails as [`mass`](Self::mass) does.
    pub fn gravity(&self, q: &[f64]) -> Result<Vec<f64>, LabError> {
        on!(self, s => Ok(list(&s.gravity(&vector("q", q)?))))
    }

    /// V(q) \[J\].
    ///
    /// # Errors
    /// Fails as [`mass`](Self::mass) does.
    #[wasm_bindgen(js_name = potentialEnergy)]
    pub fn potential_energy(&self, q: &[f64]) -> Result<f64, LabError> {
        on!(self, s => Ok(s.potential_energy(&vector("q", q)?)))
    }

    /// K = ½ q̇ᵀM q̇ \[J\].
    ///
    /// # Errors
    /// Fails as [`mass`](Self::mass) does.
    #[wasm_bindgen(js_name = kineticEnergy)]
    pub fn kinetic_energy(&self, q: &[f64], qd: &[f64]) -> Result<f64, LabError> {
        on!(self, s => Ok(s.kinetic_energy(&vector("q", q)?, &vector("qd", qd)?)))
    }

    /// q̈ = M⁻¹(u − C q̇ − g − b).
    ///
    /// # Errors
    /// Fails as [`mass`](Self::mass) does, or if M is singular.
    pub fn forward(&self, q: &[f64], qd: &[f64], u: &[f64]) -> Result<Vec<f64>, LabError> {
        on!(self, s => {
            Ok(list(&s.try_forward(&vector("q", q)?, &vector("qd", qd)?, &vector("u", u)?)?))
        })
    }

    /// u = M q̈ + C q̇ + g + b.
    ///
    /// # Errors
    /// Fails as [`mass`](Self::mass) does.
    pub fn inverse(&self, q: &[f64], qd: &[f64], qdd: &[f64]) -> Result<Vec<f64>, LabError> {
        on!(self, s => Ok(list(&s.inverse(&vector("q", q)?, &vector("qd", qd)?, &vector("qdd", qdd)?))))
    }

    /// Γⁱⱼₖ, exact, with i as the slowest index. **(PRM 10.9)**
    ///
    /// # Errors
    /// Fails as [`mass`](Self::mass) does.
    pub fn christoffel(&self, q: &[f64]) -> Result<Vec<f64>, LabError> {
        on_model!(self, s => Ok(symbols(&christoffel(s, &vector("q", q)?))))
    }

    /// Γⁱⱼₖ by central differences of M with this step.
    ///
    /// # Errors
    /// Fails as [`mass`](Self::mass) does, or if the step is not positive.
    #[wasm_bindgen(js_name = christoffelByDifferences)]
    pub fn christoffel_by_differences(&self, q: &[f64], step: f64) -> Result<Vec<f64>, LabError> {
        let step = positive("the difference step", step)?;
        on!(self, s => Ok(symbols(&christoffel_by_differences(|q| s.mass(q), &vector("q", q)?, step))))
    }

    /// max |(Ṁ−2C) + (Ṁ−2C)ᵀ|.
    ///
    /// # Errors
    /// Fails as [`mass`](Self::mass) does.
    #[wasm_bindgen(js_name = skewSymmetryDefect)]
    pub fn skew_symmetry_defect(&self, q: &[f64], qd: &[f64]) -> Result<f64, LabError> {
        on_model!(self, s => {
            let (q, qd) = (vector("q", q)?, vector("qd", qd)?);
            Ok(skew_symmetry_defect(&mass_rate(s, &q, &qd), &christoffel(s, &q).coriolis_matrix(&qd)))
        })
    }

    /// Whether M(q) is positive definite, by a Cholesky factorisation.
    ///
    /// # Errors
    /// Fails as [`mass`](Self::mass) does.
    #[wasm_bindgen(js_name = massIsPositiveDefinite)]
    pub fn mass_is_positive_definite(&self, q: &[f64]) -> Result<bool, LabError> {
        on!(self, s => {
            let q = vector("q", q)?;
            Ok(solve_mass(&s.mass(&q), &(q * 0.0)).is_ok())
        })
    }

    /// The inertia ellipse q̇ᵀM q̇ = 1: the semi-axes, longest first, then their unit directions.
    ///
    /// # Errors
    /// Fails as [`mass`](Self::mass) does, or if M is singular.
    #[wasm_bindgen(js_name = inertiaEllipse)]
    pub fn inertia_ellipse(&self, q: &[f64]) -> Result<Vec<f64>, LabError> {
        on!(self, s => {
            let ellipse = InertiaEllipse::new(&s.mass(&vector("q", q)?))?;
            Ok(ellipse.semi_axes.iter().chain(ellipse.directions.iter()).copied().collect())
        })
    }

    /// (q, q̇) after one step of `h` \[s\] of the named integrator with constant u.
    ///
    /// # Errors
    /// Fails as [`mass`](Self::mass) does, or if the integrator fails.
    pub fn step(&self, name: &str, q: &[f64], qd: &[f64], u: &[f64], h: f64) -> Result<Vec<f64>, LabError> {
        let (row, h) = (integrator(name)?, positive("the step", h)?);
        on!(self, s => {
            let (q, qd) = row.step(s, &vector("q", q)?, &vector("qd", qd)?, &vector("u", u)?, h)?;
            Ok(q.iter().chain(qd.iter()).copied().collect())
        })
    }

    /// max |E − E₀|/|E₀| over `steps` steps of `h` \[s\] from (q, q̇), u = 0.
    ///
    /// # Errors
    /// Fails as [`step`](Self::step) does.
    #[wasm_bindgen(js_name = energyDrift)]
    pub fn energy_drift(
        &self,
        name: &str,
        q: &[f64],
        qd: &[f64],
        h: f64,
        steps: u32,
    ) -> Result<f64, LabError> {
        let (row, h) = (integrator(name)?, positive("the step", h)?);
        on!(self, s => {
            let (q, qd) = (vector("q", q)?, vector("qd", qd)?);
            Ok(energy_drift(s, &q, &qd, &(q * 0.0), h, steps as usize, row)?)
        })
    }
}

/// Two uniform rods with checked parameters.
pub(crate) fn two_rods(l1: f64, m1: f64, l2: f64, m2: f64, a_g: f64) -> Result<Reach2R, LabError> {
    let (l1, m1) = (positive("length 1", l1)?, positive("mass 1", m1)?);
    let (l2, m2) = (positive("length 2", l2)?, positive("mass 2", m2)?);
    Ok(Reach2R::uniform(l1, m1, l2, m2, number("gravity", a_g)?))
}

/// The elbow and the tip of a two-link arm: x, y, x, y \[m\].
pub(crate) fn elbow_and_tip(arm: &Reach2R, q: &SVector<f64, 2>) -> [f64; 4] {
    let q = q.data.0[0];
    let ([ex, ey], [tx, ty]) = (arm.point_over(&q, 0, [arm.l1, 0.0]), arm.point_over(&q, 1, [arm.l2, 0.0]));
    [ex, ey, tx, ty]
}

fn list<const N: usize>(vector: &SVector<f64, N>) -> Vec<f64> {
    vector.as_slice().to_vec()
}

/// The entries in row-major order; nalgebra stores columns.
fn rows<const N: usize>(matrix: &SMatrix<f64, N, N>) -> Vec<f64> {
    matrix.transpose().as_slice().to_vec()
}

fn symbols<const N: usize>(table: &Christoffel<N>) -> Vec<f64> {
    let index = || 0..N;
    index()
        .flat_map(|i| index().flat_map(move |j| index().map(move |k| (i, j, k))))
        .map(|(i, j, k)| table.get(i, j, k))
        .collect()
}
