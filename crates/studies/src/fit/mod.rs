//! Fits of the model's parameters to participants' answers: c_r from percentages, eta from the steps of
//! switches.

mod answers;
mod calibration;
mod coverage;
mod csv_text;
mod eta;
mod infer;
mod kind;
mod lognormal;
mod minimum;
mod risk_weight;
mod set;
mod switches;
mod table;
mod walk;

pub use answers::{AnswerFile, Answers, SUM_TOLERANCE, Situation};
pub use calibration::{Calibration, Check, LEVELS, PARAMETERS, Replication, checks};
pub use coverage::{Coverage, DIFFUSE, EtaDesign, MEDIAN, risk_weight_coverage};
pub use csv_text::read_csv_text;
pub use eta::{Eta, EtaFit, Evidence, fit_eta};
pub use infer::{
    CHAINS, ChoiceEvidence, ChosenWorlds, Draws, Figure, HeldOut, Inference, InferenceModel,
    InferenceSettings, Means, MeansRow, OptionCheck, PERCEPTION_UNITS, PerceptionScore, Person, Population,
    QUANTITIES, Score, Switches, Walk, compare_perceptions, infer, infer_means,
};
pub use kind::{EvidenceKind, participants_files};
pub use lognormal::{LogNormal, MIN_BOUNDED, MIN_DRAWS, NoInterval};
pub use risk_weight::{
    CELL_ERROR, Errors, Estimate, FittedOption, LEAST_SQUARES_CAUTION, RiskWeightFit, RiskWeightSettings,
    fit_risk_weight,
};
pub use set::Set;
pub use switches::{Executed, Switch, SwitchFile};
pub(crate) use table::NAME;
pub use table::{Column as TableColumn, TableLine, bad_cell, read as table_rows, similar_names};
pub use walk::{Guidance, Piece};
