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
    accset acteventbuffer add aliascamera aliasio aliasioreset bitclear bitset bookerrno camflush \
    camgetparameter camgetresult camloadjob camreqimage camsetexposure camsetparameter camsetprogrammode \
    camsetrunmode camstartloadjob camwaitloadjob cancelload checkprogref cirpathmode clear cleariobuff \
    clearrawbytes clkreset clkstart clkstop close closedir confj confl copyfile copyrawbytes cornerpathwarning \
    corrclear corrcon corrdiscon corrwrite cyclebreakpoint deacteventbuffer decr dispset egmactjoint egmactmove \
    egmactpose egmgetid egmreset egmsetupai egmsetupao egmsetupgi egmsetupltapp egmsetupuc erasemodule errlog \
    errraise errwrite getdataval getgroupsignalinfo getjointdata getsysdata gettorquemargin gettrapdata gripload \
    idelete idisable incr invertdo iobusstart iobusstate iodisable ioenable isleep load makedir mechunitload \
    motionprocessmodeset motionsup open opendir packdnheader packrawbytes pathaccl pathacclim pathlengthreset \
    pathlengthstart pathlengthstop pathrecstart pathrecstop pathresol pulsedo raisetouser readany readanybin \
    readblock readcfgdata readerrdata readrawbytes readvararr removeallcyclicbool removecyclicbool removedir \
    removefile removesuperv renamefile reset resetaxisdistance resetaxismovetime resetppmoved resetretrycount \
    resettorquemargin rewind rmqemptyqueue rmqfindslot rmqgetmessage rmqgetmsgdata rmqgetmsgheader rmqreadwait \
    rmqsendmessage rmqsendwait safetycontrollersyncrequest save savecfgdata scwrite sendevice set setalldataval \
    setao setdatasearch setdataval setdo setgo setsysdata setupcyclicbool setupsuperv siclose siconnect \
    sigetcyclic singarea sisetcyclic skipwarn socketaccept socketbind socketclose socketconnect socketcreate \
    socketlisten socketreceive socketreceivefrom socketsend socketsendto softdeact speedlimaxis speedlimcheckpoint \
    speedrefresh spycancel spystart spystop startload stopmove stopmovereset storepath sttune sttunereset \
    systemstopaction testsigndefine testsignreset texttabinstall tperase tpreaddnum tpreadfk tpreadnum tpshow \
    tpwrite triggcheckio triggdatacopy triggdatareset triggequip triggio triggrampao triggspeed triggstopproc \
    tryint tunereset tuneservo uimsgbox uimsgwrite uimsgwriteabort uishow unload unpackrawbytes velset waitai \
    waitao waitdi waitdo waitgi waitgo waitrob waitsynctask waittestandset waittime waituntil worldacclim write \
    writeanybin writebin writeblock writecfgdata writerawbytes writestrbin writevar writevararr wzboxdef \
    wzcyldef wzdisable wzdoset wzenable wzfree wzhomejointdef wzlimjointdef wzlimsup wzsphdef";

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
    break stop waitai waitao waitdi waitdo waitgi waitgo waitload waitrob waitsynctask waittestandset waittime waituntil \
    tpreadfk tpreadnum tpreaddnum uimsgbox syncmoveon syncmoveoff";

/// Instructions after which it is not known where the arm comes from: they move it, or let others do so, or go on with a way that was
/// interrupted. In lower case, sorted.
const MOVES: &str = "\
    clearpath contactl egmmovec egmmovel egmrunjoint egmrunpose egmstop hollowwristreset indamove indcmove inddmove indreset \
    indrmove loadid manloadidproc mtoolrotcalib mtooltcpcalib pathrecmovebwd pathrecmovefwd procerrrecovery restopath setleadthrough \
    softact startmove startmoveretry stcalib stclose stepbwdpath stindgun stindgunreset stoolrotcalib stooltcpcalib stopen syncmoveresume \
    syncmovesuspend syncmoveundo";

