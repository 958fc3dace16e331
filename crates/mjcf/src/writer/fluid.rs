//! Writes the fluid, and the shapes on which it acts.

use nalgebra::{Matrix3, Rotation3};
use robot_dynamics_description::{
    FluidEllipsoid, FluidForm, FluidShape, LinkShape, MassProperties, Medium, Pose,
};
use robot_dynamics_xml::excerpt;

use super::MjcfWriter;

/// Boxes and added masses that agree to this are those that MuJoCo computes.
const ROUNDING: f64 = 1e-9;

impl MjcfWriter<'_> {
    /// Writes the fluid's attributes of `<option>`.
    pub(super) fn write_medium(&mut self) {
        let Medium { density, viscosity, wind } = self.robot.medium;
        self.xml.unless("density", density, 0.0).unless("viscosity", viscosity, 0.0);
        if wind != [0.0; 3] {
            self.xml.numbers("wind", &wind);
        }
    }

    /// The axes of the inertia box of a link, if it has one and no other fluid shape. Lists what differs from
    /// MuJoCo, where a fluid acts on the box of each body without ellipsoids.
    pub(super) fn box_axes(&mut self, link: &str, body: &MassProperties) -> Option<Rotation3<f64>> {
        if !self.robot.medium.acts() {
            return None;
        }
        let own: Vec<&FluidShape> =
            self.robot.fluid_shapes.iter().filter(|shape| shape.link == link).collect();
        let place = format!("link {:?}", excerpt(link));
        if own.iter().any(|shape| matches!(shape.form, FluidForm::Ellipsoid(_))) {
            if own.iter().any(|shape| matches!(shape.form, FluidForm::InertiaBox { .. })) {
                self.add_loss(&place, "an inertia box beside ellipsoids, which MJCF lacks");
            }
            return None;
        }
        let axes = match own[..] {
            [shape] => Rotation3::from_matrix_unchecked(Matrix3::from_fn(|i, j| {
                shape.link_from_shape.rotation[i][j]
            })),
            [] => {
                self.add_loss(&place, "no fluid acts on it, but MuJoCo applies its inertia box");
                return None;
            }
            _ => {
                self.add_loss(&place, "several inertia boxes, of which MJCF has one");
                return None;
            }
        };
        let expected = FluidShape::inertia_box_along(link, body, &axes);
        if expected.is_none_or(|expected| !are_near(&expected, own[0])) {
            self.add_loss(&place, "its fluid box is not that of its inertia, which MuJoCo uses");
            return None;
        }
        Some(axes)
    }

    /// Takes the ellipsoid that is that of a shape, and returns its coefficients.
    pub(super) fn take_ellipsoid(&mut self, shape: &LinkShape) -> Option<[f64; 5]> {
        let half_axes = FluidEllipsoid::of_shape(&shape.shape)?.half_axes;
        let own = self.ellipsoids.get_mut(shape.link.as_str())?;
        let is_same = |(pose, ellipsoid): &(Pose, FluidEllipsoid)| {
            *pose == shape.link_from_shape && ellipsoid.half_axes == half_axes
        };
        let index = own.iter().position(is_same)?;
        let (_, ellipsoid) = own.remove(index);
        self.check_added_mass(&shape.link, &ellipsoid);
        Some(ellipsoid.coefficients())
    }

    /// Writes the remaining ellipsoids of a link as geoms without contact.
    pub(super) fn write_ellipsoids(&mut self, link: &str) {
        let all = self.ellipsoids.remove(link).unwrap_or_default();
        let is_massless =
            self.robot.links.iter().any(|own| own.name == link && own.mass_properties.is_none());
        let place = format!("link {:?}", excerpt(link));
        if is_massless && self.robot.fluid_shapes.iter().any(|shape| shape.link == link) {
            self.add_loss(&place, "fluid shapes of a link without mass, on which MuJoCo applies no fluid");
        }
        for (pose, ellipsoid) in all {
            self.check_added_mass(link, &ellipsoid);
            self.add_note(&place, "an ellipsoid in the fluid is written as a geom without contact");
            self.xml.start("geom").attribute("type", "ellipsoid").numbers("size", &ellipsoid.half_axes);
            self.write_placement(&pose);
            self.xml.attribute("contype", "0").attribute("conaffinity", "0");
            if self.has_looks {
                self.xml.attribute("group", "2");
            }
            self.write_coefficients(&ellipsoid.coefficients());
            self.xml.end();
        }
    }

    pub(super) fn write_coefficients(&mut self, coefficients: &[f64; 5]) {
        self.xml.attribute("fluidshape", "ellipsoid").numbers("fluidcoef", coefficients);
    }

    /// Lists an added mass other than MuJoCo's.
    fn check_added_mass(&mut self, link: &str, ellipsoid: &FluidEllipsoid) {
        let usual = FluidEllipsoid::new(ellipsoid.half_axes);
        let scale = usual.added_mass.iter().sum::<f64>();
        let reach = ellipsoid.half_axes.iter().fold(0.0_f64, |most, x| most.max(*x)).powi(2);
        let differ = |own: [f64; 3], usual: [f64; 3], scale: f64| {
            own.iter().zip(usual).any(|(own, usual)| (own - usual).abs() > ROUNDING * scale)
        };
        if differ(ellipsoid.added_mass, usual.added_mass, scale)
            || differ(ellipsoid.added_inertia, usual.added_inertia, scale * reach)
        {
            let message = "an added mass other than that of its ellipsoid, which MuJoCo uses";
            self.add_loss(&format!("link {:?}", excerpt(link)), message);
        }
    }
}

fn are_near(a: &FluidShape, b: &FluidShape) -> bool {
    let (FluidForm::InertiaBox { size: one }, FluidForm::InertiaBox { size: other }) = (&a.form, &b.form)
    else {
        return false;
    };
    let scale = one.iter().sum::<f64>();
    let shift = a.link_from_shape.translation.iter().zip(b.link_from_shape.translation);
    one.iter().zip(other).all(|(one, other)| (one - other).abs() <= ROUNDING * scale)
        && shift.into_iter().all(|(one, other)| (one - other).abs() <= ROUNDING * (scale + one.abs()))
}
