//! Slices of hardware floats, viewed as slices of floats with a fused multiply-add.
#![allow(unsafe_code)]

use crate::View;
use crate::fma_float::FmaFloat;

macro_rules! view {
    ($float:ty) => {
        impl View<$float> for FmaFloat<$float> {
            #[inline(always)]
            fn of(x: $float) -> Self {
                Self(x)
            }
            #[inline(always)]
            fn value(self) -> $float {
                self.0
            }
            #[inline(always)]
            fn view(numbers: &[$float]) -> &[Self] {
                // SAFETY: `FmaFloat<T>` is a transparent wrapper of T: same size, alignment and valid bits.
                // The lifetime is the argument's.
                unsafe { core::slice::from_raw_parts(numbers.as_ptr().cast(), numbers.len()) }
            }
            #[inline(always)]
            fn view_mut(numbers: &mut [$float]) -> &mut [Self] {
                // SAFETY: as above, and the argument is borrowed for as long as the result.
                unsafe { core::slice::from_raw_parts_mut(numbers.as_mut_ptr().cast(), numbers.len()) }
            }
            #[inline(always)]
            fn values(numbers: &[Self]) -> &[$float] {
                // SAFETY: as above.
                unsafe { core::slice::from_raw_parts(numbers.as_ptr().cast(), numbers.len()) }
            }
            #[inline(always)]
            fn values_mut(numbers: &mut [Self]) -> &mut [$float] {
                // SAFETY: as above, and the argument is borrowed for as long as the result.
                unsafe { core::slice::from_raw_parts_mut(numbers.as_mut_ptr().cast(), numbers.len()) }
            }
        }
    };
}
view!(f64);
view!(f32);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_machines_numbers_are_the_same_numbers() {
        let mut numbers = [1.0, -0.0, f64::NAN, f64::MIN_POSITIVE / 4.0];
        let bits = numbers.map(f64::to_bits);
        assert_eq!(
            FmaFloat::view(&numbers[..]).iter().map(|x: &FmaFloat<f64>| x.0.to_bits()).collect::<Vec<_>>(),
            bits
        );
        let viewed: &mut [FmaFloat<f64>] = View::view_mut(&mut numbers[..]);
        viewed[2] = View::of(7.5);
        assert_eq!(<FmaFloat<f64> as View<f64>>::values(viewed)[2], 7.5);
        View::<f64>::values_mut(viewed)[1] = 2.5;
        assert_eq!(numbers[1..3], [2.5, 7.5]);
        assert_eq!(View::<f32>::value(FmaFloat(0.1f32)), 0.1);
    }
}