/// Whether an instruction ends what is known of the arm's way, although it is no motion to a target.
pub fn moves(name: &str) -> bool {
    static ALL: Names = Names::new(|| names(MOVES));
    ALL.contains(name)
}

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
    abs absdnum acos acosdnum ainput aoutput argname asin asindnum atan atan2 atan2dnum atandnum bitand \
    bitanddnum bitcheck bitcheckdnum bitlsh bitlshdnum bitneg bitnegdnum bitor bitordnum bitrsh bitrshdnum \
    bitxor bitxordnum bytetostr calcjointt calcrobt calcrotaxframez calcrotaxisframe camgetexposure \
    camgetloadedjob camgetmode camgetname camnumberofresults cdate cjointt clkread corrread cos cosdnum cpos \
    crobt crossprod cspeedoverride ctime ctool cwobj decodenum dectohex defaccframe defdframe defframe dim \
    dinput distance dnumtonum dnumtostr dotprod doutput egmgetstate eulerzyx eventtype exechandler execlevel exp \
    filesize filesizednum filetime fssize fssizednum getaxisdistance getaxismovetime getmaxnumberofcyclicbool \
    getmecunitname getmodalpayloadmode getmodalpaymode getmotortorque getnextcyclicbool getnextmechunit \
    getnextsym getnumberofcyclicbool getserviceinfo getsignalorigin getsysinfo gettaskname gettime gettspstatus \
    getuasusername ginput ginputdnum goutput goutputdnum hextodec indinpos indspeed iounitstate \
    isbrakecheckactive iscyclicbool isfile isleadthrough ismechunitactive ispers isstopmoveact isstopstateevent \
    issyncmoveon issysid isvar max maxextlinearspeed maxextreorientspeed maxrobreorientspeed maxrobspeed min \
    mirpos modexist modtime modtimednum motionplannerno nonmotionmode norient numtodnum numtostr offs opmode \
    orientzyx orobt paridposvalid paridrobvalid pathlengthget pathlevel pathrecvalidbwd pathrecvalidfwd \
    pfrestart poseinv posemult posevect pow powdnum ppmovedinmanmode present proginfo progmemfree quatmult rand \
    rawbyteslen readbin readdir readmotor readnum readstr readstrbin readvar reltool remainingretries \
    rmqgetslotname robname robos robotstate round rounddnum runmode seed sin sindnum socketgetstatus socketpeek \
    sqrt sqrtdnum stcalcforce stcalctorque stdevstatus stiscalib stisclosed stisindgun stisopen strdigcalc \
    strdigcmp strfind strformat strlen strmap strmatch strmemb strorder strpart strtobyte strtodnum strtoval tan \
    tandnum taskisactive taskisexecuting taskrunmec taskrunrob taskruntime tasksinsync testandset testdi \
    testsignread textget texttabfreetouse texttabget tpreadfk triggdatavalid trunc truncdnum type uialphaentry \
    uiclientexist uidnumentry uidnumtune uilistview uimessagebox uinumentry uinumtune validio valtostr vectmagn";

pub fn is_function(name: &str) -> bool {
    static ALL: Names = Names::new(|| names(FUNCTIONS));
    ALL.contains(name)
}

/// Functions among them that write into one of their arguments.
pub fn sets_argument(name: &str) -> bool {
    matches!(
        name,
        "getnextcyclicbool"
            | "getnextmechunit"
            | "getnextsym"
            | "paridposvalid"
            | "readdir"
            | "strtodnum"
            | "strtoval"
            | "testandset"
            | "uilistview"
    )
}

/// Instructions that print or send the values of their arguments, and set none.
pub fn only_reads(name: &str) -> bool {
    matches!(name, "errwrite" | "socketsend" | "tpshow" | "tpwrite" | "write" | "writestrbin")
}

/// Arguments of a calibration or a search (by their place among those that are no switches) whose values it takes and does not set: the
/// joints of `MToolTCPCalib Pos1, Pos2, Pos3, Pos4, Tool, MaxErr, MeanErr` and `MToolRotCalib RefTip, ZPos \XPos, Tool` (ABB, Technical
/// reference manual, RAPID instructions), the points of `Search_1D Result, StartPoint, SearchPoint, Speed, Tool`.
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
    fn an_instruction_is_of_one_kind_and_lists_are_sorted() {
        for list in [QUIET, MOVES, FUNCTIONS] {
            let all: Vec<&str> = list.split_ascii_whitespace().collect();
            assert!(all.is_sorted(), "{all:?}");
        }
        for name in MOVES.split_ascii_whitespace() {
            assert!(
                !is_quiet(name) && !is_wait(name) && motion(name).is_none() && !is_frame(name) && !arms(name),
                "{name}"
            );
        }
        assert!(
            is_wait("stop") && is_quiet("stopmove") && is_quiet("wzboxdef") && moves("restopath") && moves("startmove")
        );
    }

    #[test]
    fn arc_instructions_tell_their_process() {
        assert_eq!(motion("arclstart").unwrap().process, Some(true));
        assert_eq!(motion("arcc1end").unwrap().process, Some(false));
        assert_eq!(motion("arcl").unwrap().process, None);
        assert!(motion("arcrefresh").is_none() && motion("triggio").is_none());
    }
}
