//! Rotation of a rigid body: its inertia and its motion, against exact results.

use std::f64::consts::FRAC_PI_2;

use dynamics::{
    Attitude, FreeRotation, cayley_body_step, complete_elliptic_k, euler_body_step, euler_in_body,
    euler_in_principal_axes, euler_in_world, incomplete_elliptic_f, jacobi_sn_cn_dn,
};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use robot_dynamics_description::{
    InertiaError, MassProperties, RotationalInertia, parallel_axis, parallel_axis_planar,
};
use robot_dynamics_integrators::IntegratorError;

/// Nodes and weights of Gauss's three-point rule on [−1, 1]: exact for cubics.
const GAUSS3: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];

/// Mass, first moment and inertia about the origin of a list of (mass, position): PRM 10.42 as a sum.
fn moments_of(points: &[(f64, Vector3<f64>)]) -> (f64, Vector3<f64>, Matrix3<f64>) {
    points.iter().fold((0.0, Vector3::zeros(), Matrix3::zeros()), |(m, s, i), &(dm, r)| {
        (m + dm, s + r * dm, i + (Matrix3::identity() * r.norm_squared() - r * r.transpose()) * dm)
    })
}

/// (dm, r) of a density 1 over [−1,1]³ mapped by `place` with volume element `jacobian`, on `n`³ cells.
fn sample(
    n: usize,
    place: impl Fn(f64, f64, f64) -> Vector3<f64>,
    jacobian: impl Fn(f64, f64, f64) -> f64,
) -> Vec<(f64, Vector3<f64>)> {
    let line: Vec<(f64, f64)> = (0..n)
        .flat_map(|k| {
            let center = (2.0 * k as f64 + 1.0) / n as f64 - 1.0;
            GAUSS3.map(|(x, w)| (center + x / n as f64, w / n as f64))
        })
        .collect();
    let mut points = Vec::new();
    for &(x, wx) in &line {
        for &(y, wy) in &line {
            for &(z, wz) in &line {
                points.push((wx * wy * wz * jacobian(x, y, z), place(x, y, z)));
            }
        }
    }
    points
}

/// Each closed form against the volume integral (PRM 10.42), by Gauss's rule in suitable coordinates.
#[test]
fn shapes_match_volume_integral() {
    use std::f64::consts::PI;
    let (a, b, c) = (0.4, 1.1, 0.7);
    let boxed = sample(1, |x, y, z| Vector3::new(a * x, b * y, c * z) / 2.0, |_, _, _| a * b * c / 8.0);
    // Polar coordinates: radius s = (x+1)/2, angle φ = π(y+1).
    let cylinder = sample(
        12,
        |x, y, z| {
            let (s, phi) = (b * (x + 1.0) / 2.0, PI * (y + 1.0));
            Vector3::new(s * phi.cos(), s * phi.sin(), c * z / 2.0)
        },
        |x, _, _| (b * (x + 1.0) / 2.0) * (b / 2.0) * PI * (c / 2.0),
    );
    // Spherical coordinates stretched by the semi-axes: height ζ = z on the unit sphere.
    let ellipsoid = sample(
        12,
        |x, y, z| {
            let (s, phi, ring) = (0.5 * (x + 1.0), PI * (y + 1.0), (1.0 - z * z).sqrt());
            Vector3::new(a * s * ring * phi.cos(), b * s * ring * phi.sin(), c * s * z)
        },
        |x, _, _| a * b * c * (0.5 * (x + 1.0)).powi(2) / 2.0 * PI,
    );
    let density = 7.0;
    let cases = [
        ("box", MassProperties::solid_box(density, Vector3::new(a, b, c)).unwrap(), boxed),
        ("cylinder", MassProperties::solid_cylinder(density, b, c).unwrap(), cylinder),
        ("ellipsoid", MassProperties::solid_ellipsoid(density, Vector3::new(a, b, c)).unwrap(), ellipsoid),
    ];
    for (name, body, points) in cases {
        let (m, s, i) = moments_of(&points);
        // The integrands are polynomials of degree ≤ 4 in the lengths times sin², cos² on 36 nodes a turn.
        // Gauss's error (6th derivative, 12 cells) is below 1e-9 of the value.
        assert!((body.mass() / density - m).abs() < 1e-8 * m, "{name}: mass");
        assert!((body.center_of_mass() - s / m).norm() < 1e-8, "{name}: centre of mass");
        let miss = (body.inertia_about_center_of_mass() / density - i).amax();
        assert!(miss < 1e-8 * i.amax(), "{name}: inertia misses the integral by {miss:e}");
    }
}

