//! Files that took time to make, in a folder of bounded size. A server that is killed while it writes one leaves the others as they are.
//!
//! ```text
//! KEY.cached:  "TRISTRIP" │ version │ CRC-32 of the bytes │ their length │ the bytes
//! ```
//!
//! # Algorithm
//! - Written under a temporary name, then renamed: a name leads to a whole file or to none. The writer locks its temporary file; one that nobody locks was left behind
//!   by a process that was killed, and is removed when a server starts.
//! - Opened: head and length are compared always, the checksum once for each version of the file in a process. A damaged file is removed, and made again.
//! - Evicted: the least recently used files, by their times of access, which the cache sets itself. A file that is being sent stays open until it is sent.
//!
//! Several servers may share a folder.

use std::collections::HashMap;
use std::fs::{self, File, FileTimes, TryLockError};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::SystemTime;

use bytes::Bytes;

use crate::bytes_source::{BytesSource, read_at};
use crate::error::Error;

const MAGIC: &[u8; 8] = b"TRISTRIP";
const VERSION: u32 = 1;
const HEAD_BYTES: u64 = 24;
const EXTENSION: &str = "cached";
const TEMPORARY: &str = "writing";

/// A folder of cached files.
#[derive(Debug)]
pub(crate) struct Cache {
    folder: PathBuf,
    most_bytes: u64,
    /// The files whose checksum is that of their bytes, in the version that was read.
    verified: Mutex<HashMap<String, (u64, SystemTime)>>,
}

