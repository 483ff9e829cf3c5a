//! Writes docs/effects.md and docs/effects/*.svg from the effect catalogue: `cargo run --example effect_pictures`.

mod pages;

fn main() -> std::io::Result<()> {
    std::fs::create_dir_all("docs/effects")?;
    for (path, text) in pages::all() {
        std::fs::write(path, text)?;
    }
    Ok(())
}
