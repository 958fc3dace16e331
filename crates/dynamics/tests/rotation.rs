//! Rotation of a rigid body: inertia, and (below) its motion.

use dynamics::{InertiaError, MassProperties, parallel_axis, parallel_axis_planar};
use nalgebra::{Matrix3, Rotation3, Vector3};

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

/// Each closed form against the volume integral (PRM 10.42), by Gauss's rule in fitting coordinates.
#[test]
fn shapes_match_the_volume_integral() {
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
            let (s, phi, ring) = ((x + 1.0) / 2.0, PI * (y + 1.0), (1.0 - z * z).sqrt());
            Vector3::new(a * s * ring * phi.cos(), b * s * ring * phi.sin(), c * s * z)
        },
        |x, _, _| a * b * c * ((x + 1.0) / 2.0).powi(2) / 2.0 * PI,
    );
    let density = 7.0;
    let cases = [
        ("box", MassProperties::solid_box(density, Vector3::new(a, b, c)).unwrap(), boxed),
        ("cylinder", MassProperties::solid_cylinder(density, b, c).unwrap(), cylinder),
        ("ellipsoid", MassProperties::solid_ellipsoid(density, Vector3::new(a, b, c)).unwrap(), ellipsoid),
    ];
    for (name, body, points) in cases {
        let (m, s, i) = moments_of(&points);
        // The integrands are polynomials of degree ≤ 4 in the lengths times sin², cos² on 36 nodes a turn:
        // Gauss's error (6th derivative, 12 cells) is below 1e-9 of the value.
        assert!((body.mass() / density - m).abs() < 1e-8 * m, "{name}: mass");
        assert!((body.center_of_mass() - s / m).norm() < 1e-8, "{name}: centre of mass");
        let miss = (body.inertia_about_center_of_mass() / density - i).amax();
        assert!(miss < 1e-8 * i.amax(), "{name}: inertia misses the integral by {miss:e}");
    }
}

/// The composite 𝓘 = Σ R(𝓘 + m(|r|²1 − r rᵀ))Rᵀ and the point-mass sum agree on a body made of dust.
#[test]
fn composite_and_parallel_axis_agree_with_the_sum_over_points() {
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

    // Principal axes rebuild the matrix and are right-handed.
    let principal = seen.principal();
    let r = principal.body_from_principal.matrix();
    let rebuilt = r * Matrix3::from_diagonal(&principal.moments) * r.transpose();
    assert!((rebuilt - seen.inertia_about_center_of_mass()).amax() < 1e-13);
    assert!((r.determinant() - 1.0).abs() < 1e-14);
    assert!(principal.moments[0] <= principal.moments[1] && principal.moments[1] <= principal.moments[2]);
}

/// What no mass distribution has cannot be built, and the error says which law it breaks.
#[test]
fn impossible_inertia_is_refused() {
    let origin = Vector3::zeros();
    let build = |mass: f64, moments: [f64; 3]| {
        MassProperties::new(mass, origin, Matrix3::from_diagonal(&Vector3::from(moments)))
    };
    assert!(matches!(build(0.0, [1.0; 3]), Err(InertiaError::NotPositive { quantity: "mass", value: 0.0 })));
    assert!(matches!(build(-1.0, [1.0; 3]), Err(InertiaError::NotPositive { .. })));
    assert!(matches!(build(f64::NAN, [1.0; 3]), Err(InertiaError::NonFinite { quantity: "mass", index: 0 })));
    assert!(matches!(build(1.0, [1.0, f64::INFINITY, 1.0]), Err(InertiaError::NonFinite { index: 4, .. })));
    assert!(matches!(build(1.0, [-0.1, 1.0, 1.0]), Err(InertiaError::NegativeMoment { .. })));
    assert!(matches!(build(1.0, [1.0, 3.0, 1.0]), Err(InertiaError::TriangleInequality { .. })));
    assert!(matches!(build(1.0, [1.0, 2.001, 1.0]), Err(InertiaError::TriangleInequality { .. })));
    // A thin plate, a thin rod, a point: all on the boundary, all bodies. So is a plate rounded to 7 digits.
    for moments in [[1.0, 2.0, 3.0], [0.0, 1.0, 1.0], [0.0; 3], [0.3333333, 0.3333333, 0.6666667]] {
        build(1.0, moments).unwrap();
    }
    let mut skewed = Matrix3::identity();
    skewed[(0, 2)] = 0.1;
    let error = MassProperties::new(1.0, origin, skewed).unwrap_err();
    assert_eq!(error, InertiaError::NotSymmetric { row: 0, column: 2, upper: 0.1, lower: 0.0 });
    assert!(error.to_string().contains("(0, 2) is 0.1"));
    assert_eq!(MassProperties::composite(&[]), Err(InertiaError::NoParts));
    assert!(MassProperties::solid_box(1000.0, Vector3::new(1.0, 0.0, 1.0)).is_err());
    assert!(MassProperties::solid_cylinder(1000.0, -0.1, 1.0).is_err());
    assert!(MassProperties::solid_sphere(f64::NAN, 0.1).is_err());
}
