//! The closed forms of the models against independent derivations, and their known properties.

use std::f64::consts::{FRAC_PI_2, PI};

use dynamics::laws::States;
use dynamics::{
    BodyJacobian, Christoffel, Dynamics, Lagrangian, Link, PlanarArm, PlanarBody, PlanarKinematics,
    PolarMass, Reach2R, RpArm, christoffel, christoffel_by_differences, generalized_force,
    gravity_from_bodies, mass_from_bodies, mass_rate, potential_from_bodies, rk4_step, skew_symmetry_defect,
};
use nalgebra::{SMatrix, SVector, Vector2, matrix, vector};
use proptest::prelude::*;
use robot_dynamics_integrators::IntegratorError;
use robot_dynamics_number::{Dual, Scalar};

const RP: RpArm = RpArm { r1: 0.4, m1: 2.0, i1: 0.1, m2: 1.5, i2: 0.05, a_g: 9.81 };

/// M ≻ 0 at 1000 seeded configurations: every pivot of its Cholesky factor exists.
#[test]
fn reach_3r_mass_is_positive_definite() {
    let arm = PlanarArm::reach_3r();
    for state in States::<3>::new(30).count(1000).iter() {
        let mass = arm.mass(&state.q);
        assert!(mass.cholesky().is_some(), "state {} of seed 30: {}", state.index, state.q);
        assert_eq!(mass, mass.transpose());
    }
}

/// Ṁ − 2C by differenced symbols (1e-6) and by exact ones (1e-12); Ṁ uses neither.
#[test]
fn reach_3r_skew_symmetry() {
    let arm = PlanarArm::reach_3r();
    for state in States::<3>::new(31).count(1000).iter() {
        let rate = mass_rate(&arm, &state.q, &state.qd);
        let differenced = christoffel_by_differences(|q| arm.mass(q), &state.q, 1e-6);
        let by_differences = skew_symmetry_defect(&rate, &differenced.coriolis_matrix(&state.qd));
        let exact = skew_symmetry_defect(&rate, &christoffel(&arm, &state.q).coriolis_matrix(&state.qd));
        assert!(by_differences < 1e-6 && exact < 1e-12, "{by_differences:e} {exact:e} at {state:?}");
    }
}

/// inverse(forward(τ)) = τ to 1e-9.
#[test]
fn reach_3r_inverse_undoes_forward() {
    let arm = PlanarArm::reach_3r();
    for state in States::<3>::new(32).count(1000).iter() {
        let qdd = arm.forward(&state.q, &state.qd, &state.u);
        let defect = (arm.inverse(&state.q, &state.qd, &qdd) - state.u).norm();
        assert!(defect < 1e-9, "{defect:e} at {state:?}");
    }
}

/// The recipe with two links equals the closed form of the 2R arm, in every term.
#[test]
fn planar_arm_of_two_links_matches_reach_2r() {
    let closed = Reach2R { r1: 0.3, i2: 0.2, ..Reach2R::uniform(0.8, 2.0, 0.6, 1.0, 9.81) };
    let recipe = PlanarArm::from(closed);
    for state in States::<2>::new(33).iter() {
        let (q, qd) = (&state.q, &state.qd);
        // 16 roundings of terms up to 30 J, 10 N·m and 4 kg·m²: 1e-13.
        assert!((closed.mass(q) - recipe.mass(q)).norm() < 1e-13, "{state:?}");
        assert!((closed.gravity(q) - recipe.gravity(q)).norm() < 1e-13, "{state:?}");
        assert!(
            (closed.velocity_product(q, qd) - recipe.velocity_product(q, qd)).norm() < 1e-13,
            "{state:?}"
        );
        assert!((closed.potential_energy(q) - recipe.potential_energy(q)).abs() < 1e-13, "{state:?}");
        assert!(closed.christoffel(q).max_difference(&christoffel(&recipe, q)) < 1e-13, "{state:?}");
    }
}

