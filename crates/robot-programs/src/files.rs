//! Which files there are beside a program.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// Which files there are.
#[derive(Debug, Clone, Default)]
pub enum Files {
    /// As the file system says.
    #[default]
    Disk,
    /// As a folder tree was listed: thousands of programs are not asked for one by one, under every name they may have.
    Listed(HashSet<PathBuf>),
}

impl Files {
    /// Whether there is a file of this name.
    pub fn has(&self, path: &Path) -> bool {
        match self {
            Self::Disk => path.is_file(),
            Self::Listed(files) => files.contains(path),
        }
    }
}
