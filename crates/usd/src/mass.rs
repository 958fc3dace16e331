//! Masses: those that prims state, and those of their collision shapes.
//!
//! The mass of a body has precedence over those of its shapes, which have precedence over densities. The
//! density of a shape has precedence over that of its body, then that of its material, then 1000 kg/m³. The
//! centre of mass and the inertia of a body replace those of its shapes.

use nalgebra::{Matrix3, Vector3};
use robot_dynamics_description::{InertiaError, MassProperties, Shape};
use robot_dynamics_mesh::hull;

use crate::findings::Findings;
use crate::geometry::Geometry;
use crate::prim::Prim;
use crate::shape::{PlacedShape, rotation};
use crate::transform::quaternion;

/// The density without any other statement \[kg/m³\].
const WATER: f64 = 1000.0;

/// A collision shape of a body.
#[derive(Clone, Debug)]
pub(crate) struct MassShape<'a> {
    pub(crate) prim: usize,
    pub(crate) shape: &'a PlacedShape,
    /// The density of its material, in units of the stage.
    pub(crate) material_density: Option<f64>,
}

/// The mass properties that a prim states, each with `None` where it leaves them to be computed.
struct Stated {
    mass: Option<f64>,
    density: Option<f64>,
    /// In the frame of the node \[m\].
    center: Option<Vector3<f64>>,
    /// About the centre of mass, in the axes of the node \[kg m²\].
    inertia: Option<Matrix3<f64>>,
}

impl Geometry<'_> {
    fn stated(&self, at: usize, findings: &mut Findings) -> Stated {
        let prim = &self.scene.prims[at];
        if !prim.has("PhysicsMassAPI") && !prim.has("NewtonMassAPI") {
            return Stated { mass: None, density: None, center: None, inertia: None };
        }
        let mut positive = |name: &str| {
            let value = prim.number(name).filter(|value| *value != 0.0)?;
            let is_valid = value > 0.0 && value < 1e30;
            if !is_valid {
                findings.refuse(
                    &prim.path,
                    format!("{name} = {value} is not positive; correct it, or delete it"),
                );
            }
            is_valid.then_some(value)
        };
        let mass = positive("physics:mass").map(|mass| mass * self.kilograms);
        let density = positive("physics:density");
        let transform = self.node_from_prim(at);
        // The default is minus infinity.
        let center =
            prim.vector("physics:centerOfMass").filter(|center| center.iter().all(|x| x.is_finite()));
        let center = center.map(|center| transform.apply(center));
        let axes = *rotation(&transform.rigid()).matrix();
        let unit = self.kilograms * self.meters * self.meters;
        let inertia = inertia(prim, findings).map(|inertia| axes * inertia * axes.transpose() * unit);
        Stated { mass, density, center, inertia }
    }

    /// The mass properties of the body at a prim, in the frame of its node; `None` without mass.
    pub(crate) fn mass_properties(
        &self,
        body: usize,
        shapes: &[MassShape<'_>],
        findings: &mut Findings,
    ) -> Option<MassProperties> {
        let prim = &self.scene.prims[body];
        let stated = self.stated(body, findings);
        let is_complete = stated.mass.is_some() && stated.center.is_some() && stated.inertia.is_some();
        let parts: Vec<MassProperties> = if is_complete {
            // The masses of the shapes are without effect.
            for shape in shapes {
                self.stated(shape.prim, &mut Findings::new(findings.options.clone()));
            }
            Vec::new()
        } else {
            shapes.iter().filter_map(|shape| self.shape_mass(shape, &stated, findings)).collect()
        };
        let computed = (!parts.is_empty()).then(|| MassProperties::composite(&parts).ok()).flatten();
        let Some(mass) = stated.mass.or(computed.as_ref().map(MassProperties::mass)) else {
            if stated.inertia.is_some() || stated.center.is_some() {
                findings.leave_out(
                    &prim.path,
                    "it has an inertia, but no mass and no collision shape: it has no mass",
                );
            } else {
                findings.default_value(&prim.path, "no mass and no collision shape: the body has no mass");
            }
            return None;
        };
        let center =
            stated.center.or(computed.as_ref().map(MassProperties::center_of_mass)).unwrap_or_default();
        let inertia = stated.inertia.or_else(|| {
            let computed = computed.as_ref()?;
            // Masses scale the inertia, and a stated centre does not change it.
            Some(computed.inertia_about_center_of_mass() * (mass / computed.mass()))
        });
        let inertia = inertia.unwrap_or_else(|| {
            let message = "it has a mass, but no inertia and no collision shape: the inertia is that of a point; give \
                           physics:diagonalInertia";
            findings.warn(&prim.path, message);
            Matrix3::zeros()
        });
        match MassProperties::as_written(mass, center, inertia) {
            Ok(body) => Some(rigid_body(prim, body, findings)),
            Err(error) => {
                findings.refuse(&prim.path, format!("{error}; correct its mass"));
                None
            }
        }
    }

    /// The mass of one shape.
    fn shape_mass(
        &self,
        shape: &MassShape<'_>,
        body: &Stated,
        findings: &mut Findings,
    ) -> Option<MassProperties> {
        let prim = &self.scene.prims[shape.prim];
        let stated = self.stated(shape.prim, findings);
        let unit = self.kilograms / self.meters.powi(3);
        let density = stated.density.or(body.density).or(shape.material_density);
        if density.is_none() && stated.mass.is_none() && body.mass.is_none() {
            let message = "no mass and no density: it is filled with 1000 kg/m³, the default of USD";
            findings.default_value(&prim.path, message);
        }
        let density = density.map_or(WATER, |density| density * unit);
        let is_shell =
            prim.word("newton:massModel") == Some("shell") || prim.flag("mjc:shellinertia") == Some(true);
        if is_shell {
            findings.leave_out(&prim.path, "the mass of a shell is not in the model: the shape is solid");
        }
        let hull_only = prim.word("physics:approximation") == Some("convexHull");
        let solid = match solid(density, shape.shape, hull_only) {
            Ok(solid) => solid,
            Err(error) => {
                findings
                    .leave_out(&prim.path, format!("its mass is left out: {error}; give the body a mass"));
                return None;
            }
        };
        let mass = stated.mass.unwrap_or(solid.mass());
        let inertia = stated.inertia.unwrap_or(solid.inertia_about_center_of_mass() * (mass / solid.mass()));
        MassProperties::as_written(mass, stated.center.unwrap_or(solid.center_of_mass()), inertia).ok()
    }
}

