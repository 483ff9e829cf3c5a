//! Writes a page with every figure and table, from a made run of the bundled robot: `cargo run --example report_gallery [FILE]`.
//!
//! The data are simulated with this crate's own effects and stand for no measurement; the page is there to be looked at.

mod data;

fn main() -> lostmotion::error::Result<()> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "target/report_gallery.html".into());
    let page = data::page()?;
    lostmotion::io::output::write_whole(path.as_ref(), page.render().as_bytes())?;
    eprintln!("{path}");
    Ok(())
}
