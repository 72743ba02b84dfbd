//! Columns of tables as Arrow data, with the feature `parquet`.

#[cfg(feature = "parquet")]
mod arrow;

#[cfg(feature = "parquet")]
pub use arrow::{Column, Columns, field};
