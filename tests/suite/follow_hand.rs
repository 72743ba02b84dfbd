//! A robot that follows the human's hand, wherever that goes.

#[path = "../../examples/follow_hand.rs"]
#[expect(dead_code, reason = "its main")]
mod example;

use cocarry::episode::Outcome;
use cocarry_studies::paper::ENVIRONMENTS;
use example::{HALL, Way, followed};

/// A hand that wiggles by 50 degrees to either side, at 0.5 m/s for a minute: less than 30 N in the mean,
/// which includes the human's half of the weight of 4 kg (20 N), and no contact.
fn a_minute_in(number: usize, way: Way) {
    let summary = followed(&ENVIRONMENTS[number - 1], way).expect("a walk");
    let interaction = summary.interaction.expect("bodies");
    assert_eq!((summary.outcome, summary.steps), (Outcome::OutOfTime, 300), "{:?}", summary.collision);
    assert!(interaction.mean_force() < 30.0, "{} N", interaction.mean_force());
    assert!(interaction.deflection < 0.05, "{} m", interaction.deflection);
}

#[test]
fn a_hand_that_wiggles_is_followed_in_environment_1() {
    a_minute_in(1, Way::Circle);
}

#[test]
fn a_hand_that_wiggles_is_followed_in_environment_2() {
    a_minute_in(2, Way::Circle);
}

#[test]
fn a_hand_that_wiggles_is_followed_in_environment_3() {
    a_minute_in(3, Way::Circle);
}

#[test]
fn a_hand_that_wiggles_is_followed_in_environment_4() {
    a_minute_in(4, Way::Circle);
}

#[test]
fn a_hand_that_goes_up_and_down_a_hall_is_followed() {
    a_minute_in(4, HALL);
}