/// The composite 𝓘 = Σ R(𝓘 + m(|r|²1 − r rᵀ))Rᵀ and the sum over points agree on a body of random point
/// masses.
#[test]
fn composite_and_parallel_axis_match_sum_over_points() {
    let dust: Vec<(f64, Vector3<f64>)> = (1..=7)
        .map(|k| {
            let t = f64::from(k);
            (0.3 + 0.1 * t, Vector3::new((1.3 * t).sin(), (0.7 * t).cos(), (2.1 * t).sin() + 0.2 * t))
        })
        .collect();
    let (m, s, about_origin) = moments_of(&dust);
    let body = MassProperties::point_masses(&dust).unwrap();
    assert!((body.mass() - m).abs() < 1e-14 && (body.center_of_mass() - s / m).norm() < 1e-14);
    assert!((body.inertia_about_origin() - about_origin).amax() < 1e-13);

    // Moved as a whole, or point by point.
    let (turn, shift) = (Rotation3::from_euler_angles(0.4, -1.1, 2.0), Vector3::new(0.5, -2.0, 1.0));
    let moved: Vec<_> = dust.iter().map(|&(m, r)| (m, turn * r + shift)).collect();
    let (seen, rebuilt) = (body.transformed(&turn, &shift), MassProperties::point_masses(&moved).unwrap());
    assert!((seen.center_of_mass() - rebuilt.center_of_mass()).norm() < 1e-14);
    assert!((seen.inertia_about_origin() - moments_of(&moved).2).amax() < 1e-12);

    // The composite of two halves is the whole; the planar theorem is the z row of the spatial one.
    let halves = [&dust[..3], &dust[3..]].map(|half| MassProperties::point_masses(half).unwrap());
    let whole = MassProperties::composite(&halves).unwrap();
    assert!((whole.inertia_about_origin() - about_origin).amax() < 1e-13);
    let offset = Vector3::new(0.3, -0.4, 9.0);
    let spatial = parallel_axis(&body.inertia_about_center_of_mass(), m, &offset)[(2, 2)];
    let planar = parallel_axis_planar(body.inertia_about_center_of_mass()[(2, 2)], m, 0.5);
    assert!((spatial - planar).abs() < 1e-13);

    // Principal axes reproduce the matrix and are right-handed.
    let principal = seen.principal();
    let r = principal.body_from_principal.matrix();
    let rebuilt = r * Matrix3::from_diagonal(&principal.moments) * r.transpose();
    assert!((rebuilt - seen.inertia_about_center_of_mass()).amax() < 1e-13);
    assert!((r.determinant() - 1.0).abs() < 1e-14);
    assert!(principal.moments[0] <= principal.moments[1] && principal.moments[1] <= principal.moments[2]);
}

