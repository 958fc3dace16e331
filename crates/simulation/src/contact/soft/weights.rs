//! The inverse inertia of each constraint, computed once, in the robot's reference pose.

use std::collections::HashMap;

use nalgebra::Vector3;
use robot_dynamics_core::configuration::manifold::coordinate_ranges;
use robot_dynamics_core::factorization::sparse;
use robot_dynamics_core::factorization::sparse::coordinate_parents;
use robot_dynamics_core::joint::Chart;
use robot_dynamics_core::kinematics::tendon_path::TendonPath;
use robot_dynamics_core::{Model, Workspace, mass_matrix, neutral};
use robot_dynamics_description::JointDescription;
use robot_dynamics_integrators::IntegratorError;

use crate::placement::Placement;
use robot_dynamics_core::configuration::joint_sum::JointSum;

/// The means of the diagonals of J M⁻¹ Jᵀ.
#[derive(Clone, Debug)]
pub(super) struct InverseWeights {
    /// For each link, by the index of its frame, at its centre of mass: translation \[1/kg\] and rotation
    /// \[1/(kg·m²)\]. 0 for frames that are not links, and for links that do not move.
    pub(super) frames: Vec<[f64; 2]>,
    /// For each coordinate. The three of a ball joint share one value, and so do a free joint's translations
    /// and its rotations.
    pub(super) coordinates: Vec<f64>,
    /// For each tendon.
    pub(super) tendons: Vec<f64>,
}

impl InverseWeights {
    /// # Errors
    /// [`IntegratorError::SingularMass`]: M is singular.
    pub(super) fn new(model: &Model) -> Result<Self, IntegratorError> {
        let n = model.nv;
        let (mut workspace, mut placement) = (Workspace::new(model), Placement::new(model));
        let q = reference_pose(model);
        let (dof_parent, mut factor) = (coordinate_parents(model), vec![0.0; n * n]);
        mass_matrix(model, &mut workspace, &q, &mut factor);
        let diagonal: Vec<f64> = (0..n).map(|k| factor[k * n + k]).collect();
        sparse::factor_watched(&dof_parent, &mut factor, |k| diagonal[k])?;
        placement.set(model, &mut workspace, &q);
        // rᵀM⁻¹r.
        let weigh = |row: &[f64]| {
            let mut moved = row.to_vec();
            sparse::solve(&dof_parent, &factor, &mut moved);
            row.iter().zip(&moved).map(|(row, moved)| row * moved).sum::<f64>()
        };
        let mut coordinates: Vec<f64> = (0..n)
            .map(|k| {
                let mut unit = vec![0.0; n];
                unit[k] = 1.0;
                weigh(&unit)
            })
            .collect();
        for stretch in coordinate_ranges(model) {
            let groups = match stretch.chart {
                Chart::Line => 0,
                Chart::Rotation => 1,
                Chart::Placement => 2,
            };
            for group in 0..groups {
                let own = &mut coordinates[stretch.v + 3 * group..stretch.v + 3 * group + 3];
                let mean = own.iter().sum::<f64>() / 3.0;
                own.fill(mean);
            }
        }
        let by_mass = weighed_by_mass(model);
        for (coordinate, weight) in
            by_mass.values().flat_map(|(weight, own)| own.iter().map(|k| (*k, *weight)))
        {
            coordinates[coordinate] = weight;
        }
        let mut frames = vec![[0.0; 2]; model.frames().len()];
        for link in &model.description().links {
            let Some(frame) = model.frame(&link.name) else { continue };
            let (weights, frame) = (&mut frames[frame.index], model.frame_of(frame));
            let Some(body) = frame.body else { continue };
            if let Some((weight, _)) = by_mass.get(link.name.as_str()) {
                *weights = [*weight, 0.0];
                continue;
            }
            let center = link.mass_properties.map_or_else(Vector3::zeros, |mass| mass.center_of_mass());
            let (rotation, origin) = placement.body(body);
            let center = origin + rotation * Vector3::from(frame.body_from_frame.apply(center.into()));
            for (part, weight) in weights.iter_mut().enumerate() {
                let square = |axis: usize| {
                    let mut row = vec![0.0; n];
                    placement.each_motion(model, body, center, |dof, velocity, spin| {
                        let along = if part == 0 { velocity[axis] } else { spin[axis] };
                        row[dof.coordinate] += dof.ratio * along;
                    });
                    weigh(&row)
                };
                *weight = (0..3).map(square).sum::<f64>() / 3.0;
            }
        }
        let of_tendon = |tendon| {
            let mut row = vec![0.0; n];
            JointSum::of_tendon(model, tendon).spread(1.0, &mut row);
            weigh(&row)
        };
        let of_path = |path: TendonPath| {
            let mut row = vec![0.0; n];
            path.length_and_row(model, &placement, &mut row);
            weigh(&row)
        };
        let over_joints = model.description().tendons.iter().map(of_tendon);
        let tendons = over_joints.chain(TendonPath::all(model).into_iter().map(of_path)).collect();
        Ok(Self { frames, coordinates, tendons })
    }
}

/// The links whose prismatic joints are weighted by mass alone: 1/m, and the coordinates of these joints.
fn weighed_by_mass(model: &Model) -> HashMap<&str, (f64, Vec<usize>)> {
    let description = model.description();
    let joints = description.joints.iter().filter(|joint| joint.softness.is_weighed_by_mass);
    let by_child: HashMap<&str, &JointDescription> =
        joints.map(|joint| (joint.child.as_str(), joint)).collect();
    let mut found = HashMap::new();
    for link in description.links.iter().filter(|_| !by_child.is_empty()) {
        let Some(mass) = link.mass_properties.map(|own| own.mass()).filter(|mass| *mass > 0.0) else {
            continue;
        };
        // The prismatic joints of one body are a chain through massless links.
        let below = core::iter::successors(by_child.get(link.name.as_str()), |joint| {
            by_child.get(joint.parent.as_str())
        });
        let coordinate = |joint: &&JointDescription| {
            model.joints.iter().find(|own| own.name == joint.name && own.nv == 1).map(|own| own.v_index)
        };
        let coordinates: Vec<usize> = below.filter_map(coordinate).collect();
        if !coordinates.is_empty() {
            found.insert(link.name.as_str(), (mass.recip(), coordinates));
        }
    }
    found
}

/// Each joint at the position of its file.
fn reference_pose(model: &Model) -> Vec<f64> {
    // The weights of spatial tendons depend on where free bodies are.
    let of_file = model.named_pose("qpos0").filter(|_| !model.description().spatial_tendons.is_empty());
    let mut q = of_file.map_or_else(|| neutral(model), |(q, _)| q);
    for joint in model.joints().iter().filter(|joint| joint.nv == 1) {
        let described = model.description().joints.iter().find(|own| own.name == joint.name);
        if let Some(described) = described.filter(|own| own.mimic.is_none()) {
            q[joint.q_index] = described.softness.reference;
        }
    }
    q
}
