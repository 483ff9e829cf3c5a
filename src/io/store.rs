//! Object stores: programs under `s3://BUCKET/PREFIX`, or below `file:///FOLDER`, which needs no server.
//!
//! Method: the crate `object_store`, which also repeats requests that fail; several requests at once on one thread. Endpoint,
//! region and credentials are those of the usual variables (`AWS_ENDPOINT_URL`, `AWS_REGION`, `AWS_ACCESS_KEY_ID`, ...); an endpoint that
//! begins with `http://` is used without encryption, as it says. What is read goes to files on disk in pieces. An object is put whole,
//! or in parts that become an object when the last one is there.
//!
//! A *location* is the whole name of an object in its bucket.

use super::input::hex;
use crate::error::{Error, Place, Result, shown};
use crate::name::text_of_name;
use futures_util::stream::{self, StreamExt, TryStreamExt};
use object_store::aws::{AmazonS3Builder, AmazonS3ConfigKey};
use object_store::local::LocalFileSystem;
use object_store::path::Path as Location;
use object_store::{Error as StoreError, ObjectStore, ObjectStoreExt, WriteMultipart};
use sha2::{Digest as _, Sha256};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tokio::runtime::Runtime;

/// Requests at once.
const AT_ONCE: usize = 16;
/// Bytes of a part of a large object; a smaller object is put in one request. Stores ask for 5 MiB at least, and 10,000 parts at most.
const PART: usize = 8 << 20;
/// Uploads at once, and parts of each on their way: together they bound the memory, 64 MiB.
const UPLOADS: usize = 4;
const PARTS: usize = 2;

/// A part of an object store: what lies below an address.
pub struct Store {
    /// What stands before locations in messages: `s3://BUCKET/`.
    base: String,
    /// Location below which the programs are; empty, or without a slash at its end.
    prefix: String,
    objects: Arc<dyn ObjectStore>,
    runtime: Runtime,
}

/// What was read of an object.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Fetched<T> {
    /// All of it.
    Whole(T),
    /// There is no such object, or it may not be read; why.
    Not(String),
}

/// Size, hash and first bytes of an object.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Digest {
    /// Bytes.
    pub size: u64,
    /// SHA-256, hexadecimal.
    pub sha256: String,
    /// Its first bytes.
    pub head: Vec<u8>,
}

impl Store {
    /// Opens an address; nothing is asked of the store yet.
    ///
    /// # Errors
    /// Bad input where the address has no bucket or cannot be used.
    pub fn open(address: &Path) -> Result<Self> {
        let text = address.to_str().unwrap_or_default();
        let bad = |found: String, expected: &str| Error::bad(Place::file(shown(address)), found, expected);
        let expected = "s3://BUCKET/PREFIX or file:///FOLDER";
        if let Some(folder) = text.strip_prefix("file://") {
            if !folder.starts_with('/') {
                return Err(bad("an address without a folder".into(), expected));
            }
            return Self::of(Arc::new(LocalFileSystem::new()), "file:///", folder);
        }
        let rest = text.strip_prefix("s3://").ok_or_else(|| bad("no address".into(), expected))?;
        let (bucket, prefix) = rest.split_once('/').unwrap_or((rest, ""));
        if bucket.is_empty() {
            return Err(bad("an address without a bucket".into(), expected));
        }
        let builder = AmazonS3Builder::from_env().with_bucket_name(bucket);
        let plain = [AmazonS3ConfigKey::Endpoint, AmazonS3ConfigKey::S3Endpoint]
            .iter()
            .any(|key| builder.get_config_value(key).is_some_and(|v| v.starts_with("http://")));
        let builder = if plain { builder.with_allow_http(true) } else { builder };
        let objects =
            builder.build().map_err(|e| bad(e.to_string(), "the settings of an S3 client (AWS_ variables)"))?;
        Self::of(Arc::new(objects), &format!("s3://{bucket}/"), prefix)
    }

    /// A store that is open; `base` stands before its locations in messages.
    ///
    /// # Errors
    /// Bad input where `prefix` is no location.
    pub fn of(objects: Arc<dyn ObjectStore>, base: &str, prefix: &str) -> Result<Self> {
        let prefix = prefix.trim_matches('/').to_string();
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
        let runtime = runtime.map_err(|e| Error::internal("start requests", e))?;
        let store = Self { base: base.into(), prefix, objects, runtime };
        store.parsed(&store.prefix)?;
        Ok(store)
    }

    /// Location below which the programs are.
    pub fn prefix(&self) -> &str {
        &self.prefix
    }

