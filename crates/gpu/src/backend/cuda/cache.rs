//! Compiled kernels in files of the user's cache, so that a program compiles a robot once.
//!
//! A file has the name of its key's hash. It holds the key (compiler, options, source text), the code and a
//! checksum. A file with another key or a wrong checksum counts as missing. Files are written under another
//! name and renamed, so that a reader never sees a part of one. Errors of the file system leave the code
//! uncached.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// The environment variable for the folder: `0` switches the cache off.
const VARIABLE: &str = "ROBOT_DYNAMICS_KERNEL_CACHE";

/// The first bytes of each file, with the version of the format.
const MAGIC: &[u8] = b"robot-dynamics kernel 1\n";

/// The folder for compiled kernels; `None` if the cache is off, or the user has no folder for caches.
pub(super) fn folder() -> Option<PathBuf> {
    folder_of(|name| std::env::var_os(name).filter(|value| !value.is_empty()))
}

fn folder_of(variable: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    if let Some(folder) = variable(VARIABLE) {
        return (folder != "0").then(|| folder.into());
    }
    let base = if cfg!(windows) {
        variable("LOCALAPPDATA").map(PathBuf::from)
    } else {
        let home = || variable("HOME").map(|home| Path::new(&home).join(".cache"));
        variable("XDG_CACHE_HOME").map(PathBuf::from).filter(|folder| folder.is_absolute()).or_else(home)
    };
    Some(base?.join("robot-dynamics").join("kernels"))
}

/// The code of this key, if the folder has it.
pub(super) fn load(folder: &Path, key: &[u8]) -> Option<Vec<u8>> {
    parse(&fs::read(folder.join(file_name(key))).ok()?, key).map(<[u8]>::to_vec)
}

/// Writes the code of this key, if the folder can be written.
pub(super) fn store(folder: &Path, key: &[u8], code: &[u8]) {
    static WRITTEN: AtomicU64 = AtomicU64::new(0);
    let name = file_name(key);
    let number = WRITTEN.fetch_add(1, Ordering::Relaxed);
    let partial = folder.join(format!("{name}.{}.{number}.tmp", std::process::id()));
    let written = fs::create_dir_all(folder)
        .and_then(|()| fs::write(&partial, contents(key, code)))
        .and_then(|()| fs::rename(&partial, folder.join(&name)));
    if written.is_err() {
        // The code is used without a file.
        let _ = fs::remove_file(&partial);
    }
}

fn contents(key: &[u8], code: &[u8]) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    for part in [key, code] {
        bytes.extend((part.len() as u64).to_le_bytes());
        bytes.extend(part);
    }
    let sum = hash(&bytes, 0);
    bytes.extend(sum.to_le_bytes());
    bytes
}

/// The code in a file's bytes, if they are those of this key.
fn parse<'a>(bytes: &'a [u8], key: &[u8]) -> Option<&'a [u8]> {
    let (all, sum) = bytes.split_last_chunk::<8>()?;
    if hash(all, 0).to_le_bytes() != *sum {
        return None;
    }
    let part = |bytes: &'a [u8]| {
        let (length, rest) = bytes.split_first_chunk::<8>()?;
        rest.split_at_checked(usize::try_from(u64::from_le_bytes(*length)).ok()?)
    };
    let (found, rest) = part(all.strip_prefix(MAGIC)?)?;
    let (code, rest) = part(rest)?;
    (found == key && rest.is_empty()).then_some(code)
}

/// 128 bits of two hashes.
fn file_name(key: &[u8]) -> String {
    format!("{:016x}{:016x}", hash(key, 0), hash(key, 1))
}

/// FNV-1a with 64 bits, after a first byte.
fn hash(bytes: &[u8], first: u8) -> u64 {
    let step = |sum: u64, byte: &u8| (sum ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
    bytes.iter().fold(step(0xcbf2_9ce4_8422_2325, &first), step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_folder_follows_the_environment() {
        let folder = |pairs: &[(&str, &str)]| {
            folder_of(|name| pairs.iter().find(|(own, _)| *own == name).map(|(_, value)| (*value).into()))
        };
        assert_eq!(folder(&[(VARIABLE, "0"), ("HOME", "/h")]), None);
        assert_eq!(folder(&[(VARIABLE, "/k"), ("HOME", "/h")]), Some("/k".into()));
        if !cfg!(windows) {
            assert_eq!(folder(&[]), None);
            assert_eq!(folder(&[("HOME", "/h")]), Some("/h/.cache/robot-dynamics/kernels".into()));
            let both = [("HOME", "/h"), ("XDG_CACHE_HOME", "/x")];
            assert_eq!(folder(&both), Some("/x/robot-dynamics/kernels".into()));
        }
    }

    #[test]
    fn an_entry_is_found_by_its_key_until_it_is_damaged() {
        let folder = std::env::temp_dir().join(format!("robot-dynamics-cache-{}", std::process::id()));
        assert_eq!(load(&folder, b"key"), None);
        store(&folder, b"key", b"code");
        assert_eq!(load(&folder, b"key").as_deref(), Some(&b"code"[..]));
        assert_eq!(load(&folder, b"other"), None);
        let file = folder.join(file_name(b"key"));
        let whole = fs::read(&file).unwrap();
        for at in 0..whole.len() {
            let mut damaged = whole.clone();
            damaged[at] ^= 1;
            assert_eq!(parse(&damaged, b"key"), None, "byte {at}");
            assert_eq!(parse(&whole[..at], b"key"), None, "cut at {at}");
        }
        fs::write(&file, &whole[..9]).unwrap();
        assert_eq!(load(&folder, b"key"), None);
        store(&folder, b"key", b"again");
        assert_eq!(load(&folder, b"key").as_deref(), Some(&b"again"[..]));
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1, "no partial file is left");
        fs::remove_dir_all(&folder).unwrap();
    }
}