/// Bytes that were made, from the cache or not.
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
    /// Opens a folder, which is created if it does not exist, and removes what killed processes left there.
    pub(crate) fn open(folder: &Path, most_bytes: u64) -> Result<Self, Error> {
        let failed = |source| Error::io(folder, source);
        fs::create_dir_all(folder).map_err(failed)?;
        for path in files(folder, TEMPORARY).map_err(failed)? {
            let is_left =
                File::open(&path).is_ok_and(|file| !matches!(file.try_lock(), Err(TryLockError::WouldBlock)));
            if is_left {
                fs::remove_file(&path).unwrap_or_default();
            }
        }
        let cache = Self { folder: folder.to_path_buf(), most_bytes, verified: Mutex::default() };
        cache.evict();
        Ok(cache)
    }

    /// Returns the bytes of a key, if they are there and not damaged.
    pub(crate) fn get(&self, key: &str) -> Option<Made> {
        let path = self.path(key);
        let file = File::open(&path).ok()?;
        match self.checked(key, file) {
            Ok(made) => Some(made),
            Err(error) => {
                tracing::warn!(key, %error, "damaged file of the cache removed");
                fs::remove_file(&path).unwrap_or_default();
                None
            }
        }
    }

    /// Keeps bytes, and returns them. What cannot be written is kept in memory as long as it is sent.
    pub(crate) fn put(&self, key: &str, bytes: Vec<u8>) -> Made {
        let made = match self.write(key, &bytes) {
            Ok(file) => self.checked(key, file),
            Err(error) => Err(error),
        };
        self.evict();
        made.unwrap_or_else(|error| {
            tracing::warn!(key, %error, "not written to the cache");
            Made::in_memory(bytes)
        })
    }

    /// Returns the bytes that all files take.
    pub(crate) fn used_bytes(&self) -> u64 {
        let files = files(&self.folder, EXTENSION).unwrap_or_default();
        files.iter().filter_map(|path| fs::metadata(path).ok()).map(|metadata| metadata.len()).sum()
    }

    fn path(&self, key: &str) -> PathBuf {
        self.folder.join(key).with_extension(EXTENSION)
    }

    fn write(&self, key: &str, bytes: &[u8]) -> io::Result<File> {
        let suffix = format!(".{TEMPORARY}");
        let mut temporary =
            tempfile::Builder::new().prefix("tristrip-").suffix(&suffix).tempfile_in(&self.folder)?;
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

    /// Compares a file with its head.
    fn checked(&self, key: &str, mut file: File) -> io::Result<Made> {
        let wrong = |what: &str| io::Error::new(io::ErrorKind::InvalidData, what.to_owned());
        let mut head = [0; HEAD_BYTES as usize];
        file.read_exact(&mut head)?;
        let (magic, rest) = head.split_at(MAGIC.len());
        let number =
            |at: usize| rest[at..at + 4].try_into().map(u32::from_le_bytes).map_err(|_| wrong("head"));
        let (version, checksum) = (number(0)?, number(4)?);
        let length = u64::from(number(8)?) | u64::from(number(12)?) << 32;
        let metadata = file.metadata()?;
        if magic != MAGIC || version != VERSION || metadata.len() != HEAD_BYTES.saturating_add(length) {
            return Err(wrong("head or length"));
        }
        let seen = (metadata.len(), metadata.modified()?);
        let is_verified =
            self.verified.lock().unwrap_or_else(PoisonError::into_inner).get(key) == Some(&seen);
        if !is_verified {
            if checksum_of(&file)? != checksum {
                return Err(wrong("checksum"));
            }
            self.verified.lock().unwrap_or_else(PoisonError::into_inner).insert(key.to_owned(), seen);
        }
        // A time that cannot be set makes the file a candidate for eviction sooner.
        file.set_times(FileTimes::new().set_accessed(SystemTime::now())).unwrap_or_default();
        Ok(Made { source: BytesSource::of_file(file, HEAD_BYTES, length)?, checksum })
    }

    /// Removes the least recently used files until the others take few enough bytes.
    fn evict(&self) {
        let mut found: Vec<(SystemTime, u64, PathBuf)> = files(&self.folder, EXTENSION)
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

/// Returns the checksum of the bytes behind the head.
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

/// Returns the files of a folder with an extension.
fn files(folder: &Path, extension: &str) -> io::Result<Vec<PathBuf>> {
    let has_extension = |path: &PathBuf| path.extension().is_some_and(|found| found == extension);
    Ok(fs::read_dir(folder)?.filter_map(|entry| Some(entry.ok()?.path())).filter(has_extension).collect())
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
        assert!(cache.get("a").is_none());
        let long = vec![7; 200_000];
        let made = cache.put("a", long.clone());
        assert_eq!((made.source.len(), made.source.read().unwrap()), (200_000, long.clone()));
        cache.put("b", b"short".to_vec());
        let again = Cache::open(dir.path(), 1 << 30).unwrap();
        assert_eq!(bytes_of(&again, "a"), Some(long));
        assert_eq!(bytes_of(&again, "b").as_deref(), Some(&b"short"[..]));
        assert_eq!(again.used_bytes(), 200_000 + 5 + 2 * HEAD_BYTES);
    }

    #[test]
    fn damaged_files_are_removed() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.cached");
        type Damage = fn(&mut Vec<u8>);
        let damages: [Damage; 6] = [
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
        let used_at = |key: &str, seconds: u64| {
            let time = SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(seconds);
            let file = File::open(dir.path().join(key).with_extension("cached")).unwrap();
            file.set_times(FileTimes::new().set_accessed(time)).unwrap();
        };
        cache.put("a", vec![1; 900]);
        cache.put("b", vec![2; 900]);
        cache.put("c", vec![3; 900]);
        used_at("a", 2000);
        used_at("b", 1000);
        used_at("c", 3000);
        cache.put("d", vec![4; 900]);
        assert!(cache.get("b").is_none());
        assert!(["a", "c", "d"].iter().all(|key| cache.get(key).is_some()));
        // What is larger than the cache is sent, and not kept.
        let made = cache.put("e", vec![5; 100_000]);
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
        fs::write(dir.path().join("other"), "of the user").unwrap();
        Cache::open(dir.path(), 0).unwrap();
        assert!(!left.exists() && written.exists() && dir.path().join("other").exists());
    }

    #[test]
    fn a_folder_that_cannot_be_written_loses_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let cache = Cache::open(&dir.path().join("cache"), 1 << 30).unwrap();
        fs::remove_dir(dir.path().join("cache")).unwrap();
        assert_eq!(cache.put("a", b"kept".to_vec()).source.read().unwrap(), b"kept");
    }
}
