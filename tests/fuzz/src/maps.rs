//! Maps.

use crate::file;
use cocarry::geometry::Point;
use cocarry_maps::{Ends, from_map};
use std::sync::Once;

pub const YAML: &str = "image: grid.pgm\nresolution: 0.1\norigin: [0.0, 0.0, 0.0]\noccupied_thresh: 0.65\nfree_thresh: 0.196\nnegate: 0\n";

/// A map of 6 m by 4 m with an obstacle.
pub fn graymap() -> Vec<u8> {
    let mut bytes = b"P5\n60 40\n255\n".to_vec();
    let is_obstacle = |x: usize, y: usize| (20..25).contains(&x) && (10..15).contains(&y);
    bytes.extend((0..60 * 40).map(|i| if is_obstacle(i % 60, i / 60) { 0 } else { 254 }));
    bytes
}

fn read(name: &str, bytes: &[u8]) {
    let [start, target] = [[0.8, 0.8], [5.0, 3.0]].map(Point::from);
    let _ = from_map(&file(name, bytes), &Ends { start, target, robot_width: None, tolerance: None });
}

/// A description, which may name a sound image, or a plan.
pub fn map(name: &str, bytes: &[u8]) {
    static WRITTEN: Once = Once::new();
    WRITTEN.call_once(|| drop(file("grid.pgm", &graymap())));
    read(name, bytes);
}

pub fn image(bytes: &[u8]) {
    file("grid.pgm", bytes);
    read("map.yaml", YAML.as_bytes());
}
