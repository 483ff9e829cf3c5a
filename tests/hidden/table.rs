//! The table of figures against targets, and the confusion matrix.

use crate::score::Score;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// A figure: what, target, hits, of how many.
pub struct Figure {
    pub what: &'static str,
    pub target: &'static str,
    pub hits: usize,
    pub of: usize,
}

impl Figure {
    pub fn rate(&self) -> f64 {
        if self.of == 0 { f64::NAN } else { self.hits as f64 / self.of as f64 }
    }
}

fn count(
    scores: &[Score],
    what: &'static str,
    target: &'static str,
    class: &str,
    hit: impl Fn(&Score) -> bool,
) -> Figure {
    let of: Vec<&Score> = scores.iter().filter(|s| s.class == class).collect();
    Figure { what, target, hits: of.iter().filter(|s| hit(s)).count(), of: of.len() }
}

/// The figures that are shares of cases.
pub fn figures(scores: &[Score]) -> Vec<Figure> {
    let first = |s: &Score| s.effects.iter().all(|e| e.first);
    let right = |s: &Score| s.effects.iter().all(|e| e.right);
    let mut list = vec![
        count(scores, "null: something named", "0", "null", |s| !s.verdict_right || !s.false_alarms.is_empty()),
        count(scores, "single 10 MDB: right (set of at most 3)", ">= 99 %", "single 10", right),
        count(scores, "single 10 MDB: named first", ">= 95 %", "single 10", first),
        count(scores, "single 3 MDB: right (set of at most 3)", ">= 95 %", "single 3", right),
        count(scores, "single 3 MDB: named first", ">= 90 %", "single 3", first),
        count(scores, "single large: right (set of at most 3)", ">= 99 %", "single large", right),
        count(scores, "single large: named first", ">= 95 %", "single large", first),
        count(scores, "pair: all named first, nothing else", "-", "pair", |s| first(s) && s.false_alarms.is_empty()),
        count(scores, "triple: all named first, nothing else", "-", "triple", |s| {
            first(s) && s.false_alarms.is_empty()
        }),
        count(scores, "outside the catalogue: unknown", ">= 90 %", "unknown", |s| s.verdict_right),
        count(scores, "bad file: bad_data", ">= 98 %", "bad", |s| s.verdict_right),
    ];
    for (what, class) in
        [("single 10 MDB: a false name beside", "single 10"), ("single 3 MDB: a false name beside", "single 3")]
    {
        list.push(count(scores, what, "0", class, |s| !s.false_alarms.is_empty()));
    }
    let found = scores.iter().filter(|s| s.class != "bad").flat_map(|s| &s.effects);
    let (hits, of) = found.clone().fold((0, 0), |n, e| (n.0 + e.inside.0, n.1 + e.inside.1));
    list.push(Figure { what: "parameter inside its ci95 (effects named first)", target: "93-97 %", hits, of });
    let sized: Vec<f64> = found.filter_map(|e| e.size).collect();
    let near = sized.iter().filter(|s| (**s - 1.0).abs() < 0.2).count();
    list.push(Figure { what: "size within 20 % (effects named first)", target: "-", hits: near, of: sized.len() });
    list
}

/// Micro-averaged F1 of a class: by first names, and with sets of at most three.
pub fn f1(scores: &[Score], class: &str) -> (f64, f64) {
    let of: Vec<&Score> = scores.iter().filter(|s| s.class == class).collect();
    let f1 = |hit: &dyn Fn(&crate::score::Found) -> bool| {
        let truth: usize = of.iter().map(|s| s.effects.len()).sum();
        let hits: usize = of.iter().map(|s| s.effects.iter().filter(|e| hit(e)).count()).sum();
        // A round in whose set the truth stands, but not first, is a false name by first names.
        let extra: usize =
            of.iter().map(|s| s.false_alarms.len() + s.effects.iter().filter(|e| e.right && !hit(e)).count()).sum();
        2.0 * hits as f64 / (hits + extra + truth).max(1) as f64
    };
    (f1(&|e| e.first), f1(&|e| e.right))
}

/// Value below which a share of them lie.
pub fn quantile(values: &[f64], share: f64) -> f64 {
    let mut v = values.to_vec();
    v.sort_by(f64::total_cmp);
    if v.is_empty() { f64::NAN } else { v[((v.len() - 1) as f64 * share).round() as usize] }
}

