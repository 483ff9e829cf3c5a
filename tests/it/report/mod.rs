//! The page: well-formed, self-contained, escaped, and steady whatever is put into it.

#[path = "../../../examples/report_gallery/data/mod.rs"]
mod gallery;

mod drawings;
mod hostile;

use lostmotion::report::{method, *};
use lostmotion::robot::JointKind;
use roxmltree::{Document, Node};
use std::sync::LazyLock;

static GALLERY: LazyLock<String> = LazyLock::new(|| gallery::page().expect("the gallery has a page").render());

/// The page as XML: the doctype goes, void elements are closed.
fn xml(html: &str) -> String {
    let mut out = String::new();
    let mut rest = html.strip_prefix("<!DOCTYPE html>").expect("starts with the doctype");
    while let Some(at) = rest.find('<') {
        out.push_str(&rest[..at]);
        let end = at + rest[at..].find('>').expect("every tag ends") + 1;
        let tag = &rest[at..end];
        let void = ["<meta", "<br", "<input"].iter().any(|v| tag.starts_with(v));
        out.push_str(if void { &tag[..tag.len() - 1] } else { tag });
        out.push_str(if void { "/>" } else { "" });
        rest = &rest[end..];
    }
    out + rest
}

/// Parses a page strictly and hands its elements to a check.
pub fn with_elements(html: &str, check: impl FnOnce(&[Node])) {
    let text = xml(html);
    let document = Document::parse(&text).unwrap_or_else(|e| panic!("not well-formed: {e}"));
    check(&document.descendants().filter(Node::is_element).collect::<Vec<_>>());
}

pub fn named<'a, 'i>(all: &[Node<'a, 'i>], name: &str) -> Vec<Node<'a, 'i>> {
    all.iter().copied().filter(|n| n.tag_name().name() == name).collect()
}

fn class_of<'a>(n: &Node<'a, '_>) -> &'a str {
    n.attribute("class").unwrap_or("")
}

fn text_of(n: &Node) -> String {
    n.descendants().filter(Node::is_text).filter_map(|t| t.text()).collect()
}

/// Every attribute of every drawing is free of what no browser can draw.
pub fn draws_only_numbers(html: &str) {
    assert!(!html.contains("NaN"), "NaN on the page");
    with_elements(html, |all| {
        for n in all.iter().filter(|n| n.ancestors().any(|a| a.tag_name().name() == "svg")) {
            for a in n.attributes().filter(|a| {
                [
                    "d",
                    "x",
                    "y",
                    "x1",
                    "x2",
                    "y1",
                    "y2",
                    "cx",
                    "cy",
                    "r",
                    "width",
                    "height",
                    "points",
                    "viewBox",
                    "transform",
                ]
                .contains(&a.name())
            }) {
                assert!(!a.value().contains("inf"), "{}={}", a.name(), a.value());
            }
        }
    });
}

/// Points of path data with absolute M and L.
fn points(d: &str) -> Vec<[f64; 2]> {
    d.split(['M', 'L'])
        .filter(|s| !s.is_empty())
        .map(|s| {
            let mut v = s.split_whitespace().map(|v| v.parse::<f64>().expect("a number"));
            [v.next().expect("x"), v.next().expect("y")]
        })
        .collect()
}

fn one(content: impl Into<Content>) -> String {
    let mut page = Page::new("test", "Test");
    page.joint("A1", JointKind::Revolute).joint("Z", JointKind::Prismatic);
    page.section("", "", content);
    page.render()
}

fn run(role: Role) -> Run {
    Run::new("run", role)
}

#[test]
fn a_page_with_everything_is_well_formed_and_says_what_its_drawings_are() {
    with_elements(&GALLERY, |all| {
        assert_eq!(named(all, "h1").len(), 1);
        let drawings: Vec<_> = named(all, "svg").into_iter().filter(|n| n.attribute("aria-hidden").is_none()).collect();
        assert!(drawings.len() >= 20, "{}", drawings.len());
        assert!(
            drawings
                .iter()
                .all(|s| s.attribute("role") == Some("img") && s.attribute("aria-label").is_some_and(|l| l.len() > 10))
        );
        assert!(named(all, "th").iter().all(|th| th.attribute("scope").is_some()));
        assert!(named(all, "html")[0].attribute("lang").is_some());
        let ids: Vec<_> = all.iter().filter_map(|n| n.attribute("id")).collect();
        let links: Vec<_> = named(all, "a")
            .iter()
            .filter_map(|a| a.attribute("href"))
            .map(|h| h.trim_start_matches('#').to_owned())
            .collect();
        assert_eq!(ids, links, "the list of sections leads to each of them, in order");
    });
    draws_only_numbers(&GALLERY);
}

#[test]
fn a_page_needs_nothing_from_outside() {
    with_elements(&GALLERY, |all| {
        for n in all {
            for a in n.attributes() {
                let outside = matches!(a.name(), "src" | "href" | "action" | "data" | "poster" | "srcset");
                assert!(!outside || a.value().starts_with('#'), "{} {}", a.name(), a.value());
            }
        }
        assert!(named(all, "link").is_empty() && named(all, "img").is_empty());
    });
    // `url(#name)` is a place in the page itself
    let elsewhere = GALLERY.replace("url(#", "");
    for word in ["http:", "https:", "@import", "url(", "//cdn"] {
        assert!(!elsewhere.contains(word), "{word}");
    }
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    assert_eq!(*GALLERY, gallery::page().expect("a page").render());
}

#[test]
fn the_table_of_reversals_shows_each_run_beside_the_others() {
    let value = |total_um, reduction| ReversalValue { total_um, beyond_nominal_um: None, reduction };
    // Zhang (2023) table 5, first two reversals
    let html = one(ReversalsView {
        runs: vec![Run::new("no compensation", Role::Before), Run::new("compensation", Role::After)],
        rows: vec![
            ReversalRow {
                joint: "A1".into(),
                at_deg: None,
                sense: 1,
                values: vec![value(198.0, None), value(14.0, Some(1.0 - 14.0 / 198.0))],
            },
            ReversalRow {
                joint: "A1".into(),
                at_deg: None,
                sense: -1,
                values: vec![value(167.0, None), value(10.0, Some(1.0 - 10.0 / 167.0))],
            },
        ],
    });
    with_elements(&html, |all| {
        let rows: Vec<Vec<String>> = named(all, "tr")
            .iter()
            .map(|r| r.children().filter(Node::is_element).map(|c| text_of(&c)).collect())
            .collect();
        assert_eq!(rows[2], ["A1↑", "198", "14", "93\u{202f}%"]);
        assert_eq!(rows[3], ["A1↓", "167", "10", "94\u{202f}%"]);
        let groups: Vec<_> = named(all, "th").iter().filter_map(|t| t.attribute("colspan")).collect();
        assert_eq!(groups, ["1", "2"]);
    });
}

#[test]
fn a_page_may_have_a_single_section_and_names_its_method_and_source() {
    let html = one(vec![method::PLAY, method::CIRCLE]);
    with_elements(&html, |all| {
        assert_eq!(named(all, "section").len(), 1);
        assert!(named(all, "nav").is_empty() && named(all, "script").is_empty());
        let words = text_of(&named(all, "section")[0]);
        assert!(words.contains("equation 6") && words.contains("Taubin"), "{words}");
    });
}