    /// A location as messages show it.
    pub fn name_of(&self, location: &str) -> String {
        self.base.clone() + &text_of_name(location.as_ref())
    }

    /// Location of a path below the prefix; `None`: its name is no text.
    pub fn location(&self, path: &Path) -> Option<String> {
        let key = path.to_str()?;
        Some(if self.prefix.is_empty() { key.into() } else { format!("{}/{key}", self.prefix) })
    }

    /// Whether a place of the other store lies in the same one, at the same prefix, above it or below it.
    pub fn overlaps(&self, other: &Self) -> bool {
        let inside = |a: &str, b: &str| b.is_empty() || a == b || a.strip_prefix(b).is_some_and(|r| r.starts_with('/'));
        self.base == other.base && (inside(&self.prefix, &other.prefix) || inside(&other.prefix, &self.prefix))
    }

    /// Paths below the prefix of all objects there, in the order of the store, that `wanted` takes.
    ///
    /// # Errors
    /// The store cannot be listed.
    pub fn list(&self, wanted: &dyn Fn(&str) -> bool) -> Result<Vec<String>> {
        let all = self.list_below(&self.prefix, usize::MAX, &|_| true)?;
        let below = |l: &String| match self.prefix.is_empty() {
            true => Some(l.clone()),
            false => Some(l.strip_prefix(&self.prefix)?.strip_prefix('/')?.to_string()),
        };
        Ok(all.iter().filter_map(below).filter(|key| wanted(key)).collect())
    }

    /// Locations of all objects below `folder`; it stops when `counts` was true for more than `most`.
    ///
    /// # Errors
    /// The store cannot be listed.
    pub fn list_below(&self, folder: &str, most: usize, counts: &dyn Fn(&str) -> bool) -> Result<Vec<String>> {
        let at = self.parsed(folder)?;
        self.runtime.block_on(async {
            let mut objects = self.objects.list(Some(&at).filter(|_| !folder.is_empty()));
            let (mut found, mut counted) = (Vec::new(), 0);
            while let Some(object) = objects.next().await {
                let object = match object {
                    Err(StoreError::NotFound { .. }) => break,
                    other => other.map_err(|e| self.failed(folder, "list", &e))?,
                };
                let location = object.location.to_string();
                counted += usize::from(counts(&location));
                found.push(location);
                if counted > most {
                    break;
                }
            }
            Ok(found)
        })
    }

    /// Locations of the objects in each folder, not in those below it, sorted.
    ///
    /// # Errors
    /// The store cannot be listed.
    pub fn list_folders(&self, folders: &[String]) -> Result<Vec<Vec<String>>> {
        let one = |folder: &String| {
            let folder = folder.clone();
            async move {
                let at = self.parsed(&folder)?;
                let mut found: Vec<String> =
                    match self.objects.list_with_delimiter(Some(&at).filter(|_| !folder.is_empty())).await {
                        Err(StoreError::NotFound { .. }) => Vec::new(),
                        Err(e) => return Err(self.failed(&folder, "list", &e)),
                        Ok(list) => list.objects.into_iter().map(|o| o.location.to_string()).collect(),
                    };
                found.sort();
                Ok(found)
            }
        };
        self.runtime.block_on(stream::iter(folders).map(one).buffered(AT_ONCE).try_collect())
    }

    /// Size, SHA-256 and the first `head` bytes of objects, in constant memory.
    ///
    /// # Errors
    /// The store fails, other than by not having an object.
    pub fn digests(&self, locations: &[String], head: usize) -> Result<Vec<Fetched<Digest>>> {
        let one = |location: &String| {
            let location = location.clone();
            async move {
                let (mut hash, mut digest) =
                    (Sha256::new(), Digest { size: 0, sha256: String::new(), head: Vec::new() });
                let mut take = |piece: &[u8]| {
                    hash.update(piece);
                    digest.size += piece.len() as u64;
                    let room = head.saturating_sub(digest.head.len()).min(piece.len());
                    digest.head.extend_from_slice(&piece[..room]);
                    Ok(())
                };
                let got = self.read(&location, &mut take).await?;
                digest.sha256 = hex(&hash.finalize());
                Ok(match got {
                    Fetched::Whole(()) => Fetched::Whole(digest),
                    Fetched::Not(why) => Fetched::Not(why),
                })
            }
        };
        self.runtime.block_on(stream::iter(locations).map(one).buffered(AT_ONCE).try_collect())
    }

