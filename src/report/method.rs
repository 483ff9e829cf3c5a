//! Notes on method: what a figure rests on, its equation and its source, to be quoted by name.
//!
//! Equations are MathML of our own, written here; words from files never get into them.

use maud::{Markup, PreEscaped, html};
use std::borrow::Cow;

/// The paper whose method the tool carries out.
const PAPER: &str = "Experimental assessment and feedforward control of backlash and stiction in industrial serial robots for low-speed operations";

/// A note.
#[derive(Debug, Clone)]
pub struct Method {
    pub name: Cow<'static, str>,
    pub text: Cow<'static, str>,
    /// MathML, or empty.
    equation: &'static str,
    /// Number of the equation in its source, or empty.
    number: &'static str,
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
    "The joint q follows its command p at the distance of the half gap b and stands still while the gap is crossed. b may depend on position.",
    "<math display=\"block\"><mrow><msub><mi>q</mi><mi>j</mi></msub><mo>=</mo><mo>{</mo><mtable columnalign=\"left left\">\
<mtr><mtd><msub><mi>p</mi><mi>j</mi></msub><mo>−</mo><mi>b</mi></mtd><mtd><mtext>moving up, </mtext><msub><mi>p</mi><mi>j</mi></msub><mo>≥</mo><msub><mi>q</mi><mrow><mi>j</mi><mo>−</mo><mn>1</mn></mrow></msub><mo>+</mo><mi>b</mi></mtd></mtr>\
<mtr><mtd><msub><mi>p</mi><mi>j</mi></msub><mo>+</mo><mi>b</mi></mtd><mtd><mtext>moving down, </mtext><msub><mi>p</mi><mi>j</mi></msub><mo>≤</mo><msub><mi>q</mi><mrow><mi>j</mi><mo>−</mo><mn>1</mn></mrow></msub><mo>−</mo><mi>b</mi></mtd></mtr>\
<mtr><mtd><msub><mi>q</mi><mrow><mi>j</mi><mo>−</mo><mn>1</mn></mrow></msub></mtd><mtd><mtext>otherwise</mtext></mtd></mtr>\
</mtable></mrow></math>",
    "equation 6",
    PAPER,
);

/// Stiction behind a reversal.
pub const STICTION: Method = Method::known(
    "Stiction",
    "Behind a reversal at p_rev the joint stands still until the command has moved as far as the spike that is left; the servo works the spike s off with the time constant τ (or with the travel).",
    "<math display=\"block\"><mrow><msub><mi>r</mi><mi>f</mi></msub><mo>=</mo><mo>−</mo><mi>dir</mi><mo>·</mo><mi>min</mi><mo>(</mo><mo>|</mo><mi>p</mi><mo>−</mo><msub><mi>p</mi><mi>rev</mi></msub><mo>|</mo><mo>,</mo><mspace width=\"0.3em\"/><mi>s</mi><msup><mi>e</mi><mrow><mo>−</mo><mo>(</mo><mi>t</mi><mo>−</mo><msub><mi>t</mi><mi>rev</mi></msub><mo>)</mo><mo>/</mo><mi>τ</mi></mrow></msup><mo>)</mo></mrow></math>",
    "after equations 8 and 9",
    PAPER,
);

/// Gap from dwells reached from both sides.
pub const STATIC_GAP: Method = Method::known(
    "Half gap from dwells",
    "Each position is reached from below and from above and rested at; half of the difference of the two joint positions is the half gap. Joint positions come from the measured TCP by inverse kinematics, each dwell is a mean, each cycle a value.",
    "<math display=\"block\"><mrow><mi>b</mi><mo>=</mo><mfrac><mn>1</mn><mn>2</mn></mfrac><mo>(</mo><msub><mover><mi>q</mi><mo>¯</mo></mover><mtext>from above</mtext></msub><mo>−</mo><msub><mover><mi>q</mi><mo>¯</mo></mover><mtext>from below</mtext></msub><mo>)</mo></mrow></math>",
    "section 3.3, equation 6",
    PAPER,
);