/// C q̇ = Σ m J_cᵀ J̇_c q̇ by Newton: the centripetal accelerations of the links, without Christoffel
/// symbols.
#[test]
fn planar_arm_velocity_product_is_centripetal() {
    let arm = PlanarArm::reach_3r();
    for state in States::<3>::new(34).iter() {
        let bodies: [BodyJacobian<f64, 3>; 3] = arm.bodies_over(&state.q.into());
        let (mut angle, mut omega) = (0.0, 0.0);
        let mut joint = Vector2::<f64>::zeros();
        let mut expected = SVector::<f64, 3>::zeros();
        for k in 0..3 {
            angle += state.q[k];
            omega += state.qd[k];
            // A point at distance r on a turning link accelerates by −r ω² towards the joint.
            let inward = vector![angle.cos(), angle.sin()] * -(omega * omega);
            let acceleration = joint + inward * arm.links[k].centre;
            joint += inward * arm.links[k].length;
            let [x, y] = bodies[k].centre.map(SVector::from);
            expected += (x * acceleration[0] + y * acceleration[1]) * arm.links[k].mass;
        }
        let defect = (arm.velocity_product(&state.q, &state.qd) - expected).norm();
        assert!(defect < 1e-13, "{defect:e} at {state:?}");
    }
}

/// The geometric Jacobians of the centres of mass are the derivatives of their positions.
#[test]
fn geometric_and_differentiated_jacobians_agree() {
    let arm = PlanarArm::reach_3r();
    for state in States::<3>::new(35).iter() {
        for (k, body) in arm.bodies_over(&state.q.into()).iter().enumerate() {
            let jacobian = arm.point_jacobian(&state.q, k, [arm.links[k].centre, 0.0]);
            let geometric = SMatrix::<f64, 2, 3>::from_fn(|i, j| body.centre[i][j]);
            assert!((jacobian - geometric).norm() < 1e-15, "link {k} at {state:?}");
        }
    }
}

/// The closed forms of the RP arm against the recipe: a turning link and one that slides along it.
#[test]
fn rp_arm_closed_forms() {
    for state in States::<2>::new(36).iter() {
        let [turn, slide] = Dual::<f64, 2>::variables(&state.q.into());
        let (sine, cosine) = turn.sin_cos();
        let radii = [Dual::constant(RP.r1), slide];
        let links = [(RP.m1, RP.i1), (RP.m2, RP.i2)];
        let bodies: [BodyJacobian<f64, 2>; 2] = core::array::from_fn(|k| BodyJacobian {
            mass: links[k].0,
            inertia: links[k].1,
            height: (radii[k] * sine).value,
            centre: [(radii[k] * cosine).gradient, (radii[k] * sine).gradient],
            rotation: turn.gradient,
        });
        let mass = mass_from_bodies(&bodies);
        let expected = SMatrix::<f64, 2, 2>::from_fn(|i, j| mass[i][j]);
        assert!((RP.mass(&state.q) - expected).norm() < 1e-13, "{state:?}");
        let gravity = SVector::from(gravity_from_bodies(&bodies, RP.a_g));
        assert!((RP.gravity(&state.q) - gravity).norm() < 1e-13, "{state:?}");
        let potential = potential_from_bodies(&bodies, RP.a_g);
        assert!((RP.potential_energy(&state.q) - potential).abs() < 1e-13, "{state:?}");
        assert_eq!(RP.christoffel(&state.q), christoffel(&RP, &state.q));
        let product = RP.christoffel(&state.q).velocity_product(&state.qd);
        assert!((RP.velocity_product(&state.q, &state.qd) - product).norm() < 1e-13, "{state:?}");
    }
    // m2 q2 = 1.5 · 0.8.
    let symbols = RP.christoffel(&vector![0.2, 0.8]);
    assert!((symbols.get(0, 0, 1) - 1.2).abs() < 1e-15 && (symbols.get(1, 0, 0) + 1.2).abs() < 1e-15);
}

/// 2 kg at 1.5 m: Γ²₁₂ = m r = 3, and the closed form is the exact derivative everywhere.
#[test]
fn polar_mass_closed_forms() {
    let mass = PolarMass { m: 2.0, a_g: 9.81 };
    assert_eq!(mass.christoffel(&vector![1.5, 0.3]).get(1, 0, 1), 3.0);
    assert_eq!(mass.christoffel(&vector![1.5, 0.3]).get(0, 1, 1), -3.0);
    for state in States::<2>::new(37).iter() {
        assert_eq!(mass.christoffel(&state.q), christoffel(&mass, &state.q));
        let product = mass.christoffel(&state.q).velocity_product(&state.qd);
        assert!((mass.velocity_product(&state.q, &state.qd) - product).norm() < 1e-13, "{state:?}");
    }
}

