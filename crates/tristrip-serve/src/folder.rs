//! The directory of a server, as a handle. Nothing outside it is opened, even if links in it lead
//! outside or change in the meantime.
//!
//! The handle resolves every path component below the directory. It rejects absolute links and
//! links that lead outside (`openat2` on Linux). Only regular files are opened; opening never waits
//! for the other end of a pipe.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use cap_fs_ext::OpenOptionsSyncExt;
use cap_std::ambient_authority;
use cap_std::fs::{Dir, Metadata, OpenOptions};

use crate::error::Error;
use crate::paths::SitePath;

/// A directory whose files are served.
#[derive(Debug)]
pub(crate) struct Folder {
    dir: Dir,
    path: PathBuf,
}

/// The version of a file. It changes when the file is written or replaced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Version {
    pub(crate) bytes: u64,
    pub(crate) modified: Option<SystemTime>,
    /// The inode number, or 0 on systems without inodes.
    number: u64,
}

impl Version {
    fn new(metadata: &Metadata) -> Self {
        #[cfg(unix)]
        let number = cap_std::fs::MetadataExt::ino(metadata);
        #[cfg(not(unix))]
        let number = 0;
        let modified = metadata.modified().ok().map(cap_std::time::SystemTime::into_std);
        Self { bytes: metadata.len(), modified, number }
    }

    /// Returns the version as text without spaces and quotes.
    pub(crate) fn tag(&self) -> String {
        let since = self.modified.and_then(|time| time.duration_since(SystemTime::UNIX_EPOCH).ok());
        let nanoseconds = since.map_or(0, |since| since.as_nanos());
        format!("{:x}-{nanoseconds:x}-{:x}", self.bytes, self.number)
    }
}

impl Folder {
    pub(crate) fn open(path: &Path) -> Result<Self, Error> {
        let failed = |source| Error::io(path, source);
        let real = path.canonicalize().map_err(failed)?;
        let dir = Dir::open_ambient_dir(&real, ambient_authority()).map_err(failed)?;
        Ok(Self { dir, path: real })
    }

    /// Opens a regular file.
    pub(crate) fn open_file(&self, path: &SitePath) -> io::Result<(File, Version)> {
        let mut options = OpenOptions::new();
        options.read(true).nonblock(true);
        let file = self.dir.open_with(path.as_str(), &options)?;
        let metadata = file.metadata()?;
        Ok((file.into_std(), version_of(&metadata)?))
    }

    /// Returns the version of a regular file without opening it.
    pub(crate) fn version(&self, path: &SitePath) -> io::Result<Version> {
        version_of(&self.dir.metadata(path.as_str())?)
    }

    /// Reads a complete file of at most this size.
    pub(crate) fn read(&self, path: &SitePath, most_bytes: u64) -> io::Result<Vec<u8>> {
        let (file, version) = self.open_file(path)?;
        let mut bytes = Vec::with_capacity(usize::try_from(version.bytes.min(most_bytes)).unwrap_or(0));
        file.take(most_bytes.saturating_add(1)).read_to_end(&mut bytes)?;
        if bytes.len() as u64 > most_bytes {
            return Err(io::ErrorKind::FileTooLarge.into());
        }
        Ok(bytes)
    }

    /// Returns the path of a file with all links resolved, for readers that open other files in the
    /// same directory.
    pub(crate) fn real_path(&self, path: &SitePath) -> io::Result<PathBuf> {
        Ok(self.path.join(self.dir.canonicalize(path.as_str())?))
    }

    /// Returns the path of the directory with all links resolved.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the regular files and the subdirectories of a directory, sorted by name. The empty
    /// path means the directory of the server. The result includes links to files but not links to
    /// directories, which could form a cycle. Reads at most `left` entries of any kind, and
    /// subtracts them from `left`.
    pub(crate) fn entries(&self, path: &str, left: &mut usize) -> io::Result<Vec<Entry>> {
        let here = if path.is_empty() { "." } else { path };
        let mut found = Vec::new();
        if *left == 0 {
            return Ok(found);
        }
        for entry in self.dir.read_dir(here)? {
            if *left == 0 {
                break;
            }
            *left -= 1;
            let Ok(entry) = entry else { continue };
            let Ok(name) = entry.file_name().into_string() else { continue };
            let Ok(kind) = entry.file_type() else { continue };
            let below = if path.is_empty() { name } else { format!("{path}/{name}") };
            let Ok(below) = SitePath::new(&below) else { continue };
            if kind.is_dir() {
                found.push(Entry { path: below, version: None });
                continue;
            }
            let version = if kind.is_symlink() {
                self.version(&below)
            } else {
                entry.metadata().and_then(|metadata| version_of(&metadata))
            };
            if let Ok(version) = version {
                found.push(Entry { path: below, version: Some(version) });
            }
        }
        found.sort_by(|a, b| a.path.cmp(&b.path));
        Ok(found)
    }
}

