//! The content of a server: the files of a directory, or files in memory.

use std::collections::BTreeMap;
use std::io;
use std::path::PathBuf;
use std::sync::Arc;

use bytes::Bytes;
use tokio::sync::{OnceCell, Semaphore};

use crate::bytes_source::BytesSource;
use crate::catalogue::{Catalogue, Contents, Listed, contents_of_bytes};
use crate::error::Error;
use crate::folder::Folder;
use crate::media::media_type;
use crate::paths::SitePath;
use crate::replies::Resource;
use crate::thumbnails;

/// The content of a server.
#[derive(Debug, Clone)]
pub enum Content {
    /// The files of a directory and its subdirectories.
    Folder(PathBuf),
    /// Files in memory.
    Files(Vec<MemoryFile>),
}

/// A file in memory.
#[derive(Debug, Clone)]
pub struct MemoryFile {
    /// The name, which becomes part of the URL, such as `bunny.ply.glb`.
    pub name: String,
    /// The content.
    pub bytes: Vec<u8>,
}

/// Opened content.
#[derive(Debug)]
pub(crate) enum Store {
    Folder(Arc<Folder>),
    Memory(BTreeMap<SitePath, Stored>),
}

/// A file in memory with its contents and thumbnail.
#[derive(Debug)]
pub(crate) struct Stored {
    resource: Resource,
    bytes: Bytes,
    contents: Contents,
    thumbnail: OnceCell<Result<Bytes, String>>,
}

impl Store {
    pub(crate) fn open(content: Content) -> Result<Self, Error> {
        match content {
            Content::Folder(path) => Ok(Self::Folder(Arc::new(Folder::open(&path)?))),
            Content::Files(files) => {
                let mut store = BTreeMap::new();
                for MemoryFile { name, bytes } in files {
                    let path = SitePath::new(&name).map_err(|_| Error::Parameter {
                        name: "name",
                        found: name.clone(),
                        expected: "a relative path without hidden files and reserved characters",
                    })?;
                    store.insert(path, Stored::new(&name, bytes.into()));
                }
                Ok(Self::Memory(store))
            }
        }
    }
}

/// Opens a file of a directory. May block.
pub(crate) fn open_resource(folder: &Folder, path: &SitePath) -> io::Result<Resource> {
    let (file, version) = folder.open_file(path)?;
    Ok(Resource {
        source: BytesSource::of_file(file, 0, version.bytes)?,
        media_type: media_type(path.as_str()),
        tag: version.tag(),
        modified: version.modified,
    })
}

impl Stored {
    fn new(name: &str, bytes: Bytes) -> Self {
        let tag = format!("{:x}-{:08x}", bytes.len(), crc32fast::hash(&bytes));
        let source = BytesSource::Memory(bytes.clone());
        let resource = Resource { source, media_type: media_type(name), tag, modified: None };
        let contents = contents_of_bytes(&bytes);
        Self { resource, bytes, contents, thumbnail: OnceCell::new() }
    }

    pub(crate) fn resource(&self) -> &Resource {
        &self.resource
    }

    /// Returns the thumbnail. It is drawn once, as soon as a permit is available.
    pub(crate) async fn thumbnail(&self, permits: &Arc<Semaphore>) -> Result<Resource, String> {
        let drawn = self.thumbnail.get_or_init(|| async {
            let permit = Arc::clone(permits).acquire_owned().await;
            let bytes = self.bytes.clone();
            let draw = move || {
                // Held until the drawing ends, even if the client leaves.
                let _permit = permit;
                thumbnails::of_glb(&bytes)
            };
            match tokio::task::spawn_blocking(draw).await {
                Ok(png) => png.map(Bytes::from),
                Err(_) => Err("internal error while drawing the thumbnail".into()),
            }
        });
        let png = drawn.await.clone()?;
        let tag = format!("{}-png", self.resource.tag);
        Ok(Resource { source: BytesSource::Memory(png), media_type: "image/png", tag, modified: None })
    }
}

/// Lists files in memory.
pub(crate) fn list(store: &BTreeMap<SitePath, Stored>) -> Catalogue {
    let listed =
        |(path, stored): (&SitePath, &Stored)| Listed::file(path, stored.bytes.len() as u64, stored.contents);
    Catalogue { models: store.iter().map(listed).collect(), notes: Vec::new() }
}
