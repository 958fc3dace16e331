//! Slices of the caller's numbers, read as slices of the numbers that a kernel computes with.
use crate::Scalar;

/// A number with the representation of an `S`: slices of one are slices of the other, without a copy.
pub trait View<S: Scalar>: Scalar {
    /// The number for x, without rounding.
    fn of(x: S) -> Self;
    /// The `S` for this number, without rounding.
    fn value(self) -> S;
    /// The numbers of the slice, viewed as this type.
    fn view(numbers: &[S]) -> &[Self];
    /// The numbers of the slice, viewed as this type and writable.
    fn view_mut(numbers: &mut [S]) -> &mut [Self];
    /// The reverse of [`View::view`].
    fn values(numbers: &[Self]) -> &[S];
    /// The reverse of [`View::view_mut`].
    fn values_mut(numbers: &mut [Self]) -> &mut [S];
}

impl<S: Scalar> View<S> for S {
    #[inline(always)]
    fn of(x: S) -> S {
        x
    }
    #[inline(always)]
    fn value(self) -> S {
        self
    }
    #[inline(always)]
    fn view(numbers: &[S]) -> &[S] {
        numbers
    }
    #[inline(always)]
    fn view_mut(numbers: &mut [S]) -> &mut [S] {
        numbers
    }
    #[inline(always)]
    fn values(numbers: &[S]) -> &[S] {
        numbers
    }
    #[inline(always)]
    fn values_mut(numbers: &mut [S]) -> &mut [S] {
        numbers
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_its_own_view() {
        let mut numbers = [1.0, 2.0];
        f64::view_mut(&mut numbers)[1] = <f64 as View<f64>>::of(3.0);
        assert_eq!(f64::view(&numbers), [1.0, 3.0]);
    }
}