/// The whole report as text.
pub fn report(scores: &[Score]) -> String {
    let mut s = format!("\n{:<52} {:>10} {:>18}\n", "figure", "target", "measured");
    for f in figures(scores) {
        let _ = writeln!(s, "{:<52} {:>10} {:>8.1} % {:>4}/{:<4}", f.what, f.target, 100.0 * f.rate(), f.hits, f.of);
    }
    for (class, target) in [("pair", "0.95"), ("triple", "0.90")] {
        let (first, set) = f1(scores, class);
        let _ =
            writeln!(s, "{:<52} {:>10} {first:>8.3}   with sets {set:.3}", format!("{class}: F1, named first"), target);
    }
    for (what, value) in [
        ("gap closed, measured squares against oracle", scores.iter().filter_map(|s| s.closed).collect::<Vec<_>>()),
        ("gap closed, noise-free, linear", scores.iter().filter_map(|s| s.closed_exact).collect()),
    ] {
        let _ = writeln!(
            s,
            "{what:<52} {:>10} {:>8.1} % median, {:.1} % at 5 %, of {}",
            "97 / 90 %",
            100.0 * quantile(&value, 0.5),
            100.0 * quantile(&value, 0.05),
            value.len()
        );
    }
    let seconds: Vec<f64> = scores.iter().map(|s| s.seconds).collect();
    let _ = writeln!(
        s,
        "{:<52} {:>10} {:>8.2} s median, {:.2} s longest",
        "time of a diagnosis",
        "-",
        quantile(&seconds, 0.5),
        quantile(&seconds, 1.0)
    );
    s + &matrix(scores) + &misses(scores)
}

/// Effect against effect, over the single cases: rows are true, columns named first.
fn matrix(scores: &[Score]) -> String {
    let mut cells: BTreeMap<(&str, String), usize> = BTreeMap::new();
    for s in scores.iter().filter(|s| s.class.starts_with("single")) {
        for e in &s.effects {
            let as_what = match &e.named {
                _ if e.first => "= right".to_string(),
                Some((name, _)) if *name == e.name => "= other target".to_string(),
                Some((name, _)) => name.clone(),
                None => format!("- {}", s.verdict),
            };
            *cells.entry((&e.name, as_what)).or_default() += 1;
        }
    }
    let mut columns: Vec<String> = cells.keys().map(|(_, c)| c.clone()).collect();
    columns.sort();
    columns.dedup();
    let rows: std::collections::BTreeSet<&str> = cells.keys().map(|(r, _)| *r).collect();
    let mut s = String::from("\nconfusion, single effects (true down, named first across)\n");
    for (k, c) in columns.iter().enumerate() {
        let _ = writeln!(s, "  [{k}] {c}");
    }
    let _ = write!(s, "{:<20}", "");
    (0..columns.len()).for_each(|k| s += &format!("{:>5}", format!("[{k}]")));
    s.push('\n');
    for r in rows {
        let _ = write!(s, "{r:<20}");
        for c in &columns {
            let n = cells.get(&(r, c.clone())).copied().unwrap_or(0);
            s += &if n == 0 { "    .".to_string() } else { format!("{n:>5}") };
        }
        s.push('\n');
    }
    s
}

/// One line for each case that is not wholly right.
fn misses(scores: &[Score]) -> String {
    let mut s = String::from("\nnot wholly right\n");
    for c in scores {
        let first = c.effects.iter().all(|e| e.first);
        if !(c.verdict_right && first && c.false_alarms.is_empty()) {
            let _ = writeln!(s, "{}", line(c));
        }
    }
    s
}

/// A case on one line.
pub fn line(c: &Score) -> String {
    let effects: Vec<String> = c
        .effects
        .iter()
        .map(|e| {
            let mark = if e.first {
                "first"
            } else if e.right {
                "in set"
            } else {
                "MISSED"
            };
            let named = e.named.as_ref().filter(|_| !e.first).map_or(String::new(), |(n, t)| format!(" as {n} {t}"));
            let size = e.size.map_or(String::new(), |v| format!(" x{v:.3}"));
            let inside = if e.inside.1 > 0 { format!(" ci {}/{}", e.inside.0, e.inside.1) } else { String::new() };
            format!("{} {}: {mark}{named}{size}{inside}", e.name, e.target)
        })
        .collect();
    let closed = c.closed.map_or(String::new(), |v| format!(" closed {:.1} %", 100.0 * v));
    let exact = c.closed_exact.map_or(String::new(), |v| format!(" (exact {:.1} %)", 100.0 * v));
    let extra = if c.false_alarms.is_empty() { String::new() } else { format!(" FALSE {}", c.false_alarms.join(", ")) };
    format!(
        "{:<46} {:<12} {} [{}]{extra}{closed}{exact} {:.1} s {}",
        c.case,
        c.verdict,
        if c.verdict_right { "ok" } else { "WRONG" },
        effects.join("; "),
        c.seconds,
        c.note
    )
}
