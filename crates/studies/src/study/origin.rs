//! The origin of a file of results: the study, and the arithmetic.

/// Where rows come from.
#[derive(Clone, Debug)]
#[cfg_attr(not(feature = "parquet"), expect(dead_code, reason = "only Parquet files tell it"))]
pub(super) struct Origin {
    /// The text of the study file, if it is known.
    pub text: Option<String>,
    /// The study's digest.
    pub study: String,
    /// The number of episodes of the study.
    pub episodes: u64,
    /// The stamp of the arithmetic.
    pub arithmetic: String,
}
