//! Copies that keep their capacity, so that later steps do not allocate.
//!
//! A derived `Clone` gives a copy's vectors capacity only for their elements, and its `clone_from` allocates.
//! [`clone_in_place`] wraps the definition of a struct: a copy has the capacity of the original, and
//! `clone_from` reuses memory that is large enough.

/// Defines a struct with named fields, and `Clone` as the module describes it.
#[doc(hidden)]
#[macro_export]
macro_rules! clone_in_place {
    (
        $(#[$meta:meta])*
        $visibility:vis struct $name:ident {
            $($(#[$field_meta:meta])* $field_visibility:vis $field:ident: $type:ty),* $(,)?
        }
    ) => {
        $(#[$meta])*
        $visibility struct $name {
            $($(#[$field_meta])* $field_visibility $field: $type),*
        }

        impl Clone for $name {
            fn clone(&self) -> Self {
                #[allow(unused_imports)]
                use $crate::clone_in_place::{AnyCopy, Original, VectorCopy};
                Self { $($field: Original(&self.$field).copied()),* }
            }

            fn clone_from(&mut self, source: &Self) {
                $(self.$field.clone_from(&source.$field);)*
            }
        }
    };
}
pub use clone_in_place;

/// A field to copy. Method resolution finds [`VectorCopy`] for vectors and arrays of them first, because
/// [`AnyCopy`] needs one more reference.
pub struct Original<'a, T>(pub &'a T);

/// A copy with the capacity of the original.
pub trait VectorCopy {
    type Copy;
    fn copied(self) -> Self::Copy;
}

fn with_room<T: Clone>(original: &Vec<T>) -> Vec<T> {
    let mut copy = Vec::with_capacity(original.capacity());
    copy.extend_from_slice(original);
    copy
}

impl<T: Clone> VectorCopy for Original<'_, Vec<T>> {
    type Copy = Vec<T>;
    fn copied(self) -> Vec<T> {
        with_room(self.0)
    }
}

impl<T: Clone, const N: usize> VectorCopy for Original<'_, [Vec<T>; N]> {
    type Copy = [Vec<T>; N];
    fn copied(self) -> [Vec<T>; N] {
        self.0.each_ref().map(with_room)
    }
}

/// A copy of anything else.
pub trait AnyCopy {
    type Copy;
    fn copied(&self) -> Self::Copy;
}

impl<T: Clone> AnyCopy for Original<'_, T> {
    type Copy = T;
    fn copied(&self) -> T {
        self.0.clone()
    }
}

#[cfg(test)]
mod tests {
    clone_in_place! {
        #[derive(Debug, PartialEq)]
        struct Example {
            numbers: Vec<f64>,
            pairs: [Vec<u8>; 2],
            name: &'static str,
        }
    }

    fn example() -> Example {
        let mut example =
            Example { numbers: Vec::with_capacity(9), pairs: [vec![1], Vec::with_capacity(5)], name: "a" };
        example.numbers.push(0.5);
        example
    }

    #[test]
    fn copies_have_room() {
        let copy = example().clone();
        assert_eq!(copy, example());
        assert!(copy.numbers.capacity() >= 9 && copy.pairs[1].capacity() >= 5);
    }

    #[test]
    fn copies_are_written_into_what_is_there() {
        let mut other = Example { numbers: vec![0.0; 20], pairs: [vec![0; 8], vec![0; 8]], name: "b" };
        let place = other.numbers.as_ptr();
        other.clone_from(&example());
        assert_eq!(other, example());
        assert!(
            other.numbers.as_ptr() == place
                && other.numbers.capacity() == 20
                && other.pairs[0].capacity() == 8
        );
    }
}
