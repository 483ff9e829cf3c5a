//! What RAPID's own names mean: reserved words, motion instructions, instructions and functions that never move the robot,
//! predefined speeds and zones.
//!
//! Reference: ABB, Technical reference manual, RAPID Instructions, Functions and Data types (speeddata, zonedata). A name that
//! is in no list here may move the robot: the lists need not be complete to be safe.

use crate::script::PathKind;
use std::collections::HashSet;
use std::sync::LazyLock;

/// Reserved words that cannot stand inside a statement: one there means that a `;` is missing.
pub fn is_statement_word(word: &str) -> bool {
    // most words of a program are longer or shorter than any of these
    (2..=9).contains(&word.len())
        && matches!(
            word,
            "alias"
                | "backward"
                | "case"
                | "connect"
                | "const"
                | "default"
                | "do"
                | "else"
                | "elseif"
                | "endfor"
                | "endfunc"
                | "endif"
                | "endmodule"
                | "endproc"
                | "endrecord"
                | "endtest"
                | "endtrap"
                | "endwhile"
                | "error"
                | "exit"
                | "for"
                | "from"
                | "func"
                | "goto"
                | "if"
                | "inout"
                | "local"
                | "module"
                | "pers"
                | "proc"
                | "raise"
                | "record"
                | "retry"
                | "return"
                | "step"
                | "test"
                | "then"
                | "to"
                | "trap"
                | "trynext"
                | "undo"
                | "var"
                | "while"
                | "with"
        )
}

/// Whether a name is reserved in any way.
pub fn is_reserved(word: &str) -> bool {
    is_statement_word(word)
        || matches!(
            word,
            "and"
                | "or"
                | "xor"
                | "not"
                | "div"
                | "mod"
                | "true"
                | "false"
                | "task"
                | "sysmodule"
                | "nostepin"
                | "noview"
                | "readonly"
                | "viewonly"
        )
}

/// Operators that are words.
pub fn is_operator(word: &str) -> bool {
    matches!(word, "and" | "or" | "xor" | "div" | "mod")
}

/// What a motion instruction leads to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Leads {
    /// A jointtarget.
    Joints,
    /// A robtarget.
    Pose,
    /// Where it ends is not known.
    Search,
    /// External axes alone.
    External,
}

/// A motion instruction.
#[derive(Debug, Clone, Copy)]
pub struct Motion {
    pub path: PathKind,
    pub leads: Leads,
    /// Which of the required arguments is the target.
    pub target: usize,
    /// `MoveAbsJ`, `MoveJ`, `MoveL`: target, speed, zone, tool in this order, and nothing happens on the way.
    pub plain: bool,
    /// Its tool stands third after its target, and more may follow (a signal and its value). Process moves have it last.
    pub tool_third: bool,
    /// Process state after it.
    pub process: Option<bool>,
    /// It stands and works at its end (a spot weld).
    pub works: bool,
}

/// The motion instruction of a name in lower case.
pub fn motion(name: &str) -> Option<Motion> {
    let known = |path, leads, target| Motion {
        path,
        leads,
        target,
        plain: false,
        tool_third: false,
        process: None,
        works: false,
    };
    let third = |path, target| Motion { tool_third: true, ..known(path, Leads::Pose, target) };
    let simple = |path, leads| Motion { plain: true, tool_third: true, ..known(path, leads, 0) };
    Some(match name {
        "moveabsj" => simple(PathKind::Joint, Leads::Joints),
        "movej" => simple(PathKind::Joint, Leads::Pose),
        "movel" => simple(PathKind::Linear, Leads::Pose),
        "movec" => third(PathKind::Curve, 1),
        "triggabsj" => known(PathKind::Joint, Leads::Joints, 0),
        "moveextj" => known(PathKind::Joint, Leads::External, 0),
        "searchl" => known(PathKind::Linear, Leads::Search, 2),
        "searchc" => known(PathKind::Curve, Leads::Search, 3),
        "searchextj" => known(PathKind::Joint, Leads::Search, 2),
        "movejdo" | "movejao" | "movejgo" | "movejsync" => third(PathKind::Joint, 0),
        "moveldo" | "movelao" | "movelgo" | "movelsync" => third(PathKind::Linear, 0),
        "movecdo" | "movecao" | "movecgo" | "movecsync" => third(PathKind::Curve, 1),
        "triggj" => known(PathKind::Joint, Leads::Pose, 0),
        "triggl" | "trigglios" => known(PathKind::Linear, Leads::Pose, 0),
        "triggc" => known(PathKind::Curve, Leads::Pose, 1),
        "spotl" | "spotml" => Motion { works: true, ..known(PathKind::Linear, Leads::Pose, 0) },
        "spotj" | "spotmj" => Motion { works: true, ..known(PathKind::Joint, Leads::Pose, 0) },
        "displ" | "paintl" | "capl" | "gluel" | "laserl" => known(PathKind::Linear, Leads::Pose, 0),
        "dispc" | "paintc" | "capc" | "gluec" | "laserc" => known(PathKind::Curve, Leads::Pose, 1),
        _ => return arc(name),
    })
}

