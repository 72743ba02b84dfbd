//! Teams with bodies in random walled worlds: round sharp bends nobody touches anything, and the grips hold.

use cocarry::episode::EpisodeSettings;
use cocarry::robot::Robot;
use cocarry::scenario::{Plant, PlantKind, RobotSetup};
use cocarry_studies::paper::cycles::Search;
use cocarry_studies::paper::placed::Placed;

/// Worlds in which the object touched a pillar or the end of a wall in a bend (14, 39, 121, 233), in which
/// the arm folded up to its limits in a bend at the start (146, 416), and in which the human touched a wall
/// beyond the target, where the team had turned from its start onto the last line of the path (238, 282,
/// 458); in which the base cut the corner of an obstacle near its start (9, 1234), in which the team
/// reversed, changed its mind and went on, again and again (2230, 2438, 2464), and in which a turn joined the
/// last line of its path beyond the arc that leaves room for the human at the target (20300).
const SEEDS: [u64; 15] = [9, 14, 39, 121, 146, 233, 238, 282, 416, 458, 1234, 2230, 2438, 2464, 20300];

#[test]
fn teams_go_round_sharp_bends_without_contact_and_keep_hold_of_the_object() {
    let robot = Robot::built_in().expect("the built-in robot");
    let plant = Plant::new(PlantKind::Rapier, RobotSetup::new(&robot));
    for seed in SEEDS {
        let search = Search {
            plant: &plant,
            settings: &EpisodeSettings::default(),
            worlds: 1,
            seed,
            placed: Placed::AsDrawn,
        };
        let found = search.run(&|| {}).expect("a world with room");
        assert_eq!(found.arrived, 1, "world {seed}: {:?}", found.lost[0].outcome);
    }
}

/// A world that is turned, mirrored or moved is the same world to a team with bodies.
#[test]
fn teams_arrive_wherever_a_world_lies() {
    let robot = Robot::built_in().expect("the built-in robot");
    let plant = Plant::new(PlantKind::Rapier, RobotSetup::new(&robot));
    for (name, placed) in Placed::ALL {
        for seed in [14, 238] {
            let search =
                Search { plant: &plant, settings: &EpisodeSettings::default(), worlds: 1, seed, placed };
            let found = search.run(&|| {}).expect("a world with room");
            assert_eq!(found.arrived, 1, "world {seed}, {name}: {:?}", found.lost[0].outcome);
        }
    }
}

/// One of the worlds drawn for this seed has its start in the middle of its field: no target is far from it,
/// and the draw of one did not end.
#[test]
fn a_search_ends_where_no_target_is_far_from_a_start() {
    let robot = Robot::built_in().expect("the built-in robot");
    let plant = Plant::new(PlantKind::Kinematic, RobotSetup::new(&robot));
    let search = Search {
        plant: &plant,
        settings: &EpisodeSettings::default(),
        worlds: 1,
        seed: 10_224,
        placed: Placed::AsDrawn,
    };
    assert_eq!(search.run(&|| {}).expect("a world with room").episodes, 1);
}
