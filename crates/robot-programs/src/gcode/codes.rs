//! Letters of axes, and G words by what they do, times ten.

/// Letters of axes.
pub(super) const AXES: &[u8] = b"XYZABCUVW";

/// G words without effect on where a block leads, times ten.
pub(super) const HARMLESS: &[u32] = &[80, 131, 150, 690, 960, 970, 980, 990, 1130, 1870];
/// Splines and parabolas, modal as G1 is.
pub(super) const SPLINES: &[u32] = &[50, 51, 52, 53, 60, 61, 62, 63];
/// Canned cycles.
pub(super) const CANNED: &[u32] = &[730, 740, 760, 810, 820, 830, 840, 850, 860, 870, 880, 890];
/// Moves to where a probe touches or leaves, modal.
pub(super) const TOUCHES: &[u32] = &[382, 383, 384, 385];
/// G words by which printers probe their bed; G80 is one of them on some.
pub(super) const PROBES: &[u32] = &[290, 320, 340, 800];

/// G words that are followed wherever they stand: after any other the words of all blocks mean something else.
pub(super) fn is_followed(c: u32) -> bool {
    const ACTIONS: &[u32] = &[
        40, 90, 100, 110, 280, 281, 300, 301, 500, 501, 520, 530, 610, 611, 640, 650, 660, 661, 670, 920, 921, 922,
        923, 1610, 1620,
    ];
    const MODES: &[u32] = &[
        0, 10, 20, 30, 170, 180, 190, 200, 210, 400, 410, 411, 420, 421, 430, 431, 440, 490, 800, 900, 901, 910, 911,
        930, 940, 950,
    ];
    let known = [ACTIONS, MODES, HARMLESS, CANNED, SPLINES, TOUCHES].iter().any(|list| list.contains(&c));
    known || is_work_frame(c)
}

/// G54 to G59.3: work frames that are moved against each other. Others of this hundred turn them, or follow a table.
pub(super) fn is_work_frame(c: u32) -> bool {
    matches!(c, 540 | 541 | 550 | 560 | 570 | 580 | 590..=593)
}

/// A G word times ten; what is no such word becomes one that is not known.
pub(super) fn code(v: f64) -> u32 {
    let tenths = (v * 10.0).round();
    if (v * 10.0 - tenths).abs() < 1e-6 && (0.0..99_990.0).contains(&tenths) { tenths as u32 } else { 99_999 }
}

pub(super) fn code_text(code: u32) -> String {
    if code.is_multiple_of(10) { format!("G{}", code / 10) } else { format!("G{}.{}", code / 10, code % 10) }
}
