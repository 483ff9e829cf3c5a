//! Addresses of object stores: `s3://BUCKET/PREFIX`, and `file:///FOLDER` to try a job without a server.

use crate::error::{Error, Place, Result, shown};
use std::path::Path;

const SCHEMES: [&str; 2] = ["s3://", "file://"];

/// Whether a path of the command line is an address of an object store, and no file.
pub fn is_address(path: &Path) -> bool {
    path.to_str().is_some_and(|text| SCHEMES.iter().any(|scheme| text.starts_with(scheme)))
}

/// Refuses an address where a path on disk is needed; `what` is the argument.
///
/// # Errors
/// Bad input where `path` is an address.
pub fn refuse(what: &str, path: Option<&Path>) -> Result<()> {
    match path.filter(|p| is_address(p)) {
        Some(path) => {
            let found = format!("{}, an address of an object store", shown(path));
            Err(Error::bad(Place::file(what), found, "a path on disk"))
        }
        None => Ok(()),
    }
}

/// Refuses addresses in a build that reads none.
///
/// # Errors
/// Bad input where `path` is an address.
#[cfg(not(feature = "cloud"))]
pub fn refuse_all(path: &Path) -> Result<()> {
    if !is_address(path) {
        return Ok(());
    }
    let expected = "a path on disk: this build was made without the feature `cloud`, which reads object stores";
    Err(Error::bad(Place::file(shown(path)), "an address of an object store", expected))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_is_told_from_a_path() {
        for address in ["s3://cell/programs", "file:///tmp/cell"] {
            assert!(is_address(Path::new(address)) && refuse("IN", Some(Path::new(address))).is_err());
        }
        for path in ["cell/programs", "s3:/cell", "./s3://cell", "-"] {
            assert!(!is_address(Path::new(path)) && refuse("IN", Some(Path::new(path))).is_ok(), "{path}");
        }
    }
}
