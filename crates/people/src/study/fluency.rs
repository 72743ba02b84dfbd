//! The statements about the fluency of a human-robot team after G. Hoffman, "Evaluating Fluency in Human-Robot
//! Collaboration", IEEE Transactions on Human-Machine Systems 49(3), 2019, 209-218, with the subscales that
//! they belong to there.

/// A statement, and whether agreement with it counts against its subscale.
pub(super) struct Statement {
    pub text: &'static str,
    pub is_reversed: bool,
}

const fn plain(text: &'static str) -> Statement {
    Statement { text, is_reversed: false }
}

const fn reversed(text: &'static str) -> Statement {
    Statement { text, is_reversed: true }
}

/// The number of points, and the words at the ends, where a study file gives none.
pub(super) const POINTS: u64 = 7;
pub(super) const ENDS: [&str; 2] = ["strongly disagree", "strongly agree"];

/// The statements, each asked once.
pub(super) const STATEMENTS: [Statement; 23] = [
    plain("The human-robot team worked fluently together."),
    plain("The human-robot team's fluency improved over time."),
    plain("The robot contributed to the fluency of the interaction."),
    reversed("I had to carry the weight to make the human-robot team better."),
    plain("The robot contributed equally to the team performance."),
    reversed("I was the most important team member on the team."),
    plain("The robot was the most important team member on the team."),
    plain("I trusted the robot to do the right thing at the right time."),
    plain("The robot was trustworthy."),
    plain("The robot was intelligent."),
    plain("The robot was committed to the task."),
    plain("The human-robot team improved over time."),
    plain("The robot's performance improved over time."),
    reversed("I feel uncomfortable with the robot."),
    plain("The robot and I understand each other."),
    plain("I believe the robot likes me."),
    plain("The robot and I respect each other."),
    plain("I am confident in the robot's ability to help me."),
    plain("I feel that the robot appreciates me."),
    plain("The robot and I trust each other."),
    plain("The robot perceives accurately what my goals are."),
    reversed("The robot does not understand what I am trying to accomplish."),
    plain("The robot and I are working towards mutually agreed upon goals."),
];

/// A subscale: its name, and the indices of its statements.
pub(crate) struct Subscale {
    /// Its name in tables.
    pub name: &'static str,
    items: &'static [usize],
}

/// The subscales. Two statements belong to two of them.
pub(crate) const SUBSCALES: [Subscale; 7] = [
    Subscale { name: "human-robot fluency", items: &[0, 1, 2] },
    Subscale { name: "robot relative contribution", items: &[3, 4, 5, 6] },
    Subscale { name: "trust in the robot", items: &[7, 8] },
    Subscale { name: "positive teammate traits", items: &[9, 8, 10] },
    Subscale { name: "improvement", items: &[11, 1, 12] },
    Subscale { name: "working alliance: bond", items: &[13, 14, 15, 16, 17, 18, 19] },
    Subscale { name: "working alliance: goal", items: &[20, 21, 22] },
];

impl Subscale {
    /// The mean of answers from 1 to `points`, one for each statement; those of reversed statements are turned
    /// round.
    pub fn mean(&self, answers: &[f64], points: u64) -> Option<f64> {
        let turned = |&item: &usize| {
            let answer = *answers.get(item)?;
            Some(if STATEMENTS[item].is_reversed { points as f64 + 1.0 - answer } else { answer })
        };
        let sum: Option<f64> = self.items.iter().map(turned).sum();
        Some(sum? / self.items.len() as f64)
    }

    /// Its statements, each with whether it is reversed.
    pub fn statements(&self) -> impl Iterator<Item = (&'static str, bool)> {
        self.items.iter().map(|&item| (STATEMENTS[item].text, STATEMENTS[item].is_reversed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_means_of_subscales_turn_reversed_statements_round() {
        let mut answers = [4.0; STATEMENTS.len()];
        assert!(SUBSCALES.iter().all(|subscale| subscale.mean(&answers, 7) == Some(4.0)));
        // "I had to carry the weight": full agreement is the least contribution of the robot
        answers[3] = 7.0;
        assert_eq!(SUBSCALES[1].mean(&answers, 7), Some((1.0 + 3.0 * 4.0) / 4.0));
        assert_eq!(SUBSCALES[1].mean(&answers[..3], 7), None);
        // every statement belongs to a subscale
        let used: std::collections::BTreeSet<usize> =
            SUBSCALES.iter().flat_map(|subscale| subscale.items.iter().copied()).collect();
        assert_eq!(used.len(), STATEMENTS.len());
    }
}
