//! Text, documents and tables on standard output.

use anyhow::Result;

/// Prints a result on standard output. A reader that has gone has read what it wanted; the command goes on to its answer.
pub(crate) fn print(text: &str) -> Result<()> {
    use std::io::{ErrorKind, Write};
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() == ErrorKind::BrokenPipe => Ok(()),
        done => done.map_err(|e| crate::error::Error::io("standard output", "write", e).into()),
    }
}

/// One JSON document with a last newline.
pub(crate) fn print_json(document: &impl serde::Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(document).map_err(|e| crate::error::Error::internal("write JSON", e))?;
    print(&(text + "\n"))
}

/// An empty table: numbers to the right, one line below the header.
pub(crate) fn table(header: &[&str]) -> comfy_table::Table {
    use comfy_table::{TableComponent, presets};
    let mut table = comfy_table::Table::new();
    table.load_preset(presets::NOTHING).set_header(header);
    for line in [TableComponent::HeaderLines, TableComponent::MiddleHeaderIntersections] {
        table.set_style(line, '─');
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(comfy_table::CellAlignment::Right);
    }
    table
}
