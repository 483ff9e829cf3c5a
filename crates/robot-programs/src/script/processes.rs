//! Steps at which a process (welding, dispensing) may be on, wherever control comes from.
//!
//! It counts as on wherever one way through the program leaves it on: an end of it that may be passed by ends nothing for those who pass
//! by, a loop may begin with what its last pass left on, and a routine with what was on where it is called.

use super::order::Join;
use super::{Break, Script, Step, StepKind};

/// For each step whether a process may be on before it; empty: none ever is.
///
/// From where control comes to a break is taken from [`Script::ways`]; to a label or a loop of which that is not known it may come from
/// every break of its routine, to a routine of which that is not known from every call, and to what stands after a call from every end of a
/// routine.
pub fn before_each(script: &Script) -> Vec<bool> {
    let steps = &script.steps;
    if !steps.iter().any(|s| matches!(s.kind, StepKind::Process(true))) {
        return Vec::new();
    }
    let mut states = States { before: vec![false; steps.len() + 1], grown: true };
    let routines = routines(steps);
    while std::mem::take(&mut states.grown) {
        for routine in &routines {
            states.pass(script, &routines, routine.clone());
        }
    }
    states.before.truncate(steps.len());
    states.before
}

type Steps = std::ops::Range<usize>;

/// The steps of each routine.
fn routines(steps: &[Step]) -> Vec<Steps> {
    let starts = steps.iter().enumerate().filter(|(_, s)| matches!(s.kind, StepKind::Break(Break::Start)));
    // what stands before the first start belongs to it
    let mut bounds: Vec<usize> = std::iter::once(0).chain(starts.skip(1).map(|(k, _)| k)).collect();
    bounds.push(steps.len());
    bounds.windows(2).map(|w| w[0]..w[1]).collect()
}

struct States {
    /// Before each step, and at the end.
    before: Vec<bool>,
    /// Some state has changed in a pass.
    grown: bool,
}

impl States {
    /// Goes through a routine once: states only grow, so that it comes to an end.
    fn pass(&mut self, script: &Script, routines: &[Steps], routine: Steps) {
        let mut on = false;
        for k in routine.clone() {
            self.reach(k, on);
            on = match script.steps[k].kind {
                StepKind::Process(now) => now,
                StepKind::Break(kind) => self.after(script, routines, &routine, k, kind),
                _ => on,
            };
        }
        // the next routine does not go on from here
        if routine.end == script.steps.len() {
            self.reach(routine.end, on);
        }
    }

    fn reach(&mut self, step: usize, on: bool) {
        if on && !self.before[step] {
            self.before[step] = true;
            self.grown = true;
        }
    }

    /// Whether it may be on after a break.
    fn after(&self, script: &Script, routines: &[Steps], routine: &Steps, k: usize, kind: Break) -> bool {
        let way = script.ways.binary_search_by_key(&k, |j| j.at).ok().map(|n| &script.ways[n]);
        let of = |join: &Join| join.from.iter().any(|from| self.before.get(*from).copied().unwrap_or(false));
        let breaks = |mut steps: Steps, counts: &dyn Fn(Break) -> bool| {
            steps.any(|n| self.before[n] && matches!(script.steps[n].kind, StepKind::Break(kind) if counts(kind)))
        };
        match (way, kind) {
            (Some(join), _) => of(join),
            (None, Break::Frame | Break::Axes(_) | Break::Interrupt) => self.before[k],
            (None, Break::Start) => breaks(0..script.steps.len(), &|kind| kind == Break::Call),
            // one that is not in the text is taken to leave it as it was
            (None, Break::Call) => self.before[k] || routines.len() > 1 && self.left(script, routines),
            (None, Break::Jump | Break::Loop) => {
                self.before[k] || self.end(script, routine) || breaks(routine.clone(), &|_| true)
            }
        }
    }

    /// Whether it may be on where some routine is left.
    fn left(&self, script: &Script, routines: &[Steps]) -> bool {
        let away = script.ways.iter().filter(|j| j.from.is_empty());
        away.map(|j| j.at).any(|k| self.before[k]) || routines.iter().any(|r| self.end(script, r))
    }

