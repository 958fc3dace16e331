//! Whether a link's mass and inertia are those of a rigid body; if not, taken as written, or repaired on request.

use dynamics::{MassProperties, six_digits};
use multibody::{Pose, Treatment};
use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::inertial::Inertial;
use crate::reader::Reader;

impl<'a> Reader<'a> {
    /// The link's mass properties in the link's axes; `None` for a link without mass and inertia.
    ///
    /// The file gives 𝓘 about the centre of mass c in the axes of `<origin>`, turned by R from the link's:
    /// 𝓘_link = R 𝓘 Rᵀ. **(PRM 10.46)** `extent` \[m\] is how far the link's joints are apart.
    pub(crate) fn mass_properties(&mut self, inertial: &Inertial<'a>, extent: f64) -> Option<MassProperties> {
        let Inertial { element, mass, inertia, pose } = inertial;
        if *mass == 0.0 && inertia.iter().all(|&entry| entry == 0.0) {
            self.read(element, "mass 0 and inertia 0: a link without mass");
            return None;
        }
        // Fails only for what is listed as an error already.
        let written = MassProperties::as_written(*mass, Vector3::zeros(), *inertia).ok()?;
        let body = self.rigid_body(inertial, written, extent);
        self.read(element, format!("mass {mass} kg and inertia"));
        let is_something = body.mass() > 0.0 || body.inertia_about_center_of_mass() != Matrix3::zeros();
        is_something.then(|| in_link(&body, pose))
    }

    /// The body, with a warning where no rigid body has such moments.
    fn rigid_body(
        &mut self,
        inertial: &Inertial<'a>,
        written: MassProperties,
        extent: f64,
    ) -> MassProperties {
        let element = &inertial.element;
        let size = extent.max(length(&inertial.pose.translation));
        let Some(flaw) = written.flaw_beyond_rounding(size) else { return written };
        let what = if written.mass() == 0.0 {
            format!("the mass is 0 but the inertia is not: moments {}", moments(&written))
        } else {
            flaw.to_string()
        };
        let (line, place) = (element.line, element.place.clone());
        if self.options.repair_inertia && !self.options.strict {
            let mended = written.repaired();
            let message = format!(
                "{what}; repaired: principal moments {} → {} kg·m², {}",
                moments(&written),
                moments(&mended),
                entries(&mended.inertia_about_center_of_mass())
            );
            self.push(line, place, Treatment::Repaired, message);
            return mended;
        }
        let advice = if written.mass() == 0.0 { "give the mass, or zero both" } else { "correct it" };
        self.push(
            line,
            place,
            Treatment::AsWritten,
            format!("{what}; taken as written: {advice}, or repair it on loading"),
        );
        written
    }
}

fn in_link(body: &MassProperties, pose: &Pose) -> MassProperties {
    let r = Matrix3::from_fn(|i, j| pose.rotation[i][j]);
    body.transformed(&Rotation3::from_matrix_unchecked(r), &Vector3::from(pose.translation))
}

fn length(x: &[f64; 3]) -> f64 {
    x.iter().fold(0.0_f64, |norm, x| norm.hypot(*x))
}

fn moments(body: &MassProperties) -> String {
    let moments: [f64; 3] = body.principal().moments.into();
    moments.map(six_digits).join(", ")
}

/// The six entries as a file writes them, in the axes of `<origin>`.
fn entries(inertia: &Matrix3<f64>) -> String {
    let at = [("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2)];
    at.map(|(name, i, j)| format!("{name}={}", six_digits(inertia[(i, j)]))).join(" ")
}
