//! From where control comes to the start of a function: from its calls, if each of them stands in the file as a statement of its own.

use crate::script::{Break, Join, Script, StepKind};
use crate::urscript::read::Parsed;
use std::collections::HashMap;

/// Adds to the script from where control comes to its functions. `starts`: the function of each start, in order; `calls`: what each break of a
/// call calls, where it is nothing but that call; `entry`: the function with which the program starts.
pub(super) fn join(
    p: &Parsed,
    entry: Option<usize>,
    starts: &[Option<usize>],
    calls: &[Option<String>],
    script: &mut Script,
) {
    let breaks = |kind: Break| {
        let all = script.steps.iter().enumerate();
        all.filter(move |(_, s)| matches!(s.kind, StepKind::Break(k) if k == kind))
            .map(|(k, _)| k)
            .collect::<Vec<usize>>()
    };
    let (started, called) = (breaks(Break::Start), breaks(Break::Call));
    // a thread may run, or end, anything at any time
    if !breaks(Break::Interrupt).is_empty() || started.len() != starts.len() || called.len() != calls.len() {
        return;
    }
    let mut everywhere: HashMap<&str, usize> = HashMap::new();
    p.items.iter().flat_map(|item| p.called(item)).for_each(|name| *everywhere.entry(name).or_default() += 1);
    let mut named: HashMap<&str, usize> = HashMap::new();
    p.defs.iter().for_each(|(name, _)| *named.entry(name).or_default() += 1);
    let mut by_name: HashMap<&str, Vec<usize>> = HashMap::new();
    for (at, name) in called.iter().zip(calls) {
        by_name.entry(name.as_deref().unwrap_or_default()).or_default().push(*at);
    }
    let mut joins = Vec::new();
    for (at, def) in started.iter().zip(starts) {
        let Some(name) = def.filter(|d| entry != Some(*d)).and_then(|d| p.defs.get(d)).map(|d| d.0.as_str()) else {
            continue;
        };
        let from = by_name.get(name).cloned().unwrap_or_default();
        if named.get(name) == Some(&1) && !from.is_empty() && everywhere.get(name) == Some(&from.len()) {
            joins.push(Join { at: *at, from });
        }
    }
    script.joins.extend(joins);
    script.joins.sort_by_key(|j| j.at);
}
