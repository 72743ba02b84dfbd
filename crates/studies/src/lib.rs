//! Many episodes: the paper's claims, studies, fits, the regression gate, the report, and tasks of a cluster.

pub mod cluster;
#[cfg(feature = "parquet")]
pub mod columns;
pub mod fit;
pub mod paper;
pub mod parallel;
pub mod regression;
pub mod report;
pub mod statistics;
pub mod study;
pub mod table;
pub mod zarr;