/// `ArcL`, `ArcC`, `ArcL1Start`, `ArcCEnd`, `ArcMoveL`, ...
///
/// `arc = "Arc" ("L" | "C" | "Move" ("L" | "C" | "J")) {digit} ["Start" | "End"]`
fn arc(name: &str) -> Option<Motion> {
    let rest = name.strip_prefix("arc")?;
    let (moves, rest) = rest.strip_prefix("move").map_or((false, rest), |r| (true, r));
    let (path, target) = match rest.as_bytes().first()? {
        b'l' => (PathKind::Linear, 0),
        b'c' => (PathKind::Curve, 1),
        b'j' if moves => (PathKind::Joint, 0),
        _ => return None,
    };
    let rest = rest[1..].trim_start_matches(|c: char| c.is_ascii_digit());
    let process = match rest {
        "" => None,
        "start" => Some(true),
        "end" => Some(false),
        _ => return None,
    };
    Some(Motion { path, leads: Leads::Pose, target, plain: false, tool_third: false, process, works: false })
}

/// Instructions that neither move the robot nor change what targets mean. In lower case, sorted.
const QUIET: &str = "\
    accset add bitclear bitset bookerrno cirpathmode clear clkreset clkstart clkstop close confj confl copyfile copyrawbytes \
    cornerpathwarning cyclebreakpoint decr dispset erasemodule errlog errwrite getdataval getsysdata gripload \
    idelete idisable incr invertdo iodisable ioenable isleep makedir mechunitload motionsup open opendir \
    packrawbytes pathaccl pathacclim pathresol pulsedo readany readblock readcfgdata readrawbytes removefile \
    reset rewind scwrite set setao setdataval setdo setgo singarea socketaccept socketbind socketclose \
    socketconnect socketcreate socketlisten socketreceive socketsend spycancel spystart tperase tpreaddnum \
    tpreadfk tpreadnum tpshow tpwrite triggcheckio triggequip triggio triggrampao triggspeed tunereset tuneservo \
    uimsgbox uishow unpackrawbytes velset waitai waitao waitdi waitdo waitgi waitgo waitrob waitsynctask \
    waittestandset waittime waituntil worldacclim write writeanybin writebin writeblock writecfgdata \
    writerawbytes writestrbin";

/// The names of a list with blanks between them.
type Names = LazyLock<HashSet<&'static str>>;

fn names(list: &'static str) -> HashSet<&'static str> {
    list.split_ascii_whitespace().collect()
}

pub fn is_quiet(name: &str) -> bool {
    static ALL: Names = Names::new(|| names(QUIET));
    ALL.contains(name)
}

/// Instructions at which the robot stands and waits.
pub fn is_wait(name: &str) -> bool {
    static ALL: Names = Names::new(|| names(WAITS));
    ALL.contains(name)
}

/// A name that only begins so may be a procedure of another module, and move: `WaitHome`.
const WAITS: &str = "\
    waitai waitao waitdi waitdo waitgi waitgo waitload waitrob waitsynctask waittestandset waittime waituntil \
    tpreadfk tpreadnum tpreaddnum uimsgbox syncmoveon syncmoveoff";

/// What leads the arm away from its targets from one instruction on until another.
const LEADS: [(&str, &str); 4] =
    [("softact", "softdeact"), ("cssact", "cssdeactmovel"), ("fcact", "fcdeact"), ("synctosensor", "synctosensor")];

/// Whether an instruction begins to lead the arm away from its targets (its name), or ends that; `off`: it has `\Off`.
pub fn leads(name: &str, off: bool) -> Option<Option<&'static str>> {
    let (on, end) = LEADS.iter().find(|(on, end)| *on == name || *end == name)?;
    Some(if off || on != end && *end == name { None } else { Some(*on) })
}

/// Instructions that change what targets mean.
pub fn is_frame(name: &str) -> bool {
    name.starts_with("pdisp")
        || name.starts_with("eoffs")
        // after these a work object moves with a conveyor, or the arm with a sensor
        || matches!(name, "actunit" | "deactunit" | "waitwobj" | "dropwobj" | "waitsensor" | "dropsensor")
}

/// Instructions that arm an interrupt.
pub fn arms(name: &str) -> bool {
    name.starts_with("isignal")
        || matches!(
            name,
            "iwatch"
                | "ienable"
                | "itimer"
                | "ivarvalue"
                | "ipers"
                | "ierror"
                | "ipathpos"
                | "ivariable"
                | "iphase"
                | "triggint"
        )
}

