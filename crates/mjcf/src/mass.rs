//! The mass properties of bodies: from `<inertial>` or geoms, within the bounds of `<compiler>`.

use nalgebra::{Isometry3, Matrix3, Translation3, Vector3};
use robot_dynamics_description::{Disposition, MassProperties, PrincipalInertia, six_digits};
use robot_dynamics_xml::excerpt;

use crate::body::Body;
use crate::geom::{Geom, GeomType};
use crate::inertial::Inertial;
use crate::mesh_mass::MeshExtent;
use crate::reader::Reader;
use crate::settings::{Compiler, InertiaSource};
use crate::{MjcfError, primitive};

/// The mass properties of a body.
#[derive(Clone, Copy, Default)]
pub(crate) struct Mass {
    /// In the axes of the body; `None` for the world and for bodies without mass.
    pub(crate) properties: Option<MassProperties>,
    /// The principal frame in the file, if the file gives principal moments.
    pub(crate) frame: Option<Isometry3<f64>>,
}

/// A geom of less mass \[kg\] is ignored, as in MuJoCo.
const MASS_THRESHOLD: f64 = 1e-14;

impl Reader<'_> {
    /// The mass properties of all bodies.
    pub(crate) fn masses(&mut self, bodies: &[Body]) -> Vec<Mass> {
        let mut masses: Vec<Mass> = vec![Mass::default()];
        masses.extend(bodies[1..].iter().map(|body| self.mass(body)));
        let wanted = self.compilers[0].total_mass;
        let total: f64 = masses.iter().filter_map(|mass| mass.properties).map(|body| body.mass()).sum();
        if wanted > 0.0 && total > 0.0 {
            let factor = wanted / total;
            for mass in masses.iter_mut().filter_map(|mass| mass.properties.as_mut()) {
                let (own, inertia) = (mass.mass(), mass.inertia_about_center_of_mass());
                // Fails only for an overflow. The mass then stays, and the model refuses it.
                if let Ok(scaled) =
                    MassProperties::as_written(own * factor, mass.center_of_mass(), inertia * factor)
                {
                    *mass = scaled;
                }
            }
            let message =
                format!("settotalmass={wanted}: all masses and inertias times {}", six_digits(factor));
            self.push(1, "compiler".into(), Disposition::Read, message);
        }
        masses
    }

    fn mass(&mut self, body: &Body) -> Mass {
        let written = body.inertial.as_deref();
        let from_geoms = match self.compiler(&body.element).inertia_from_geoms {
            InertiaSource::Always => true,
            InertiaSource::Never => false,
            InertiaSource::WhereMissing => written.is_none(),
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
        self.report_read(&element, format!("mass {m} kg and inertia from {how}"));
        let has_mass = mass.mass() > 0.0 || mass.inertia_about_center_of_mass() != Matrix3::zeros();
        Mass { properties: has_mass.then_some(mass), frame }
    }

    /// The mass properties of an `<inertial>`, with a warning if no rigid body has such moments.
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
            let repaired = body.repaired();
            let message = format!(
                "{flaw}; repaired: principal moments {} → {} kg·m²",
                moments(&body),
                moments(&repaired)
            );
            self.push(element.line, element.place.clone(), Disposition::Repaired, message);
            return Some(repaired);
        }
        self.warn(element, format!("{flaw}; taken as written: correct it, or repair it on loading"));
        Some(body)
    }

    /// Applies `boundmass`, `boundinertia` and `balanceinertia`.
    fn within_bounds(&mut self, body: &Body, mass: Option<MassProperties>) -> Option<MassProperties> {
        let Compiler { least_mass, least_moment, balance_inertia, .. } = *self.compiler(&body.element);
        if least_mass <= 0.0 && least_moment <= 0.0 && !balance_inertia {
            return mass;
        }
        // MuJoCo puts the least mass of a body without mass at the position of the body in its parent.
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
            self.report_default(&body.element, message);
        }
        if bounded == moments && mass.mass() >= least_mass {
            return Some(mass);
        }
        let turn = body_from_principal.matrix();
        let inertia = turn * Matrix3::from_diagonal(&bounded) * turn.transpose();
        let inertia = (inertia + inertia.transpose()) * 0.5;
        if mass.mass() < least_mass || moments.min() < least_moment {
            self.report_default(&body.element, "boundmass or boundinertia raises its mass or its moments");
        }
        MassProperties::as_written(mass.mass().max(least_mass), mass.center_of_mass(), inertia).ok()
    }

    /// The mass properties of all geoms of the inertia groups, and the frame of a single primitive.
    fn mass_of_geoms(&mut self, body: &Body) -> Option<(MassProperties, Option<Isometry3<f64>>)> {
        let mut parts = Vec::new();
        let mut frames = Vec::new();
        for geom in &body.geoms {
            if self.compiler(&body.element).inertia_groups.contains(&geom.group)
                && let Some(part) = self.mass_of_geom(geom).filter(|part| part.mass() > MASS_THRESHOLD)
            {
                parts.push(part);
                frames.push(geom.mesh.is_none().then_some(geom.body_from_geom));
            }
        }
        let only = if let [frame] = frames[..] { frame } else { None };
        MassProperties::composite(&parts).ok().map(|mass| (mass, only))
    }

    /// The mass properties of a geom in the axes of its body.
    fn mass_of_geom(&mut self, geom: &Geom) -> Option<MassProperties> {
        if geom.mass == Some(0.0) || (geom.mass.is_none() && geom.density == 0.0) {
            return None;
        }
        let of_plugin = matches!(geom.form, GeomType::SignedDistance) && !self.mesh_has_points(geom);
        // Volume or area, mass properties at density 1, and the frame in the body.
        let (measure, own, place) = match (geom.form, &geom.mesh) {
            (GeomType::Plane, _) => return None,
            (GeomType::HeightField, _) => {
                let size = self.height_field_size(geom)?;
                solid(GeomType::Box, size, geom.shell, geom.body_from_geom)?
            }
            (GeomType::SignedDistance, _) if of_plugin => {
                let message =
                    "its mass is not in the model: the signed distance field of a plugin is not supported";
                self.report_ignored_physics(&geom.element, message);
                return None;
            }
            (GeomType::Mesh | GeomType::SignedDistance, Some(mesh)) => {
                if geom.shell {
                    let message = "shellinertia of a mesh, which MuJoCo 4 refuses: taken as mass in the surface; write \
                                   inertia=\"shell\" in its <asset>";
                    self.warn(&geom.element, message);
                }
                let extent = self.usable_mesh(geom, mesh)?;
                (extent.measure, extent.body, geom.body_from_geom)
            }
            (form, mesh) => {
                let (size, place) = match mesh {
                    None => (geom.size, geom.body_from_geom),
                    Some(mesh) => self.fit_primitive(geom, mesh)?,
                };
                solid(form, size, geom.shell, place)?
            }
        };
        if measure <= MASS_THRESHOLD && geom.mass.is_some() {
            return None;
        }
        let density = geom.mass.map_or(geom.density, |mass| mass / measure);
        let inertia = own.inertia_about_center_of_mass() * density;
        let own = MassProperties::as_written(measure * density, own.center_of_mass(), inertia).ok()?;
        let own = geom.scale.body(&own)?;
        let Isometry3 { rotation, translation } = place;
        Some(own.transformed(&rotation.to_rotation_matrix(), &translation.vector))
    }

    /// Whether the mesh of a geom is a file or a list of points. Otherwise its points come from a plugin.
    fn mesh_has_points(&mut self, geom: &Geom) -> bool {
        let Some(mesh) = geom.mesh.as_deref() else { return false };
        // A missing mesh is reported with the shape.
        let Some(element) = self.mesh_named(mesh) else { return true };
        ["file", "vertex", "builtin"].iter().any(|source| self.text(&element, source).is_some())
    }

    /// As in MuJoCo, the mass of a height field is that of a box around the geom's origin. Its half height is
    /// a quarter of the largest elevation plus half the depth of the base.
    fn height_field_size(&mut self, geom: &Geom) -> Option<[f64; 3]> {
        let wanted = self.text(&geom.element, "hfield")?;
        let field = self.raw_element(*self.height_fields.get(wanted)?);
        let [x, y, height, base] = self.numbers::<4>(&field, "size")?;
        Some([x, y, 0.25 * height + 0.5 * base])
    }

    /// The extent of a mesh; `None` with an error if it cannot be used. An unknown mesh is reported by
    /// `mesh_shape`.
    pub(crate) fn usable_mesh(&mut self, geom: &Geom, mesh: &str) -> Option<MeshExtent> {
        self.mesh_named(mesh)?;
        match &*self.mesh_extent(mesh, geom.shell && geom.form == GeomType::Mesh) {
            Ok(extent) => Some(*extent),
            Err(reason) => {
                let (line, place) = (geom.element.line, geom.element.place.clone());
                let (mesh, reason) = (excerpt(mesh), reason.clone());
                self.errors.push(MjcfError::Mesh { line, place, mesh, reason });
                None
            }
        }
    }

    /// Size and frame of a primitive that is fitted to a mesh. Its axes are the principal axes of the mesh,
    /// the longest along z. Its size is that of the box with the same inertia, or with `fitaabb` that of the
    /// bounding box along these axes. The factors of frames apply to the frame, and not to the size.
    pub(crate) fn fit_primitive(&mut self, geom: &Geom, mesh: &str) -> Option<([f64; 3], Isometry3<f64>)> {
        let extent = self.usable_mesh(geom, mesh)?;
        if self.compiler(&geom.element).fit_bounds {
            let [center, [x, y, z]] = extent.bounds;
            let size = match geom.form {
                GeomType::Sphere => [x.max(y).max(z), 0.0, 0.0],
                GeomType::Capsule => [x.max(y), z - x.max(y), 0.0],
                GeomType::Cylinder => [x.max(y), z, 0.0],
                _ => [x, y, z],
            };
            let mesh_from_bounds = geom.scale.place(extent.mesh_from_box * Translation3::from(center));
            return Some((size.map(|x| x * geom.fit_scale), geom.body_from_geom * mesh_from_bounds));
        }
        let PrincipalInertia { moments, body_from_principal } = extent.body.principal();
        // Half edges of a box with these moments, the largest about x: I₁ + I₂ − I₃ = m a²·2/3, and
        // cyclically.
        let half_edge = |sum: f64| 0.5 * (6.0 * sum.max(0.0) / extent.measure).sqrt();
        let [c, b, a]: [f64; 3] = moments.into();
        let [x, y, z] = [half_edge(b + c - a), half_edge(a + c - b), half_edge(a + b - c)];
        let size = match geom.form {
            GeomType::Sphere => [(x + y + z) / 3.0, 0.0, 0.0],
            GeomType::Capsule => [0.5 * (x + y), (z - 0.25 * (x + y)).max(0.0), 0.0],
            GeomType::Cylinder => [0.5 * (x + y), z, 0.0],
            _ => [x, y, z],
        };
        let axes = body_from_principal.matrix();
        // Reversed columns give descending moments; one sign keeps the frame right-handed.
        let axes = Matrix3::from_columns(&[
            axes.column(2).into_owned(),
            -axes.column(1),
            axes.column(0).into_owned(),
        ]);
        let turn = nalgebra::Rotation3::from_matrix_unchecked(axes);
        let mesh_from_box =
            Isometry3::from_parts(Translation3::from(extent.body.center_of_mass()), turn.into());
        Some((size.map(|x| x * geom.fit_scale), geom.body_from_geom * geom.scale.place(mesh_from_box)))
    }
}

/// The measure of a primitive, its mass properties at density 1, and its frame in the body.
fn solid(
    form: GeomType,
    size: [f64; 3],
    shell: bool,
    place: Isometry3<f64>,
) -> Option<(f64, MassProperties, Isometry3<f64>)> {
    let extent = primitive::extent(form, size, shell)?;
    let inertia = Matrix3::from_diagonal(&Vector3::from(extent.moments.map(|i| i * extent.measure)));
    let own = MassProperties::as_written(extent.measure, Vector3::zeros(), inertia).ok()?;
    Some((extent.measure, own, place))
}
