//! Pictures as PDF files of one page: paths with plain colours, as vectors.

use super::Width;
use cocarry::Error;
use resvg::tiny_skia::{LineCap, LineJoin, PathSegment, Transform};
use resvg::usvg::{Color, FillRule, Group, Node, Options, Paint, Path, Tree};
use std::fmt::Write;

/// A picture whose letters are outlines as a PDF file of this width. Equal pictures give equal bytes.
///
/// # Errors
/// The picture has something other than paths with plain, opaque colours.
pub fn pdf(svg: &str, width: Width) -> Result<Vec<u8>, Error> {
    let tree = Tree::from_str(svg, &Options::default()).map_err(|error| refused(&error.to_string()))?;
    let (breadth, height) = (f64::from(tree.size().width()), f64::from(tree.size().height()));
    let scale = width.points() / breadth;
    // the y axis of a page points upward
    let mut content = format!("{0} 0 0 -{0} 0 {1} cm\n", short(scale), short(scale * height));
    draw(tree.root(), &mut content)?;
    let page = format!("[0 0 {} {}]", short(scale * breadth), short(scale * height));
    let objects = [
        "<< /Type /Catalog /Pages 2 0 R >>".to_owned(),
        "<< /Type /Pages /Kids [3 0 R] /Count 1 >>".to_owned(),
        format!("<< /Type /Page /Parent 2 0 R /MediaBox {page} /Resources << >> /Contents 4 0 R >>"),
        format!("<< /Length {} >>\nstream\n{content}endstream", content.len()),
    ];
    let mut file = String::from("%PDF-1.4\n");
    let mut places = String::new();
    for (number, object) in (1..).zip(&objects) {
        let _ = writeln!(places, "{:010} 00000 n ", file.len());
        let _ = write!(file, "{number} 0 obj\n{object}\nendobj\n");
    }
    let (count, begin) = (objects.len() + 1, file.len());
    let _ = write!(
        file,
        "xref\n0 {count}\n0000000000 65535 f \n{places}trailer\n<< /Size {count} /Root 1 0 R >>\nstartxref\n{begin}\n%%EOF\n"
    );
    Ok(file.into_bytes())
}

fn refused(what: &str) -> Error {
    Error::new(format!("the picture cannot be written as PDF: {what}"))
}

fn draw(group: &Group, content: &mut String) -> Result<(), Error> {
    if group.should_isolate() {
        return Err(refused("it has a group that is transparent, cut or filtered"));
    }
    for node in group.children() {
        match node {
            Node::Group(group) => draw(group, content)?,
            Node::Path(path) if path.is_visible() => draw_path(path, content)?,
            Node::Path(_) => {}
            Node::Image(_) | Node::Text(_) => return Err(refused("it has an image or a text")),
        }
    }
    Ok(())
}

