//! Notes on method: what a figure is based on, its equation and its source, to be quoted by name.
//!
//! Equations are HTML of our own, written here; words from files never get into them. MathML would need a font for mathematics
//! on the reader's machine.

use maud::{Markup, PreEscaped, html};
use std::borrow::Cow;

/// The paper whose method the tool carries out.
const PAPER: &str = "Experimental assessment and feedforward control of backlash and stiction in industrial serial robots for low-speed operations";

/// A note.
#[derive(Debug, Clone)]
pub struct Method {
    /// Name of the method.
    pub name: Cow<'static, str>,
    /// What it does, in sentences.
    pub text: Cow<'static, str>,
    /// HTML, or empty.
    equation: &'static str,
    /// Number of the equation in its source, or empty.
    number: &'static str,
    /// Author, year and equation.
    pub source: Cow<'static, str>,
}

impl Method {
    /// A note in words of the caller's own.
    pub fn new(
        name: impl Into<Cow<'static, str>>,
        text: impl Into<Cow<'static, str>>,
        source: impl Into<Cow<'static, str>>,
    ) -> Self {
        Self { name: name.into(), text: text.into(), equation: "", number: "", source: source.into() }
    }

    const fn known(
        name: &'static str,
        text: &'static str,
        equation: &'static str,
        number: &'static str,
        source: &'static str,
    ) -> Self {
        Self { name: Cow::Borrowed(name), text: Cow::Borrowed(text), equation, number, source: Cow::Borrowed(source) }
    }
}

/// Play operator.
pub const PLAY: Method = Method::known(
    "Backlash as play",
    "The joint q follows its command p at a distance of the half gap b and stands still while the gap is crossed. One line contains the three cases of the equation. b may depend on position.",
    "<i>q<sub>j</sub></i> = min( max( <i>q</i><sub><i>j</i>−1</sub>, <i>p<sub>j</sub></i> − <i>b</i> ), <i>p<sub>j</sub></i> + <i>b</i> )",
    "equation 6",
    PAPER,
);

/// Stiction after a reversal.
pub const STICTION: Method = Method::known(
    "Stiction",
    "After a reversal, the joint stands still until its command has moved away from the turning point by the remaining spike s. The servo reduces the spike with the time constant τ, or over the travel.",
    "<i>r</i><sub>f</sub> = −dir · min( |<i>p</i> − <i>p</i><sub>rev</sub>|, <i>s</i> e<sup>−(<i>t</i> − <i>t</i><sub>rev</sub>)/<i>τ</i></sup> )",
    "after equations 8 and 9",
    PAPER,
);

/// Friction's response after a reversal, over time.
pub const RESPONSE: Method = Method::known(
    "Friction after a reversal",
    "Friction z changes its direction over the travel x of the command, within the presliding σ. The servo first passes the change on with the gain g and then corrects it with each time constant τ; gear and link wind up by w. Gap and wind-up look the same in a log: their sum is known far better than each of them.",
    "d<i>z</i>/d<i>x</i> = (1 − <i>z</i>)/<i>σ</i>, <i>h</i>′ = <i>z</i>′ − <i>h</i>/<i>τ</i>, lost = <i>b</i> + <i>w z</i> + <i>g h</i>",
    "",
    "Dahl (1968), A solid friction model; lostmotion, documentation of identify.",
);

/// Flanks of a gap between two sensors.
pub const TWO_FLANKS: Method = Method::known(
    "Two gaps in series",
    "Each gap is the distance between the lines on which the output follows its input upwards and downwards, fitted with one slope to the rows after the gaps. Coupling: screw against motor; nut: carriage against screw. Intervals are those of strokes left out in turn (jackknife), Student's t.",
    "<i>y</i> = <i>m</i>(<i>θ</i> − <i>c</i><sub>r</sub>) upwards, <i>y</i> = <i>m</i>(<i>θ</i> − <i>c</i><sub>l</sub>) downwards, else <i>y</i> stays",
    "equation 2",
    "Mathematical modeling and experimental identification of backlash nonlinearity in prototype of a robot gantry with electric drive and ball screw transmission",
);

/// Gap from dwells reached from both sides.
pub const STATIC_GAP: Method = Method::known(
    "Half gap from dwells",
    "The joint reaches each position from below and from above and stands still there; half of the difference of the two joint positions is the half gap. Joint positions come from the measured TCP by inverse kinematics; each dwell gives a mean, each cycle a value.",
    "<i>b</i> = ½ ( <i>q</i><sub>from above</sub> − <i>q</i><sub>from below</sub> )",
    "section 3.3, equation 6",
    PAPER,
);

/// Deadzones from sweeps of one joint.
pub const DEADZONE: Method = Method::known(
    "Deadzones from growing sweeps",
    "After each reversal of the motor, the tip stands still until the deadzone is crossed. The size of the deadzone is the travel of the motor from the reversal to the point where the moving branch, extrapolated, meets the resting position of the tip. Half of it is the half gap at the middle of this travel. Only tip positions are used.",
    "<i>δ</i> = | <i>θ</i><sub>fin</sub> − <i>θ</i><sub>init</sub> | = <i>b</i>(<i>θ</i><sub>init</sub>) + <i>b</i>(<i>θ</i><sub>fin</sub>)",
    "algorithm 1",
    "Model Learning with Backlash Compensation for a Tendon-Driven Surgical Robot",
);

