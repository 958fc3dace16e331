//! Handles of objects.
//!
//! A handle is a number: eight bits of the kind, 24 of the generation, 32 of the index in the table of its
//! kind. Freeing an object increases the generation of its slot, so an old handle no longer fits. A slot has
//! a generation of its own for 2²⁴ objects; then the numbers repeat.
//!
//! Looking up a handle takes a lock without waiting: one atomic operation, and one more at the end. A read
//! lock fails only while the object is freed, a write lock also while another call uses the object.

use std::ops::{Deref, DerefMut};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard, TryLockError};

use crate::Status;
use crate::failure::Failure;

/// A kind of object that C names by handles.
pub(crate) trait Object: Sized + Send + Sync + 'static {
    /// The number of the kind, not 0.
    const KIND: u8;
    /// The name of the kind, with its article.
    const NAME: &'static str;

    /// The table of this kind.
    fn table() -> &'static Table<Self>;
}

/// The number of slots of the first chunk; each further chunk has twice as many.
const FIRST: usize = 64;
/// All chunks together have 2³² slots, less the first ones.
const CHUNKS: usize = 26;
const GENERATIONS: u32 = 1 << 24;

/// Slots that are made together.
type Chunk<T> = Box<[Slot<T>]>;

/// The objects of one kind. Slots never move, and are never released.
pub(crate) struct Table<T> {
    chunks: [OnceLock<Chunk<T>>; CHUNKS],
    free: Mutex<Free>,
}

struct Slot<T> {
    /// It changes only while the object is locked for writing. Handles of other generations are refused
    /// without the lock, so that they do not disturb the present object.
    generation: AtomicU32,
    object: RwLock<Option<T>>,
}

/// The slots without an object: freed ones, and all from `end` on.
struct Free {
    slots: Vec<u32>,
    end: u32,
}

/// An object in use by several calls.
pub(crate) struct Shared<T: 'static>(RwLockReadGuard<'static, Option<T>>);

/// An object in use by this call alone.
pub(crate) struct Exclusive<T: 'static>(RwLockWriteGuard<'static, Option<T>>);

impl<T> Table<T> {
    pub(crate) const fn new() -> Self {
        Self {
            chunks: [const { OnceLock::new() }; CHUNKS],
            free: Mutex::new(Free { slots: Vec::new(), end: 0 }),
        }
    }

    fn slot(&self, index: u32) -> Option<&Slot<T>> {
        let (chunk, offset) = position(index);
        self.chunks.get(chunk)?.get()?.get(offset)
    }
}

/// The chunk of a slot and its place there.
fn position(index: u32) -> (usize, usize) {
    let shifted = index as usize + FIRST;
    let chunk = (shifted / FIRST).ilog2() as usize;
    (chunk, shifted - (FIRST << chunk))
}

/// Stores an object and returns its handle.
pub(crate) fn insert<T: Object>(object: T) -> Result<u64, Failure> {
    let table = T::table();
    let mut free = table.free.lock().unwrap_or_else(PoisonError::into_inner);
    let index = if let Some(index) = free.slots.pop() {
        index
    } else {
        let index = free.end;
        free.end = index.checked_add(1).ok_or_else(|| Failure::new(Status::System, "too many objects"))?;
        index
    };
    drop(free);
    let (chunk, offset) = position(index);
    let empty = || Slot { generation: AtomicU32::new(0), object: RwLock::new(None) };
    let slots = table.chunks[chunk].get_or_init(|| (0..FIRST << chunk).map(|_| empty()).collect());
    let slot = &slots[offset];
    *slot.object.write().unwrap_or_else(PoisonError::into_inner) = Some(object);
    let generation = slot.generation.load(Ordering::Acquire);
    Ok(u64::from(T::KIND) << 56 | u64::from(generation) << 32 | u64::from(index))
}

