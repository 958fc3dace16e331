//! The law of an ellipsoid: see [`FluidEllipsoid`].

use core::f64::consts::PI;

use nalgebra::{Matrix3, Matrix6, Vector3};
use robot_dynamics_description::{FluidEllipsoid, Medium};

use crate::fluid::pair::Pair;

/// The coefficients of one ellipsoid in one medium.
#[derive(Clone, Debug)]
pub(in crate::fluid) struct EllipsoidLaw {
    density: f64,
    /// Added mass and added moments, times the density.
    added: Pair,
    /// 6πβr and 8πβr³.
    viscous: [f64; 2],
    /// C_M ρ V.
    magnus: f64,
    /// C_K ρ.
    kutta: f64,
    blunt_drag: f64,
    slender_drag: f64,
    /// (r_y r_z)² and so on.
    normal: Vector3<f64>,
    /// The largest projected area.
    largest_area: f64,
    /// ρ (C_a I + C_s (I_max − I)).
    turning: Vector3<f64>,
}

/// The quantities that the direction u of the velocity determines, with their gradients by u as functions of
/// any vector. Unit vectors keep the squares of small velocities from vanishing.
struct Projection {
    /// u, and |v|.
    direction: Vector3<f64>,
    speed: f64,
    /// A, the area projected along u.
    area: f64,
    area_gradient: Vector3<f64>,
    /// The factor K of the lift |v|² K (n × u) × u.
    lift: f64,
    lift_gradient: Vector3<f64>,
}

impl EllipsoidLaw {
    pub(super) fn new(ellipsoid: &FluidEllipsoid, medium: &Medium) -> Self {
        let Medium { density, viscosity, .. } = *medium;
        let r = ellipsoid.half_axes;
        let longest = r[0].max(r[1]).max(r[2]);
        let shortest = r[0].min(r[1]).min(r[2]);
        let middle = r[0] + r[1] + r[2] - longest - shortest;
        let mean = (r[0] + r[1] + r[2]) / 3.0;
        let swept = |axis: f64, across: f64| 8.0 / 15.0 * PI * axis * across.powi(4);
        let most = swept(middle, longest);
        let of_axis = |i: usize| {
            let own = swept(r[i], r[(i + 1) % 3].max(r[(i + 2) % 3]));
            density * (ellipsoid.angular_drag * own + ellipsoid.slender_drag * (most - own))
        };
        let square = |x: f64| x * x;
        Self {
            density,
            added: [ellipsoid.added_mass, ellipsoid.added_inertia]
                .map(|added| Vector3::from(added) * density),
            viscous: [6.0 * PI * viscosity * mean, 8.0 * PI * viscosity * mean.powi(3)],
            magnus: ellipsoid.magnus_lift * density * ellipsoid.volume(),
            kutta: ellipsoid.kutta_lift * density,
            blunt_drag: ellipsoid.blunt_drag,
            slender_drag: ellipsoid.slender_drag,
            normal: Vector3::new(square(r[1] * r[2]), square(r[2] * r[0]), square(r[0] * r[1])),
            largest_area: PI * longest * middle,
            turning: Vector3::new(of_axis(0), of_axis(1), of_axis(2)),
        }
    }

    pub(super) fn force(&self, [v, w]: &Pair) -> Pair {
        let [p, l] = self.momenta(v, w);
        let Projection { direction: u, speed, area, lift, .. } = self.projection(v);
        let lift = speed * speed * lift * self.normal.component_mul(&u).cross(&u).cross(&u);
        let drag = self.viscous[0] + speed * self.quadratic_drag(area);
        let turning = self.viscous[1] + self.turning.component_mul(w).norm();
        [p.cross(w) + self.magnus * w.cross(v) + lift - drag * v, p.cross(v) + l.cross(w) - turning * w]
    }

