//! Reads a problem file of NIST: starts, certified values, data.

use crate::support::bundled;
use std::path::Path;

/// A problem with its certified solution.
pub struct NistProblem {
    pub name: String,
    /// Difficulty as NIST ranks it: lower, average, higher.
    pub level: String,
    pub starts: [Vec<f64>; 2],
    pub certified: Vec<f64>,
    pub deviations: Vec<f64>,
    pub sum_squares: f64,
    /// Response and predictors.
    pub rows: Vec<(f64, Vec<f64>)>,
}

impl NistProblem {
    pub fn parameters(&self) -> usize {
        self.certified.len()
    }

    fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).unwrap();
        let name = path.file_stem().unwrap().to_str().unwrap().to_string();
        let numbers = |line: &str| line.split_whitespace().map_while(|w| w.parse().ok()).collect::<Vec<f64>>();
        let mut all = Self {
            level: text.lines().find_map(|l| l.trim().strip_suffix(" Level of Difficulty")).unwrap().to_lowercase(),
            starts: [Vec::new(), Vec::new()],
            certified: Vec::new(),
            deviations: Vec::new(),
            sum_squares: 0.0,
            rows: Vec::new(),
            name,
        };
        let mut data = false;
        for line in text.lines() {
            if let Some((b, values)) = line.split_once('=')
                && b.trim().strip_prefix('b').is_some_and(|k| k.parse::<usize>().is_ok())
                && let [first, second, certified, deviation] = numbers(values)[..]
            {
                all.starts[0].push(first);
                all.starts[1].push(second);
                all.certified.push(certified);
                all.deviations.push(deviation);
            } else if let Some(sum) = line.strip_prefix("Residual Sum of Squares:") {
                all.sum_squares = sum.trim().parse().unwrap();
            } else if line.starts_with("Data:") {
                data = line.split_whitespace().nth(1) == Some("y");
            } else if data && let [y, x @ ..] = &numbers(line)[..] {
                all.rows.push((*y, x.to_vec()));
            }
        }
        // the one problem whose response is a logarithm
        if all.name == "Nelson" {
            all.rows.iter_mut().for_each(|(y, _)| *y = y.ln());
        }
        all
    }
}

/// All 27 problems by name.
pub fn all() -> Vec<NistProblem> {
    let folder = bundled("tests/data/nist");
    let entries = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
    let mut files: Vec<_> = entries.filter(|p| p.extension().is_some_and(|e| e == "dat")).collect();
    files.sort();
    let problems: Vec<NistProblem> = files.iter().map(|p| NistProblem::read(p)).collect();
    assert_eq!(problems.len(), 27);
    problems
}