/// Frees an object. The null handle is ignored.
pub(crate) fn remove<T: Object>(handle: u64) -> Result<(), Failure> {
    if handle == 0 {
        return Ok(());
    }
    let slot = slot_of::<T>(handle)?;
    let mut own = match slot.object.try_write() {
        Ok(own) => own,
        // An earlier call on the object panicked.
        Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
        Err(TryLockError::WouldBlock) => return Err(in_use::<T>()),
    };
    check::<T>(slot, own.as_ref(), handle)?;
    let object = own.take();
    slot.generation.store((generation_of(handle) + 1) % GENERATIONS, Ordering::Release);
    drop(own);
    drop(object);
    // The lock of a slot with a fault is poisoned for good, so the slot is not used again.
    if !slot.object.is_poisoned() {
        T::table().free.lock().unwrap_or_else(PoisonError::into_inner).slots.push(handle as u32);
    }
    Ok(())
}

/// The object of a handle, for reading.
pub(crate) fn shared<T: Object>(handle: u64) -> Result<Shared<T>, Failure> {
    let slot = slot_of::<T>(handle)?;
    let own = match slot.object.try_read() {
        Ok(own) => own,
        Err(TryLockError::Poisoned(poisoned)) => {
            check::<T>(slot, poisoned.get_ref().as_ref(), handle)?;
            return Err(panicked::<T>());
        }
        Err(TryLockError::WouldBlock) => return Err(in_use::<T>()),
    };
    check::<T>(slot, own.as_ref(), handle)?;
    Ok(Shared(own))
}

/// The object of a handle, for this call alone.
pub(crate) fn exclusive<T: Object>(handle: u64) -> Result<Exclusive<T>, Failure> {
    let slot = slot_of::<T>(handle)?;
    let own = match slot.object.try_write() {
        Ok(own) => own,
        Err(TryLockError::Poisoned(poisoned)) => {
            check::<T>(slot, poisoned.get_ref().as_ref(), handle)?;
            return Err(panicked::<T>());
        }
        Err(TryLockError::WouldBlock) => return Err(in_use::<T>()),
    };
    check::<T>(slot, own.as_ref(), handle)?;
    Ok(Exclusive(own))
}

impl<T> Deref for Shared<T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.0.as_ref().expect("a checked slot has an object")
    }
}

impl<T> Deref for Exclusive<T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.0.as_ref().expect("a checked slot has an object")
    }
}

impl<T> DerefMut for Exclusive<T> {
    fn deref_mut(&mut self) -> &mut T {
        self.0.as_mut().expect("a checked slot has an object")
    }
}

/// The slot of a handle of this kind and of the slot's present generation.
fn slot_of<T: Object>(handle: u64) -> Result<&'static Slot<T>, Failure> {
    if handle >> 56 != u64::from(T::KIND) {
        return Err(foreign::<T>(handle));
    }
    let slot = T::table().slot(handle as u32).ok_or_else(invalid::<T>)?;
    let is_present = slot.generation.load(Ordering::Acquire) == generation_of(handle);
    if is_present { Ok(slot) } else { Err(invalid::<T>()) }
}

fn generation_of(handle: u64) -> u32 {
    (handle >> 32) as u32 % GENERATIONS
}

/// Checks a locked slot, whose generation may have changed before the lock.
fn check<T: Object>(slot: &Slot<T>, own: Option<&T>, handle: u64) -> Result<(), Failure> {
    let is_present = slot.generation.load(Ordering::Acquire) == generation_of(handle);
    if is_present && own.is_some() { Ok(()) } else { Err(invalid::<T>()) }
}

#[cold]
fn foreign<T: Object>(handle: u64) -> Failure {
    let text = if handle == 0 { "is null" } else { "names an object of another kind" };
    Failure::new(Status::InvalidHandle, format!("the handle of {} {text}", T::NAME))
}

#[cold]
fn invalid<T: Object>() -> Failure {
    Failure::new(Status::InvalidHandle, format!("the handle names no existing object; {} was freed", T::NAME))
}

#[cold]
fn in_use<T: Object>() -> Failure {
    Failure::new(
        Status::InUse,
        format!("{} serves another call now; use one object for each thread", T::NAME),
    )
}

#[cold]
fn panicked<T: Object>() -> Failure {
    Failure::new(Status::Panic, format!("an earlier call on {} panicked; free the object", T::NAME))
}

