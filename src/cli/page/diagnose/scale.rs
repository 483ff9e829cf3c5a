//! The unit of the residuals on the page.

use crate::diagnose::result::document::Diagnosis;
use crate::diagnose::result::words::GapUnit;
use crate::report::Tile;

/// Unit of the residuals on the page: micrometres, or thousandths of a degree if only joints were measured.
pub(super) struct GapScale {
    pub(super) quantity: &'static str,
    pub(super) unit: &'static str,
    /// From SI.
    pub(super) si: f64,
    /// From the `_um` figures of the document.
    pub(super) um: f64,
}

impl GapScale {
    pub(super) fn of(d: &Diagnosis) -> Self {
        if d.unit == GapUnit::MICROMETRE {
            Self { quantity: "gap at the TCP", unit: "µm", si: 1e6, um: 1.0 }
        } else {
            let mdeg = 180e3 / std::f64::consts::PI;
            Self { quantity: "gap of the joints", unit: "mdeg", si: mdeg, um: mdeg * 1e-6 }
        }
    }

    pub(super) fn tile(&self, label: &str, um: f64) -> Tile {
        Tile::number(label, um * self.um, if self.um * um < 10.0 { 2 } else { 1 }, self.unit)
    }
}