/// Without a force the point moves on a straight line at constant speed; with gravity, on a parabola.
#[test]
fn polar_mass_moves_in_a_straight_line() {
    for a_g in [0.0, 9.81] {
        let mass = PolarMass { m: 2.0, a_g };
        // From (1, 0) with velocity (−0.4, 0.7): passes the origin at a distance of 0.87 m.
        let (mut q, mut qd) = (vector![1.0, 0.0], vector![-0.4, 0.7]);
        let h = 1e-3;
        for step in 1..=1000 {
            (q, qd) = rk4_step(&mass, &q, &qd, &Vector2::zeros(), h).unwrap();
            let t = f64::from(step) * h;
            let expected = vector![1.0 - 0.4 * t, 0.7 * t - 0.5 * a_g * t * t];
            let found = vector![q[1].cos(), q[1].sin()] * q[0];
            // RK4 leaves h⁴ t/120 times fifth derivatives, which are 4! (|v|/r)⁵ < 10⁴ here: 1e-10.
            assert!((found - expected).norm() < 1e-10, "a_g {a_g}, t {t}: {found} {expected}");
        }
    }
}

/// At the origin the direction of a point mass has no inertia: coordinate 1.
#[test]
fn polar_mass_at_origin_is_singular() {
    let mass = PolarMass { m: 2.0, a_g: 0.0 };
    let error = mass.try_forward(&Vector2::zeros(), &Vector2::zeros(), &vector![1.0, 1.0]).unwrap_err();
    assert_eq!(error, IntegratorError::SingularMass { coordinate: 1, pivot: 0.0 });
}

/// Power: u·q̇ = f·ṗ for a force at any point of any link, and of a free body.
#[test]
fn forces_at_points_do_the_work_of_generalized_forces() {
    let arm = PlanarArm::reach_3r();
    let body = PlanarBody { m: 2.0, i_zz: 0.3, a_g: 9.81 };
    for state in States::<3>::new(38).iter() {
        let (force, point) = (vector![state.u[0], state.u[1]], [state.qdd[0], state.qdd[1]]);
        let step = 1e-6;
        let check = |map: SMatrix<f64, 3, 2>, position: &dyn Fn(&SVector<f64, 3>) -> [f64; 2]| {
            let [ahead, behind] = [step, -step].map(|s| SVector::from(position(&(state.q + state.qd * s))));
            // Central difference of the position: (step |q̇|)²/6 of a 20 m lever and ε/step, 1e-8 m/s.
            let velocity: Vector2<f64> = (ahead - behind) / (2.0 * step);
            let (power, expected) = (generalized_force(&map, &force).dot(&state.qd), force.dot(&velocity));
            assert!((power - expected).abs() < 1e-6, "{power} {expected} at {state:?}");
        };
        for link in 0..3 {
            check(arm.force_map(&state.q, link, point), &|q| arm.point_over(&(*q).into(), link, point));
        }
        let arm = Reach2R::worked_example();
        let tip = arm.point_over(&[state.q[0], state.q[1]], 1, [arm.l2, 0.0]);
        let (first, second) = (state.q[0].sin_cos(), (state.q[0] + state.q[1]).sin_cos());
        assert!((tip[0] - first.1 - second.1).abs() + (tip[1] - first.0 - second.0).abs() < 1e-15);
        check(body.force_map(&state.q, 0, point), &|q| body.point_over(&(*q).into(), 0, point));
    }
}

/// The arm held against its weight: the generalized force of gravity is Σ J_cᵀ (0, −m a_g) = −g.
#[test]
fn weights_at_the_centres_of_mass_are_gravity() {
    let arm = PlanarArm::reach_3r();
    for state in States::<3>::new(39).iter() {
        let mut u = SVector::<f64, 3>::zeros();
        for (k, link) in arm.links.iter().enumerate() {
            let map = arm.force_map(&state.q, k, [link.centre, 0.0]);
            u += generalized_force(&map, &vector![0.0, -link.mass * arm.a_g]);
        }
        assert!((u + arm.gravity(&state.q)).norm() < 1e-13, "{state:?}");
    }
}

