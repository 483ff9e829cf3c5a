//! The page itself: HTML shell, head, sections.
//!
//! Every word from outside passes through maud, which escapes it; only this crate's own style, script and equations go in as
//! they are. The page is also well-formed XML but for HTML's void elements.

use super::map;
use super::method;
use super::number::count;
use super::plots::joints::Joints;
use super::plots::{backlash_line, bars, gap_curve, heat, histogram, path3d, polar, traces, ways};
use super::tables;
use super::views::{Content, Page, Section, Tone};
use maud::{DOCTYPE, Markup, PreEscaped, html};

const STYLE: &str = include_str!("style.css");
const SCRIPTS: [&str; 2] = [include_str!("turn.js"), include_str!("zoom.js")];
/// Digits of a SHA-256 that are shown.
const SHORT: usize = 12;
/// Files, options and warnings beyond this are counted only.
const LISTED: usize = 60;
/// Notes of a section that are open at once.
const NOTES: usize = 15;

impl Page {
    /// The page as HTML.
    pub fn render(&self) -> String {
        let joints = Joints(&self.joints);
        // words alone need no script
        let has_use = self.sections.iter().any(|s| !matches!(s.content, Content::Method(_) | Content::Notes(_)));
        html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="color-scheme" content="light dark";
                    meta name="generator" content=(concat!("lostmotion ", env!("CARGO_PKG_VERSION")));
                    title { (self.title) }
                    style { (PreEscaped(STYLE)) }
                }
                body {
                    (self.head())
                    main { @for (i, s) in self.sections.iter().enumerate() { (section(i, s, &joints)) } }
                    (self.provenance())
                    footer { p {
                        "lostmotion " (env!("CARGO_PKG_VERSION")) ". mdeg: a thousandth of a degree; µm: a thousandth of a millimetre. "
                        "The same input gives the same page, byte for byte; the page contains no date."
                        @if has_use { span.screen { " Charts: drag across a part to enlarge it, double-click to show everything; the keys + and −, or Ctrl with the wheel, also zoom." } }
                    } }
                    @if has_use { @for script in SCRIPTS { script { (PreEscaped(script)) } } }
                }
            }
        }
        .into_string()
    }

    fn head(&self) -> Markup {
        html! {
            header {
                p.kicker { "lostmotion " (self.command) }
                h1 { (self.title) }
                @if !self.summary.is_empty() { p.lead { (self.summary) } }
                @if !self.verdict.text.is_empty() { (verdict(self.verdict.tone, &self.verdict.text)) }
                @if !self.next.is_empty() {
                    div.next {
                        h2 { "What to do next" }
                        ol { @for (about, what) in self.next.iter().take(LISTED) { li { @if !about.is_empty() { strong { (about) } ": " } (what) } } }
                        (further(self.next.len()))
                    }
                }
                @if !self.tiles.is_empty() {
                    ul.tiles { @for t in &self.tiles {
                        li {
                            span.name { (t.label) }
                            span.value { (t.value) @if !t.unit.is_empty() { " " span.unit { (t.unit) } } }
                            @if !t.detail.is_empty() { span.detail { (t.detail) } }
                        }
                    } }
                }
                @if !self.warnings.is_empty() {
                    aside.warnings {
                        h2 { "Notes" }
                        ul { @for w in self.warnings.iter().take(LISTED) { li { (w) } } }
                        (further(self.warnings.len()))
                    }
                }
                @if self.sections.len() > 3 {
                    nav aria-label="Sections" { ol {
                        @for (i, s) in self.sections.iter().enumerate() { li { a href=(format!("#s{}", i + 1)) { (self.nav_name(s)) } } }
                    } }
                }
            }
        }
    }

    /// Name of a section among the others: its kind, or its finding where the kind is there twice.
    fn nav_name<'a>(&self, s: &'a Section) -> &'a str {
        let twice = self.sections.iter().filter(|o| o.content.name() == s.content.name()).count() > 1;
        if twice && !s.title.is_empty() { &s.title } else { s.content.name() }
    }

    /// Robot, files and options: what the figures are based on.
    fn provenance(&self) -> Markup {
        html! {
            @if self.robot.is_some() || !self.files.is_empty() || !self.options.is_empty() {
                div.provenance {
                    @if self.robot.is_some() || !self.files.is_empty() {
                        table {
                            thead { tr { th scope="col" { "Role" } th scope="col" { "File or robot" } th scope="col" { "SHA-256" } } }
                            tbody {
                                @if let Some(r) = &self.robot { tr { th scope="row" { "robot" } td { (r.name) } td { (hash(&r.sha256)) } } }
                                @for f in self.files.iter().take(LISTED) { tr { th scope="row" { (f.role) } td { (f.name) } td { (hash(&f.sha256)) } } }
                            }
                        }
                        (further(self.files.len()))
                    }
                    @if !self.options.is_empty() {
                        table {
                            thead { tr { th scope="col" { "Option" } th scope="col" { "Value" } } }
                            tbody { @for (name, value) in self.options.iter().take(LISTED) { tr { th scope="row" { (name) } td { (value) } } } }
                        }
                    }
                }
            }
        }
    }
}

