//! The likely cause: the one wrong unit that explains a link's statistics best.

use core::fmt;

#[cfg(feature = "serde")]
use serde::Serialize;

use super::LinkStatistics;

/// The numbers that seem wrong, and their factor.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize))]
#[non_exhaustive]
pub struct Cause {
    /// The numbers.
    pub culprit: Culprit,
    /// The approximate factor by which they are too large; below 1 for too small. Accurate to half a decade.
    pub factor: f64,
}

/// The numbers of a file that can be in the wrong unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Culprit {
    /// m.
    Masses,
    /// I.
    Moments,
    /// m and I by the same factor, as with a wrong density in CAD.
    MassesAndMoments,
    /// The joints' offsets.
    Spacing,
    /// c.
    CentersOfMass,
    /// Angles of frames.
    Angles,
    /// Limits of rotations.
    AngleLimits,
    /// Limits of slides.
    SlideLimits,
}

/// Units that are often confused, with the number of wrong units in a right one.
const UNITS: [(Culprit, f64, &str); 15] = [
    (Culprit::Masses, 1e3, "g written for kg"),
    (Culprit::Masses, 1e-3, "t written for kg"),
    (Culprit::Moments, 1e3, "g·m² or t·mm² written for kg·m²"),
    (Culprit::Moments, 1e4, "kg·cm² written for kg·m²"),
    (Culprit::Moments, 1e6, "kg·mm² written for kg·m²"),
    (Culprit::Moments, 1e7, "g·cm² written for kg·m²"),
    (Culprit::Moments, 1e9, "g·mm² written for kg·m²"),
    (Culprit::Moments, 1e-3, "t·m² written for kg·m²"),
    (Culprit::Moments, 1e-6, "converted from kg·mm² twice"),
    (Culprit::MassesAndMoments, 1e3, "g written for kg"),
    (Culprit::MassesAndMoments, 1e-3, "t written for kg"),
    (Culprit::Spacing, 1e3, "mm written for m"),
    (Culprit::Spacing, 1e-3, "km written for m"),
    (Culprit::CentersOfMass, 1e3, "mm written for m"),
    (Culprit::SlideLimits, 1e3, "mm written for m"),
];

fn units(culprit: Culprit) -> impl Iterator<Item = &'static (Culprit, f64, &'static str)> {
    UNITS.iter().filter(move |unit| unit.0 == culprit)
}

/// The factor beyond which no wrong unit is a plausible explanation \[decades\].
const PLACEHOLDER: f64 = 11.0;

impl fmt::Display for Cause {
    /// Formats as `moments about 1e6 times too large (kg·mm² written for kg·m²?)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self.culprit {
            Culprit::Masses => "mass",
            Culprit::Moments => "moments of inertia",
            Culprit::MassesAndMoments => "mass and moments of inertia",
            Culprit::Spacing => "joint spacing",
            Culprit::CentersOfMass => "centre of mass",
            Culprit::Angles | Culprit::AngleLimits => return f.write_str("degrees written for radians?"),
            Culprit::SlideLimits => "travel",
        };
        let decades = self.factor.log10();
        if !decades.is_finite() || decades.abs() > PLACEHOLDER {
            return write!(f, "{what}: a placeholder?");
        }
        if decades.abs() < 0.5 {
            return write!(f, "{what}?");
        }
        let sense = if decades > 0.0 { "large" } else { "small" };
        write!(f, "{what} about {:.0e} times too {sense}", 10f64.powf(decades.abs().round()))?;
        let distance = |factor: f64| (factor.log10() - decades).abs();
        let nearest = units(self.culprit).min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
        match nearest {
            Some(&(_, factor, unit)) if distance(factor) <= 0.7 => write!(f, " ({unit}?)"),
            _ => Ok(()),
        }
    }
}

/// log₁₀ of ρ, of √(I₃/m)/L and of m/L³ of a link, if they are known.
pub(super) type Decades = [Option<f64>; 3];