/// Declares a handle and its kind of object.
macro_rules! object {
    ($object:ty, $kind:literal, $name:literal) => {
        impl crate::handle::Object for $object {
            const KIND: u8 = $kind;
            const NAME: &'static str = $name;

            fn table() -> &'static crate::handle::Table<Self> {
                static TABLE: crate::handle::Table<$object> = crate::handle::Table::new();
                &TABLE
            }
        }
    };
}

pub(crate) use object;

#[cfg(test)]
mod tests {
    use super::*;

    struct Number {
        value: u64,
    }

    object!(Number, 200, "the number");

    #[test]
    fn slots_have_distinct_positions_in_chunks_of_double_size() {
        let (mut expected, mut size) = ((0, 0), FIRST);
        for index in 0..100_000 {
            assert_eq!(position(index), expected);
            expected.1 += 1;
            if expected.1 == size {
                (expected, size) = ((expected.0 + 1, 0), 2 * size);
            }
        }
        let (chunk, offset) = position(u32::MAX);
        assert!(chunk == CHUNKS && offset < FIRST << CHUNKS, "the last slots have no chunk");
    }

    #[test]
    fn handles_of_freed_objects_and_of_other_kinds_are_invalid() {
        let first = insert(Number { value: 1 }).expect("a slot");
        assert_eq!(first >> 56, 200);
        assert_eq!(shared::<Number>(first).expect("an object").value, 1);
        remove::<Number>(first).expect("an object");
        let status = |result: Result<(), Failure>| result.expect_err("an error").status;
        assert_eq!(status(shared::<Number>(first).map(drop)), Status::InvalidHandle);
        assert_eq!(status(remove::<Number>(first)), Status::InvalidHandle);
        let second = insert(Number { value: 2 }).expect("a slot");
        assert_ne!(first, second);
        assert_eq!(status(exclusive::<Number>(second ^ 1 << 56).map(drop)), Status::InvalidHandle);
        assert_eq!(status(exclusive::<Number>(second ^ 1 << 32).map(drop)), Status::InvalidHandle);
        exclusive::<Number>(second).expect("an object").value = 3;
        assert_eq!(shared::<Number>(second).expect("an object").value, 3);
        remove::<Number>(second).expect("an object");
    }

    struct Faulty;

    object!(Faulty, 201, "the faulty object");

    #[test]
    fn objects_of_panicked_calls_can_only_be_freed() {
        let handle = insert(Faulty).expect("a slot");
        let call = std::panic::catch_unwind(|| {
            let _own = exclusive::<Faulty>(handle);
            std::panic::resume_unwind(Box::new("a fault"));
        });
        assert!(call.is_err());
        let status = |handle| exclusive::<Faulty>(handle).map(drop).expect_err("an error").status;
        assert_eq!(status(handle), Status::Panic);
        assert_eq!(shared::<Faulty>(handle).map(drop).expect_err("an error").status, Status::Panic);
        remove::<Faulty>(handle).expect("an object");
        assert_eq!(status(handle), Status::InvalidHandle);
        assert_ne!(insert(Faulty).expect("a slot") as u32, handle as u32, "the slot is not used again");
    }

    struct Held;

    object!(Held, 202, "the held object");

    #[test]
    fn objects_in_use_are_neither_used_nor_freed() {
        let handle = insert(Held).expect("a slot");
        let status = |result: Result<(), Failure>| result.expect_err("an error").status;
        let own = exclusive::<Held>(handle).expect("an object");
        assert_eq!(status(shared::<Held>(handle).map(drop)), Status::InUse);
        assert_eq!(status(exclusive::<Held>(handle).map(drop)), Status::InUse);
        assert_eq!(status(remove::<Held>(handle)), Status::InUse);
        drop(own);
        let (first, second) = (shared::<Held>(handle), shared::<Held>(handle));
        assert!(first.is_ok() && second.is_ok());
        assert_eq!(status(remove::<Held>(handle)), Status::InUse);
        drop((first, second));
        remove::<Held>(handle).expect("an object");
    }
}
