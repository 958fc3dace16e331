//! Forward kinematics and the Jacobians of every link, in the world's axes.

use robot_dynamics_core::Model;
use robot_dynamics_description::{Base, JointDescription, JointKind, Pose, check_length};
use robot_dynamics_number::Scalar;

use crate::lagrange::algebra::{M3, V3};

/// The pose of a link and its Jacobians by each coordinate of v, in the world's axes.
#[derive(Clone, Debug)]
pub struct LinkKinematics<S> {
    rotation: M3<S>,
    origin: V3<S>,
    /// The columns of J_ω and of the origin's J, one for each coordinate of v.
    angular: Vec<V3<S>>,
    linear: Vec<V3<S>>,
    pub(super) moving: bool,
}

impl<S: Scalar> LinkKinematics<S> {
    /// R, `world_from_link`, by rows.
    pub fn rotation(&self) -> [[S; 3]; 3] {
        self.rotation.0
    }

    /// The link's origin in the world \[m\].
    pub fn origin(&self) -> [S; 3] {
        self.origin.0
    }

    /// A point of the link, given in its frame, in the world \[m\].
    pub fn point(&self, point_in_link: [S; 3]) -> [S; 3] {
        (self.origin + self.rotation * V3(point_in_link)).0
    }

    /// The columns of J_ω: ω = J_ω v \[rad/s\].
    pub fn angular_jacobian(&self) -> Vec<[S; 3]> {
        self.angular.iter().map(|column| column.0).collect()
    }

    /// The columns of J: the velocity of a point fixed to the link, given in its frame, is J v \[m/s\].
    pub fn point_jacobian(&self, point_in_link: [S; 3]) -> Vec<[S; 3]> {
        // ẋ = ṗ + ω × (x − p).
        let arm = self.rotation * V3(point_in_link);
        self.linear
            .iter()
            .zip(&self.angular)
            .map(|(linear, angular)| (*linear + angular.cross(arm)).0)
            .collect()
    }

    fn world(nv: usize) -> Self {
        Self {
            rotation: M3::identity(),
            origin: V3::zero(),
            angular: vec![V3::zero(); nv],
            linear: vec![V3::zero(); nv],
            moving: false,
        }
    }

    /// Moves the frame's origin by a vector in the world: the columns change by J_ω × shift.
    fn shift(&mut self, shift: V3<S>) {
        self.origin += shift;
        for (linear, angular) in self.linear.iter_mut().zip(&self.angular) {
            *linear += angular.cross(shift);
        }
    }

    /// Continues to a frame at a constant placement in this one.
    fn fixed(&mut self, placement: &Pose) {
        self.shift(self.rotation * V3::from_f64(placement.translation));
        self.rotation = self.rotation.times(&M3::from_f64(placement.rotation));
    }

    /// Continues to a frame that is rotated by `angle` about `axis`; the rate of the angle is
    /// `ratio`·v\[coordinate\].
    fn turn(&mut self, axis: V3<S>, angle: S, coordinate: usize, ratio: f64) {
        self.angular[coordinate] += (self.rotation * axis) * S::from_f64(ratio);
        self.rotation = self.rotation.times(&rodrigues(axis, angle));
        self.moving = true;
    }

    /// Continues to a frame that is displaced by `way` along `axis`; the rate of the displacement is
    /// `ratio`·v\[coordinate\].
    fn slide(&mut self, axis: V3<S>, way: S, coordinate: usize, ratio: f64) {
        let direction = self.rotation * axis;
        self.shift(direction * way);
        self.linear[coordinate] += direction * S::from_f64(ratio);
        self.moving = true;
    }

    /// Continues to a frame that is rotated by a quaternion (x y z w); v\[coordinate..\] is ω in that frame.
    fn turn_freely(&mut self, xyzw: &[S], coordinate: usize) {
        self.rotation = self.rotation.times(&quaternion_rotation(xyzw));
        for k in 0..3 {
            self.angular[coordinate + k] += self.rotation.column(k);
        }
        self.moving = true;
    }
}

/// The pose and the Jacobians of every link at q, in the description's order of links.
///
/// ```
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// use robot_dynamics::verification::lagrange;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let rod = &lagrange::link_kinematics(&model, &[0.3])[1]; // link 0 is the ceiling
/// let [x, _, z] = rod.point([0.5, 0.0, 0.0]);
/// assert!((x - 0.5 * 0.3_f64.cos()).abs() < 1e-15 && (z + 0.5 * 0.3_f64.sin()).abs() < 1e-15);
/// let [[_, _, slope]] = rod.point_jacobian([0.5, 0.0, 0.0])[..] else { unreachable!("one coordinate") };
/// assert!((slope + 0.5 * 0.3_f64.cos()).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// Panics if q has the wrong length.
#[track_caller]
pub fn link_kinematics<S: Scalar>(model: &Model, q: &[S]) -> Vec<LinkKinematics<S>> {
    check_length("q", q.len(), model.nq());
    let description = model.description();
    let index = |name: &str| description.links.iter().position(|link| link.name == name).expect("checked");
    let is_child = |name: &str| description.joints.iter().any(|joint| joint.child == name);
    let root = description.links.iter().position(|link| !is_child(&link.name)).expect("checked");
    let mut base = LinkKinematics::world(model.nv());
    if description.base == Base::Floating {
        let joint = model.joint(&description.floating_base_name()).expect("a floating base adds this joint");
        move_freely(&mut base, &q[joint.q_index..joint.q_index + 7], joint.v_index);
    }
    let mut links: Vec<Option<LinkKinematics<S>>> = vec![None; description.links.len()];
    links[root] = Some(base);
    let mut pending = vec![root];
    while let Some(parent) = pending.pop() {
        for joint in description.joints.iter().filter(|j| j.parent == description.links[parent].name) {
            let mut link = links[parent].clone().expect("placed before its children");
            link.fixed(&joint.parent_from_joint);
            move_joint(model, joint, q, &mut link);
            let child = index(&joint.child);
            links[child] = Some(link);
            pending.push(child);
        }
    }
    links.into_iter().map(|link| link.expect("a tree reaches every link")).collect()
}