    /// Copies objects to files, whose folders are there.
    ///
    /// # Errors
    /// The store or the disk fails, other than by not having an object.
    pub fn get(&self, objects: &[(String, PathBuf)]) -> Result<Vec<Fetched<()>>> {
        let one = |(location, path): &(String, PathBuf)| {
            let (location, path) = (location.clone(), path.clone());
            async move {
                let mut file = None;
                let mut take = |piece: &[u8]| {
                    if file.is_none() {
                        file = Some(std::fs::File::create(&path).map_err(|e| Error::io(&path, "write", e))?);
                    }
                    file.as_mut().map_or(Ok(()), |f| f.write_all(piece)).map_err(|e| Error::io(&path, "write", e))
                };
                self.read(&location, &mut take).await
            }
        };
        self.runtime.block_on(stream::iter(objects).map(one).buffered(AT_ONCE).try_collect())
    }

    /// Gives an object's bytes to `take` in pieces, at least one.
    async fn read(&self, location: &str, take: &mut dyn FnMut(&[u8]) -> Result<()>) -> Result<Fetched<()>> {
        let refused = |e: &StoreError| match e {
            StoreError::NotFound { .. } => Some(Fetched::Not("there is no such object".into())),
            StoreError::PermissionDenied { .. } => Some(Fetched::Not(format!("it may not be read ({e})"))),
            _ => None,
        };
        let object = match self.objects.get(&self.parsed(location)?).await {
            Err(e) => return refused(&e).ok_or_else(|| self.failed(location, "read", &e)),
            Ok(object) => object,
        };
        take(&[])?;
        let mut pieces = object.into_stream();
        while let Some(piece) = pieces.next().await {
            take(&piece.map_err(|e| self.failed(location, "read", &e))?)?;
        }
        Ok(Fetched::Whole(()))
    }

    /// Puts files as objects, each whole.
    ///
    /// # Errors
    /// The store or the disk fails.
    pub fn put(&self, objects: &[(PathBuf, String)]) -> Result<()> {
        let one = |(path, location): &(PathBuf, String)| {
            let (path, location) = (path.clone(), location.clone());
            async move { self.put_one(&path, &location).await }
        };
        self.runtime.block_on(stream::iter(objects).map(one).buffer_unordered(UPLOADS).try_collect())
    }

    async fn put_one(&self, path: &Path, location: &str) -> Result<()> {
        let at = self.parsed(location)?;
        let on_disk = |e| Error::io(path, "read", e);
        let failed = |e: StoreError| self.failed(location, "write", &e);
        let mut file = std::fs::File::open(path).map_err(on_disk)?;
        let mut piece = part(&mut file).map_err(on_disk)?;
        if piece.len() < PART {
            return self.objects.put(&at, piece.into()).await.map(drop).map_err(failed);
        }
        let mut upload =
            WriteMultipart::new_with_chunk_size(self.objects.put_multipart(&at).await.map_err(failed)?, PART);
        loop {
            upload.write(&piece);
            let read = match upload.wait_for_capacity(PARTS).await.map_err(failed) {
                Ok(()) => part(&mut file).map_err(on_disk),
                Err(e) => Err(e),
            };
            match read {
                Ok(next) if next.is_empty() => return upload.finish().await.map(drop).map_err(failed),
                Ok(next) => piece = next,
                Err(e) => {
                    // what is left of it is no object; a store drops such parts by its own rules
                    let _ = upload.abort().await;
                    return Err(e);
                }
            }
        }
    }

    /// Takes objects away; one that is not there is no error.
    ///
    /// # Errors
    /// The store fails.
    pub fn delete(&self, locations: &[String]) -> Result<()> {
        self.runtime.block_on(async {
            for location in locations {
                match self.objects.delete(&self.parsed(location)?).await {
                    Ok(()) | Err(StoreError::NotFound { .. }) => {}
                    Err(e) => return Err(self.failed(location, "remove", &e)),
                }
            }
            Ok(())
        })
    }

    fn parsed(&self, location: &str) -> Result<Location> {
        let found = |e: object_store::path::Error| {
            Error::bad(
                Place::file(self.name_of(location)),
                e.to_string(),
                "names of objects with one `/` between their parts",
            )
        };
        Location::parse(location).map_err(found)
    }

    fn failed(&self, location: &str, action: &'static str, why: &StoreError) -> Error {
        Error::io_of(self.name_of(location), action, std::io::Error::other(why.to_string()))
    }
}

/// The next bytes of a file, [`PART`] of them but at its end.
fn part(file: &mut impl Read) -> std::io::Result<Vec<u8>> {
    let mut piece = Vec::new();
    file.take(PART as u64).read_to_end(&mut piece)?;
    Ok(piece)
}