/// Inertias that no mass distribution has are errors that name the violated law.
#[test]
fn impossible_inertia_is_an_error() {
    let origin = Vector3::zeros();
    let build = |mass: f64, moments: [f64; 3]| {
        MassProperties::new(mass, origin, Matrix3::from_diagonal(&Vector3::from(moments)))
    };
    let input = |mass: f64, moments: [f64; 3]| match build(mass, moments) {
        Err(InertiaError::Input(input)) => input.quantity,
        other => panic!("{other:?}"),
    };
    assert_eq!([input(0.0, [1.0; 3]), input(-1.0, [1.0; 3])], ["the mass", "the mass"]);
    assert_eq!(input(f64::NAN, [1.0; 3]), "mass[0]");
    assert_eq!(input(1.0, [1.0, f64::INFINITY, 1.0]), "inertia[4]");
    assert!(matches!(build(1.0, [-0.1, 1.0, 1.0]), Err(InertiaError::NegativeMoment { .. })));
    assert!(matches!(build(1.0, [1.0, 3.0, 1.0]), Err(InertiaError::TriangleInequality { .. })));
    assert!(matches!(build(1.0, [1.0, 2.001, 1.0]), Err(InertiaError::TriangleInequality { .. })));
    // A thin plate, a thin rod and a point are on the boundary and valid. So is a plate rounded to 7 digits.
    for moments in [[1.0, 2.0, 3.0], [0.0, 1.0, 1.0], [0.0; 3], [0.3333333, 0.3333333, 0.6666667]] {
        build(1.0, moments).unwrap();
    }
    let mut skewed = Matrix3::identity();
    skewed[(0, 2)] = 0.1;
    let error = MassProperties::new(1.0, origin, skewed).unwrap_err();
    assert_eq!(error, InertiaError::NotSymmetric { row: 0, column: 2, upper: 0.1, lower: 0.0 });
    assert!(error.to_string().contains("(0, 2) is 0.1"));
    assert!(MassProperties::composite(&[]).is_err());
    assert!(MassProperties::solid_box(1000.0, Vector3::new(1.0, 0.0, 1.0)).is_err());
    assert!(MassProperties::solid_cylinder(1000.0, -0.1, 1.0).is_err());
    assert!(MassProperties::solid_sphere(f64::NAN, 0.1).is_err());
}

/// A step of either method.
type Step = fn(
    &UnitQuaternion<f64>,
    &Vector3<f64>,
    &Vector3<f64>,
    &RotationalInertia,
    f64,
) -> Result<Attitude, IntegratorError>;

const STEPS: [(&str, Step, f64); 2] = [("RK4", euler_body_step, 4.0), ("Cayley", cayley_body_step, 2.0)];

/// A body whose principal axes are not its own axes, principal moments 1, 2, 2.7 kg·m².
fn tilted_body() -> RotationalInertia {
    let r = Rotation3::from_euler_angles(0.3, -0.7, 1.9);
    let moments = Matrix3::from_diagonal(&Vector3::new(2.0, 2.7, 1.0));
    RotationalInertia::new(r.matrix() * moments * r.matrix().transpose()).unwrap()
}

/// The chapter's brick: edges 0.3, 0.2, 0.1 m; moments ascending along x, y, z.
fn brick() -> RotationalInertia {
    MassProperties::solid_box(1000.0, Vector3::new(0.3, 0.2, 0.1)).unwrap().rotational().unwrap()
}

/// Spins in both regimes of the tilted body, near and far from the axes, and near the separatrix.
fn spins(body: &RotationalInertia) -> Vec<Vector3<f64>> {
    let axes = body.principal().body_from_principal;
    [
        [0.3, -0.5, 2.0],
        [-0.3, 0.5, -2.0],
        [2.0, 0.4, 0.3],
        [-2.0, -0.4, 0.3],
        [0.01, 1.5, -0.01],
        [1e-4, -1.5, 2e-4],
        [-0.6, 1.0, 0.9],
    ]
    .map(|w| axes * Vector3::from(w))
    .to_vec()
}