/// A joint's position as a function of q: q_joint = `ratio`·q\[`q_index`\] + `offset`, moved by
/// v\[`v_index`\].
pub(super) struct JointSource {
    pub q_index: usize,
    pub v_index: usize,
    pub ratio: f64,
    pub offset: f64,
}

/// The source of a joint's position: its own entry of q, or its leaders.
pub(super) fn joint_source(model: &Model, joint: &JointDescription) -> JointSource {
    let Some(mimic) = &joint.mimic else {
        let place = model.joint(&joint.name).expect("every joint of the description is in the model");
        return JointSource { q_index: place.q_index, v_index: place.v_index, ratio: 1.0, offset: 0.0 };
    };
    let leader = model.description().joints.iter().find(|j| j.name == mimic.joint).expect("checked");
    let leader = joint_source(model, leader);
    JointSource {
        ratio: mimic.ratio * leader.ratio,
        offset: mimic.ratio * leader.offset + mimic.offset,
        ..leader
    }
}

/// Continues from the joint's frame at q = 0 to the child link's frame.
fn move_joint<S: Scalar>(model: &Model, joint: &JointDescription, q: &[S], link: &mut LinkKinematics<S>) {
    if joint.kind == JointKind::Fixed {
        return;
    }
    let JointSource { q_index: i, v_index: j, ratio, offset } = joint_source(model, joint);
    let position = |k: usize| q[i + k].scale(ratio) + S::from_f64(offset);
    match joint.kind {
        JointKind::Fixed => {}
        JointKind::Revolute { axis } | JointKind::Continuous { axis } => {
            link.turn(unit(axis), position(0), j, ratio);
        }
        JointKind::Prismatic { axis } => link.slide(unit(axis), position(0), j, ratio),
        JointKind::Helical { axis, pitch } => {
            link.turn(unit(axis), position(0), j, ratio);
            link.slide(unit(axis), position(0).scale(pitch), j, ratio * pitch);
        }
        JointKind::Universal { first, second } => {
            link.turn(unit(first), position(0), j, 1.0);
            link.turn(unit(second), position(1), j + 1, 1.0);
        }
        JointKind::Planar { normal } => {
            let [x, y] = axes_of_plane(normal);
            link.slide(V3::from_f64(x), position(0), j, 1.0);
            link.slide(V3::from_f64(y), position(1), j + 1, 1.0);
            link.turn(unit(normal), position(2), j + 2, 1.0);
        }
        JointKind::Spherical => link.turn_freely(&q[i..i + 4], j),
        JointKind::Floating => move_freely(link, &q[i..i + 7], j),
    }
}

/// q = \[x y z, qx qy qz qw\] in the joint's frame, v = \[linear, angular\] in the child's.
fn move_freely<S: Scalar>(link: &mut LinkKinematics<S>, q: &[S], coordinate: usize) {
    link.shift(link.rotation * V3([q[0], q[1], q[2]]));
    link.turn_freely(&q[3..7], coordinate + 3);
    for k in 0..3 {
        link.linear[coordinate + k] += link.rotation.column(k);
    }
}

fn unit<S: Scalar>(axis: [f64; 3]) -> V3<S> {
    let norm = axis.iter().map(|a| a * a).sum::<f64>().sqrt();
    V3::from_f64(axis.map(|a| a / norm))
}

/// The x and y axes of a planar joint. x is the coordinate axis after the one with the normal's largest
/// component (the first of equals), made perpendicular to the normal; y = normal × x.
fn axes_of_plane(normal: [f64; 3]) -> [[f64; 3]; 2] {
    let V3(n): V3<f64> = unit(normal);
    let largest = (1..3).fold(0, |best, k| if n[k].abs() > n[best].abs() { k } else { best });
    let along = n[(largest + 1) % 3];
    let mut x = n.map(|component| -along * component);
    x[(largest + 1) % 3] += 1.0;
    let x: V3<f64> = unit(x);
    [x.0, V3(n).cross(x).0]
}

/// exp(\[a\]× θ) = 1 + sin θ \[a\]× + (1 − cos θ) \[a\]×² for a unit axis a. **(MLS §2.2; MR §3.2.3)**
fn rodrigues<S: Scalar>(axis: V3<S>, angle: S) -> M3<S> {
    let (sine, cosine) = angle.sin_cos();
    let k = M3::skew(axis);
    let kk = k.times(&k);
    let one = M3::<S>::identity();
    M3(core::array::from_fn(|i| {
        core::array::from_fn(|j| one.0[i][j] + sine * k.0[i][j] + (S::one() - cosine) * kk.0[i][j])
    }))
}

/// R of the quaternion (u, w), u = (x y z): R a = a + 2 (w u × a + u × (u × a))/|q|².
fn quaternion_rotation<S: Scalar>(xyzw: &[S]) -> M3<S> {
    let (u, w) = (V3([xyzw[0], xyzw[1], xyzw[2]]), xyzw[3]);
    let two = S::from_f64(2.0) / (u.dot(u) + w * w);
    let turned = |a: V3<S>| a + (u.cross(a) * w + u.cross(u.cross(a))) * two;
    let columns = M3::<S>::identity().0.map(|axis| turned(V3(axis)).0);
    M3(columns).transpose()
}
