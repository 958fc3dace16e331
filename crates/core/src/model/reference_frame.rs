//! The axes and the reference point of a frame's velocity.

/// The axes of a frame's velocity or acceleration, and the reference point of the linear part. For a wrench,
/// the axes and the point of application of the force. Pinocchio's `ReferenceFrame` has the same variants.
///
/// | variant | axes | reference point | Pinocchio |
/// | --- | --- | --- | --- |
/// | [`Local`](Self::Local) | the frame's | the frame's origin | `LOCAL` |
/// | [`World`](Self::World) | the world's | the world's origin | `WORLD` |
/// | [`LocalWorldAligned`](Self::LocalWorldAligned) | the world's | the frame's origin | `LOCAL_WORLD_ALIGNED` |
///
/// The default is `LocalWorldAligned`.
///
/// ```
/// use robot_dynamics::algorithms::ReferenceFrame;
/// assert_eq!(ReferenceFrame::default(), ReferenceFrame::LocalWorldAligned);
/// assert_eq!(ReferenceFrame::ALL.map(ReferenceFrame::name), ["local", "world", "local_world_aligned"]);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ReferenceFrame {
    /// The frame's own axes, and its origin: the body twist (MR §3.3.2). `LOCAL` in Pinocchio.
    #[doc(alias = "LOCAL")]
    #[doc(alias = "in_frame")]
    Local,
    /// The world's axes, and the point of the frame's body that coincides with the world's origin: the
    /// spatial twist (MR §3.3.2). `WORLD` in Pinocchio.
    #[doc(alias = "WORLD")]
    #[doc(alias = "in_world")]
    World,
    /// The world's axes, and the frame's origin: ṗ and ω as an observer at rest sees them.
    /// `LOCAL_WORLD_ALIGNED` in Pinocchio.
    #[doc(alias = "LOCAL_WORLD_ALIGNED")]
    #[doc(alias = "world_aligned")]
    #[default]
    LocalWorldAligned,
}

impl ReferenceFrame {
    /// All variants.
    pub const ALL: [Self; 3] = [Self::Local, Self::World, Self::LocalWorldAligned];

    /// The name in Python and in the names of generated functions.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Local => "local",
            Self::World => "world",
            Self::LocalWorldAligned => "local_world_aligned",
        }
    }
}
