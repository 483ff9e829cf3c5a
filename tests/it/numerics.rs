//! Tails and quantiles against scipy (`tests/oracle/stats.py`).

use lostmotion::numerics::{fisher, student};
use serde_json::Value;

fn oracle() -> Value {
    serde_json::from_str(include_str!("../oracle/stats.json")).unwrap()
}

fn close(found: f64, want: f64, relative: f64, what: &Value) {
    assert!((found - want).abs() <= relative * want.abs(), "{found:e} for {what}");
}

#[test]
fn val_students_t_agrees_with_scipy_up_to_ten_million_degrees_of_freedom() {
    let oracle = oracle();
    for c in oracle["t_two_sided"].as_array().unwrap() {
        let (t, dof, p) = (c["t"].as_f64().unwrap(), c["dof"].as_f64().unwrap(), c["p"].as_f64().unwrap());
        close(student::two_sided_p(t, dof), p, 1e-7, c);
    }
    for c in oracle["t_factor"].as_array().unwrap() {
        let (level, dof) = (c["level"].as_f64().unwrap(), c["dof"].as_f64().unwrap());
        close(student::factor(level, dof), c["factor"].as_f64().unwrap(), 1e-7, c);
    }
}

#[test]
fn val_fishers_f_agrees_with_scipy_up_to_ten_million_degrees_of_freedom() {
    let oracle = oracle();
    let dof = |c: &Value| (c["dof"][0].as_f64().unwrap(), c["dof"][1].as_f64().unwrap());
    for c in oracle["f_tail"].as_array().unwrap() {
        let (a, b) = dof(c);
        close(fisher::tail(c["f"].as_f64().unwrap(), a, b), c["p"].as_f64().unwrap(), 1e-6, c);
    }
    for c in oracle["f_exceeded"].as_array().unwrap() {
        let (a, b) = dof(c);
        close(fisher::exceeded_with(c["p"].as_f64().unwrap(), a, b), c["f"].as_f64().unwrap(), 1e-7, c);
    }
}

#[test]
fn there_is_nothing_to_test_with_without_degrees_of_freedom() {
    assert_eq!(student::two_sided_p(5.0, 0.0), 1.0);
    assert_eq!(student::factor(0.95, 0.0), f64::INFINITY);
    assert_eq!(fisher::tail(f64::NAN, 2.0, 3.0), 1.0);
    assert_eq!(fisher::tail(f64::INFINITY, 2.0, 3.0), 0.0);
}
