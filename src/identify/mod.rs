//! Identification: from measurement logs to half gaps per joint, with intervals ([`crate::gaps::Gaps`]).
//!
//! Rooms:
//! - [`static_test`]: every angle reached from both sides with a dwell (seed 000, Table 1 and Figure 5).
//! - [`path`]: gaps and stiction from reversals in continuous motion (seed 000, sections 3 and 5).

pub mod path;
pub mod static_test;
