//! Where a name leads: the file that an output replaces, whether or not it is there.

use super::folder::folder_of;
use std::path::{Path, PathBuf};

/// Links that are followed before they count as a circle.
const MOST: usize = 40;

/// The file that `path` leads to, where its last part is a link (also one to a file that is not there yet); else `path` itself.
pub fn target_of(path: &Path) -> PathBuf {
    let mut here = path.to_path_buf();
    for _ in 0..MOST {
        match std::fs::read_link(&here) {
            Ok(next) => here = folder_of(&here).join(next),
            Err(_) if here == path => return here,
            Err(_) => return std::fs::canonicalize(&here).unwrap_or(here),
        }
    }
    path.to_path_buf()
}

/// The folder in which the file stands that `path` leads to.
pub fn home_of(path: &Path) -> PathBuf {
    folder_of(&target_of(path)).to_path_buf()
}

/// Whether both lead to one file, whether or not it is there.
pub fn same(a: &Path, b: &Path) -> bool {
    a == b || real(a).is_some_and(|a| real(b) == Some(a))
}

/// The one name of a file without links, whether or not it is there; `None`: its folder is not there.
pub fn real(path: &Path) -> Option<PathBuf> {
    let target = target_of(path);
    std::fs::canonicalize(&target)
        .ok()
        .or_else(|| Some(std::fs::canonicalize(folder_of(&target)).ok()?.join(target.file_name()?)))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn a_link_leads_to_its_file_also_where_that_is_not_there_and_a_circle_to_itself() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        std::fs::create_dir(at("far")).unwrap();
        std::fs::write(at("far/a.csv"), "").unwrap();
        for (link, to) in
            [("a.csv", "far/a.csv"), ("b.csv", "a.csv"), ("new.csv", "far/new.csv"), ("x", "y"), ("y", "x")]
        {
            symlink(to, at(link)).unwrap();
        }
        let far = std::fs::canonicalize(at("far")).unwrap();
        assert_eq!(target_of(&at("a.csv")), far.join("a.csv"));
        assert_eq!(target_of(&at("b.csv")), far.join("a.csv"));
        assert_eq!(target_of(&at("new.csv")), at("far/new.csv"));
        assert_eq!(real(&at("new.csv")), Some(far.join("new.csv")));
        assert_eq!(target_of(&at("x")), at("x"));
        assert_eq!(target_of(&at("plain.csv")), at("plain.csv"));
        assert_eq!(home_of(&at("new.csv")), at("far"));
        assert!(same(&at("b.csv"), &at("far/a.csv")) && !same(&at("b.csv"), &at("new.csv")));
    }
}
