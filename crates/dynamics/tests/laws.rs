//! Every law on every model: one line per model, see `dynamics::laws`.

use dynamics::laws::{self, States};
use dynamics::{FromLagrangian, Link, PlanarArm, PlanarBody, PolarMass, Reach2R, RpArm};
use nalgebra::vector;

#[test]
fn reach_2r() {
    laws::check_all("Reach2R", &Reach2R::worked_example(), &States::new(1)).unwrap();
}

#[test]
fn reach_3r() {
    laws::check_all("Reach3R", &PlanarArm::reach_3r(), &States::new(2)).unwrap();
}

/// Links whose centres of mass and inertias are those of no rod.
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

#[test]
fn rp_arm() {
    let arm = RpArm { r1: 0.4, m1: 2.0, i1: 0.1, m2: 1.5, i2: 0.05, a_g: 9.81 };
    laws::check_all("RpArm", &arm, &States::new(4)).unwrap();
}

/// r stays away from 0, where the direction of the mass is not defined.
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
