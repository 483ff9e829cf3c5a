//! Levenberg-Marquardt on the 27 nonlinear problems of NIST's Statistical Reference Datasets, from both certified starts.
//!
//! The files in `tests/data/nist` are NIST's own; models are written here as the files print them ([`models`]), derivatives
//! come from dual numbers ([`dual`]) and are checked against differences ([`derivative`]). The digits that each fit must reach stand in
//! `docs/numerics.md`; the test reads that table, so the page cannot claim more than is true.

mod derivative;
mod dual;
mod file;
mod models;

use dual::Dual;
use file::NistProblem;
use lostmotion::numerics::least_squares::{Function, Options, TerminationReason, minimise};
use models::model;
use nalgebra::DMatrix;

/// Most parameters of a problem.
const MOST: usize = 9;

fn residuals(problem: &NistProblem, p: &[f64]) -> Vec<f64> {
    problem.rows.iter().map(|(y, x)| model(&problem.name, p, x) - y).collect()
}

fn jacobian(problem: &NistProblem, p: &[f64]) -> DMatrix<f64> {
    let seeds: Vec<Dual<MOST>> = p.iter().enumerate().map(|(k, v)| Dual::variable(*v, k)).collect();
    let rows: Vec<Dual<MOST>> = problem.rows.iter().map(|(_, x)| model(&problem.name, &seeds, x)).collect();
    DMatrix::from_fn(rows.len(), p.len(), |i, k| rows[i].derivatives[k])
}

/// Digits to which `found` agrees with a certified value of eleven digits.
fn digits(found: f64, certified: f64) -> f64 {
    let error = ((found - certified) / certified).abs();
    if error.is_nan() { 0.0 } else { (-error.max(1e-11).log10()).clamp(0.0, 11.0) }
}

/// What a fit from one start reached.
struct Reached {
    reason: TerminationReason,
    steps: usize,
    /// Digits of the worst parameter, of the worst standard deviation, and of the residual sum of squares.
    parameters: f64,
    deviations: f64,
    sum: f64,
}

fn fit(problem: &NistProblem, start: &[f64], by_differences: bool) -> Reached {
    let mut function = Function::new(
        |p: &[f64]| residuals(problem, p),
        |p: &[f64]| match by_differences {
            true => derivative::central(|q| residuals(problem, q), p, &vec![0.0; p.len()]),
            false => jacobian(problem, p),
        },
    );
    let found = minimise(&mut function, start.to_vec(), &Options::default());
    let variance = found.cost / (problem.rows.len() - problem.parameters()) as f64;
    let sigmas = found.information().sigmas(variance).unwrap_or(vec![f64::NAN; problem.parameters()]);
    let worst = |found: &[f64], certified: &[f64]| {
        found.iter().zip(certified).map(|(f, c)| digits(*f, *c)).fold(f64::INFINITY, f64::min)
    };
    Reached {
        reason: found.reason,
        steps: found.steps,
        parameters: worst(&found.point, &problem.certified),
        deviations: worst(&sigmas, &problem.deviations),
        sum: digits(found.cost, problem.sum_squares),
    }
}

/// Rows of the table in `docs/numerics.md`: name, then for each start the digits of parameters, deviations and sum.
fn documented() -> Vec<(String, Vec<f64>)> {
    let page = include_str!("../../../docs/numerics.md");
    let rows = page.lines().filter_map(|l| l.strip_prefix("| ")?.strip_suffix(" |"));
    rows.filter_map(|row| {
        let cells: Vec<&str> = row.split(" | ").map(str::trim).collect();
        let numbers: Vec<f64> = cells.get(2..8)?.iter().map_while(|c| c.parse().ok()).collect();
        (numbers.len() == 6).then(|| (cells[0].to_string(), numbers))
    })
    .collect()
}

#[test]
fn val_every_certified_problem_is_solved_from_both_starts_to_the_documented_digits() {
    let documented = documented();
    assert_eq!(documented.len(), 27, "one row per problem");
    let mut failures = Vec::new();
    for problem in file::all() {
        let wanted = &documented.iter().find(|(name, _)| *name == problem.name).expect("every problem has a row").1;
        let mut row = format!("| {} | {}", problem.name, problem.level);
        for (start, wanted) in problem.starts.iter().zip(wanted.chunks(3)) {
            let found = fit(&problem, start, false);
            row += &format!(" | {:.1} | {:.1} | {:.1}", found.parameters, found.deviations, found.sum);
            // a start that is documented with no digits must be owned up to
            assert_eq!(found.reason.converged(), wanted[0] > 0.0, "{}: {:?}", problem.name, found.reason);
            let reached = [found.parameters, found.deviations, found.sum];
            if reached.iter().zip(wanted).any(|(r, w)| r + 0.05 < *w) {
                failures.push(format!("{}: {:?} after {} steps, {reached:?}", problem.name, found.reason, found.steps));
            }
        }
        println!("{row} |");
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

#[test]
fn val_derivatives_of_the_models_agree_with_differences_at_both_starts_and_at_the_minimum() {
    for problem in file::all() {
        for p in problem.starts.iter().chain([&problem.certified]) {
            let exact = jacobian(&problem, p);
            let error = derivative::error_of(|q| residuals(&problem, q), &exact, p, &vec![0.0; p.len()]);
            assert!(error < 1e-5, "{}: {error:e}", problem.name);
        }
    }
}

#[test]
fn val_differences_in_place_of_derivatives_reach_the_certified_values_too() {
    for problem in file::all() {
        for start in &problem.starts {
            let found = fit(&problem, start, true);
            assert!(
                !found.reason.converged() || found.parameters > 3.5,
                "{}: {:?}, {} digits",
                problem.name,
                found.reason,
                found.parameters
            );
        }
    }
}
