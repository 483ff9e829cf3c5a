//! Bases on external axes, conveyors and other robots, by `$config.dat`.
//!
//! Frame data of an inline form name a base by its number. `BAS(#FRAMES)` and the parameters of a motion put it into force as the `FRAMES`
//! of KUKA's `bas.src` does: where `MACHINE_FRAME_DAT[n].MACH_DEF_INDEX` names an external axis it is `EK(root, type, BASE_DATA[n])`, which
//! counts from that axis's root and moves with it; on a conveyor `EB`, on another robot `LK`. `BAS(#BASE,n)`, `$BASE=BASE_DATA[n]` and
//! `SBASE` take `BASE_DATA[n]` in the world whatever the list says.

use super::lists::as_set;
use super::reason::Reason;
use crate::bases::{CarriedBases, Carrier};
use crate::script::Text;
use crate::script::pose::Frame;
use std::collections::BTreeMap;

impl CarriedBases {
    /// Reads a data list.
    ///
    /// `list = {"MACHINE_FRAME_DAT" "[" number "]" "=" "{" ... "MACH_DEF_INDEX" number ... "}" | "MACHINE_DEF" "[" number "]" "=" "{" ...
    /// "COOP_KRC_INDEX" number ... "MECH_TYPE" "#" type ... "}"}`
    pub fn of_list(text: &str) -> Self {
        let mut machines: BTreeMap<u32, Machine> = BTreeMap::new();
        let mut frames: BTreeMap<u32, u32> = BTreeMap::new();
        for line in text.lines().filter(|l| l.to_ascii_uppercase().contains("MACHINE_")) {
            let line = plain(line).to_ascii_uppercase();
            if let Some((n, value)) = element(&line, "MACHINE_FRAME_DAT[") {
                frames.extend(number(value, "MACH_DEF_INDEX").filter(|m| *m > 0).map(|m| (n, m)));
            } else if let Some((n, value)) = element(&line, "MACHINE_DEF[") {
                machines.insert(n, Machine::of(value));
            }
        }
        // of a machine that is not listed nothing is known
        let carrier = |machine: u32| match machines.get(&machine) {
            Some(known) => known.carries().map(|external_axis| Carrier { machine, external_axis }),
            None => Some(Carrier { machine, external_axis: false }),
        };
        Self { bases: frames.into_iter().filter_map(|(n, machine)| Some((n, carrier(machine)?))).collect() }
    }

    /// What frame data put into force as the base of number `n`, of which the program's text makes `frame`.
    pub(super) fn in_force(&self, n: u32, frame: Frame) -> Frame {
        let Some(Carrier { machine, external_axis }) = self.bases.get(&n).copied() else { return frame };
        if !external_axis {
            return Frame::unclear(Reason::BaseMoves { base: n, machine });
        }
        let on = format!("on MACHINE_DEF[{machine}]");
        match frame {
            Frame::Named(own) if own == n.to_string() => Frame::Named(format!("{own} {on}")),
            Frame::Given(_) => as_set(n).made("", &on),
            set => set.made("", &on),
        }
    }
}

/// An element of `MACHINE_DEF`.
struct Machine {
    /// Controller of the machine; 1: the own one.
    controller: Option<u32>,
    kind: String,
}

impl Machine {
    fn of(value: &str) -> Self {
        let kind = after(value, "MECH_TYPE").and_then(|v| v.strip_prefix('#')).unwrap_or_default();
        let kind = kind.split(|c: char| !(c.is_alphanumeric() || c == '_')).next().unwrap_or_default();
        Self { controller: number(value, "COOP_KRC_INDEX"), kind: kind.into() }
    }

    /// Whether a base on it is on an external axis of the own controller; `None`: it counts from the world.
    fn carries(&self) -> Option<bool> {
        let own = self.controller == Some(1);
        match self.kind.as_str() {
            "NONE" => None,
            "ROBOT" if own => None,
            "ROBOT" | "CONVEYOR" | "" => Some(false),
            _ => Some(own),
        }
    }
}

/// A line without its comment and without what stands between quotes.
fn plain(line: &str) -> String {
    let parts = line.split('"').step_by(2);
    let whole: String = parts.collect();
    whole.split(';').next().unwrap_or_default().trim().to_string()
}