pub(super) fn decades(link: &LinkStatistics) -> Decades {
    [link.ellipsoid_density, link.gyration_over_extent(), link.mass_over_cubed_extent()]
        .map(|value| value.map(f64::log10).filter(|decades| decades.is_finite()))
}

/// Medians over correct robots, and the spread of their links \[decades\]: 850 kg/m³, 0.31, 90 kg/m³.
const TYPICAL: [(f64, f64); 3] = [(2.93, 0.35), (-0.51, 0.25), (1.95, 0.75)];

/// The culprit that explains the statistics x best. Let s be the shift of each statistic per decade of a
/// factor. The factor's decades are f = Σ s x/σ² / Σ s²/σ², and the culprit with the least Σ (x − f s)²/σ²
/// wins. A factor of no known unit costs up to as much as a statistic 3σ away.
pub(super) fn explain(found: Decades, is_general: bool) -> Cause {
    const CANDIDATES: [(Culprit, [f64; 3]); 4] = [
        (Culprit::Moments, [-1.5, 0.5, 0.0]),
        (Culprit::Masses, [2.5, -0.5, 1.0]),
        (Culprit::MassesAndMoments, [1.0, 0.0, 1.0]),
        (Culprit::Spacing, [0.0, -1.0, -3.0]),
    ];
    let known = || found.iter().zip(TYPICAL).enumerate();
    let sum = |term: &dyn Fn(usize, f64) -> f64| -> f64 {
        known()
            .filter_map(|(i, (x, (mean, sigma)))| Some(term(i, x.as_ref()? - mean) / (sigma * sigma)))
            .sum()
    };
    let mut best = (f64::INFINITY, Cause { culprit: Culprit::Moments, factor: 1.0 });
    for (culprit, shift) in CANDIDATES {
        // One link's spacing is also its neighbours'.
        let square = sum(&|i, _| shift[i] * shift[i]);
        if square == 0.0 || (culprit == Culprit::Spacing && !is_general) {
            continue;
        }
        let decades = sum(&|i, x| shift[i] * x) / square;
        let off = units(culprit).map(|(_, factor, _)| (factor.log10() - decades).abs()).fold(1.25, f64::min);
        let rest = sum(&|i, x| (x - decades * shift[i]).powi(2)) + (off / 0.4).powi(2);
        if rest < best.0 - 1e-9 {
            best = (rest, Cause { culprit, factor: 10f64.powf(decades) });
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A typical link with one wrong culprit is explained by that culprit and its factor.
    #[test]
    fn each_culprit_explains_its_own_traces() {
        let typical = TYPICAL.map(|(mean, _)| mean);
        let spoilt = |shift: [f64; 3], decades: f64| [0, 1, 2].map(|i| Some(typical[i] + decades * shift[i]));
        for (culprit, shift) in [
            (Culprit::Masses, [2.5, -0.5, 1.0]),
            (Culprit::Moments, [-1.5, 0.5, 0.0]),
            (Culprit::MassesAndMoments, [1.0, 0.0, 1.0]),
            (Culprit::Spacing, [0.0, -1.0, -3.0]),
        ] {
            for decades in [-6.0, -3.0, 3.0, 6.0] {
                let cause = explain(spoilt(shift, decades), true);
                assert_eq!(cause.culprit, culprit, "{decades}");
                assert!((cause.factor.log10() - decades).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn causes_name_the_unit() {
        let shown = |culprit, factor| Cause { culprit, factor }.to_string();
        assert_eq!(
            shown(Culprit::Moments, 6e5),
            "moments of inertia about 1e6 times too large (kg·mm² written for kg·m²?)"
        );
        assert_eq!(shown(Culprit::Masses, 2e-3), "mass about 1e3 times too small (t written for kg?)");
        assert_eq!(shown(Culprit::Moments, 80.0), "moments of inertia about 1e2 times too large");
        assert_eq!(shown(Culprit::Moments, 1e-33), "moments of inertia: a placeholder?");
        assert_eq!(shown(Culprit::Angles, 57.3), "degrees written for radians?");
    }
}
