//! The results of a folder and its programs are kept apart: a link in the output folder may lead back to a program.

use crate::error::{Error, Place, Result, shown};
use crate::io::journal::{self, Towards};
use crate::io::links;
use crate::numerics::parallel::ParMap;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Where the programs of a folder are, and where their results go, links followed.
#[derive(Debug)]
pub(super) struct Apart {
    /// The folder of the programs, and that of the results.
    from: Option<PathBuf>,
    to: Option<PathBuf>,
    /// The program that is read from a file, and how many results go to it.
    files: HashMap<PathBuf, (Option<PathBuf>, usize)>,
    /// A program may be replaced by its own result.
    in_place: bool,
}

impl Apart {
    /// Of `programs`, relative to `folder`, whose results go below `output`.
    pub(super) fn of(folder: &Path, programs: &[PathBuf], output: &Path, in_place: bool) -> Self {
        let both = |p: &PathBuf| (links::real(&folder.join(p)), links::real(&output.join(p)));
        let both: Vec<_> = programs.par_map(both);
        let mut files: HashMap<PathBuf, (Option<PathBuf>, usize)> = HashMap::with_capacity(2 * both.len());
        for ((from, to), program) in both.into_iter().zip(programs) {
            if let Some(from) = from {
                files.entry(from).or_default().0 = Some(folder.join(program));
            }
            if let Some(to) = to {
                files.entry(to).or_default().1 += 1;
            }
        }
        let real = |p: &Path| std::fs::canonicalize(p).ok();
        Self { from: real(folder), to: real(output), files, in_place }
    }

    /// Refuses a result `to` of the program `from` that would replace a program, or go among them, or to one file with another
    /// result. What a killed run left where a link leads is taken back.
    ///
    /// # Errors
    /// Bad input that names the result.
    pub(super) fn check(&self, from: &Path, to: &Path) -> Result<()> {
        let Some(real) = links::real(to) else { return Ok(()) };
        let refuse = |found: String| {
            let expected = "a separate file (remove the link)";
            Err(Error::bad(Place::file(shown(to)), found, expected))
        };
        let below = |folder: &Option<PathBuf>| folder.as_ref().is_some_and(|f| real.starts_with(f));
        let own = links::real(from).as_ref() == Some(&real);
        match self.files.get(&real) {
            Some((_, results)) if *results > 1 => return refuse("a link to the result of another program".into()),
            Some((Some(program), _)) if !(self.in_place && own) => {
                return refuse(format!("a link to the program {}", shown(program)));
            }
            _ => {}
        }
        if !self.in_place && below(&self.from) && !below(&self.to) {
            return refuse("a link into the folder of the programs".into());
        }
        if !below(&self.to) && !below(&self.from) {
            journal::finish(&links::home_of(to), Towards::Before)?;
        }
        Ok(())
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn a_result_goes_over_no_program_and_over_no_other_result() {
        let dir = tempfile::tempdir().unwrap();
        let (input, output) = (dir.path().join("in"), dir.path().join("out"));
        let names = ["a.csv", "b.csv", "c.csv", "d.csv", "e.csv", "f.csv"];
        std::fs::create_dir_all(input.join("sub")).unwrap();
        std::fs::create_dir(&output).unwrap();
        names.iter().for_each(|n| std::fs::write(input.join(n), n).unwrap());
        symlink("../in/a.csv", output.join("a.csv")).unwrap();
        symlink("../in/a.csv", output.join("b.csv")).unwrap();
        symlink("../in/sub/new.csv", output.join("c.csv")).unwrap();
        symlink("e.csv", output.join("d.csv")).unwrap();
        let programs: Vec<PathBuf> = names.iter().map(PathBuf::from).collect();
        let said = |in_place: bool| -> Vec<String> {
            let apart = Apart::of(&input, &programs, &output, in_place);
            let check = |n: &&str| apart.check(&input.join(n), &output.join(n)).err().map(|e| e.to_string());
            names.iter().map(|n| check(n).unwrap_or_default()).collect()
        };
        let strict = said(false);
        for (told, words) in strict.iter().zip([
            "result of another program", // two links to one program
            "result of another program",
            "into the folder of the programs",
            "result of another program",
            "result of another program",
            "",
        ]) {
            assert!(told.contains(words) && told.is_empty() == words.is_empty(), "{strict:?}");
        }
        std::fs::remove_file(output.join("b.csv")).unwrap();
        assert!(said(false)[0].contains("the program"));
        // in place a program may go over itself, and over no other
        let forced = said(true);
        assert!(forced[0].is_empty() && forced[2].is_empty() && !forced[3].is_empty(), "{forced:?}");
        symlink("../in/f.csv", output.join("b.csv")).unwrap();
        assert!(said(true)[1].contains("the program"));
    }

    #[test]
    fn a_folder_in_place_goes_over_itself_alone() {
        let dir = tempfile::tempdir().unwrap();
        std::fs::write(dir.path().join("a.csv"), "").unwrap();
        symlink("a.csv", dir.path().join("b.csv")).unwrap();
        let programs = [PathBuf::from("a.csv"), PathBuf::from("b.csv")];
        let check = |programs: &[PathBuf], name: &str| {
            Apart::of(dir.path(), programs, dir.path(), true).check(&dir.path().join(name), &dir.path().join(name))
        };
        assert!(check(&programs[..1], "a.csv").is_ok());
        assert!(check(&programs, "a.csv").is_err() && check(&programs, "b.csv").is_err(), "one file, rewritten twice");
    }
}