/// Newton's law for a free body: a force off the centre of mass accelerates and rotates it.
#[test]
fn planar_body_obeys_newton() {
    let body = PlanarBody { m: 2.0, i_zz: 0.3, a_g: 9.81 };
    assert_eq!(body.mass(&SVector::zeros()), matrix![2.0, 0.0, 0.0; 0.0, 2.0, 0.0; 0.0, 0.0, 0.3]);
    for state in States::<3>::new(40).iter() {
        let force = vector![state.u[0], state.u[1]];
        let lever = vector![0.4, -0.1];
        let u = generalized_force(&body.force_map(&state.q, 0, lever.into()), &force);
        let (sine, cosine) = state.q[2].sin_cos();
        let arm = vector![cosine * lever[0] - sine * lever[1], sine * lever[0] + cosine * lever[1]];
        let torque = arm[0] * force[1] - arm[1] * force[0];
        let expected = vector![force[0] / 2.0, force[1] / 2.0 - 9.81, torque / 0.3];
        assert!((body.forward(&state.q, &state.qd, &u) - expected).norm() < 1e-12, "{state:?}");
    }
}

#[test]
#[should_panic(expected = "this arm has links 0 to 2, there is no link 3")]
fn missing_link_panics() {
    let _ = PlanarArm::reach_3r().point_jacobian(&SVector::zeros(), 3, [0.0, 0.0]);
}

/// C + S with S q̇ = 0 moves the arm in the same way, but Ṁ − 2(C+S) is not skew-symmetric.
#[test]
fn shifted_coriolis_matrix_is_not_skew() {
    let arm = Reach2R::worked_example();
    for state in States::<2>::new(41).iter().filter(|state| state.qd.norm() > 0.1) {
        let (q, qd, u) = (&state.q, &state.qd, &state.u);
        let c: SMatrix<f64, 2, 2> = arm.christoffel(q).coriolis_matrix(qd);
        // Rows orthogonal to q̇.
        let s = matrix![qd[1], -qd[0]; 0.5 * qd[1], -0.5 * qd[0]];
        let accelerate =
            |c: SMatrix<f64, 2, 2>| arm.mass(q).cholesky().unwrap().solve(&(u - c * qd - arm.gravity(q)));
        let expected = arm.forward(q, qd, u);
        // κ(M) ≤ 35 at any pose of this arm (stretched), forces up to 100 N·m: 35 · 100 · 20 ε < 1e-10.
        assert!((accelerate(c) - expected).norm() < 1e-10, "{state:?}");
        assert!((accelerate(c + s) - expected).norm() < 1e-10, "{state:?}");
        let rate = mass_rate(&arm, q, qd);
        assert!(skew_symmetry_defect(&rate, &c) < 1e-12, "{state:?}");
        // The defect of −2S: its largest entry is at least |q̇| times a constant.
        let defect = skew_symmetry_defect(&rate, &(c + s));
        assert!(defect > 0.5 * qd.norm(), "{defect} at {state:?}");
    }
}

/// A table of symbols returns its entries; its product is the double sum over j and k.
#[test]
fn christoffel_table_is_indexed_by_row_first() {
    let symbols = Christoffel::from_table([[[1.0, 2.0], [2.0, 3.0]], [[4.0, 5.0], [5.0, 6.0]]]);
    assert_eq!((symbols.get(0, 1, 1), symbols.get(1, 0, 0), symbols.get(1, 0, 1)), (3.0, 4.0, 5.0));
    // Row 0: 1·4 + 2·2·(2·3) + 3·9 = 55 for q̇ = (2, 3); row 1: 4·4 + 2·5·6 + 6·9 = 130.
    assert_eq!(symbols.velocity_product(&vector![2.0, 3.0]), vector![55.0, 130.0]);
}

/// Exact and differenced symbols of a Lagrangian that no model of the crate has: M depends on all of q.
#[test]
fn exact_symbols_match_differences_on_a_dense_mass_matrix() {
    struct Dense;
    impl Lagrangian<2> for Dense {
        fn mass_over<S: Scalar>(&self, q: &[S; 2]) -> [[S; 2]; 2] {
            let (sine, cosine) = (q[0] * q[1]).sin_cos();
            let off = sine * q[0] / (q[1] * q[1] + S::one());
            [[S::from_f64(4.0) + cosine, off], [off, (q[0] * q[0] + S::from_f64(3.0)).sqrt()]]
        }
        fn potential_over<S: Scalar>(&self, _: &[S; 2]) -> S {
            S::zero()
        }
    }
    for state in States::<2>::new(42).count(50).iter() {
        let mass = |q: &SVector<f64, 2>| {
            let mass = Dense.mass_over(&(*q).into());
            SMatrix::<f64, 2, 2>::from_fn(|i, j| mass[i][j])
        };
        let defect =
            christoffel(&Dense, &state.q).max_difference(&christoffel_by_differences(mass, &state.q, 1e-6));
        // Truncation: step² M‴/6 with M‴ up to π⁴; rounding: ε M/step. Together 1e-8.
        assert!(defect < 1e-8, "{defect:e} at {state:?}");
    }
}