#[test]
fn jacobi_functions_satisfy_their_identities() {
    // A&S table 17.1: K(0.5); and the limits.
    assert!((complete_elliptic_k(0.5) - 1.854_074_677_301_372).abs() < 1e-15);
    assert_eq!(complete_elliptic_k(0.0), FRAC_PI_2);
    assert_eq!(complete_elliptic_k(1.0), f64::INFINITY);
    // A&S §16.4, example: sn(0.2|0.81) = 0.19762.
    assert!((jacobi_sn_cn_dn(0.2, 0.81).0 - 0.19762).abs() < 5e-6);
    for m in [0.0, 1e-12, 0.1, 0.5, 0.81, 0.99, 1.0 - 1e-9, 1.0] {
        let k = complete_elliptic_k(m);
        for j in -12..=12 {
            let (u, v) = (0.37 * f64::from(j), 0.61);
            let (s, c, d) = jacobi_sn_cn_dn(u, m);
            let (s2, c2, d2) = jacobi_sn_cn_dn(v, m);
            // Rounding of sine and cosine, and of the arguments up to |u| = 5.
            let tolerance = 1e-14;
            assert!((s * s + c * c - 1.0).abs() < tolerance, "m {m} u {u}");
            assert!((d * d + m * s * s - 1.0).abs() < tolerance, "m {m} u {u}");
            // The addition theorem relates values at different arguments.
            let sum = (s * c2 * d2 + s2 * c * d) / (1.0 - m * s * s * s2 * s2);
            assert!((jacobi_sn_cn_dn(u + v, m).0 - sum).abs() < tolerance, "m {m} u {u}: addition");
            // F inverts the amplitude. Close to the maximum of sn its inverse is ill-conditioned, so angles
            // end at 1.4 rad.
            let angle = 0.1166 * f64::from(j);
            let f = incomplete_elliptic_f(angle, m);
            assert!((jacobi_sn_cn_dn(f, m).0 - angle.sin()).abs() < tolerance, "m {m} angle {angle}: F");
        }
        if k.is_finite() {
            let half = jacobi_sn_cn_dn(k / 2.0, m).0;
            assert!((half - (1.0 + (1.0 - m).sqrt()).sqrt().recip()).abs() < 1e-14, "m {m}: sn(K/2)");
            // dF/dφ = 1/dn = 1/√(1−m) there, and π/2 is accurate to ε.
            let tolerance = 1e-14 * k + f64::EPSILON / (1.0 - m).sqrt();
            assert!((incomplete_elliptic_f(FRAC_PI_2, m) - k).abs() < tolerance, "m {m}: F(π/2) = K");
        }
    }
}

