//! Every law on every model: one line per model, see `dynamics::laws`.

use dynamics::laws::{self, States};
use dynamics::{Dynamics, FromLagrangian, Link, PlanarArm, PlanarBody, PolarMass, Reach2R, RpArm};
use nalgebra::{SMatrix, SVector, matrix, vector};

#[test]
fn reach_2r() {
    laws::check_all("Reach2R", &Reach2R::worked_example(), &States::new(1)).unwrap();
}

#[test]
fn reach_3r() {
    laws::check_all("Reach3R", &PlanarArm::reach_3r(), &States::new(2)).unwrap();
}

/// Links whose centres of mass and inertias differ from those of rods.
#[test]
fn planar_arm_of_five_links() {
    let link = |length, centre, mass, inertia| Link { length, centre, mass, inertia };
    let links = [
        link(0.7, 0.2, 3.0, 0.30),
        link(0.5, 0.6, 1.0, 0.02),
        link(0.1, -0.1, 2.0, 0.05),
        link(0.4, 0.1, 0.5, 0.01),
        link(0.3, 0.3, 0.2, 0.03),
    ];
    laws::check_all("PlanarArm<5>", &PlanarArm { links, a_g: 9.81 }, &States::new(3)).unwrap();
}

/// Twelve links: κ(M) reaches 5·10⁴, and the tolerances of the laws grow with it and with N.
#[test]
fn planar_arm_of_twelve_links() {
    let arm = PlanarArm { links: [Link::rod(0.5, 1.0); 12], a_g: 9.81 };
    laws::check_all("PlanarArm<12>", &arm, &States::new(13)).unwrap();
}

/// An outer link of a milligram: κ(M) is 2·10⁸, and the laws hold to its condition number.
#[test]
fn reach_2r_with_tiny_outer_link() {
    let arm = Reach2R::uniform(1.0, 2.0, 0.1, 1e-6, 9.81);
    laws::check_all("Reach2R, light", &arm, &States::new(14)).unwrap();
}

#[test]
fn rp_arm() {
    let arm = RpArm { r1: 0.4, m1: 2.0, i1: 0.1, m2: 1.5, i2: 0.05, a_g: 9.81 };
    laws::check_all("RpArm", &arm, &States::new(4)).unwrap();
}

/// r stays away from 0, where the direction of the mass is undefined.
#[test]
fn polar_mass() {
    let states = States::new(5).within(vector![0.1, -3.0], vector![3.0, 3.0]);
    laws::check_all("PolarMass", &PolarMass { m: 2.0, a_g: 9.81 }, &states).unwrap();
}

#[test]
fn planar_body() {
    laws::check_all("PlanarBody", &PlanarBody { m: 3.0, i_zz: 0.2, a_g: 9.81 }, &States::new(6)).unwrap();
}

#[test]
fn from_lagrangian() {
    let arm = FromLagrangian(Reach2R::worked_example());
    laws::check_all("FromLagrangian<Reach2R>", &arm, &States::new(7)).unwrap();
}

/// Linear damping; the laws with b must hold for b ≠ 0.
#[test]
fn damped_arm() {
    let damped = Altered { damping: 0.3, ..Altered::NOTHING };
    laws::check("damped Reach2R", &damped, &States::new(8)).unwrap();
}

/// `check` accepts a trait object, for a robot chosen at run time.
#[test]
fn trait_object_of_dynamics() {
    let arm: Box<dyn Dynamics<3>> = Box::new(PlanarArm::reach_3r());
    laws::check("dyn Reach3R", &*arm, &States::new(9)).unwrap();
}

/// The 2R arm with altered terms: each mistake violates the law that detects it.
#[derive(Clone, Copy)]
struct Altered {
    gravity: f64,
    coriolis: f64,
    asymmetry: f64,
    inertia: f64,
    damping: f64,
    kinetic: f64,
    shift: f64,
}

impl Altered {
    /// The unaltered arm.
    const NOTHING: Self = Self {
        gravity: 1.0,
        coriolis: 1.0,
        asymmetry: 0.0,
        inertia: 1.0,
        damping: 0.0,
        kinetic: 1.0,
        shift: 0.0,
    };

