//! The pages as one site: every page is in the table of contents, every link leads somewhere.

use crate::support::bundled;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn pages() -> Vec<PathBuf> {
    let mut out: Vec<PathBuf> = std::fs::read_dir(bundled("docs"))
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.extension().is_some_and(|e| e == "md"))
        .collect();
    out.push(bundled("README.md"));
    out.sort();
    out
}

/// Text without what stands in code.
fn prose(text: &str) -> String {
    let mut out = String::new();
    let mut code = false;
    for line in text.lines() {
        if line.starts_with("```") {
            code = !code;
        } else if !code {
            for (i, part) in line.split('`').enumerate() {
                if i % 2 == 0 {
                    out.push_str(part);
                }
            }
            out.push('\n');
        }
    }
    out
}

/// Targets of `](...)`.
fn links(text: &str) -> Vec<String> {
    let prose = prose(text);
    let ends = prose.split("](").skip(1).filter_map(|rest| rest.split_once(')'));
    ends.map(|(to, _)| to.split_whitespace().next().unwrap_or_default().to_string()).collect()
}

/// Anchors of a page's headings, as GitHub and mdBook make them.
fn anchors(text: &str) -> BTreeSet<String> {
    let mut code = false;
    let mut out = BTreeSet::new();
    for line in text.lines() {
        code ^= line.starts_with("```");
        if !code && line.starts_with('#') {
            let heading = line.trim_start_matches('#').trim().to_lowercase();
            let kept = heading.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
            out.insert(kept.map(|c| if c == ' ' { '-' } else { c }).collect());
        }
    }
    out
}

#[test]
fn every_link_between_the_pages_leads_somewhere() {
    let mut checked = 0;
    for page in pages() {
        let text = std::fs::read_to_string(&page).unwrap();
        for link in links(&text) {
            if link.starts_with("http") || link.starts_with("mailto:") {
                continue;
            }
            let (file, anchor) = link.split_once('#').map_or((link.as_str(), None), |(f, a)| (f, Some(a)));
            let target = if file.is_empty() { page.clone() } else { page.parent().unwrap_or(Path::new("")).join(file) };
            assert!(target.exists(), "{}: {link}", page.display());
            if let Some(anchor) = anchor {
                let there = anchors(&std::fs::read_to_string(&target).unwrap());
                assert!(there.contains(anchor), "{}: {link}; the page has {there:?}", page.display());
            }
            checked += 1;
        }
    }
    assert!(checked > 100, "{checked} links");
}

#[test]
fn every_page_is_in_the_table_of_contents_once() {
    let summary = std::fs::read_to_string(bundled("docs/SUMMARY.md")).unwrap();
    let mut listed = links(&summary);
    listed.sort();
    let names = pages().into_iter().filter(|p| p.parent().is_some_and(|f| f.ends_with("docs")));
    let mut there: Vec<String> = names.map(|p| p.file_name().unwrap().to_str().unwrap().to_string()).collect();
    there.retain(|n| n != "SUMMARY.md");
    there.sort();
    assert_eq!(listed, there);
}

#[test]
fn no_page_of_the_site_links_out_of_its_folder() {
    // the book contains `docs` alone: a link to a file outside works in a checkout only
    for page in pages().into_iter().filter(|p| p.parent().is_some_and(|f| f.ends_with("docs"))) {
        for link in links(&std::fs::read_to_string(&page).unwrap()) {
            let elsewhere = link.starts_with("https://") || link.starts_with("mailto:");
            assert!(elsewhere || !link.contains("..") && !link.starts_with('/'), "{}: {link}", page.display());
        }
    }
}
