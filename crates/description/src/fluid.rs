//! The fluid around a robot, and the shapes on which it acts.

mod added_mass;

use core::f64::consts::PI;

use nalgebra::{Matrix3, Rotation3};
#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::{MassProperties, Pose, Shape};

/// The least moment of inertia of an inertia box \[kg·m²\], as in MuJoCo.
const LEAST_MOMENT: f64 = 1e-15;

/// A uniform fluid around the robot, such as air or water.
///
/// It acts on the [`fluid_shapes`](crate::RobotDescription::fluid_shapes) of the robot, and not at all if density
/// and viscosity are 0. Buoyancy is not modelled.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Medium {
    /// ρ \[kg/m³\]: 1.2 for air, 1000 for water.
    pub density: f64,
    /// β \[Pa·s\]: 0.00002 for air, 0.0009 for water.
    pub viscosity: f64,
    /// The velocity of the fluid in the world frame \[m/s\].
    #[cfg_attr(feature = "serde", serde(default))]
    pub wind: [f64; 3],
}

impl Medium {
    /// A fluid at rest of this density \[kg/m³\] and viscosity \[Pa·s\].
    pub fn still(density: f64, viscosity: f64) -> Self {
        Self { density, viscosity, wind: [0.0; 3] }
    }

    /// With this velocity in the world frame \[m/s\].
    ///
    /// ```
    /// let air = robot_dynamics::description::Medium::still(1.2, 1.8e-5).with_wind([3.0, 0.0, 0.0]);
    /// assert!(air.acts() && !robot_dynamics::description::Medium::default().acts());
    /// ```
    pub fn with_wind(self, wind: [f64; 3]) -> Self {
        Self { wind, ..self }
    }

    /// Whether it exerts forces: density or viscosity is not 0.
    pub fn acts(&self) -> bool {
        self.density != 0.0 || self.viscosity != 0.0
    }
}

/// A part of a link on which the fluid acts.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct FluidShape {
    /// The link.
    pub link: String,
    /// The placement of the shape's centre and axes.
    pub link_from_shape: Pose,
    /// Its form.
    pub form: FluidForm,
}

/// The form of a [`FluidShape`], which determines the model of the forces.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum FluidForm {
    /// A box with the mass and the inertia of its link, MuJoCo's inertia model. With the edges a, b, c, the
    /// diameter d = (a + b + c)/3, and the velocity v, ω of the shape relative to the fluid along its axes,
    ///
    /// ```text
    /// f_x = −3πβd v_x − ½ρ b c |v_x| v_x,   g_x = −πβd³ ω_x − ρ a (b⁴ + c⁴) |ω_x| ω_x / 64.
    /// ```
    InertiaBox {
        /// The edges a, b, c \[m\].
        size: [f64; 3],
    },
    /// An ellipsoid, MuJoCo's ellipsoid model.
    Ellipsoid(FluidEllipsoid),
}

/// An ellipsoid in a fluid, with the coefficients of MuJoCo's ellipsoid model.
///
/// With the velocity v, ω of its centre relative to the fluid, along its axes, force and moment are
///
/// ```text
/// f = p × ω + C_M ρV ω × v + C_K ρA (v·n)/(|v| |n|²) (n × v) × v − (6πβr + ρ|v| [C_b A + C_s (A_max − A)]) v,
/// g = p × v + L × ω − (8πβr³ + ρ |[C_a I + C_s (I_max − I)] ω|) ω,
/// ```
///
/// p = ρ m∘v and L = ρ J∘ω are the momenta of the added mass m and the added moments J. V is the volume and r
/// the mean half axis. A is the area projected along v, n = (a²v_x, b²v_y, c²v_z) the normal to the section
/// that generates it, with a = r_y r_z and so on. A_max is the largest projected area. I is
/// 8π/15 r_x max(r_y, r_z)⁴ and so on, I_max its bound. Terms of the acceleration are absent, as in MuJoCo.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct FluidEllipsoid {
    /// The half axes \[m\].
    pub half_axes: [f64; 3],
    /// C_b, the drag of the projected area.
    pub blunt_drag: f64,
    /// C_s, the drag of the remaining area.
    pub slender_drag: f64,
    /// C_a, the drag of rotations.
    pub angular_drag: f64,
    /// C_K, the lift by the Kutta condition.
    pub kutta_lift: f64,
    /// C_M, the lift by the Magnus effect.
    pub magnus_lift: f64,
    /// The added mass along each axis, divided by the density \[m³\].
    pub added_mass: [f64; 3],
    /// The added moment of inertia about each axis, divided by the density \[m⁵\].
    pub added_inertia: [f64; 3],
}