/// On a horizontal table there is no moment about the base: the momentum (M q̇)₁ of joint 1 is conserved.
#[test]
fn angular_momentum_about_base_is_conserved_on_table() {
    let table = PlanarArm { a_g: 0.0, ..PlanarArm::reach_3r() };
    for state in States::<3>::new(43).count(20).iter() {
        let (mut q, mut qd) = (state.q, state.qd);
        let start = (table.mass(&q) * qd)[0];
        for _ in 0..1000 {
            (q, qd) = rk4_step(&table, &q, &qd, &SVector::zeros(), 1e-3).unwrap();
        }
        // RK4's error after 1 s at rates up to 20 rad/s: (20 h)⁵/120 per step, 3e-8 in all, times 1 kg·m².
        let defect = (table.mass(&q) * qd)[0] - start;
        assert!(defect.abs() < 1e-7, "{defect:e} kg·m²/s at {state:?}");
    }
}

/// A pendulum released θ₀ from the bottom returns after T = 4 K(sin(θ₀/2))/ω₀, ω₀² = m a_g r/(I + m r²).
///
/// K, the complete elliptic integral, is π/2 over the arithmetic–geometric mean of 1 and cos(θ₀/2).
#[test]
fn one_link_swings_with_exact_period() {
    let arm = PlanarArm { links: [Link { length: 1.0, centre: 0.4, mass: 1.3, inertia: 0.1 }], a_g: 9.81 };
    for amplitude in [0.1_f64, 1.0, 2.0, 3.0] {
        let (mut a, mut g) = (1.0_f64, (amplitude / 2.0).cos());
        for _ in 0..10 {
            (a, g) = (0.5 * (a + g), (a * g).sqrt());
        }
        let omega = (1.3 * 9.81 * 0.4 / (0.1 + 1.3 * 0.4 * 0.4_f64)).sqrt();
        let period = 2.0 * PI / (a * omega);
        let start = vector![amplitude - FRAC_PI_2];
        let (mut q, mut qd) = (start, SVector::<f64, 1>::zeros());
        let steps = 4000;
        for _ in 0..steps {
            (q, qd) = rk4_step(&arm, &q, &qd, &SVector::zeros(), period / f64::from(steps)).unwrap();
        }
        // RK4 with 4000 steps a swing and rates up to 2ω₀: below 1e-9; the rest is exact.
        assert!((q - start).norm() < 1e-9 && qd.norm() < 1e-8, "{amplitude}: {q} {qd}");
    }
}

proptest! {
    /// A rotation of the whole arm about its base changes neither M nor C q̇; they depend on the shape only.
    #[test]
    fn inertia_depends_on_shape_only(
        q in prop::array::uniform3(-PI..PI),
        qd in prop::array::uniform3(-3.0..3.0_f64),
        turn in -PI..PI,
    ) {
        let arm = PlanarArm::reach_3r();
        let (q, qd) = (SVector::from(q), SVector::from(qd));
        let turned = q + vector![turn, 0.0, 0.0];
        // Coordinates of up to 1.5 m and angles of up to 13 rad, each rounded: 1e-14 kg·m², 1e-12 N·m.
        prop_assert!((arm.mass(&q) - arm.mass(&turned)).norm() < 1e-13);
        prop_assert!((arm.velocity_product(&q, &qd) - arm.velocity_product(&turned, &qd)).norm() < 1e-12);
    }

    /// The mirror image of a motion is a motion: q → −q with V unchanged on a table, u → −u.
    #[test]
    fn mirrored_motions_are_motions(
        q in prop::array::uniform3(-PI..PI),
        qd in prop::array::uniform3(-3.0..3.0_f64),
        u in prop::array::uniform3(-10.0..10.0_f64),
    ) {
        let table = PlanarArm { a_g: 0.0, ..PlanarArm::reach_3r() };
        let (q, qd, u) = (SVector::from(q), SVector::from(qd), SVector::from(u));
        let (there, mirrored) = (table.forward(&q, &qd, &u), table.forward(&-q, &-qd, &-u));
        // sin and cos are exactly odd and even, and so is every operation after them.
        prop_assert_eq!(there, -mirrored);
    }
}
