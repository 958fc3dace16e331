//! Checks of single numbers, poses and names.

use std::collections::HashMap;

use crate::{ModelError, PolynomialStiffnessDamping, Pose};

pub(super) fn index_names<'a>(
    sort: &'static str,
    names: impl Iterator<Item = &'a str>,
) -> Result<HashMap<&'a str, usize>, ModelError> {
    let mut index = HashMap::new();
    for (i, name) in names.enumerate() {
        if index.insert(name, i).is_some() {
            return Err(ModelError::DuplicateName { sort, name: name.into() });
        }
    }
    Ok(index)
}

pub(super) fn check(
    ok: bool,
    owner: &str,
    quantity: &'static str,
    value: f64,
    expected: &'static str,
) -> Result<(), ModelError> {
    if ok { Ok(()) } else { Err(ModelError::BadNumber { owner: owner.into(), quantity, value, expected }) }
}

/// RᵀR = 1 and det R = 1 up to 1e-6: looser than rounding, but tight enough to detect a wrong matrix.
pub(crate) fn check_pose(owner: &str, pose: &Pose) -> Result<(), ModelError> {
    for x in pose.translation {
        check(x.is_finite(), owner, "translation", x, "finite")?;
    }
    let defect = pose.rotation_defect();
    if defect <= 1e-6 { Ok(()) } else { Err(ModelError::NotARotation { owner: owner.into(), defect }) }
}

pub(super) fn check_range(
    owner: &str,
    quantity: &'static str,
    [lower, upper]: [f64; 2],
) -> Result<(), ModelError> {
    check(!lower.is_nan(), owner, quantity, lower, "a number")?;
    check(upper >= lower, owner, quantity, upper, "at or above its lower end")
}

pub(super) fn check_terms(owner: &str, terms: &PolynomialStiffnessDamping) -> Result<(), ModelError> {
    for value in terms.stiffness.into_iter().chain(terms.damping) {
        check(value.is_finite(), owner, "higher term", value, "finite")?;
    }
    Ok(())
}

pub(super) fn unknown(user: &str, sort: &'static str, name: &str) -> ModelError {
    ModelError::UnknownName { user: user.into(), sort, name: name.into() }
}