    pub(super) fn derivative(&self, [v, w]: &Pair) -> Matrix6<f64> {
        let [p, l] = self.momenta(v, w);
        let [added_mass, added_inertia] = self.added.map(|added| Matrix3::from_diagonal(&added));
        let (across_v, across_w, across_p) = (v.cross_matrix(), w.cross_matrix(), p.cross_matrix());
        // Added mass and Magnus lift.
        let mut force_by_v = -across_w * added_mass + self.magnus * across_w;
        let force_by_w = across_p - self.magnus * across_v;
        let moment_by_v = across_p - across_v * added_mass;
        let mut moment_by_w = l.cross_matrix() - across_w * added_inertia;
        // Kutta lift |v|² K (u (n·u) − n (u·u)), n = D u. Lift and drag are of degree 2 in v, so their
        // derivatives at v are |v| times those at u.
        let Projection { direction: u, speed, area, area_gradient, lift, lift_gradient } = self.projection(v);
        let (diagonal, normal) = (Matrix3::from_diagonal(&self.normal), self.normal.component_mul(&u));
        let (along, square) = (normal.dot(&u), u.norm_squared());
        let mut at_direction = (u * along - normal * square) * lift_gradient.transpose();
        at_direction += lift
            * (Matrix3::from_diagonal_element(along) + 2.0 * u * normal.transpose()
                - diagonal * square
                - 2.0 * normal * u.transpose());
        let by_area = self.density * (self.blunt_drag - self.slender_drag);
        let quadratic = self.quadratic_drag(area);
        at_direction -= Matrix3::from_diagonal_element(quadratic);
        at_direction -= u * (u * quadratic + area_gradient * by_area).transpose();
        force_by_v += at_direction * speed - Matrix3::from_diagonal_element(self.viscous[0]);
        let turned = self.turning.component_mul(w);
        let size = turned.norm();
        moment_by_w -= Matrix3::from_diagonal_element(self.viscous[1] + size);
        if size > 0.0 {
            moment_by_w -= w * (turned.component_mul(&self.turning) / size).transpose();
        }
        blocks(&[[force_by_v, force_by_w], [moment_by_v, moment_by_w]])
    }

    /// That of the drag with a constant area, and with the mean drag of rotations: it agrees with minus the
    /// derivative in the direction of the velocity.
    pub(super) fn damping(&self, [v, w]: &Pair) -> Matrix6<f64> {
        let of = |viscous: f64, drag: f64, direction: &Vector3<f64>| {
            let unit = direction.try_normalize(0.0).unwrap_or_default();
            Matrix3::from_diagonal_element(viscous + drag) + unit * unit.transpose() * drag
        };
        let Projection { speed, area, .. } = self.projection(v);
        let drag = speed * self.quadratic_drag(area).max(0.0);
        let turning = self.turning.component_mul(w).norm();
        let zero = Matrix3::zeros();
        blocks(&[[of(self.viscous[0], drag, v), zero], [zero, of(self.viscous[1], turning, w)]])
    }

    /// p and L of the added mass.
    fn momenta(&self, v: &Vector3<f64>, w: &Vector3<f64>) -> Pair {
        [self.added[0].component_mul(v), self.added[1].component_mul(w)]
    }

    /// ρ (C_b A + C_s (A_max − A)).
    fn quadratic_drag(&self, area: f64) -> f64 {
        self.density * (self.blunt_drag * area + self.slender_drag * (self.largest_area - area))
    }

    /// A = π √(n·n / u·n), and K = C_K ρ A (u·n) / n·n.
    fn projection(&self, v: &Vector3<f64>) -> Projection {
        let (zero, speed) = (Vector3::zeros(), v.norm());
        let Some(u) = v.try_normalize(0.0) else {
            return Projection {
                direction: zero,
                speed: 0.0,
                area: 0.0,
                area_gradient: zero,
                lift: 0.0,
                lift_gradient: zero,
            };
        };
        let normal = self.normal.component_mul(&u);
        let (along, square) = (normal.dot(&u), normal.norm_squared());
        let along_gradient = 2.0 * normal;
        let square_gradient = 2.0 * self.normal.component_mul(&normal);
        let area = PI * (square / along).sqrt();
        let area_gradient = (square_gradient / square - along_gradient / along) * (0.5 * area);
        // As a function of any vector x, K is C_K ρ A (x·n) / (|x| n·n).
        let cosine = along / square;
        let cosine_gradient = (along_gradient / along - u - square_gradient / square) * cosine;
        Projection {
            direction: u,
            speed,
            area,
            area_gradient,
            lift: self.kutta * cosine * area,
            lift_gradient: (cosine_gradient * area + area_gradient * cosine) * self.kutta,
        }
    }
}

/// The matrix of these blocks.
fn blocks(blocks: &[[Matrix3<f64>; 2]; 2]) -> Matrix6<f64> {
    Matrix6::from_fn(|i, j| blocks[i / 3][j / 3][(i % 3, j % 3)])
}
