//! Meshes.

use super::Bench;
use crate::hostile_meshes::{DAE, with_mesh};
use crate::support::{stderr, stdout};

/// A binary STL of a net of triangles, of as many as fit.
fn stl(bench: &Bench) -> Vec<u8> {
    let count = (bench.longest() - 84) / 50;
    let mut bytes = vec![b' '; 80];
    bytes.extend((count as u32).to_le_bytes());
    for i in 0..count {
        let corner =
            |k: usize| [(k % 1000) as f32 * 1e-3, (k / 1000 % 1000) as f32 * 1e-3, (k % 7) as f32 * 1e-2];
        bytes.extend([0; 12]);
        for k in [i, i + 1, i + 1000] {
            bytes.extend(corner(k).into_iter().flat_map(f32::to_le_bytes));
        }
        bytes.extend([0, 0]);
    }
    bytes
}

/// Vertices and as many triangles as may be, then comments.
fn obj(bench: &Bench) -> String {
    let corner = |i: usize| format!("v {} {} {}\n", i % 1000, i / 1000 % 1000, i % 7);
    let vertices: String = (0..500_000).map(corner).collect();
    let faces: String = (1..500_000).map(|i| format!("f {i} {} 1\n", i + 1)).collect();
    bench.filled(&format!("{vertices}{}", faces.repeat(3)), "# x\n")
}

/// Positions and triangles up to the length.
fn dae(bench: &Bench) -> String {
    let count = 1_000_000;
    let numbers: String = (0..count).map(|i| format!("{} {} {} ", i % 1000, i / 1000, i % 7)).collect();
    let corners: String = (0..count).map(|i| format!("{i} {} 0 ", (i + 1) % count)).collect();
    let text = DAE.replace("0 0 0 1 0 0 0 1 0 0 0 1", &numbers).replace("0 1 2 0 2 3 0 3 1 1 3 2", &corners);
    let text = text.replace("count=\"12\"", &format!("count=\"{}\"", 3 * count));
    let text = text.replace("count=\"4\" stride", &format!("count=\"{count}\" stride"));
    bench.filled(&text.replace("<triangles count=\"4\"", &format!("<triangles count=\"{count}\"")), "\n")
}

pub(super) fn meshes(bench: Bench) {
    for (name, mut bytes) in
        [("a.stl", stl(&bench)), ("a.obj", obj(&bench).into_bytes()), ("a.dae", dae(&bench).into_bytes())]
    {
        with_mesh(bench.folder(), name, b"").expect("a robot");
        bench.write(name, &bytes);
        let output = bench.reads("robot check carrier.toml");
        let said = |output| stderr(output) + &stdout(output);
        assert!(!said(&output).contains("has no shape"), "{name}: {}", said(&output));
        bytes.resize(bench.longest() + 1, b' ');
        bench.write(name, &bytes);
        let output = bench.reads("robot check carrier.toml");
        let expected = format!("{name}: larger than {} bytes", bench.longest());
        assert!(said(&output).contains(&expected), "{}", said(&output));
    }
}
