//! TODO: planar_arm