/// The body, with a warning if no rigid body has such moments.
fn rigid_body(prim: &Prim, written: MassProperties, findings: &mut Findings) -> MassProperties {
    // Moments are floats: their rounding is that of a part of the size of the body.
    let inertia = written.inertia_about_center_of_mass();
    let rounding = f64::from(f32::EPSILON) * inertia.amax();
    if written.moment_violation() <= rounding {
        return written;
    }
    let Some(flaw) = written.flaw_beyond_rounding(written.center_of_mass().norm()) else {
        return written;
    };
    if findings.options.repair_inertia && !findings.options.strict {
        let message = format!("{flaw}; repaired");
        findings.push(&prim.path, robot_dynamics_description::Disposition::Repaired, message);
        return written.repaired();
    }
    findings.warn(&prim.path, format!("{flaw}; taken as written: correct it, or repair it on loading"));
    written
}

/// The inertia that a prim states about its centre of mass, in its axes and units.
fn inertia(prim: &Prim, findings: &mut Findings) -> Option<Matrix3<f64>> {
    let moments = prim.vector("physics:diagonalInertia").filter(|moments| moments.amax() != 0.0);
    let axes = prim.numbers("physics:principalAxes").and_then(|numbers| <[f64; 4]>::try_from(numbers).ok());
    let axes = axes.and_then(quaternion).unwrap_or_else(Matrix3::identity);
    let found = match prim.numbers("newton:inertia") {
        Some(&[xx, yy, zz, xy, xz, yz]) => Some(Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)),
        Some(numbers) if !numbers.is_empty() => {
            let reason = format!("newton:inertia has {} numbers instead of 6; correct it", numbers.len());
            findings.refuse(&prim.path, reason);
            None
        }
        _ => moments.map(|moments| axes * Matrix3::from_diagonal(&moments) * axes.transpose()),
    }?;
    let is_finite = found.iter().all(|entry| entry.abs() < 1e30);
    if !is_finite {
        findings.refuse(&prim.path, "its inertia is not finite; correct it");
    }
    is_finite.then_some(found)
}

/// A shape filled with a density \[kg/m³\].
fn solid(density: f64, placed: &PlacedShape, hull_only: bool) -> Result<MassProperties, String> {
    let text = |error: InertiaError| error.to_string();
    let own = match placed.shape {
        Shape::Box { size } => MassProperties::solid_box(density, size.into()),
        Shape::Sphere { radius } => MassProperties::solid_sphere(density, radius),
        Shape::Ellipsoid { half_axes } => MassProperties::solid_ellipsoid(density, half_axes.into()),
        Shape::Cylinder { radius, length } => MassProperties::solid_cylinder(density, radius, length),
        Shape::Capsule { radius, length } => MassProperties::solid_capsule(density, radius, length),
        Shape::Mesh { .. } => {
            let points: Vec<Vector3<f64>> = placed.triangles.iter().flatten().copied().collect();
            let triangles = if hull_only { hull(&points) } else { Some(placed.triangles.clone()) };
            let triangles = triangles.ok_or("its points have no volume")?;
            // Its triangles are in the node.
            return MassProperties::solid_mesh(density, &triangles).map_err(text);
        }
        _ => return Err("a shape without volume".to_owned()),
    };
    let own = own.map_err(text)?;
    Ok(own.transformed(&rotation(&placed.pose), &placed.pose.translation.into()))
}
