//! What participants are marked by; nobody is left out for it.

/// A mark, and what it means.
pub(crate) type Flag = (&'static str, &'static str);

pub(crate) const DOMINATED: Flag = (
    "longer-and-riskier-over-20",
    "more than 20 % on a way that is both longer and riskier than another one: eq. (2) never prefers it",
);
pub(crate) const NOT_RIGHT: Flag =
    ("question-not-right", "a question was not answered rightly in its attempts");
pub(crate) const HIDDEN: Flag =
    ("page-hidden", "the page was hidden during an answer, or during a walk, which was then shown anew");
pub(crate) const STALLED: Flag =
    ("pictures-stalled", "a picture of a walk came more than 100 ms after the one before");
pub(crate) const LEFT_OUT: Flag = ("left-out", "an answer does not fit the study, and is in no table");

/// All of them.
pub(crate) const ALL: [Flag; 5] = [DOMINATED, NOT_RIGHT, HIDDEN, STALLED, LEFT_OUT];
