//! Checks that the mass and inertia of a link are those of a rigid body. Other values are taken as written,
//! or repaired on request.

use nalgebra::{Matrix3, Rotation3, Vector3};
use robot_dynamics_description::{Disposition, MassProperties, Pose, six_digits};

use crate::inertial::Inertial;
use crate::reader::Reader;

impl<'a> Reader<'a> {
    /// The link's mass properties in the link's axes; `None` for a link without mass and inertia.
    ///
    /// The file gives 𝓘 about the centre of mass c in the axes of `<origin>`, rotated by R from those of the
    /// link: 𝓘_link = R 𝓘 Rᵀ. **(PRM 10.46)** `extent` \[m\] is the largest distance of the link's joints.
    pub(crate) fn mass_properties(&mut self, inertial: &Inertial<'a>, extent: f64) -> Option<MassProperties> {
        let Inertial { element, mass, inertia, pose } = inertial;
        if *mass == 0.0 && inertia.iter().all(|&entry| entry == 0.0) {
            self.report_read(element, "mass 0 and inertia 0: the link has no mass");
            return None;
        }
        // Fails only for values that are listed as errors.
        let written = MassProperties::as_written(*mass, Vector3::zeros(), *inertia).ok()?;
        let body = self.rigid_body(inertial, written, extent);
        self.report_read(element, format!("mass {mass} kg and inertia"));
        let has_mass = body.mass() > 0.0 || body.inertia_about_center_of_mass() != Matrix3::zeros();
        has_mass.then(|| to_link_frame(&body, pose))
    }

    /// The body, with a warning if no rigid body has such moments.
    fn rigid_body(
        &mut self,
        inertial: &Inertial<'a>,
        written: MassProperties,
        extent: f64,
    ) -> MassProperties {
        let element = &inertial.element;
        let size = extent.max(norm(&inertial.pose.translation));
        let Some(flaw) = written.flaw_beyond_rounding(size) else { return written };
        let what = if written.mass() == 0.0 {
            format!("the mass is 0 but the inertia is not: moments {}", format_moments(&written))
        } else {
            flaw.to_string()
        };
        let (line, place) = (element.line, element.place.clone());
        if self.options.repair_inertia && !self.options.strict {
            let repaired = written.repaired();
            let message = format!(
                "{what}; repaired: principal moments {} → {} kg·m², {}",
                format_moments(&written),
                format_moments(&repaired),
                format_entries(&repaired.inertia_about_center_of_mass())
            );
            self.push(line, place, Disposition::Repaired, message);
            return repaired;
        }
        let advice = if written.mass() == 0.0 { "give the mass, or zero both" } else { "correct it" };
        self.push(
            line,
            place,
            Disposition::AsWritten,
            format!("{what}; taken as written: {advice}, or repair it on loading"),
        );
        written
    }
}

fn to_link_frame(body: &MassProperties, pose: &Pose) -> MassProperties {
    let r = Matrix3::from_fn(|i, j| pose.rotation[i][j]);
    body.transformed(&Rotation3::from_matrix_unchecked(r), &Vector3::from(pose.translation))
}

fn norm(x: &[f64; 3]) -> f64 {
    x.iter().fold(0.0_f64, |sum, x| sum.hypot(*x))
}

fn format_moments(body: &MassProperties) -> String {
    let moments: [f64; 3] = body.principal().moments.into();
    moments.map(six_digits).join(", ")
}

/// The six entries of the inertia as in the file, in the axes of `<origin>`.
fn format_entries(inertia: &Matrix3<f64>) -> String {
    let at = [("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2)];
    at.map(|(name, i, j)| format!("{name}={}", six_digits(inertia[(i, j)]))).join(" ")
}
