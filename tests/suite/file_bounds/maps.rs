//! Maps: descriptions, images, floor plans.

use super::Bench;
use std::io::Write;

pub(super) const YAML: &str = "image: grid.pgm\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\noccupied_thresh: 0.65\nfree_thresh: 0.196\nnegate: 0\n";
const ENDS: &str = "--start 1,1 --target 5,3";

fn graymap(width: usize, height: usize) -> Vec<u8> {
    let mut bytes = format!("P5\n{width} {height}\n255\n").into_bytes();
    // obstacles on a grid
    let is_obstacle = |x: usize, y: usize| x % 500 > 480 && y % 500 > 480;
    bytes.extend((0..width * height).map(|i| if is_obstacle(i % width, i / width) { 0 } else { 254 }));
    bytes
}

/// A PNG of equal pixels with 16 bits for each of four channels: a small file.
fn equal_pixels(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Sixteen);
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header().unwrap();
    let mut rows = writer.stream_writer().unwrap();
    let row = vec![0xff; 8 * width as usize];
    (0..height).for_each(|_| rows.write_all(&row).unwrap());
    rows.finish().unwrap();
    drop(writer);
    bytes
}

/// The same PNG that says it has a row more.
fn taller(mut image: Vec<u8>) -> Vec<u8> {
    // signature, length of the header, then `IHDR`, width, height, 5 more bytes, and the checksum of these
    image[20..24].copy_from_slice(&8193_u32.to_be_bytes());
    let sum = crc32fast::hash(&image[12..29]);
    image[29..33].copy_from_slice(&sum.to_be_bytes());
    image
}

pub(super) fn line(file: &str) -> String {
    format!("world {file} {ENDS}")
}

pub(super) fn grids(bench: Bench) {
    bench.write("grid.pgm", graymap(200, 200));
    bench.write("m.yaml", bench.filled(YAML, "# x\n"));
    bench.reads(&line("m.yaml"));
    bench.write("m.yaml", bench.filled(YAML, "# x\n") + "\n");
    bench.refuses(&line("m.yaml"), &bench.too_long());
    for piece in ["[", "{a: ", "- ", "a: &a [*a]\n", "? ", "a: &b\n", "!!a ", "\"", "- - - - "] {
        bench.write("m.yaml", bench.filled("", piece));
        bench.refuses(&line("m.yaml"), "m.yaml");
    }
}

pub(super) fn images(bench: Bench) {
    bench.write("m.yaml", YAML);
    bench.write("grid.pgm", graymap(8192, 8192));
    bench.reads(&line("m.yaml"));
    // plain, with white space up to the length
    let plain = format!("P2\n4000 4000\n255\n{}", "254\n".repeat(16_000_000));
    bench.write("grid.pgm", bench.filled(&plain, "\n"));
    bench.reads(&line("m.yaml"));
    bench.write("grid.pgm", bench.filled(&plain, "\n") + "\n");
    bench.refuses(&line("m.yaml"), &bench.too_long());
    let pixels = equal_pixels(8192, 8192);
    bench.write("grid.pgm", &pixels);
    bench.reads(&line("m.yaml"));
    for image in [taller(pixels), graymap(8192, 8193)] {
        bench.write("grid.pgm", image);
        bench.refuses(&line("m.yaml"), "has 8192 x 8193 pixels; a map has at most 67108864");
    }
}

pub(super) fn plans(bench: Bench) {
    let plan = |before: &str, rings: &str| {
        let head = format!("{{{before}\"type\":\"FeatureCollection\",\"features\":[");
        let feature =
            "{\"type\":\"Feature\",\"properties\":{},\"geometry\":{\"type\":\"Polygon\",\"coordinates\":[[";
        format!("{head}{feature}{rings}]]}}}}]}}")
    };
    let square = "[20,20],[21,20],[21,21],[20,21],[20,20]";
    // other members, which the parser keeps
    for piece in ["[],", "{},", "0,", "\"\","] {
        let room = bench.longest() - plan("\"x\":[0],", square).len();
        let others = format!("\"x\":[{}0],", piece.repeat(room / piece.len()));
        bench.write("p.geojson", plan(&others, square));
        bench.reads(&line("p.geojson"));
    }
    let corner = |i: usize| {
        let (sine, cosine) = cocarry::math::sin_cos(std::f64::consts::TAU * i as f64 / 19_000.0);
        format!("[{:.4},{:.4}],", 200.0 + 90.0 * cosine, 200.0 + 90.0 * sine)
    };
    let round: String = (0..19_000).map(corner).collect();
    bench.write("p.geojson", bench.filled(&plan("", &(round + &corner(0)[..corner(0).len() - 1])), "\n"));
    bench.reads(&line("p.geojson"));
    bench.write("p.geojson", bench.filled(&plan("", square), "\n") + "\n");
    bench.refuses(&line("p.geojson"), &bench.too_long());
    for piece in ["[", "{\"a\":", "\"", "[[],[],", "-"] {
        bench.write("p.geojson", bench.filled("", piece));
        bench.refuses(&line("p.geojson"), "p.geojson");
    }
}

pub(super) fn drawings(bench: Bench) {
    let drawing = |inside: &str| {
        format!(
            "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 60 40' width='6000' height='4000'><rect x='20' y='20' width='1' height='1'/>{inside}</svg>"
        )
    };
    for piece in
        ["<!-- -->", "<g/>", "<rect width='0' height='0'/>", "<g transform='scale(1)' a='' b='' c='' d=''/>"]
    {
        let count = ((bench.longest() - 300) / piece.len()).min(190_000);
        bench.write("d.svg", bench.filled(&drawing(&piece.repeat(count)), "\n"));
        bench.reads(&line("d.svg"));
    }
    // one path, of as many corners as fit: it is refused for them
    let corners: String = (0..1_000_000).map(|i| format!("{} {} ", i % 50, i % 37)).collect();
    bench.write("d.svg", bench.filled(&drawing(&format!("<path d='M{corners}'/>")), "\n"));
    bench.refuses(&line("d.svg"), "corners");
    bench.write("d.svg", bench.filled(&drawing(""), "\n") + "\n");
    bench.refuses(&line("d.svg"), &bench.too_long());
    for piece in ["<g>", "<svg>", "&lt;", "<a b='", "<use href='#a'/>"] {
        bench.write("d.svg", bench.filled("<svg xmlns='http://www.w3.org/2000/svg' id='a'>", piece));
        bench.refuses(&line("d.svg"), "d.svg");
    }
}
