//! Robots: their files, URDFs and meshes.

use crate::{FOLDER, file};
use cocarry::robot::{Draft, DraftRequest, Robot};
use std::path::Path;
use std::sync::Once;

const TOML: &str = include_str!("../../../assets/robots/carrier.toml");
const URDF: &str = include_str!("../../../assets/robots/carrier.urdf");

/// Writes a file that stays.
fn once(once: &'static Once, name: &str, text: &str) {
    once.call_once(|| drop(file(name, text.as_bytes())));
}

/// A robot file next to the carrier's URDF.
pub fn robot(bytes: &[u8]) {
    static WRITTEN: Once = Once::new();
    once(&WRITTEN, "carrier.urdf", URDF);
    let _ = Robot::check(&file("carrier.toml", bytes));
}

/// A URDF next to the carrier's robot file; a robot file is drafted for it too.
pub fn urdf(bytes: &[u8]) {
    static WRITTEN: Once = Once::new();
    once(&WRITTEN, "carrier.toml", TOML);
    let urdf = file("carrier.urdf", bytes);
    let _ = Robot::check(&FOLDER.join("carrier.toml"));
    draft(&urdf);
}

fn draft(urdf: &Path) {
    let _ = Draft::new(urdf, "carrier.urdf", "carrier.toml", &DraftRequest::default());
}

/// The mesh of the only link of a URDF.
pub fn mesh(name: &str, bytes: &[u8]) {
    static WRITTEN: Once = Once::new();
    let shape = format!("<collision><geometry><mesh filename=\"{name}\"/></geometry></collision>");
    once(&WRITTEN, "mesh.urdf", &format!("<robot name=\"r\"><link name=\"l\">{shape}</link></robot>"));
    file(name, bytes);
    draft(&FOLDER.join("mesh.urdf"));
}
