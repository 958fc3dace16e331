//! TODO: rp_arm