fn draw_path(path: &Path, content: &mut String) -> Result<(), Error> {
    let Transform { sx, kx, ky, sy, tx, ty } = path.abs_transform();
    *content += "q ";
    operator(content, &[sx, ky, kx, sy, tx, ty], "cm");
    if let Some(fill) = path.fill() {
        let [red, green, blue] = plain(fill.paint(), fill.opacity().get())?;
        operator(content, &[red, green, blue], "rg");
    }
    if let Some(stroke) = path.stroke() {
        let [red, green, blue] = plain(stroke.paint(), stroke.opacity().get())?;
        operator(content, &[red, green, blue], "RG");
        operator(content, &[stroke.width().get()], "w");
        operator(content, &[stroke.miterlimit().get()], "M");
        let line = stroke.to_tiny_skia();
        let cap = match line.line_cap {
            LineCap::Butt => 0,
            LineCap::Round => 1,
            LineCap::Square => 2,
        };
        let join = match line.line_join {
            LineJoin::Round => 1,
            LineJoin::Bevel => 2,
            LineJoin::Miter | LineJoin::MiterClip => 0,
        };
        let _ = write!(content, "{cap} J {join} j ");
        if let Some(dashes) = stroke.dasharray() {
            let dashes: Vec<String> = dashes.iter().map(|length| short(f64::from(*length))).collect();
            let _ = write!(content, "[{}] {} d ", dashes.join(" "), short(f64::from(stroke.dashoffset())));
        }
    }
    let mut last = [0.0; 2];
    for segment in path.data().segments() {
        match segment {
            PathSegment::MoveTo(to) => operator(content, &[to.x, to.y], "m"),
            PathSegment::LineTo(to) => operator(content, &[to.x, to.y], "l"),
            PathSegment::QuadTo(by, to) => {
                // a cubic curve whose control points are at two thirds of the way
                let third = |from: f32, by: f32| from + 2.0 / 3.0 * (by - from);
                let points =
                    [third(last[0], by.x), third(last[1], by.y), third(to.x, by.x), third(to.y, by.y)];
                operator(content, &[&points[..], &[to.x, to.y]].concat(), "c");
            }
            PathSegment::CubicTo(a, b, to) => operator(content, &[a.x, a.y, b.x, b.y, to.x, to.y], "c"),
            PathSegment::Close => operator(content, &[], "h"),
        }
        if let PathSegment::MoveTo(to)
        | PathSegment::LineTo(to)
        | PathSegment::QuadTo(_, to)
        | PathSegment::CubicTo(_, _, to) = segment
        {
            last = [to.x, to.y];
        }
    }
    let even_odd = path.fill().is_some_and(|fill| fill.rule() == FillRule::EvenOdd);
    *content += match (path.fill().is_some(), path.stroke().is_some(), even_odd) {
        (true, true, false) => "B",
        (true, true, true) => "B*",
        (true, false, false) => "f",
        (true, false, true) => "f*",
        (false, true, _) => "S",
        (false, false, _) => "n",
    };
    *content += " Q\n";
    Ok(())
}

/// Red, green and blue from 0 to 1.
fn plain(paint: &Paint, opacity: f32) -> Result<[f32; 3], Error> {
    match paint {
        Paint::Color(Color { red, green, blue }) if opacity == 1.0 => {
            Ok([*red, *green, *blue].map(|part| f32::from(part) / 255.0))
        }
        _ => Err(refused("it has a colour that is transparent, a gradient or a pattern")),
    }
}

/// An operator of a page after its numbers.
fn operator(content: &mut String, numbers: &[f32], name: &str) {
    for number in numbers {
        *content += &short(f64::from(*number));
        content.push(' ');
    }
    *content += name;
    content.push(' ');
}

/// A number with at most four decimals; PDF has no exponents.
fn short(number: f64) -> String {
    let text = format!("{number:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str =
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"2in\" height=\"1in\" viewBox=\"0 0 200 100\">";

    #[test]
    fn closed_form_a_page_has_the_size_and_the_paths_of_the_picture() {
        let svg = format!("{HEAD}<path fill=\"#ff0000\" d=\"M0 0H100V50Z\"/></svg>");
        let file = String::from_utf8(pdf(&svg, Width::Inches(3.5)).unwrap()).unwrap();
        assert!(file.contains("/MediaBox [0 0 252 126]"), "{file}");
        // 192 px are 252 pt
        assert!(
            file.contains(
                "1.3125 0 0 -1.3125 0 126 cm\nq 0.96 0 0 0.96 0 0 cm 1 0 0 rg 0 0 m 100 0 l 100 50 l h f Q\n"
            ),
            "{file}"
        );
        let begin = file.find("\nxref\n").unwrap() + 1;
        assert!(file.ends_with(&format!("startxref\n{begin}\n%%EOF\n")));
        for number in 1..=4 {
            let entry = file[begin..].lines().nth(2 + number).unwrap();
            let place: usize = entry[..10].parse().unwrap();
            assert!(file[place..].starts_with(&format!("{number} 0 obj\n")), "{entry}");
        }
    }

    #[test]
    fn what_a_page_would_not_show_is_refused() {
        for spoiled in
            ["<g opacity=\"0.5\"><path d=\"M0 0H9V9Z\"/></g>", "<path fill-opacity=\"0.5\" d=\"M0 0H9V9Z\"/>"]
        {
            let error = pdf(&format!("{HEAD}{spoiled}</svg>"), Width::Inches(3.5)).unwrap_err();
            assert!(error.to_string().starts_with("the picture cannot be written as PDF: "), "{error}");
        }
    }
}
