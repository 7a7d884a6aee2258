//! A cache of packed files and thumbnails in a directory of limited size. If a server is killed
//! while it writes a file, the other files stay valid.
//!
//! ```text
//! KEY.cached:  "TRISTRIP" │ version │ CRC-32 of the content │ length of the content │ content
//! ```
//!
//! # Algorithm
//! - Write: files are written under a temporary name and then renamed, so a name refers to a
//!   complete file or to none. The writer locks its temporary file. An unlocked temporary file was
//!   left by a killed process; it is removed when a server starts.
//! - Open: the header and the length are always checked. The checksum is checked once per process
//!   and version of the file. A damaged file is removed and created again.
//! - Evict: the least recently used files are removed. The cache sets the access times of its files
//!   itself. A file that is being sent stays open until it is sent.
//!
//! Several servers can share a directory.

use std::collections::HashMap;
use std::fs::{self, File, FileTimes, TryLockError};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::SystemTime;

use bytes::Bytes;
use tempfile::TempDir;

use crate::bytes_source::{BytesSource, read_at};
use crate::error::Error;

const MAGIC: &[u8; 8] = b"TRISTRIP";
const VERSION: u32 = 1;
const HEAD_BYTES: u64 = 24;
const EXTENSION: &str = "cached";
const TEMPORARY: &str = "writing";
const PREFIX: &str = "tristrip-";
/// The number of hexadecimal digits of a key.
const KEY_DIGITS: usize = 40;

/// A directory of cached files.
#[derive(Debug)]
pub(crate) struct Cache {
    folder: PathBuf,
    /// The temporary directory, which is removed when the cache is dropped; `None` for a permanent
    /// one.
    _temporary: Option<TempDir>,
    most_bytes: u64,
    /// The files whose checksum was verified, with the size and modification time at that time.
    verified: Mutex<HashMap<String, (u64, SystemTime)>>,
}

/// The result of a job, from the cache or new.
#[derive(Debug, Clone)]
pub(crate) struct Made {
    pub(crate) source: BytesSource,
    pub(crate) checksum: u32,
}

impl Made {
    fn in_memory(bytes: Vec<u8>) -> Self {
        Self { checksum: crc32fast::hash(&bytes), source: BytesSource::Memory(Bytes::from(bytes)) }
    }
}

impl Cache {
    /// Opens a directory and removes temporary files of killed processes. The directory is created
    /// if it does not exist.
    pub(crate) fn open(folder: &Path, most_bytes: u64) -> Result<Self, Error> {
        let failed = |source| Error::io(folder, source);
        create(folder).map_err(failed)?;
        if !is_own(folder).map_err(failed)? {
            return Err(Error::Parameter {
                name: "cache",
                found: folder.display().to_string(),
                expected: "a directory that this user owns and others cannot write to",
            });
        }
        for path in files(folder, is_temporary).map_err(failed)? {
            let is_left =
                File::open(&path).is_ok_and(|file| !matches!(file.try_lock(), Err(TryLockError::WouldBlock)));
            if is_left {
                fs::remove_file(&path).unwrap_or_default();
            }
        }
        let cache =
            Self { folder: folder.to_path_buf(), _temporary: None, most_bytes, verified: Mutex::default() };
        cache.evict();
        Ok(cache)
    }

    /// Opens a new directory that only this user can read. It is removed with the cache.
    pub(crate) fn temporary(most_bytes: u64) -> Result<Self, Error> {
        let made = tempfile::Builder::new().prefix(PREFIX).tempdir();
        let folder = made.map_err(|source| Error::io(&std::env::temp_dir(), source))?;
        let cache = Self::open(&folder.path().join("cache"), most_bytes)?;
        Ok(Self { _temporary: Some(folder), ..cache })
    }

    /// Returns the bytes of a key if the cache has them and they are not damaged.
    pub(crate) fn get(&self, key: &str) -> Option<Made> {
        let path = self.path(key);
        let file = File::open(&path).ok()?;
        match self.checked(key, file) {
            Ok(made) => Some(made),
            Err(error) => {
                tracing::warn!(key, %error, "removed a damaged cache file");
                fs::remove_file(&path).unwrap_or_default();
                None
            }
        }
    }

    /// Stores bytes and returns them. If they cannot be written, they stay in memory while they are
    /// sent.
    pub(crate) fn put(&self, key: &str, bytes: Vec<u8>) -> Made {
        let made = match self.write(key, &bytes) {
            Ok(file) => self.checked(key, file),
            Err(error) => Err(error),
        };
        self.evict();
        made.unwrap_or_else(|error| {
            tracing::warn!(key, %error, "could not write to the cache");
            Made::in_memory(bytes)
        })
    }

    /// Returns the total size of all cached files in bytes.
    pub(crate) fn used_bytes(&self) -> u64 {
        let files = files(&self.folder, is_cached).unwrap_or_default();
        files.iter().filter_map(|path| fs::metadata(path).ok()).map(|metadata| metadata.len()).sum()
    }

    fn path(&self, key: &str) -> PathBuf {
        self.folder.join(key).with_extension(EXTENSION)
    }