/// The closed form is checked without an integrator: it satisfies the initial state, Euler's equation and
/// Ṙ = Rω̂, and conserves K and the world's L.
#[test]
fn exact_motion_satisfies_its_equations() {
    let body = tilted_body();
    let start = UnitQuaternion::from_euler_angles(0.2, -0.4, 1.0);
    for spin in spins(&body) {
        let motion = FreeRotation::new(&body, &start, &spin);
        assert!((motion.omega_in_body(0.0) - spin).norm() < 1e-14, "{spin:?}");
        // angle_to is an arc cosine near 1: it has half the digits.
        assert!(motion.world_from_body(0.0).angle_to(&start) < 1e-7, "{spin:?}");
        let momentum = body.momentum_in_world(&start, &spin);
        for t in [-3.1, 0.0, 0.8, 7.7, 40.0] {
            let at = |dt: f64| motion.omega_in_body(t + dt);
            let (omega, r) = (at(0.0), motion.world_from_body(t));
            // Five-point differences of step 1 ms: error 1e-12·(rates of 2/s)⁵ plus rounding 1e-16·40/1e-3.
            let h = 1e-3;
            let slope = ((at(h) - at(-h)) * 8.0 - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
            let miss = slope - euler_in_body(&body, &omega, &Vector3::zeros());
            assert!(miss.norm() < 1e-10, "{spin:?} t {t}: Euler's equation misses by {miss:?}");
            let turn = |dt: f64| (r.inverse() * motion.world_from_body(t + dt)).scaled_axis();
            let slope = ((turn(h) - turn(-h)) * 8.0 - (turn(2.0 * h) - turn(-2.0 * h))) / (12.0 * h);
            assert!((slope - omega).norm() < 1e-9, "{spin:?} t {t}: Ṙ = Rω̂ misses by {:?}", slope - omega);
            let change = body.momentum_in_world(&r, &omega) - momentum;
            assert!(change.norm() < 1e-12 * momentum.norm(), "{spin:?} t {t}: L changes by {change:?}");
            let energy = body.kinetic_energy(&omega) / body.kinetic_energy(&spin) - 1.0;
            assert!(energy.abs() < 1e-12, "{spin:?} t {t}: K changes by {energy:e}");
        }
        let (w, period) = (motion.omega_in_body(0.3), motion.period());
        assert!((motion.omega_in_body(0.3 + period) - w).norm() < 1e-12, "{spin:?}: period {period}");
    }
}

/// A ball, a symmetric top and spins about one axis, for which the elliptic formulas degenerate.
#[test]
fn exact_motion_of_symmetric_bodies() {
    let start = UnitQuaternion::identity();
    let steady = |moments: [f64; 3], spin: [f64; 3]| {
        let body = RotationalInertia::from_moments(Vector3::from(moments)).unwrap();
        let motion = FreeRotation::new(&body, &start, &Vector3::from(spin));
        let (w, r) = (motion.omega_in_body(2.0), motion.world_from_body(2.0));
        assert!((w - Vector3::from(spin)).norm() < 1e-14, "{moments:?} {spin:?}: {w:?}");
        let turn = UnitQuaternion::from_scaled_axis(Vector3::from(spin) * 2.0);
        assert!(r.angle_to(&turn) < 1e-7, "{moments:?} {spin:?}: {r:?}");
    };
    steady([2.0; 3], [0.3, 0.4, 0.5]);
    steady([1.0, 2.0, 2.0], [0.0, 0.4, 0.5]);
    steady([2.0, 2.0, 1.0], [0.3, 0.4, 0.0]);
    for axis in 0..3 {
        let mut spin = [0.0; 3];
        spin[axis] = -1.5;
        steady([1.0, 2.0, 2.7], spin);
    }
    steady([1.0, 2.0, 2.7], [0.0; 3]);
    // A symmetric top: the transverse part of ω turns at (I₃−I₁)ω₃/I₁ in the body.
    for (axial, transverse) in [(1.5, 1.0), (0.5, 1.0)] {
        let body = RotationalInertia::from_moments(Vector3::new(transverse, transverse, axial)).unwrap();
        let motion = FreeRotation::new(&body, &start, &Vector3::new(0.7, 0.0, 2.0));
        let angle = (axial - transverse) / transverse * 2.0 * 3.0;
        let expected = Vector3::new(0.7 * angle.cos(), 0.7 * angle.sin(), 2.0);
        assert!((motion.omega_in_body(3.0) - expected).norm() < 1e-13, "{axial}");
    }
}

/// Both steps converge to the exact motion, ω and orientation, at orders 4 and 2.
#[test]
fn steps_converge_to_exact_motion() {
    let body = tilted_body();
    let start = UnitQuaternion::from_euler_angles(0.2, -0.4, 1.0);
    for (name, step, order) in STEPS {
        for spin in spins(&body) {
            let motion = FreeRotation::new(&body, &start, &spin);
            // 2 s at 2⁻⁶ and 2⁻⁷ s: the leading term dominates, and RK4's error is 1e4 roundings or more.
            let error = |steps: u32| {
                let h = 2.0 / f64::from(steps);
                let (mut r, mut omega) = (start, spin);
                for _ in 0..steps {
                    (r, omega) = step(&r, &omega, &Vector3::zeros(), &body, h).unwrap();
                }
                let turn = (motion.world_from_body(2.0).inverse() * r).scaled_axis();
                ((omega - motion.omega_in_body(2.0)).norm(), turn.norm())
            };
            let (coarse, fine) = (error(128), error(256));
            for (what, ratio) in [("ω", coarse.0 / fine.0), ("R", coarse.1 / fine.1)] {
                let measured = ratio.log2();
                assert!((measured - order).abs() < 0.1 * order, "{name}, {spin:?}, {what}: order {measured}");
            }
        }
    }
}

/// A brick that spins about its middle axis with a small disturbance turns over; about the other axes it does
/// not.
#[test]
fn only_the_middle_axis_flips() {
    let brick = brick();
    for (name, step, _) in STEPS {
        for axis in 0..3 {
            let mut omega = Vector3::repeat(0.01);
            omega[axis] = 5.0;
            let mut r = UnitQuaternion::identity();
            let mut least = omega[axis];
            for _ in 0..20_000 {
                (r, omega) = step(&r, &omega, &Vector3::zeros(), &brick, 1e-3).unwrap();
                least = least.min(omega[axis]);
            }
            // After 20 s: fully reversed, or unchanged up to the size of the disturbance.
            if axis == 1 {
                assert!(least < -4.99, "{name}: the middle axis did not flip, least ω {least}");
            } else {
                assert!(least > 4.99, "{name}: axis {axis} flipped, least ω {least}");
            }
        }
    }
}

/// 10⁵ steps of 1 ms of the tumbling brick: the Cayley step conserves the world's L, |L| and K to 1e-12,
/// Runge–Kutta to five decimals.
#[test]
fn momentum_and_energy_are_conserved() {
    let body = brick();
    let spin = Vector3::new(0.05, 5.0, -0.03);
    let start = UnitQuaternion::from_euler_angles(0.2, -0.4, 1.0);
    let (momentum, energy) = (body.momentum_in_world(&start, &spin), body.kinetic_energy(&spin));
    for ((name, step, _), tolerance) in STEPS.into_iter().zip([1e-5, 1e-12]) {
        let (mut r, mut omega) = (start, spin);
        let (mut vector, mut size, mut kinetic) = (0.0_f64, 0.0_f64, 0.0_f64);
        for _ in 0..100_000 {
            (r, omega) = step(&r, &omega, &Vector3::zeros(), &body, 1e-3).unwrap();
            let l = body.momentum_in_world(&r, &omega);
            vector = vector.max((l - momentum).norm() / momentum.norm());
            size = size.max((l.norm() / momentum.norm() - 1.0).abs());
            kinetic = kinetic.max((body.kinetic_energy(&omega) / energy - 1.0).abs());
        }
        println!("{name:>6}: L {vector:.1e}, |L| {size:.1e}, K {kinetic:.1e} (relative, worst of 1e5 steps)");
        assert!(vector < tolerance && size < tolerance && kinetic < tolerance, "{name}");
    }
}

/// With a coarse step of 0.1 rad RK4 loses energy, the Cayley step does not.
#[test]
fn coarse_steps_lose_energy_with_rk4_only() {
    let body = brick();
    let spin = Vector3::new(0.05, 5.0, -0.03);
    let lost = STEPS.map(|(_, step, _)| {
        let (mut r, mut omega) = (UnitQuaternion::identity(), spin);
        for _ in 0..100_000 {
            (r, omega) = step(&r, &omega, &Vector3::zeros(), &body, 0.02).unwrap();
        }
        (body.kinetic_energy(&omega) / body.kinetic_energy(&spin) - 1.0).abs()
    });
    println!("K lost in 1e5 steps of 20 ms: RK4 {:.1e}, Cayley {:.1e}", lost[0], lost[1]);
    assert!(lost[0] > 1e-7 && lost[1] < 1e-12, "{lost:?}");
}

/// Step, flip the spin, step, flip: the Cayley step returns to the start, Runge–Kutta does not.
#[test]
fn cayley_step_is_reversible() {
    let body = tilted_body();
    let (start, spin) = (UnitQuaternion::from_euler_angles(0.2, -0.4, 1.0), Vector3::new(1.0, -2.0, 0.5));
    let defect = STEPS.map(|(_, step, _)| {
        let (r, omega) = step(&start, &spin, &Vector3::zeros(), &body, 0.1).unwrap();
        let (r, omega) = step(&r, &-omega, &Vector3::zeros(), &body, 0.1).unwrap();
        (omega + spin).norm() + (start.inverse() * r).scaled_axis().norm()
    });
    assert!(defect[0] > 1e-8 && defect[1] < 1e-14, "{defect:?}");
}

/// Euler's equations in the world frame, the body frame and principal axes agree.
#[test]
fn three_forms_of_euler_equation_agree() {
    let body = tilted_body();
    let principal = body.principal();
    for k in 1..=20 {
        let t = f64::from(k);
        let r = UnitQuaternion::from_euler_angles(t, (2.3 * t).sin(), 0.7 * t);
        let omega = Vector3::new((1.1 * t).sin(), (0.6 * t).cos(), (1.9 * t).sin()) * 3.0;
        let torque = Vector3::new((0.3 * t).cos(), (1.7 * t).sin(), (0.9 * t).cos()) * 2.0;
        let in_body = euler_in_body(&body, &omega, &torque);
        // d(Rω)/dt = Rω̇, because ω × ω = 0.
        let in_world = euler_in_world(&body, &r, &(r * omega), &(r * torque));
        assert!((in_world - r * in_body).norm() < 1e-13, "state {k}");
        let to = principal.body_from_principal.inverse();
        let along = euler_in_principal_axes(&principal.moments, &(to * omega), &(to * torque));
        assert!((principal.body_from_principal * along - in_body).norm() < 1e-13, "state {k}");
    }
}

/// With a constant torque in body axes both steps converge to one motion at their orders. The change of L is
/// the impulse of the torque.
#[test]
fn impulse_of_torque_changes_momentum() {
    let body = tilted_body();
    let (start, spin, torque) =
        (UnitQuaternion::identity(), Vector3::new(0.5, -1.0, 0.8), Vector3::new(0.4, 0.9, -0.3));
    let run = |step: Step, steps: u32| {
        let h = 2.0 / f64::from(steps);
        let (mut r, mut omega, mut impulse) = (start, spin, Vector3::zeros());
        for _ in 0..steps {
            let before = r;
            (r, omega) = step(&r, &omega, &torque, &body, h).unwrap();
            impulse += (before * torque + r * torque) * (h / 2.0);
        }
        (r, omega, impulse)
    };
    let exact = run(euler_body_step, 4096);
    for (name, step, order) in STEPS {
        let error = |steps| {
            let (r, omega, _) = run(step, steps);
            (omega - exact.1).norm() + (exact.0.inverse() * r).scaled_axis().norm()
        };
        let measured = (error(128) / error(256)).log2();
        assert!((measured - order).abs() < 0.1 * order, "{name}: order {measured}");
    }
    let (r, omega, impulse) = run(cayley_body_step, 100);
    let change = body.momentum_in_world(&r, &omega) - body.momentum_in_world(&start, &spin);
    // The half impulses give this sum: R₀τh/2 before, R₁τh/2 after.
    assert!((change - impulse).norm() < 1e-13, "{change:?} {impulse:?}");
}

#[test]
fn rotation_failures_are_errors() {
    let (body, r) = (brick(), UnitQuaternion::identity());
    let (omega, zero) = (Vector3::new(1.0, 2.0, 3.0), Vector3::zeros());
    for (_, step, _) in STEPS {
        let error = step(&r, &Vector3::new(f64::NAN, 0.0, 0.0), &zero, &body, 1e-3).unwrap_err();
        assert!(matches!(&error, IntegratorError::Input(input) if input.quantity == "omega"), "{error}");
        assert!(step(&r, &omega, &Vector3::new(0.0, f64::INFINITY, 0.0), &body, 1e-3).is_err());
        assert!(std::panic::catch_unwind(|| step(&r, &omega, &zero, &body, 0.0)).is_err());
    }
    let rod = Matrix3::from_diagonal(&Vector3::new(0.0, 1.0, 1.0));
    assert!(matches!(RotationalInertia::new(rod), Err(InertiaError::SingularMoment { .. })));
}
