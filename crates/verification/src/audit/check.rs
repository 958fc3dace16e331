//! One check of an audit.

#[cfg(feature = "serde")]
use serde::{Serialize, Serializer};

/// A check and its result.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize))]
#[non_exhaustive]
pub struct Check {
    /// A stable short name.
    #[cfg_attr(feature = "serde", serde(rename = "check"))]
    pub name: String,
    /// The law in readable form.
    pub law: String,
    /// The worst value.
    #[cfg_attr(feature = "serde", serde(serialize_with = "finite_or_null"))]
    pub found: f64,
    /// The required relation of `found` to `allowed`.
    pub relation: &'static str,
    /// The bound.
    #[cfg_attr(feature = "serde", serde(serialize_with = "finite_or_null"))]
    pub allowed: f64,
    /// Whether the law holds.
    pub verdict: Verdict,
    /// The state or link of the worst value.
    #[cfg_attr(feature = "serde", serde(rename = "where"))]
    pub place: String,
}

/// The result of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum Verdict {
    /// The law holds.
    Ok,
    /// The law does not hold.
    Short,
}

impl Check {
    /// A check of one number; NaN always fails.
    pub(super) fn new(
        name: impl Into<String>,
        law: impl Into<String>,
        (found, allowed): (f64, f64),
        place: impl Into<String>,
    ) -> Self {
        let verdict = if found <= allowed { Verdict::Ok } else { Verdict::Short };
        Self {
            name: name.into(),
            law: law.into(),
            found,
            relation: "<=",
            allowed,
            verdict,
            place: place.into(),
        }
    }
}

/// The worst of many comparisons of a defect with its allowed rounding.
pub(super) struct LargestDefect {
    name: &'static str,
    law: &'static str,
    found: f64,
    allowed: f64,
    ratio: f64,
    place: String,
}

impl LargestDefect {
    pub(super) fn of(name: &'static str, law: &'static str) -> Self {
        Self { name, law, found: 0.0, allowed: 0.0, ratio: -1.0, place: String::new() }
    }

    /// Records a defect at a state.
    pub(super) fn record(&mut self, found: f64, allowed: f64, state: usize) {
        // A defect of zero passes for any bound; NaN is the worst defect.
        let ratio = match found / allowed {
            _ if found == 0.0 => 0.0,
            ratio if ratio.is_nan() => f64::INFINITY,
            ratio => ratio,
        };
        if ratio > self.ratio {
            (self.found, self.allowed, self.ratio) = (found, allowed, ratio);
            self.place = format!("state {state}");
        }
    }

    pub(super) fn check(self) -> Check {
        Check::new(self.name, self.law, (self.found, self.allowed), self.place)
    }
}

/// JSON cannot represent numbers that are not finite.
#[cfg(feature = "serde")]
#[allow(clippy::trivially_copy_pass_by_ref)] // the signature that serde requires
fn finite_or_null<S: Serializer>(x: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    if x.is_finite() { serializer.serialize_f64(*x) } else { serializer.serialize_none() }
}
