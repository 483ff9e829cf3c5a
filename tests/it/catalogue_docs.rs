//! docs/effects.md and its pictures are what the catalogue says.

#[path = "../../examples/effect_pictures/pages.rs"]
mod pages;

#[test]
fn the_page_of_the_effects_and_its_pictures_are_not_stale() {
    for (path, want) in pages::all() {
        let found = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(found == want, "{path} is stale: cargo run --example effect_pictures");
    }
}

#[test]
fn every_picture_is_well_formed_and_draws_something() {
    for (path, text) in pages::all().into_iter().filter(|(p, _)| p.ends_with(".svg")) {
        let document = roxmltree::Document::parse(&text).unwrap_or_else(|e| panic!("{path}: {e}"));
        let longest = document.descendants().filter_map(|n| n.attribute("d")).map(str::len).max().unwrap_or(0);
        assert!(longest > 1000 && text.len() < 30_000, "{path}: {longest} of {}", text.len());
    }
}
