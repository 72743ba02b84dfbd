//! Mesh files that claim what they do not have, or ask for more time and memory than their size: the robot is
//! read with a warning, in bounded time and memory.

use crate::mutants::binary_stl;
use crate::spoiled_robot::{TOML, URDF, original};
use crate::support::time_for;
use cocarry::robot::Robot;
use std::path::Path;
use std::time::Instant;

/// A tetrahedron.
pub const DAE: &str = r##"<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><library_geometries><geometry id="g"><mesh><source id="p"><float_array id="pa" count="12">0 0 0 1 0 0 0 1 0 0 0 1</float_array><technique_common><accessor source="#pa" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source><vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2 0 2 3 0 3 1 1 3 2</p></triangles></mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"##;

/// The carrier whose base collides as this mesh.
pub fn with_mesh(folder: &Path, name: &str, bytes: &[u8]) -> Result<Robot, Vec<cocarry::Error>> {
    let urdf = original(URDF);
    let base = urdf.find("<link name=\"base_link\">").expect("the base");
    let from = base + urdf[base..].find("<collision>").expect("its shape");
    let to = from + urdf[from..].find("</collision>").expect("its end");
    let mesh = format!("<collision><geometry><mesh filename=\"{name}\"/></geometry>");
    std::fs::write(folder.join(URDF), format!("{}{mesh}{}", &urdf[..from], &urdf[to..])).unwrap();
    std::fs::write(folder.join(TOML), original(TOML)).unwrap();
    std::fs::write(folder.join(name), bytes).unwrap();
    Robot::check(&folder.join(TOML))
}

/// The warnings about a mesh, which is read in 5 s.
fn warnings(name: &str, bytes: impl AsRef<[u8]>) -> String {
    let folder = tempfile::tempdir().unwrap();
    let begun = Instant::now();
    let robot = with_mesh(folder.path(), name, bytes.as_ref()).unwrap_or_else(|faults| panic!("{faults:?}"));
    assert!(begun.elapsed() < time_for(5), "{name}: {:?}", begun.elapsed());
    robot.warnings.iter().map(|warning| format!("{warning}\n")).collect()
}

#[track_caller]
fn has_no_shape(name: &str, bytes: impl AsRef<[u8]>, why: &str) {
    let said = warnings(name, bytes);
    assert!(said.contains(&format!("its collision mesh `{name}` has no shape")), "{said}");
    assert!(said.contains(why), "{why:?} is missing from: {said}");
    assert!(said.len() < 2000, "{said}");
}

fn collada(from: &str, to: &str) -> String {
    assert_eq!(DAE.matches(from).count(), 1, "{from}");
    DAE.replace(from, to)
}

#[test]
fn meshes_that_are_sound_have_shapes() {
    for (name, bytes) in [("a.dae", DAE.as_bytes().to_vec()), ("a.stl", binary_stl(4))] {
        let said = warnings(name, bytes);
        assert!(!said.contains("has no shape") && !said.contains("damaged"), "{said}");
    }
}

#[test]
fn a_collada_mesh_that_claims_what_it_has_not_has_no_shape() {
    let polygons = |vcount: &str| {
        collada("<triangles count=\"4\">", "<polylist count=\"1\">")
            .replace("</triangles>", "</polylist>")
            .replace("<p>", &format!("<vcount>{vcount}</vcount><p>"))
    };
    for (text, why) in [
        (collada("<p>0 1 2 ", "<p>0 1 4294967295 "), "it cannot be read: index out of bounds"),
        (polygons("4294967295"), "number of a part's indices = 4294967295"),
        (collada("stride=\"3\"", "stride=\"0\""), ""),
        (collada("stride=\"3\"", "stride=\"4294967295\""), "stride = 4294967295; it must be at most 256"),
        (collada("count=\"12\"", "count=\"4294967295\""), "sum of its counts = 4294967299"),
        (
            collada("<triangles count=\"4\"", "<triangles count=\"1431655765\""),
            "a part's indices = 4294967295",
        ),
        (collada("offset=\"0\"", "offset=\"4294967294\""), "offset of an input, and one, = 4294967295"),
        // an array of names is read without end
        (
            collada(
                "<float_array id=\"pa\" count=\"12\">0",
                "<Name_array id=\"q\" count=\"1\">a</Name_array><float_array id=\"pa\" count=\"12\">0",
            ),
            "it has a Name_array in a mesh",
        ),
        (collada("source=\"#p\"", "source=\"#q\""), "it cannot be read: no entry found for key"),
        (
            collada("<?xml version=\"1.0\"?>", "<!DOCTYPE a [<!ENTITY b \"c\">]>"),
            "a document type declaration",
        ),
    ] {
        has_no_shape("a.dae", text, why);
    }
}