fn further(all: usize) -> Markup {
    html! { @if all > LISTED { p.dropped { "and " (count((all - LISTED) as u64)) " more" } } }
}

fn hash(sha256: &str) -> Markup {
    html! { @if sha256.is_empty() { "–" } @else { code title=(sha256) { (sha256.chars().take(SHORT).collect::<String>()) } } }
}

fn verdict(tone: Tone, text: &str) -> Markup {
    let (class, sign, word) = match tone {
        Tone::Plain => ("plain", "→", "Result"),
        Tone::Good => ("good", "✓", "Good"),
        Tone::Mixed => ("mixed", "!", "With reservations"),
        Tone::Bad => ("bad", "✕", "Not good"),
    };
    html! { div.verdict.(class) { span.sign role="img" aria-label=(word) { (sign) } p { (text) } } }
}

fn section(i: usize, s: &Section, joints: &Joints) -> Markup {
    let name = s.content.name();
    html! {
        section.half[s.content.is_narrow()] id=(format!("s{}", i + 1)) {
            @if s.title.is_empty() { h2 { (name) } } @else { p.kicker { (name) } h2 { (s.title) } }
            @if !s.caption.is_empty() { p.caption { (s.caption) } }
            (content(&s.content, joints))
        }
    }
}

/// The first notes, and the others after a click; all of them on paper.
fn notes(all: &[String]) -> Markup {
    let (first, rest) = all.split_at(all.len().min(NOTES));
    html! {
        ul.notes { @for note in first { li { (note) } } }
        @if !rest.is_empty() {
            details { summary { (count(rest.len() as u64)) " more" } ul.notes { @for note in rest { li { (note) } } } }
        }
    }
}

fn content(content: &Content, joints: &Joints) -> Markup {
    match content {
        Content::Path(v) => path3d::draw(v, joints),
        Content::Polar(v) => polar::draw(v, joints),
        Content::Traces(v) => traces::draw(v, joints),
        Content::Strips(v) => heat::strips(v, joints),
        Content::HeatPath(v) => heat::path(v, joints),
        Content::Ways(v) => ways::draw(v, joints),
        Content::Map(v) => map::draw(v),
        Content::Gaps(v) => gap_curve::draw(v, joints),
        Content::BothWays(v) => backlash_line::both_ways(v),
        Content::BacklashCurves(v) => backlash_line::curves(v),
        Content::Histogram(v) => histogram::draw(v),
        Content::Bars(v) => bars::bars(v),
        Content::Waterfall(v) => bars::waterfall(v),
        Content::Reversals(v) => tables::reversals(v, joints),
        Content::GapTable(v) => tables::gaps(v, joints),
        Content::Compensator(v) => tables::compensator(v, joints),
        Content::Places(v) => tables::places(v, joints),
        Content::Table(v) => tables::plain(v),
        Content::Notes(v) => notes(v),
        Content::Method(v) => method::draw(v),
    }
}
