//! Values that documents hold in words: data inside, a sentence at the edge.

/// Makes documents hold values of these types as their `Display` says them.
macro_rules! in_words {
    ($($of:ty),+) => {$(
        impl serde::Serialize for $of {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
                serializer.collect_str(self)
            }
        }
    )+};
}
pub(crate) use in_words;
