//! Values of properties as numbers, words or paths.

use std::cell::Cell;

use openusd::sdf;

/// The value of an attribute, or the targets of a relationship.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    /// Numbers of any type; flags are 0 or 1. Quaternions are w, x, y, z, and matrices row by row.
    Numbers(Vec<f64>),
    /// Tokens and strings.
    Words(Vec<String>),
    /// Paths of prims or properties.
    Targets(Vec<String>),
    /// A value of another type.
    Other,
}

/// A property of a prim, and whether the reader has used it.
#[derive(Debug)]
pub(crate) struct Property {
    pub(crate) value: Value,
    pub(crate) is_used: Cell<bool>,
}

impl Property {
    pub(crate) fn new(value: Value) -> Self {
        Self { value, is_used: Cell::new(false) }
    }
}

/// The number that a float stands for: the shortest decimal number that rounds to it. It is the number in the
/// text of a file, which a float cannot represent.
pub(crate) fn shortest(x: f32) -> f64 {
    if x == 0.0 || !x.is_finite() {
        return f64::from(x);
    }
    x.to_string().parse().unwrap_or(f64::from(x))
}

/// A number without its fraction, if it is from 0 to 4·10⁹.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // it is in the range
pub(crate) fn count(x: f64) -> Option<usize> {
    (0.0..4e9).contains(&x).then_some(x as usize)
}

impl Value {
    /// The number of numbers and words.
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Numbers(numbers) => numbers.len(),
            Self::Words(words) | Self::Targets(words) => words.len(),
            Self::Other => 0,
        }
    }

    pub(crate) fn of(value: sdf::Value) -> Self {
        use sdf::Value as V;
        let floats = |numbers: &[f32]| Self::Numbers(numbers.iter().map(|&x| shortest(x)).collect());
        match value {
            V::Bool(flag) => Self::Numbers(vec![f64::from(u8::from(flag))]),
            V::BoolVec(flags) => {
                Self::Numbers(flags.into_iter().map(|flag| f64::from(u8::from(flag))).collect())
            }
            V::Uchar(x) => Self::Numbers(vec![f64::from(x)]),
            V::Int(x) => Self::Numbers(vec![f64::from(x)]),
            V::IntVec(numbers) => Self::Numbers(numbers.into_iter().map(f64::from).collect()),
            V::Uint(x) => Self::Numbers(vec![f64::from(x)]),
            V::UintVec(numbers) => Self::Numbers(numbers.into_iter().map(f64::from).collect()),
            V::Int64(x) => Self::Numbers(vec![x as f64]),
            V::Int64Vec(numbers) => Self::Numbers(numbers.into_iter().map(|x| x as f64).collect()),
            V::Uint64(x) => Self::Numbers(vec![x as f64]),
            V::Half(x) => floats(&[x.to_f32()]),
            V::Float(x) => floats(&[x]),
            V::FloatVec(numbers) => floats(&numbers),
            V::Double(x) => Self::Numbers(vec![x]),
            V::DoubleVec(numbers) => Self::Numbers(numbers),
            V::Quath(q) => floats(&[q.w, q.x, q.y, q.z].map(openusd::gf::f16::to_f32)),
            V::Quatf(q) => floats(&[q.w, q.x, q.y, q.z]),
            V::Quatd(q) => Self::Numbers(vec![q.w, q.x, q.y, q.z]),
            V::Vec2f(v) => floats(&[v.x, v.y]),
            V::Vec2d(v) => Self::Numbers(vec![v.x, v.y]),
            V::Vec3h(v) => floats(&[v.x, v.y, v.z].map(openusd::gf::f16::to_f32)),
            V::Vec3f(v) => floats(&[v.x, v.y, v.z]),
            V::Vec3d(v) => Self::Numbers(vec![v.x, v.y, v.z]),
            V::Vec3i(v) => Self::Numbers([v.x, v.y, v.z].map(f64::from).to_vec()),
            V::Vec3fVec(points) => {
                Self::Numbers(points.iter().flat_map(|v| [v.x, v.y, v.z]).map(shortest).collect())
            }
            V::Vec3dVec(points) => Self::Numbers(points.iter().flat_map(|v| [v.x, v.y, v.z]).collect()),
            V::Vec4f(v) => floats(&[v.x, v.y, v.z, v.w]),
            V::Matrix4d(m) => Self::Numbers(m.0.to_vec()),
            V::Token(word) => Self::Words(vec![word.as_str().to_owned()]),
            V::TokenVec(words) => Self::Words(words.iter().map(|word| word.as_str().to_owned()).collect()),
            V::String(word) => Self::Words(vec![word]),
            V::StringVec(words) => Self::Words(words),
            V::AssetPath(path) => Self::Words(vec![path.into_string()]),
            _ => Self::Other,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::shortest;

    #[test]
    fn floats_are_the_numbers_of_the_text() {
        for text in ["0.73", "-0.16", "1100", "0.008726646", "1e-9"] {
            assert_eq!(shortest(text.parse().unwrap()), text.parse::<f64>().unwrap());
        }
        assert_eq!(shortest(f32::INFINITY), f64::INFINITY);
    }
}
