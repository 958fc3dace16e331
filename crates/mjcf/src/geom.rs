//! Reads `<geom>`: a shape of a body, which can contribute to its inertia.

use nalgebra::{Isometry3, Translation3, Vector3};
use robot_dynamics_xml::excerpt;

use crate::MjcfError;
use crate::element::Element;
use crate::frame_scale::FrameScale;
use crate::orientation::{LENGTH_THRESHOLD, from_z_to};
use crate::reader::Reader;

/// The type of a geom.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GeomType {
    Plane,
    HeightField,
    Sphere,
    Capsule,
    Ellipsoid,
    Cylinder,
    Box,
    Mesh,
    SignedDistance,
}

impl GeomType {
    /// The number of values of `size` that the type uses.
    fn sizes(self) -> usize {
        match self {
            Self::Plane | Self::HeightField | Self::Mesh | Self::SignedDistance => 0,
            Self::Sphere => 1,
            Self::Capsule | Self::Cylinder => 2,
            Self::Ellipsoid | Self::Box => 3,
        }
    }
}

/// A geom of a body.
pub(crate) struct Geom {
    /// The name with the suffixes of the replicates around it; empty for a geom without a name.
    pub(crate) name: String,
    pub(crate) element: Element,
    pub(crate) form: GeomType,
    /// Radius and half length, or half edges, or semi-axes \[m\]; not used for a primitive that is fitted to
    /// a mesh.
    pub(crate) size: [f64; 3],
    pub(crate) body_from_geom: Isometry3<f64>,
    /// The factors of the frames around it, which size and mass do not include.
    pub(crate) scale: FrameScale,
    /// \[kg\]; the density applies if it is `None`.
    pub(crate) mass: Option<f64>,
    /// \[kg/m³\], or \[kg/m²\] for a shell.
    pub(crate) density: f64,
    /// Whether the mass is distributed over the surface.
    pub(crate) shell: bool,
    pub(crate) group: i64,
    /// The mesh of the geom, or the mesh to which a primitive is fitted.
    pub(crate) mesh: Option<String>,
    pub(crate) fit_scale: f64,
    /// The coefficients of its fluid forces, if a fluid acts on it as an ellipsoid.
    pub(crate) fluid: Option<[f64; 5]>,
}

impl Reader<'_> {
    /// Reads a geom; `frame` is the pose of the `<frame>` elements around it in the body, and `scale` has
    /// their factors.
    pub(crate) fn geom(
        &mut self,
        element: Element,
        name: String,
        (frame, scale): (&Isometry3<f64>, FrameScale),
    ) -> Geom {
        let words = ["plane", "hfield", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh", "sdf"];
        let form = match self.word(&element, "type", &words) {
            Some("plane") => GeomType::Plane,
            Some("hfield") => GeomType::HeightField,
            Some("capsule") => GeomType::Capsule,
            Some("ellipsoid") => GeomType::Ellipsoid,
            Some("cylinder") => GeomType::Cylinder,
            Some("box") => GeomType::Box,
            Some("mesh") => GeomType::Mesh,
            Some("sdf") => GeomType::SignedDistance,
            _ => GeomType::Sphere,
        };
        let mut size = self.overlay(&element, "size", [0.0; 3]);
        let mesh = self.text(&element, "mesh").map(str::to_owned);
        let from_to = self.numbers::<6>(&element, "fromto");
        let own = match from_to {
            Some(ends) => self.segment_placement(&element, form, ends, &mut size),
            None => self.placement(&element),
        };
        if mesh.is_none() {
            if form == GeomType::Mesh {
                let (line, place) = (element.line, element.place.clone());
                self.errors.push(MjcfError::MissingAttribute {
                    line,
                    place,
                    attribute: "mesh",
                    example: "NAME",
                });
            }
            if let Some(value) = size[..form.sizes()].iter().find(|&&size| size <= 0.0) {
                let (line, place) = (element.line, element.place.clone());
                let attribute = "size".to_owned();
                let value = *value;
                self.errors.push(if value < 0.0 {
                    MjcfError::Negative { line, place, attribute, value }
                } else {
                    let advice = "give a positive length in each direction";
                    MjcfError::Zero { line, place, attribute, advice }
                });
            }
        }
        let mass = self.magnitude(&element, "mass");
        let density = self.magnitude(&element, "density").unwrap_or(1000.0);
        let shell = self.boolean(&element, "shellinertia").unwrap_or(false);
        #[allow(clippy::cast_possible_truncation)] // groups are small whole numbers
        let group = self.number(&element, "group").unwrap_or(0.0) as i64;
        let fit_scale = self.number(&element, "fitscale").unwrap_or(1.0);
        let fluid = self.fluid_coefficients(&element);
        let body_from_geom = frame * scale.place(own);
        if scale != FrameScale::ONE && form == GeomType::HeightField {
            let message = "the scale of a height field is not in the model";
            self.report_ignored_physics(&element, message);
        }
        Geom {
            name,
            element,
            form,
            size,
            body_from_geom,
            scale,
            mass,
            density,
            shell,
            group,
            mesh,
            fit_scale,
            fluid,
        }
    }

    /// The placement by `fromto`: z points from the second point to the first, as in MuJoCo, and the distance
    /// is the length.
    fn segment_placement(
        &mut self,
        element: &Element,
        form: GeomType,
        [a, b, c, d, e, f]: [f64; 6],
        size: &mut [f64; 3],
    ) -> Isometry3<f64> {
        let (from, to) = (Vector3::new(a, b, c), Vector3::new(d, e, f));
        let half = 0.5 * (from - to).norm();
        // A length of zero is an error, which is listed once below.
        let half = if half < LENGTH_THRESHOLD { f64::NAN } else { half };
        match form {
            GeomType::Capsule | GeomType::Cylinder => size[1] = half,
            GeomType::Ellipsoid | GeomType::Box => *size = [size[0], size[0], half],
            _ => {
                let text = excerpt(self.text(element, "type").unwrap_or("sphere"));
                self.refuse(
                    element,
                    format!("fromto is for a capsule, cylinder, ellipsoid or box, not for a {text}"),
                );
            }
        }
        if half.is_nan() {
            self.refuse_zero(element, "fromto", "its two points coincide; move one of them");
            return Isometry3::identity();
        }
        let turn = from_z_to((from - to) / (2.0 * half));
        Isometry3::from_parts(Translation3::from((from + to) * 0.5), turn)
    }
}