    fn write(&self, key: &str, bytes: &[u8]) -> io::Result<File> {
        let suffix = format!(".{TEMPORARY}");
        let mut temporary =
            tempfile::Builder::new().prefix(PREFIX).suffix(&suffix).tempfile_in(&self.folder)?;
        temporary.as_file().lock()?;
        let mut head = Vec::with_capacity(HEAD_BYTES as usize);
        head.extend(MAGIC);
        head.extend(VERSION.to_le_bytes());
        head.extend(crc32fast::hash(bytes).to_le_bytes());
        head.extend((bytes.len() as u64).to_le_bytes());
        temporary.write_all(&head)?;
        temporary.write_all(bytes)?;
        let path = self.path(key);
        temporary.persist(&path).map_err(|error| error.error)?;
        File::open(&path)
    }

    /// Checks a file against its header.
    fn checked(&self, key: &str, mut file: File) -> io::Result<Made> {
        let wrong = |what: &str| io::Error::new(io::ErrorKind::InvalidData, what.to_owned());
        let mut head = [0; HEAD_BYTES as usize];
        file.read_exact(&mut head)?;
        let (magic, rest) = head.split_at(MAGIC.len());
        let number = |at: usize| {
            rest[at..at + 4].try_into().map(u32::from_le_bytes).map_err(|_| wrong("wrong header"))
        };
        let (version, checksum) = (number(0)?, number(4)?);
        let length = u64::from(number(8)?) | u64::from(number(12)?) << 32;
        let metadata = file.metadata()?;
        if magic != MAGIC || version != VERSION || metadata.len() != HEAD_BYTES.saturating_add(length) {
            return Err(wrong("wrong header or length"));
        }
        let seen = (metadata.len(), metadata.modified()?);
        let is_verified =
            self.verified.lock().unwrap_or_else(PoisonError::into_inner).get(key) == Some(&seen);
        if !is_verified {
            if checksum_of(&file)? != checksum {
                return Err(wrong("wrong checksum"));
            }
            self.verified.lock().unwrap_or_else(PoisonError::into_inner).insert(key.to_owned(), seen);
        }
        // If the time cannot be set, the file is evicted sooner.
        file.set_times(FileTimes::new().set_accessed(SystemTime::now())).unwrap_or_default();
        Ok(Made { source: BytesSource::of_file(file, HEAD_BYTES, length)?, checksum })
    }

    /// Removes the least recently used files until the others fit into the size limit.
    fn evict(&self) {
        let mut found: Vec<(SystemTime, u64, PathBuf)> = files(&self.folder, is_cached)
            .unwrap_or_default()
            .into_iter()
            .filter_map(|path| {
                let metadata = fs::metadata(&path).ok()?;
                Some((metadata.accessed().ok()?, metadata.len(), path))
            })
            .collect();
        let mut used: u64 = found.iter().map(|(_, bytes, _)| bytes).sum();
        found.sort();
        for (_, bytes, path) in found {
            if used <= self.most_bytes {
                break;
            }
            if fs::remove_file(&path).is_ok() {
                used -= bytes;
                let key = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
                self.verified.lock().unwrap_or_else(PoisonError::into_inner).remove(&key);
            }
        }
    }
}

/// Returns the checksum of the bytes after the header.
fn checksum_of(file: &File) -> io::Result<u32> {
    let (mut hasher, mut at, mut piece) = (crc32fast::Hasher::new(), HEAD_BYTES, vec![0; 1 << 18]);
    loop {
        match read_at(file, &mut piece, at)? {
            0 => return Ok(hasher.finalize()),
            count => {
                hasher.update(&piece[..count]);
                at += count as u64;
            }
        }
    }
}

/// Creates a directory that only this user can read, if it does not exist.
fn create(folder: &Path) -> io::Result<()> {
    let mut builder = fs::DirBuilder::new();
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.recursive(true).create(folder)
}

/// Checks that this user owns a directory and that others cannot write to it. Otherwise they could
/// send any bytes to clients.
fn is_own(folder: &Path) -> io::Result<bool> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let metadata = fs::metadata(folder)?;
        Ok(metadata.uid() == rustix::process::geteuid().as_raw() && metadata.mode() & 0o002 == 0)
    }
    #[cfg(not(unix))]
    fs::metadata(folder).map(|metadata| metadata.is_dir())
}

/// Returns the files of a directory whose names match a pattern of the cache.
fn files(folder: &Path, is_named: fn(&str) -> bool) -> io::Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder)?.filter_map(Result::ok);
    let is_named = |entry: &fs::DirEntry| entry.file_name().to_str().is_some_and(is_named);
    Ok(entries.filter(is_named).map(|entry| entry.path()).collect())
}

fn is_temporary(name: &str) -> bool {
    name.starts_with(PREFIX) && name.strip_suffix(TEMPORARY).is_some_and(|rest| rest.ends_with('.'))
}