/// Offsets of the compensator.
pub const FEEDFORWARD: Method = Method::known(
    "Feedforward compensation",
    "The program that is sent holds the wanted joint position plus an offset against the gap, of the sign of the movement, and an offset against friction that fades behind each reversal. The movement never turns back while an offset fades.",
    "<math display=\"block\"><mrow><mover><mi>Θ</mi><mo>^</mo></mover><mo>=</mo><mi>Θ</mi><mo>+</mo><msub><mi>C</mi><mi>b</mi></msub><mo>+</mo><msub><mi>C</mi><mi>f</mi></msub><mo>,</mo><mspace width=\"0.8em\"/><msub><mi>C</mi><mi>b</mi></msub><mo>=</mo><mo>±</mo><mi>d</mi></mrow></math>",
    "equations 15 and 16",
    PAPER,
);

/// Friction offset over program points.
pub const FRICTION_POINTS: Method = Method::known(
    "Friction offset over program points",
    "Where a compensator counts program points behind a reversal: gain g, exponent l, k_t points.",
    "<math display=\"block\"><mrow><msub><mi>c</mi><mi>f</mi></msub><mo>=</mo><mi>g</mi><mspace width=\"0.2em\"/><mi>exp</mi><mo>(</mo><mn>1</mn><mo>−</mo><msup><mrow><mo>(</mo><mn>1</mn><mo>+</mo><mfrac><mrow><mi>k</mi><mo>−</mo><mn>1</mn></mrow><mrow><msub><mi>k</mi><mi>t</mi></msub><mo>−</mo><mn>1</mn></mrow></mfrac><mo>)</mo></mrow><mi>l</mi></msup><mo>)</mo><mo>,</mo><mspace width=\"0.6em\"/><mi>k</mi><mo>=</mo><mn>1</mn><mo>…</mo><msub><mi>k</mi><mi>t</mi></msub></mrow></math>",
    "equation 17",
    PAPER,
);

/// TCP error of a joint error.
pub const IMPACT: Method = Method::known(
    "Error at the TCP",
    "Distance of the TCP at the joint position with the error r from the TCP without it, by forward kinematics. For a half gap it is the error of one direction; two directions differ by twice that.",
    "<math display=\"block\"><mrow><msub><mi>e</mi><mi>T</mi></msub><mo>=</mo><mo>‖</mo><mi>F</mi><mo>(</mo><mi>θ</mi><mo>+</mo><mi>r</mi><mo>)</mo><mo>−</mo><mi>F</mi><mo>(</mo><mi>θ</mi><mo>)</mo><mo>‖</mo></mrow></math>",
    "equation 12 of section 2.2",
    PAPER,
);

/// Circle fit and its errors.
pub const CIRCLE: Method = Method::known(
    "Error against the best-fit circle",
    "The plane is that of the smallest singular value of the centred points, the circle in it Taubin's fit. In plane: radius minus fitted radius; out of plane: distance from the plane; total: their 2-norm. Beyond nominal: the same after the nominal path's own deviation from its circle, mostly its chords, is taken off.",
    "<math display=\"block\"><mrow><msub><mi>e</mi><mtext>total</mtext></msub><mo>=</mo><msqrt><mrow><msup><mrow><mo>(</mo><mi>ρ</mi><mo>−</mo><mi>R</mi><mo>)</mo></mrow><mn>2</mn></msup><mo>+</mo><msup><mi>n</mi><mn>2</mn></msup></mrow></msqrt></mrow></math>",
    "",
    "G. Taubin, Estimation of planar curves, surfaces, and nonplanar space curves defined by implicit equations, IEEE Transactions on Pattern Analysis and Machine Intelligence 13 (11), 1991",
);

/// Registration together with the gaps.
pub const REGISTRATION: Method = Method::known(
    "Registration",
    "The rigid transform from base to tracker frame is estimated from the log together with the gaps and away from reversals: fitted first, it would swallow part of a gap on a path that goes round in one direction.",
    "",
    "",
    "lostmotion, documentation of the measurement log",
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