/// RAPID's functions, which never move the robot. In lower case.
const FUNCTIONS: &str = "\
    abs acos aoutput argname asin atan atan2 bitand bitcheck bitlsh bitneg bitor bitrsh bitxor bytetostr \
    calcjointt calcrobt calcrotaxframez calcrotaxisframe cdate cjointt clkread corrread cos cpos crobt \
    cspeedoverride ctime ctool cwobj decodenum defaccframe defdframe defframe dim dnumtonum dnumtostr doutput \
    eulerzyx eventtype exechandler execlevel exp filesize filetime fssize getmecunitname getmodalpaymode \
    getnextmechunit getnextsym getserviceinfo getsysinfo gettaskname gettime ginput ginputdnum goutput \
    goutputdnum hextodec indinpos indspeed iounitstate isfile ismechunitactive ispers isstopmoveact \
    isstopstateevent issyncmoveon issysid isvar maxrobspeed mirpos modexist modtime motionplannerno \
    nonmotionmode numtodnum numtostr offs opmode orientzyx orobt pathlevel poseinv posemult posevect pow present \
    proginfo quatmult rand readbin readmotor readnum readstr readstrbin readvar reltool remainingretries robname \
    robos robotstate round runmode seed sin socketgetstatus socketpeek sqrt stdevstatus strfind strlen strmap \
    strmatch strmemb strorder strpart strtobyte strtoval tan taskruntime tasksinsync testandset testdi \
    testsignread tpreadfk triggdatavalid trunc type uialphaentry uiclientexist uidnumentry uidnumtune uilistview \
    uimessagebox uinumentry uinumtune validio valtostr vectmagn";

pub fn is_function(name: &str) -> bool {
    static ALL: Names = Names::new(|| names(FUNCTIONS));
    ALL.contains(name)
}

/// Functions among them that write into one of their arguments.
pub fn sets_argument(name: &str) -> bool {
    matches!(name, "getnextmechunit" | "getnextsym" | "strtoval" | "testandset" | "uilistview")
}

/// Instructions that print or send the values of their arguments, and set none.
pub fn only_reads(name: &str) -> bool {
    matches!(name, "errwrite" | "socketsend" | "tpshow" | "tpwrite" | "write" | "writestrbin")
}

/// Arguments of a calibration or a search (by their place among those that are no switches) whose values it takes and does not set: the joints of
/// `MToolTCPCalib Pos1, Pos2, Pos3, Pos4, Tool, MaxErr, MeanErr` and `MToolRotCalib RefTip, ZPos \XPos, Tool` (ABB, Technical reference manual,
/// RAPID instructions), the points of `Search_1D Result, StartPoint, SearchPoint, Speed, Tool`.
pub fn inputs(name: &str) -> std::ops::Range<usize> {
    match name {
        "mtooltcpcalib" | "stooltcpcalib" => 0..4,
        "mtoolrotcalib" | "stoolrotcalib" => 0..2,
        "search_1d" => 1..3,
        _ => 0..0,
    }
}

/// Speed of a predefined `v..`, mm/s; infinite for `vmax`.
pub fn speed_mm_s(name: &str) -> Option<f64> {
    const SPEEDS: [u32; 25] = [
        5, 10, 20, 30, 40, 50, 60, 80, 100, 150, 200, 300, 400, 500, 600, 800, 1000, 1500, 2000, 2500, 3000, 4000,
        5000, 6000, 7000,
    ];
    if name == "vmax" {
        return Some(f64::INFINITY);
    }
    let n: u32 = name.strip_prefix('v')?.parse().ok()?;
    SPEEDS.contains(&n).then_some(f64::from(n))
}

/// Radius of a predefined zone, mm; 0: `fine`.
pub fn zone_mm(name: &str) -> Option<f64> {
    const ZONES: [u32; 13] = [1, 5, 10, 15, 20, 30, 40, 50, 60, 80, 100, 150, 200];
    match name {
        "fine" => Some(0.0),
        "z0" => Some(Z0_MM),
        _ => {
            let n: u32 = name.strip_prefix('z')?.parse().ok()?;
            ZONES.contains(&n).then_some(f64::from(n))
        }
    }
}

/// Radius of `z0`, the finest predefined fly-by point, mm.
pub const Z0_MM: f64 = 0.3;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_rapids_own_waits_are_waits() {
        assert!(is_wait("waitdi") && is_wait("waituntil"));
        assert!(!is_wait("waithome") && !is_wait("waitpart") && !is_wait("waitwobj") && is_frame("waitwobj"));
    }

    #[test]
    fn arc_instructions_tell_their_process() {
        assert_eq!(motion("arclstart").unwrap().process, Some(true));
        assert_eq!(motion("arcc1end").unwrap().process, Some(false));
        assert_eq!(motion("arcl").unwrap().process, None);
        assert!(motion("arcrefresh").is_none() && motion("triggio").is_none());
    }
}