/// Number and value of an assignment to an element of a list.
fn element<'a>(line: &'a str, list: &str) -> Option<(u32, &'a str)> {
    let (index, rest) = line.strip_prefix(list)?.split_once(']')?;
    Some((index.trim().parse().ok()?, rest.trim_start().strip_prefix('=')?))
}

/// What follows a word of an aggregate.
fn after<'a>(value: &'a str, word: &str) -> Option<&'a str> {
    let inside = |c: char| c.is_alphanumeric() || c == '_';
    let place = value.match_indices(word).find(|(at, _)| {
        let ends = value[at + word.len()..].starts_with([' ', '\t']);
        ends && !value[..*at].ends_with(inside)
    })?;
    Some(value[place.0 + word.len()..].trim_start())
}

fn number(value: &str, word: &str) -> Option<u32> {
    let digits = after(value, word)?;
    digits.split(|c: char| !c.is_ascii_digit()).next()?.parse().ok()
}

/// Whether a text is a `$config.dat`.
fn is_config(text: &Text) -> bool {
    let name = text.name.rsplit(['/', '\\']).next().unwrap_or_default();
    name.eq_ignore_ascii_case("$config.dat")
}

/// What the `$config.dat` of the project say, besides what is given.
pub(super) fn carried(texts: &[Text], given: &CarriedBases) -> CarriedBases {
    let mut all = given.clone();
    for text in texts.iter().filter(|t| t.context && !t.unread && is_config(t)) {
        all.add(&text.known(|t| CarriedBases::of_list(&String::from_utf8_lossy(&t.bytes))));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bases_on_a_table_a_conveyor_and_another_robot_are_told_from_those_in_the_world() {
        let list = "DEFDAT $CONFIG PUBLIC\r\nDECL MACHINE_DEF_T MACHINE_DEF[16]\r\n\
            MACHINE_DEF[1]={NAME[] \"KR; 120\",COOP_KRC_INDEX 1,PARENT[] \"WORLD\",ROOT {X 0.0,Y 0.0},MECH_TYPE #ROBOT}\r\n\
            MACHINE_DEF[2]={NAME[] \"DKP}\",COOP_KRC_INDEX 1,PARENT[] \"WORLD\",ROOT {X 1.0,Y 0.0},MECH_TYPE #EASYS}\r\n\
            MACHINE_DEF[3]={NAME[] \" \",COOP_KRC_INDEX 1,MECH_TYPE #CONVEYOR} ;MECH_TYPE #NONE\r\n\
            MACHINE_DEF[4]={NAME[] \" \",COOP_KRC_INDEX 2,MECH_TYPE #ROBOT}\r\n\
            MACHINE_DEF[5]={NAME[] \" \",COOP_KRC_INDEX 0,MECH_TYPE #NONE}\r\n\
            DECL MACHINE_FRAME_T MACHINE_FRAME_DAT[32]\r\nMACHINE_FRAME_DAT[1]={MACH_DEF_INDEX 0,PARENT[] \"WORLD\"}\r\n\
            MACHINE_FRAME_DAT[2]={MACH_DEF_INDEX 2,PARENT[] \"DKP\"}\r\nmachine_frame_dat[3]={MACH_DEF_INDEX 3}\r\n\
            MACHINE_FRAME_DAT[4]={MACH_DEF_INDEX 4}\r\nMACHINE_FRAME_DAT[5]={MACH_DEF_INDEX 5}\r\n\
            MACHINE_FRAME_DAT[6]={MACH_DEF_INDEX 1}\r\nMACHINE_FRAME_DAT[7]={MACH_DEF_INDEX 9}\r\nENDDAT\r\n";
        let bases = CarriedBases::of_list(list);
        let of = |n: u32| bases.bases.get(&n).map(|c| (c.machine, c.external_axis));
        let found = [1, 2, 3, 4, 5, 6, 7].map(of);
        assert_eq!(found, [None, Some((2, true)), Some((3, false)), Some((4, false)), None, None, Some((9, false))]);
        assert!(CarriedBases::of_list("BASE_DATA[2]={X 1.0}\nMACHINE_FRAME_DAT[2]={\n").is_empty());
    }
}
