//! What each body's mass is: its `<inertial>`, or its geoms, within the bounds of `<compiler>`.

use dynamics::{MassProperties, PrincipalInertia, six_digits};
use multibody::Treatment;
use nalgebra::{Isometry3, Matrix3, Translation3, Vector3};
use robot_xml::excerpt;

use crate::MjcfError;
use crate::body::Body;
use crate::compiler::{Compiler, FromGeoms};
use crate::geom::{Form, Geom};
use crate::inertial::Inertial;
use crate::mesh_mass::MeshExtent;
use crate::primitive;
use crate::reader::Reader;

/// A body's mass.
#[derive(Clone, Copy, Default)]
pub(crate) struct Mass {
    /// In the body's axes; `None` for the world and for bodies without mass.
    pub(crate) properties: Option<MassProperties>,
    /// The frame that its moments were given in, where they were given as principal ones.
    pub(crate) frame: Option<Isometry3<f64>>,
}

/// A geom of less mass \[kg\] counts as none, as in MuJoCo.
const LEAST: f64 = 1e-14;

impl Reader<'_> {
    /// The masses of all bodies.
    pub(crate) fn masses(&mut self, bodies: &[Body]) -> Vec<Mass> {
        let mut masses: Vec<Mass> = vec![Mass::default()];
        masses.extend(bodies[1..].iter().map(|body| self.mass(body)));
        let wanted = self.compilers[0].total_mass;
        let total: f64 = masses.iter().filter_map(|mass| mass.properties).map(|body| body.mass()).sum();
        if wanted > 0.0 && total > 0.0 {
            let factor = wanted / total;
            for mass in masses.iter_mut().filter_map(|mass| mass.properties.as_mut()) {
                let (own, inertia) = (mass.mass(), mass.inertia_about_center_of_mass());
                // Finite numbers times a finite one; an overflow keeps the mass and is refused by the model.
                if let Ok(scaled) =
                    MassProperties::as_written(own * factor, mass.center_of_mass(), inertia * factor)
                {
                    *mass = scaled;
                }
            }
            let message =
                format!("settotalmass={wanted}: all masses and inertias times {}", six_digits(factor));
            self.push(1, "compiler".into(), Treatment::Read, message);
        }
        masses
    }

    fn mass(&mut self, body: &Body) -> Mass {
        let written = body.inertial.as_deref();
        let from_geoms = match self.compiler(&body.element).inertia_from_geoms {
            FromGeoms::Always => true,
            FromGeoms::Never => false,
            FromGeoms::WhereMissing => written.is_none(),
        };
        let inferred = if from_geoms { self.mass_of_geoms(body) } else { None };
        let is_inferred = inferred.is_some();
        let (mass, frame) = match (inferred, written) {
            (Some((mass, frame)), _) => (Some(mass), frame),
            (None, Some(written)) => {
                let frame = (!written.is_full).then_some(written.body_from_inertial);
                (self.written_mass(written), frame)
            }
            (None, None) => (None, None),
        };
        let Some(mass) = self.within_bounds(body, mass) else { return Mass::default() };
        let element = if is_inferred { None } else { written.map(|written| written.element.clone()) };
        let element = element.unwrap_or_else(|| body.element.clone());
        let (m, how) = (six_digits(mass.mass()), if is_inferred { "its geoms" } else { "its <inertial>" });
        self.read(&element, format!("mass {m} kg and inertia from {how}"));
        let is_something = mass.mass() > 0.0 || mass.inertia_about_center_of_mass() != Matrix3::zeros();
        Mass { properties: is_something.then_some(mass), frame }
    }

    /// An `<inertial>`, with a warning where no rigid body has such moments.
    fn written_mass(&mut self, written: &Inertial) -> Option<MassProperties> {
        let body = written.mass_properties()?;
        let size = body.center_of_mass().norm();
        let Some(flaw) = body.flaw_beyond_rounding(size) else { return Some(body) };
        let nothing = body.mass() == 0.0 && body.inertia_about_center_of_mass() == Matrix3::zeros();
        if nothing || self.compiler(&written.element).balance_inertia {
            return Some(body);
        }
        let element = &written.element;
        let moments = |body: &MassProperties| {
            let moments: [f64; 3] = body.principal().moments.into();
            moments.map(six_digits).join(", ")
        };
        if self.options.repair_inertia && !self.options.strict {
            let mended = body.repaired();
            let message = format!(
                "{flaw}; repaired: principal moments {} → {} kg·m²",
                moments(&body),
                moments(&mended)
            );
            self.push(element.line, element.place.clone(), Treatment::Repaired, message);
            return Some(mended);
        }
        self.as_written(element, format!("{flaw}; taken as written: correct it, or repair it on loading"));
        Some(body)
    }

    /// `boundmass`, `boundinertia` and `balanceinertia`.
    fn within_bounds(&mut self, body: &Body, mass: Option<MassProperties>) -> Option<MassProperties> {
        let Compiler { least_mass, least_moment, balance_inertia, .. } = *self.compiler(&body.element);
        if least_mass <= 0.0 && least_moment <= 0.0 && !balance_inertia {
            return mass;
        }
        // A body without mass gets the least one where its own frame is in its parent, as in MuJoCo.
        let nothing = || {
            let place = body.parent_from_body.translation.vector;
            MassProperties::as_written(0.0, place, Matrix3::zeros()).ok()
        };
        let mass = mass.or_else(nothing)?;
        let PrincipalInertia { moments, body_from_principal } = mass.principal();
        let mut bounded = moments.map(|moment| moment.max(least_moment));
        if balance_inertia && bounded[0] + bounded[1] < bounded[2] {
            let mean = bounded.mean();
            bounded = Vector3::repeat(mean);
            let message = format!("balanceinertia: three moments of {} kg·m²", six_digits(mean));
            self.defaulted(&body.element, message);
        }
        if bounded == moments && mass.mass() >= least_mass {
            return Some(mass);
        }
        let turn = body_from_principal.matrix();
        let inertia = turn * Matrix3::from_diagonal(&bounded) * turn.transpose();
        let inertia = (inertia + inertia.transpose()) * 0.5;
        if mass.mass() < least_mass || moments.min() < least_moment {
            self.defaulted(&body.element, "boundmass or boundinertia raises its mass or its moments");
        }
        MassProperties::as_written(mass.mass().max(least_mass), mass.center_of_mass(), inertia).ok()
    }

    /// The geoms of the groups that count, together; and the frame of the only one, if it is a primitive.
    fn mass_of_geoms(&mut self, body: &Body) -> Option<(MassProperties, Option<Isometry3<f64>>)> {
        let mut parts = Vec::new();
        let mut frames = Vec::new();
        for geom in &body.geoms {
            if self.compiler(&body.element).inertia_groups.contains(&geom.group)
                && let Some(part) = self.mass_of_geom(geom).filter(|part| part.mass() > LEAST)
            {
                parts.push(part);
                frames.push(geom.mesh.is_none().then_some(geom.body_from_geom));
            }
        }
        let only = if let [frame] = frames[..] { frame } else { None };
        MassProperties::composite(&parts).ok().map(|mass| (mass, only))
    }

    /// A geom's mass in its body's axes.
    fn mass_of_geom(&mut self, geom: &Geom) -> Option<MassProperties> {
        if geom.mass == Some(0.0) || (geom.mass.is_none() && geom.density == 0.0) {
            return None;
        }
        // At density 1, and its frame in the body.
        let (measure, own, place) = match (geom.form, &geom.mesh) {
            (Form::Plane, _) => return None,
            (Form::HeightField | Form::SignedDistance, _) => {
                let message =
                    "its mass is not in the model: height fields and signed distance fields have none here";
                self.ignored_physics(&geom.element, message);
                return None;
            }
            (Form::Mesh, Some(mesh)) => {
                if geom.shell {
                    let message = "shellinertia of a mesh, which MuJoCo 4 refuses: its mass is taken to be in its surface; write \
                                   inertia=\"shell\" in its <asset>";
                    self.as_written(&geom.element, message);
                }
                let extent = self.usable_mesh(geom, mesh)?;
                (extent.measure, extent.body, geom.body_from_geom)
            }
            (form, mesh) => {
                let (size, place) = match mesh {
                    None => (geom.size, geom.body_from_geom),
                    Some(mesh) => self.fitted(geom, mesh)?,
                };
                let extent = primitive::extent(form, size, geom.shell)?;
                let inertia =
                    Matrix3::from_diagonal(&Vector3::from(extent.moments.map(|i| i * extent.measure)));
                let own = MassProperties::as_written(extent.measure, Vector3::zeros(), inertia).ok()?;
                (extent.measure, own, place)
            }
        };
        if measure <= LEAST && geom.mass.is_some() {
            return None;
        }
        let density = geom.mass.map_or(geom.density, |mass| mass / measure);
        let inertia = own.inertia_about_center_of_mass() * density;
        let own = MassProperties::as_written(measure * density, own.center_of_mass(), inertia).ok()?;
        let Isometry3 { rotation, translation } = place;
        Some(own.transformed(&rotation.to_rotation_matrix(), &translation.vector))
    }

    /// The mesh's extent; where there is none, an error. A mesh that is not in the file is told with the shapes.
    fn usable_mesh(&mut self, geom: &Geom, mesh: &str) -> Option<MeshExtent> {
        self.mesh_named(mesh)?;
        match &*self.mesh_extent(mesh, geom.shell && geom.form == Form::Mesh) {
            Ok(extent) => Some(*extent),
            Err(reason) => {
                let (line, place) = (geom.element.line, geom.element.place.clone());
                let (mesh, reason) = (excerpt(mesh), reason.clone());
                self.errors.push(MjcfError::Mesh { line, place, mesh, reason });
                None
            }
        }
    }

    /// Size and place of a primitive that is fitted to a mesh: its axes are the mesh's principal ones, the longest along z,
    /// its size from the box of the same inertia.
    fn fitted(&mut self, geom: &Geom, mesh: &str) -> Option<([f64; 3], Isometry3<f64>)> {
        if self.compiler(&geom.element).fit_bounds {
            let message = "fitaabb: a primitive fitted to a mesh's bounding box is not read; its mass is from the inertia box";
            self.ignored_physics(&geom.element, message);
        }
        let extent = self.usable_mesh(geom, mesh)?;
        let PrincipalInertia { moments, body_from_principal } = extent.body.principal();
        // Half edges of a box with these moments: I₁ + I₂ − I₃ = m a²·2/3 and so on, the largest moment about x.
        let half_edge = |sum: f64| 0.5 * (6.0 * sum.max(0.0) / extent.measure).sqrt();
        let [c, b, a]: [f64; 3] = moments.into();
        let [x, y, z] = [half_edge(b + c - a), half_edge(a + c - b), half_edge(a + b - c)];
        let size = match geom.form {
            Form::Sphere => [(x + y + z) / 3.0, 0.0, 0.0],
            Form::Capsule => [0.5 * (x + y), (z - 0.25 * (x + y)).max(0.0), 0.0],
            Form::Cylinder => [0.5 * (x + y), z, 0.0],
            _ => [x, y, z],
        };
        let axes = body_from_principal.matrix();
        // Descending moments: the columns the other way round, and one of them too, to stay right-handed.
        let axes = Matrix3::from_columns(&[
            axes.column(2).into_owned(),
            -axes.column(1),
            axes.column(0).into_owned(),
        ]);
        let turn = nalgebra::Rotation3::from_matrix_unchecked(axes);
        let mesh_from_box =
            Isometry3::from_parts(Translation3::from(extent.body.center_of_mass()), turn.into());
        Some((size.map(|x| x * geom.fit_scale), geom.body_from_geom * mesh_from_box))
    }
}