    /// Whether it may be on at the end of a routine's text.
    fn end(&self, script: &Script, routine: &Steps) -> bool {
        let Some(last) = routine.clone().next_back() else { return false };
        match script.steps[last].kind {
            StepKind::Process(on) => on,
            _ => self.before[last],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Format, Text};
    use super::*;
    use crate::fixtures::{kr120, m10ia};

    /// Lines of the moves at which a process may be on.
    fn lines(format: &dyn Format, name: &str, text: &str) -> Vec<u64> {
        let axes = if name.ends_with("src") { kr120() } else { m10ia() };
        let document = format.parse(vec![Text::new(name, text.as_bytes().to_vec())], &axes).unwrap();
        let script = document.script();
        let on = before_each(script);
        let moves = script.steps.iter().enumerate().filter(|(_, s)| matches!(s.kind, StepKind::Move(_)));
        moves.filter(|(k, _)| on.get(*k).copied().unwrap_or(false)).map(|(_, s)| s.at.line).collect()
    }

    fn krl(body: &str) -> Vec<u64> {
        let mut text = String::new();
        for line in body.split('|') {
            text += &match line.trim().strip_prefix("go ") {
                Some(a1) => format!("PTP {{A1 {a1},A2 -80,A3 95,A4 20,A5 30,A6 10}}\n"),
                None => format!("{}\n", line.trim()),
            };
        }
        lines(&crate::krl::Krl, "a.src", &text)
    }

    #[test]
    fn a_process_is_on_wherever_one_way_leaves_it_on() {
        // worked out by hand: the lines of the moves, counted from the head of the first routine
        let cases: [(&str, &str, &[u64]); 9] = [
            ("straight", "DEF a()|go 0|ARC_ON()|go 5|ARC_OFF()|go 0|END", &[4]),
            ("never", "DEF a()|go 0|ARC_OFF()|go 5|END", &[]),
            ("its end may be passed by", "DEF a()|ARC_ON()|IF $IN[1] THEN|ARC_OFF()|ENDIF|go 6|END", &[6]),
            ("its start may be passed by", "DEF a()|IF $IN[1] THEN|ARC_ON()|ENDIF|go 6|ARC_OFF()|go 3|END", &[5]),
            ("off on both branches", "DEF a()|ARC_ON()|IF $IN[1] THEN|ARC_OFF()|ELSE|ARC_OFF()|ENDIF|go 6|END", &[]),
            ("the next pass", "DEF a()|go 0|LOOP|go 6|ARC_ON()|go 3|ENDLOOP|END", &[4, 6]),
            (
                "a jump back",
                "DEF a()|go 0|X:|go 6|ARC_ON()|go 3|IF $IN[1] THEN|GOTO X|ENDIF|ARC_OFF()|go 1|END",
                &[4, 6],
            ),
            (
                "a routine that is called",
                "DEF a()|go 0|ARC_ON()|B()|ARC_OFF()|go 4|END|DEF B()|go 5|go 6|END|DEF C()|go 1|END",
                &[9, 10],
            ),
            (
                "a routine that leaves it on",
                "DEF a()|go 0|B()|go 4|ARC_OFF()|go 1|END|DEF B()|go 5|ARC_ON()|go 6|END",
                &[4, 11],
            ),
        ];
        for (what, body, expected) in cases {
            assert_eq!(krl(body), expected, "{what}");
        }
    }

    #[test]
    fn a_jump_back_in_a_language_without_blocks_brings_it_along() {
        let fanuc = "/PROG A\n/MN\n1:J P[1] 100% FINE ;\n2:LBL[1] ;\n3:J P[2] 100% FINE ;\n4:Weld Start[1,1] ;\n\
            5:J P[3] 100% FINE ;\n6:IF DI[1]=ON,JMP LBL[1] ;\n7:J P[1] 100% FINE ;\n8:Weld End[1,1] ;\n\
            9:J P[2] 100% FINE ;\n/POS\n/END\n";
        assert_eq!(lines(&crate::fanuc::Fanuc, "a.ls", fanuc), [5, 7, 9]);
        let inform = "/JOB\n//NAME A\n//POS\n///NPOS 0,0,0,0,0,0\n//INST\n///DATE 2020/01/01 00:00\n///ATTR SC,RW\n///GROUP1 RB1\n\
            NOP\nMOVJ P000 VJ=50.00\n*L1\nMOVJ P001 VJ=50.00\nARCON ASF#(1)\nMOVJ P002 VJ=50.00\nJUMP *L1 IF IN#(1)=ON\n\
            MOVJ P003 VJ=50.00\nARCOF\nMOVJ P004 VJ=50.00\nEND\n";
        assert_eq!(lines(&crate::inform::Inform, "a.jbi", inform), [12, 14, 16]);
    }
}
