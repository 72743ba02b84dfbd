//! The mesh files of a robot's visual shapes, as viewers of scenes take them.

use super::shapes::Shapes;
use cocarry::geometry::Pose;
use cocarry::robot::{Robot, Shape};
use cocarry::{bounds, located};
use foxglove::messages::SceneEntity;
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The largest total size of a robot's files, bytes. They are in one message, which must fit into a record
/// that readers take.
const MAX_BYTES: u64 = 16 << 20;

/// The files of a robot's visual meshes, each once; none if one of them is missing.
#[derive(Clone, Debug, Default)]
pub(super) struct Meshes(BTreeMap<PathBuf, Mesh>);

/// A mesh file.
#[derive(Clone, Debug)]
pub(super) struct Mesh {
    media_type: &'static str,
    data: Vec<u8>,
}

impl Meshes {
    /// The files of the robot's visual shapes. Without all of them, or above 16 MiB, there are none: the robot
    /// of a snapshot or a recording is known without its files.
    pub fn of(robot: &Robot) -> Self {
        let mut found = BTreeMap::new();
        let mut size = 0;
        for geometry in robot.links.iter().flat_map(|link| &link.visuals) {
            let Shape::Mesh { file, .. } = &geometry.shape else { continue };
            if found.contains_key(file) {
                // each use is a copy in the scene
                size += found.get(file).map_or(0, |mesh: &Mesh| mesh.data.len() as u64);
            } else {
                let Some(mesh) = Mesh::read(file) else { return Self::default() };
                size += mesh.data.len() as u64;
                found.insert(file.clone(), mesh);
            }
            if size > MAX_BYTES {
                return Self::default();
            }
        }
        Self(found)
    }

    pub fn get(&self, file: &Path) -> Option<&Mesh> {
        self.0.get(file)
    }
}

impl Mesh {
    /// `None` where the file cannot be read, is too large, or has another format than STL, OBJ and COLLADA.
    fn read(file: &Path) -> Option<Self> {
        let format = file.extension()?.to_str()?.to_lowercase();
        let media_type = match &*format {
            "stl" => "model/stl",
            "obj" => "model/obj",
            "dae" => "model/vnd.collada+xml",
            _ => return None,
        };
        let mut data = located::read_bytes(&bounds::MESH, file).ok()?;
        if format == "dae" {
            data = upright(String::from_utf8(data).ok()?).into_bytes();
        }
        Some(Self { media_type, data })
    }

    /// Adds the mesh to an entity.
    pub fn draw(&self, entity: &mut SceneEntity, at: &Pose, scale: Vector3<f64>, rgba: Option<[f32; 4]>) {
        // viewers turn STL and OBJ, whose files do not tell, from y up to z up; a URDF's have z up
        let is_turned = self.media_type != "model/vnd.collada+xml";
        let quarter = Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0);
        let (at, scale) = match is_turned {
            true => {
                let turned = at * Rotation3::from_matrix_unchecked(quarter);
                (turned, Vector3::new(scale.x, scale.z, scale.y))
            }
            false => (*at, scale),
        };
        entity.model(&at, scale, rgba, (self.media_type, self.data.clone()));
    }
}

/// A COLLADA text whose vertical axis is z. Robots are made to look right in viewers that ignore the axis.
fn upright(text: String) -> String {
    const UP: &str = "<up_axis>Z_UP</up_axis>";
    if let Some((before, rest)) = text.split_once("<up_axis>")
        && let Some((_, after)) = rest.split_once("</up_axis>")
    {
        return format!("{before}{UP}{after}");
    }
    match text.split_once("</asset>") {
        Some((before, after)) => format!("{before}{UP}</asset>{after}"),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_collada_file_has_its_z_axis_up() {
        for axis in ["<up_axis>Y_UP</up_axis>", "<up_axis> X_UP </up_axis>", ""] {
            let text = format!("<COLLADA><asset>{axis}</asset><x/></COLLADA>");
            let expected = "<COLLADA><asset><up_axis>Z_UP</up_axis></asset><x/></COLLADA>";
            assert_eq!(upright(text), expected, "{axis}");
        }
    }

    /// Viewers turn STL by a quarter about x after scaling along the file's axes, and then pose it.
    #[test]
    fn closed_form_a_turned_mesh_is_where_the_urdf_has_it() {
        let viewer = Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
        let yawed = Rotation3::from_axis_angle(&Vector3::z_axis(), 0.4);
        let at = Pose::from_parts(Vector3::new(1.0, 2.0, 3.0).into(), yawed);
        let mesh = Mesh { media_type: "model/stl", data: Vec::new() };
        let mut entity = SceneEntity::default();
        let scale = Vector3::new(2.0, 3.0, 5.0);
        mesh.draw(&mut entity, &at, scale, None);
        let model = &entity.models[0];
        let (p, q, s) = (model.pose.unwrap(), model.pose.unwrap().orientation.unwrap(), model.scale.unwrap());
        let turn = nalgebra::UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(q.w, q.x, q.y, q.z));
        for vertex in [Vector3::x(), Vector3::y(), Vector3::new(0.1, 0.2, 0.3)] {
            let scaled = (viewer * vertex).component_mul(&Vector3::new(s.x, s.y, s.z));
            let place = p.position.unwrap();
            let drawn = turn * scaled + Vector3::new(place.x, place.y, place.z);
            let expected = (at * nalgebra::Point3::from(vertex.component_mul(&scale))).coords;
            assert!((drawn - expected).norm() < 1e-12, "{drawn} {expected}");
        }
    }
}