    fn arm() -> Reach2R {
        Reach2R::worked_example()
    }
}

impl Dynamics<2> for Altered {
    fn mass(&self, q: &SVector<f64, 2>) -> SMatrix<f64, 2, 2> {
        let mut mass = Self::arm().mass(q) * self.inertia;
        mass[(0, 1)] += self.asymmetry;
        mass
    }
    fn velocity_product(&self, q: &SVector<f64, 2>, qd: &SVector<f64, 2>) -> SVector<f64, 2> {
        Self::arm().velocity_product(q, qd) * self.coriolis
    }
    fn gravity(&self, q: &SVector<f64, 2>) -> SVector<f64, 2> {
        Self::arm().gravity(q) * self.gravity
    }
    fn potential_energy(&self, q: &SVector<f64, 2>) -> f64 {
        Self::arm().potential_energy(q)
    }
    fn dissipation(&self, _: &SVector<f64, 2>, qd: &SVector<f64, 2>) -> SVector<f64, 2> {
        qd * self.damping
    }
    fn kinetic_energy(&self, q: &SVector<f64, 2>, qd: &SVector<f64, 2>) -> f64 {
        0.5 * qd.dot(&(self.mass(q) * qd)) * self.kinetic
    }
    /// C + S, with S q̇ = 0.
    fn coriolis_matrix(&self, q: &SVector<f64, 2>, qd: &SVector<f64, 2>) -> SMatrix<f64, 2, 2> {
        let nothing = matrix![qd[1], -qd[0]; 0.5 * qd[1], -0.5 * qd[0]] * self.shift;
        Self::arm().christoffel(q).coriolis_matrix(qd) * self.coriolis + nothing
    }
}

#[test]
fn every_mistake_violates_its_law() {
    let right = Altered::NOTHING;
    laws::check("unaltered", &right, &States::new(11)).unwrap();
    let mistakes = [
        (Altered { asymmetry: 1e-13, ..right }, "M = Mᵀ"),
        (Altered { inertia: -1.0, ..right }, "M is positive definite"),
        (Altered { inertia: f64::NAN, ..right }, "M is finite"),
        (Altered { asymmetry: f64::NAN, ..right }, "M is finite"),
        (Altered { gravity: f64::NAN, ..right }, "inverse(eⱼ) − inverse(0) = M eⱼ"),
        (Altered { kinetic: 1.0 + 1e-12, ..right }, "K = ½ q̇ᵀM q̇"),
        (Altered { damping: -1e-6, ..right }, "b·q̇ ≥ 0"),
        (Altered { gravity: 1.0 + 1e-10, ..right }, "g = ∂V/∂q, by differences"),
        (Altered { coriolis: 1.0 + 1e-10, ..right }, "C q̇ = Ṁ q̇ − ½ ∂(q̇ᵀM q̇)/∂q, by differences"),
        (Altered { coriolis: 0.0, ..right }, "C q̇ = Ṁ q̇ − ½ ∂(q̇ᵀM q̇)/∂q, by differences"),
        (Altered { shift: 1e-9, ..right }, "Ṁ − 2C is skew-symmetric, by differences"),
    ];
    for (mistake, law) in mistakes {
        let violation = laws::check("altered", &mistake, &States::new(11)).unwrap_err();
        assert_eq!(violation.law, law, "{violation}");
    }
}

/// A violation names the law, the model, the state and the defect.
#[test]
fn violation_names_law_and_state() {
    let upside_down = Altered { gravity: -1.0, ..Altered::NOTHING };
    let violation = laws::check("upside down", &upside_down, &States::new(12)).unwrap_err();
    assert_eq!((violation.seed, violation.index, violation.state.len()), (12, 0, 2));
    assert!(violation.found > violation.allowed);
    let text = violation.to_string();
    for part in ["upside down breaks \"g = ∂V/∂q, by differences\": found ", "state 0 of seed 12: q = ["]
    {
        assert!(text.contains(part), "{text}");
    }
}
