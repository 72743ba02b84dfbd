//! stub
use super::DrawingError;
/// p
#[derive(Clone, Debug)]
pub struct RatioPanel {
    /// t
    pub title: String,
    /// r
    pub rows: Vec<RatioRow>,
}
/// r
#[derive(Clone, Debug)]
pub struct RatioRow {
    /// l
    pub label: String,
    /// r
    pub ratios: Vec<(u32, f64)>,
}
/// c
pub fn cost_ratios(_: &[RatioPanel]) -> Result<String, DrawingError> {
    Ok(String::new())
}