/// Returns the version of a regular file, or an error for anything else.
fn version_of(metadata: &Metadata) -> io::Result<Version> {
    if metadata.is_file() { Ok(Version::new(metadata)) } else { Err(io::ErrorKind::NotFound.into()) }
}

/// A file or subdirectory.
#[derive(Debug)]
pub(crate) struct Entry {
    pub(crate) path: SitePath,
    /// `None` for a directory.
    pub(crate) version: Option<Version>,
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn site(path: &str) -> SitePath {
        SitePath::new(path).unwrap()
    }

    #[test]
    fn files_are_opened_and_versions_tell_changes() {
        let dir = tempfile::tempdir().unwrap();
        fs::create_dir(dir.path().join("a")).unwrap();
        fs::write(dir.path().join("a/b.ply"), "ply").unwrap();
        let folder = Folder::open(dir.path()).unwrap();
        let (_, first) = folder.open_file(&site("a/b.ply")).unwrap();
        assert_eq!((first.bytes, folder.read(&site("a/b.ply"), 3).unwrap().as_slice()), (3, &b"ply"[..]));
        assert_eq!(folder.read(&site("a/b.ply"), 2).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        assert!(folder.open_file(&site("a")).is_err());
        assert!(folder.open_file(&site("b.ply")).is_err());
        fs::write(dir.path().join("a/b.ply"), "plyy").unwrap();
        assert_ne!(folder.version(&site("a/b.ply")).unwrap().tag(), first.tag());
        let names: Vec<_> =
            folder.entries("", &mut 100).unwrap().iter().map(|entry| entry.path.clone()).collect();
        assert_eq!(names, [site("a")]);
        assert_eq!(folder.entries("a", &mut 100).unwrap()[0].path, site("a/b.ply"));
        fs::write(dir.path().join("a/.hidden"), "").unwrap();
        let mut left = 5;
        assert_eq!(folder.entries("a", &mut left).unwrap().len(), 1);
        assert_eq!(left, 3);
        assert!(folder.entries("a", &mut 0).unwrap().is_empty());
        assert!(Folder::open(&dir.path().join("none")).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn links_do_not_lead_out_and_pipes_are_not_waited_for() {
        use std::os::unix::fs::symlink;
        let (dir, outside) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        fs::write(outside.path().join("secret"), "secret").unwrap();
        fs::write(dir.path().join("inside.ply"), "ply").unwrap();
        symlink(outside.path().join("secret"), dir.path().join("absolute")).unwrap();
        let name = outside.path().file_name().unwrap().to_str().unwrap();
        symlink(format!("../{name}/secret"), dir.path().join("relative")).unwrap();
        symlink(outside.path(), dir.path().join("folder")).unwrap();
        symlink("inside.ply", dir.path().join("good")).unwrap();
        symlink("circle", dir.path().join("circle")).unwrap();
        rustix::fs::mkfifoat(rustix::fs::CWD, dir.path().join("pipe"), rustix::fs::Mode::RUSR).unwrap();
        let folder = Folder::open(dir.path()).unwrap();
        for path in ["absolute", "relative", "folder/secret", "circle", "pipe"] {
            assert!(folder.open_file(&site(path)).is_err(), "{path}");
        }
        assert_eq!(folder.read(&site("good"), 9).unwrap(), b"ply");
        let names: Vec<_> = folder
            .entries("", &mut 100)
            .unwrap()
            .iter()
            .map(|entry| entry.path.as_str().to_owned())
            .collect();
        assert_eq!(names, ["good", "inside.ply"]);
        assert!(folder.real_path(&site("good")).unwrap().ends_with("inside.ply"));
    }
}