fn is_cached(name: &str) -> bool {
    let key = name.strip_suffix(EXTENSION).and_then(|rest| rest.strip_suffix('.'));
    key.is_some_and(|key| key.len() == KEY_DIGITS && key.bytes().all(|digit| digit.is_ascii_hexdigit()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes_of(cache: &Cache, key: &str) -> Option<Vec<u8>> {
        cache.get(key).map(|made| made.source.read().unwrap())
    }

    #[test]
    fn what_is_put_is_there_again() {
        let dir = tempfile::tempdir().unwrap();
        let cache = Cache::open(dir.path(), 1 << 30).unwrap();
        let [a, b] = ["a", "b"].map(|name| name.repeat(KEY_DIGITS));
        assert!(cache.get(&a).is_none());
        let long = vec![7; 200_000];
        let made = cache.put(&a, long.clone());
        assert_eq!((made.source.len(), made.source.read().unwrap()), (200_000, long.clone()));
        cache.put(&b, b"short".to_vec());
        let again = Cache::open(dir.path(), 1 << 30).unwrap();
        assert_eq!(bytes_of(&again, &a), Some(long));
        assert_eq!(bytes_of(&again, &b).as_deref(), Some(&b"short"[..]));
        assert_eq!(again.used_bytes(), 200_000 + 5 + 2 * HEAD_BYTES);
    }

    #[test]
    fn damaged_files_are_removed() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.cached");
        let damages: [fn(&mut Vec<u8>); 6] = [
            |bytes| bytes[100] ^= 1,
            |bytes| bytes[0] ^= 1,
            |bytes| bytes[9] ^= 1,
            |bytes| bytes.truncate(100),
            |bytes| bytes.push(0),
            Vec::clear,
        ];
        for damage in damages {
            Cache::open(dir.path(), 1 << 30).unwrap().put("a", vec![5; 1000]);
            let mut bytes = fs::read(&path).unwrap();
            damage(&mut bytes);
            fs::write(&path, &bytes).unwrap();
            assert!(Cache::open(dir.path(), 1 << 30).unwrap().get("a").is_none());
            assert!(!path.exists());
        }
    }

    #[test]
    fn the_least_recently_used_files_are_evicted() {
        let dir = tempfile::tempdir().unwrap();
        let cache = Cache::open(dir.path(), 3000).unwrap();
        let key = |name: &str| name.repeat(KEY_DIGITS);
        let used_at = |name: &str, seconds: u64| {
            let time = SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(seconds);
            let file = File::open(dir.path().join(key(name)).with_extension("cached")).unwrap();
            file.set_times(FileTimes::new().set_accessed(time)).unwrap();
        };
        cache.put(&key("a"), vec![1; 900]);
        cache.put(&key("b"), vec![2; 900]);
        cache.put(&key("c"), vec![3; 900]);
        fs::write(dir.path().join("other.cached"), vec![0; 9000]).unwrap();
        used_at("a", 2000);
        used_at("b", 1000);
        used_at("c", 3000);
        cache.put(&key("d"), vec![4; 900]);
        assert!(cache.get(&key("b")).is_none());
        assert!(["a", "c", "d"].iter().all(|name| cache.get(&key(name)).is_some()));
        assert!(dir.path().join("other.cached").exists());
        // A result larger than the cache is sent but not stored.
        let made = cache.put(&key("e"), vec![5; 100_000]);
        assert_eq!(made.source.read().unwrap(), vec![5; 100_000]);
        assert!(cache.used_bytes() <= 3000);
    }

    #[test]
    fn only_temporary_files_that_nobody_writes_are_removed() {
        let dir = tempfile::tempdir().unwrap();
        let (left, written) = (dir.path().join("tristrip-1.writing"), dir.path().join("tristrip-2.writing"));
        fs::write(&left, "half").unwrap();
        let writer = File::create(&written).unwrap();
        writer.lock().unwrap();
        let other = dir.path().join("other.writing");
        fs::write(&other, "of the user").unwrap();
        Cache::open(dir.path(), 0).unwrap();
        assert!(!left.exists() && written.exists() && other.exists());
    }

    #[cfg(unix)]
    #[test]
    fn folders_are_private_and_those_that_others_can_write_to_are_refused() {
        use std::os::unix::fs::PermissionsExt;
        let dir = tempfile::tempdir().unwrap();
        let folder = dir.path().join("a/b");
        Cache::open(&folder, 0).unwrap();
        assert_eq!(fs::metadata(&folder).unwrap().permissions().mode() & 0o777, 0o700);
        fs::set_permissions(&folder, fs::Permissions::from_mode(0o777)).unwrap();
        assert!(matches!(Cache::open(&folder, 0), Err(Error::Parameter { name: "cache", .. })));
        let cache = Cache::temporary(1 << 20).unwrap();
        let folder = cache.folder.clone();
        assert_eq!(fs::metadata(&folder).unwrap().permissions().mode() & 0o777, 0o700);
        drop(cache);
        assert!(!folder.exists());
    }

    #[test]
    fn a_folder_that_cannot_be_written_loses_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let cache = Cache::open(&dir.path().join("cache"), 1 << 30).unwrap();
        fs::remove_dir(dir.path().join("cache")).unwrap();
        assert_eq!(cache.put("a", b"kept".to_vec()).source.read().unwrap(), b"kept");
    }
}