impl FluidEllipsoid {
    /// An ellipsoid with the default coefficients of MJCF, and the added mass of potential flow
    /// **(Tuckerman 1925)**. Its integral is MuJoCo's quadrature, whose relative error is about 1e-7 for a
    /// ball and grows with the ratio of the half axes.
    ///
    /// ```
    /// let ball = robot_dynamics::description::FluidEllipsoid::new([0.1; 3]);
    /// let volume = 4.0 / 3.0 * std::f64::consts::PI * 0.001;
    /// assert!((ball.added_mass[0] / (0.5 * volume) - 1.0).abs() < 1e-6); // half of the displaced mass
    /// assert_eq!(ball.added_inertia, [0.0; 3]);
    /// ```
    pub fn new(half_axes: [f64; 3]) -> Self {
        let (added_mass, added_inertia) = added_mass::of_ellipsoid(half_axes);
        Self {
            half_axes,
            blunt_drag: 0.5,
            slender_drag: 0.25,
            angular_drag: 1.5,
            kutta_lift: 1.0,
            magnus_lift: 1.0,
            added_mass,
            added_inertia,
        }
    }

    /// With these coefficients in the order of MJCF's `fluidcoef`: blunt, slender and angular drag, Kutta and
    /// Magnus lift.
    pub fn with_coefficients(self, coefficients: [f64; 5]) -> Self {
        let [blunt_drag, slender_drag, angular_drag, kutta_lift, magnus_lift] = coefficients;
        Self { blunt_drag, slender_drag, angular_drag, kutta_lift, magnus_lift, ..self }
    }

    /// The coefficients in the order of MJCF's `fluidcoef`.
    ///
    /// ```
    /// let wing = robot_dynamics::description::FluidEllipsoid::new([0.3, 0.1, 0.01]);
    /// let wing = wing.with_coefficients([0.5, 0.25, 1.5, 2.0, 0.0]);
    /// assert_eq!(wing.coefficients()[3], wing.kutta_lift);
    /// ```
    pub fn coefficients(&self) -> [f64; 5] {
        [self.blunt_drag, self.slender_drag, self.angular_drag, self.kutta_lift, self.magnus_lift]
    }

    /// The ellipsoid of a shape: with its half lengths as half axes. `None` for a mesh, a height field and a
    /// half space.
    ///
    /// ```
    /// use robot_dynamics::description::{FluidEllipsoid, Shape};
    /// let capsule = FluidEllipsoid::of_shape(&Shape::Capsule { radius: 0.1, length: 0.6 });
    /// assert_eq!(capsule.map(|own| own.half_axes), Some([0.1, 0.1, 0.4]));
    /// ```
    pub fn of_shape(shape: &Shape) -> Option<Self> {
        let half_axes = match *shape {
            Shape::Box { size } => size.map(|edge| 0.5 * edge),
            Shape::Cylinder { radius, length } => [radius, radius, 0.5 * length],
            Shape::Sphere { radius } => [radius; 3],
            Shape::Capsule { radius, length } => [radius, radius, 0.5 * length + radius],
            Shape::Ellipsoid { half_axes } => half_axes,
            Shape::Plane { .. } | Shape::HeightField { .. } | Shape::Mesh { .. } => return None,
        };
        Some(Self::new(half_axes))
    }

    /// The volume \[m³\].
    #[doc(hidden)]
    pub fn volume(&self) -> f64 {
        4.0 / 3.0 * PI * self.half_axes.iter().product::<f64>()
    }
}

impl FluidShape {
    /// The inertia box of a link with these mass properties, along their principal axes; `None` without mass.
    ///
    /// ```
    /// use robot_dynamics::description::{FluidForm, FluidShape, MassProperties};
    /// let brick = MassProperties::solid_box(700.0, [0.3, 0.2, 0.1].into())?;
    /// let shape = FluidShape::inertia_box("brick", &brick).expect("it has mass");
    /// let FluidForm::InertiaBox { size } = shape.form else { unreachable!() };
    /// assert!((size.iter().product::<f64>() - 0.006).abs() < 1e-12); // the volume of the solid box
    /// # Ok::<(), robot_dynamics::description::InertiaError>(())
    /// ```
    pub fn inertia_box(link: impl Into<String>, body: &MassProperties) -> Option<Self> {
        Self::inertia_box_along(link, body, &body.principal().body_from_principal)
    }

    /// The inertia box along these axes, the principal axes of the body.
    #[doc(hidden)]
    pub fn inertia_box_along(
        link: impl Into<String>,
        body: &MassProperties,
        axes: &Rotation3<f64>,
    ) -> Option<Self> {
        let mass = body.mass();
        if mass.is_nan() || mass < LEAST_MOMENT {
            return None;
        }
        let turn: &Matrix3<f64> = axes.matrix();
        let moments = (turn.transpose() * body.inertia_about_center_of_mass() * turn).diagonal();
        let edge = |i: usize| {
            let sum = moments[(i + 1) % 3] + moments[(i + 2) % 3] - moments[i];
            (6.0 * sum.max(LEAST_MOMENT) / mass).sqrt()
        };
        let rotation = core::array::from_fn(|row| core::array::from_fn(|column| turn[(row, column)]));
        let link_from_shape = Pose { rotation, translation: body.center_of_mass().into() };
        Some(Self {
            link: link.into(),
            link_from_shape,
            form: FluidForm::InertiaBox { size: [0, 1, 2].map(edge) },
        })
    }
}