#[test]
fn a_collada_mesh_that_is_deep_or_wide_has_no_shape() {
    let deep = "<node>".repeat(20_000) + &"</node>".repeat(20_000);
    has_no_shape(
        "a.dae",
        collada("<node id=\"n\">", &format!("{deep}<node id=\"n\">")),
        "depth of its elements = 129",
    );
    let wide: String = (0..400_000).map(|i| format!(" a{i}=\"\"")).collect();
    has_no_shape(
        "a.dae",
        collada("<node id=\"n\">", &format!("<node id=\"n\"{wide}>")),
        "number of a tag's attributes = 400001",
    );
    let many = "<node/>".repeat(1_100_000);
    has_no_shape(
        "a.dae",
        collada("<node id=\"n\">", &format!("{many}<node id=\"n\">")),
        "number of its tags = 1000001",
    );
    // every part copies all vertices; the parser recurses for every flat polygon
    let part = "<triangles count=\"0\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/></triangles>";
    has_no_shape(
        "a.dae",
        collada("</mesh>", &format!("{}</mesh>", part.repeat(21_000))),
        "number of its parts = 21001",
    );
    let flat = format!(
        "<polylist count=\"200000\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><vcount>{}</vcount><p>{}</p></polylist>",
        "1 ".repeat(200_000),
        "0 ".repeat(200_000)
    );
    has_no_shape("a.dae", collada("</mesh>", &format!("{flat}</mesh>")), "polygons of one or two corners");
}

#[test]
fn an_obj_that_asks_for_more_than_its_size_has_no_shape() {
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
    let polygon = format!("{vertices}f{}\n", " 1 2 3 4".repeat(1_000_000));
    has_no_shape("a.obj", polygon, "number of its triangles = 3999998; it must be at most 1500000");
    let points = format!("{vertices}{}", "f 1\n".repeat(1_600_000));
    has_no_shape("a.obj", points, "number of its faces = 1600000");
    let groups: String = (0..30_000).map(|i| format!("g {i}\nf 1 2 3\n")).collect();
    has_no_shape("a.obj", format!("{vertices}{groups}"), "number of its groups and materials = 30000");
    has_no_shape("a.obj", [0xff, 0xfe, b'v', 0], "it is UTF-16; expected UTF-8");
    has_no_shape("a.obj", format!("{vertices}f 1 2 9\n"), "a.obj");
    for number in ["nan", "1e39", "-inf", "1e7"] {
        let said = warnings("a.obj", format!("v {number} 0 0\n{vertices}f 1 2 3\nf 2 3 4\n"));
        assert!(said.contains("has no shape"), "{number}: {said}");
    }
}

#[test]
fn an_stl_of_many_solids_has_no_shape() {
    has_no_shape("a.stl", "solid a\nendsolid a\n".repeat(30_000), "number of words `solid` = 60000");
}

/// A file that was cut at the end of a triangle looks like a whole one.
#[test]
fn an_stl_that_claims_more_triangles_than_it_has_is_told() {
    for (claimed, found) in [(4000, 4), (1, 4)] {
        let said = warnings("a.stl", binary_stl(claimed));
        let expected =
            format!("`a.stl` may be damaged: it claims to have {claimed} triangles and has {found}");
        assert!(said.contains(&expected), "{said}");
    }
}

/// A mesh that many links name is read once.
#[test]
fn the_largest_mesh_is_read_within_its_time() {
    let corner = |i: usize| format!("v {} {} {}\n", i % 1000, i / 1000 % 1000, i % 7);
    let vertices: String = (0..300_000).map(corner).collect();
    let faces: String = (1..300_000).map(|i| format!("f {i} {} 1\n", i + 1)).collect();
    let said = warnings("a.obj", format!("{vertices}{}", faces.repeat(4)));
    assert!(!said.contains("has no shape"), "{said}");
}