/// Offsets of the compensator.
pub const FEEDFORWARD: Method = Method::known(
    "Feedforward compensation",
    "The program that is sent contains the desired joint position, an offset for the gap with the sign of the movement, and an offset for friction that fades after each reversal. The movement never reverses while an offset fades.",
    "<i>Θ</i><sub>sent</sub> = <i>Θ</i> + <i>C</i><sub>b</sub> + <i>C</i><sub>f</sub>, <i>C</i><sub>b</sub> = dir · <i>d</i>",
    "equations 15 and 16",
    PAPER,
);

/// Friction offset over program points.
pub const FRICTION_POINTS: Method = Method::known(
    "Friction offset over program points",
    "Where a compensator counts program points after a reversal: gain g, exponent l, over kₜ points.",
    "<i>c</i><sub>f</sub> = <i>g</i> exp( 1 − (1 + (<i>k</i> − 1)/(<i>k</i><sub>t</sub> − 1))<sup><i>l</i></sup> ), <i>k</i> = 1 … <i>k</i><sub>t</sub>",
    "equation 17",
    PAPER,
);

/// TCP error of a joint error.
pub const IMPACT: Method = Method::known(
    "Error at the TCP",
    "Distance of the TCP at the joint position with the error r from the TCP without it, by forward kinematics. For a half gap it is the error of one direction; two directions differ by twice that.",
    "<i>e</i><sub>T</sub> = ‖ <i>F</i>(<i>θ</i> + <i>r</i>) − <i>F</i>(<i>θ</i>) ‖",
    "equation 12 of section 2.2",
    PAPER,
);

/// Circle fit and its errors.
pub const CIRCLE: Method = Method::known(
    "Error against the best-fit circle",
    "The plane is that of the smallest singular value of the centred points, the circle in it Taubin's fit. In plane: radius minus fitted radius; out of plane: distance from the plane; total: their 2-norm. Beyond nominal: the same after subtraction of the deviation of the nominal path from its circle, mostly by its chords.",
    "<i>e</i> = √( (<i>ρ</i> − <i>R</i>)² + <i>n</i>² )",
    "",
    "G. Taubin, Estimation of planar curves, surfaces, and nonplanar space curves defined by implicit equations, IEEE Transactions on Pattern Analysis and Machine Intelligence 13 (11), 1991",
);

/// Registration together with the gaps.
pub const REGISTRATION: Method = Method::known(
    "Registration",
    "The rigid transform from base to tracker frame is estimated from the log together with the gaps and away from reversals. If it were fitted first, it would absorb part of a gap on a path that runs in one direction.",
    "",
    "",
    "lostmotion, documentation of the measurement log",
);

/// The paper on positions reached from both sides.
const BACKLASH_PAPER: &str = "M. Slamani, A. Nubiola, I. A. Bonev, Modeling and assessment of the backlash error of an industrial robot, Robotica, 2012";

/// Repeatability and backlash of poses.
pub const BIDIRECTIONAL: Method = Method::known(
    "Repeatability and backlash",
    "Of each pose: RP is 3 standard deviations of one direction; the backlash is the mean of the forward errors minus the mean of the backward ones; R contains both directions and their distance. ISO 230-2 since 1997 takes 2 standard deviations instead of 3.",
    "<i>R</i> = max( 3<i>s</i>↑ + 3<i>s</i>↓ + |<i>ȳ</i>|, 6<i>s</i>↑, 6<i>s</i>↓ )",
    "equations 1, 23 and 24",
    BACKLASH_PAPER,
);

/// Degree by lack of fit.
pub const LACK_OF_FIT: Method = Method::known(
    "Degree by lack of fit",
    "F compares the residual of a polynomial of degree p at the means of n poses with the scatter of the repeats (n_t readings of the backlash in all) about their means. The first degree whose F is not significant is used.",
    "<i>F</i> = [ Σ <i>m</i><sub>i</sub> (<i>ȳ</i><sub>i</sub> − <i>ŷ</i><sub>i</sub>)² / (<i>n</i> − <i>p</i> − 1) ] / [ Σ Σ (<i>y</i><sub>iu</sub> − <i>ȳ</i><sub>i</sub>)² / (<i>n</i><sub>t</sub> − <i>n</i>) ]",
    "equations 7 to 14",
    BACKLASH_PAPER,
);

/// Indicator variables.
pub const INDICATOR: Method = Method::known(
    "Indicator variables of states",
    "D is 1 in the state and 0 in the reference. Student's t test decides on its offset in a fit of the reference and this state; if the offset is significant, on its slope; and so on. States without a significant term share the curve of the reference.",
    "<i>y</i> = <i>β</i><sub>0</sub> + <i>β</i><sub>1</sub><i>x</i> + … + <i>β</i>′<sub>0</sub><i>D</i> + <i>β</i>′<sub>1</sub><i>Dx</i> + …, <i>t</i> = <i>b</i>/<i>s</i>(<i>b</i>)",
    "equations 15 to 22",
    BACKLASH_PAPER,
);

/// The notes as a list.
pub(super) fn draw(notes: &[Method]) -> Markup {
    html! {
        div.methods {
            @for m in notes {
                article {
                    h3 { (m.name) }
                    p { (m.text) }
                    @if !m.equation.is_empty() { div.equation { (PreEscaped(m.equation)) } }
                    @if !m.source.is_empty() {
                        p.source { cite { (m.source) } @if !m.number.is_empty() { ", " (m.number) } "." }
                    }
                }
            }
        }
    }
}
