//! Pictures as PDF files of one page: paths with plain colours, as vectors.

use super::Width;
use cocarry::Error;
use pdf_writer::types::{LineCapStyle, LineJoinStyle};
use pdf_writer::{Content, Pdf, Rect, Ref};
use resvg::tiny_skia::{LineCap, LineJoin, PathSegment, Transform};
use resvg::usvg::{Color, FillRule, Group, Node, Options, Paint, Path, Tree};

/// A picture whose letters are outlines as a PDF file of this width. Equal pictures give equal bytes.
///
/// # Errors
/// The picture has something other than paths with plain, opaque colours.
pub fn pdf(svg: &str, width: Width) -> Result<Vec<u8>, Error> {
    let tree = Tree::from_str(svg, &Options::default()).map_err(|error| refused(&error.to_string()))?;
    let scale = width.points() as f32 / tree.size().width();
    let height = scale * tree.size().height();
    let mut content = Content::new();
    // the y axis of a page points upward
    content.transform([scale, 0.0, 0.0, -scale, 0.0, height]);
    draw(tree.root(), &mut content)?;
    let mut file = Pdf::new();
    let [catalog, pages, page, drawing] = [1, 2, 3, 4].map(Ref::new);
    file.catalog(catalog).pages(pages);
    file.pages(pages).kids([page]).count(1);
    let media = Rect::new(0.0, 0.0, width.points() as f32, height);
    file.page(page).parent(pages).media_box(media).contents(drawing).resources();
    file.stream(drawing, &content.finish());
    Ok(file.finish())
}

fn refused(what: &str) -> Error {
    Error::new(format!("the picture cannot be written as PDF: {what}"))
}

fn draw(group: &Group, content: &mut Content) -> Result<(), Error> {
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

fn draw_path(path: &Path, content: &mut Content) -> Result<(), Error> {
    let Transform { sx, kx, ky, sy, tx, ty } = path.abs_transform();
    content.save_state().transform([sx, ky, kx, sy, tx, ty]);
    if let Some(fill) = path.fill() {
        let [red, green, blue] = plain(fill.paint(), fill.opacity().get())?;
        content.set_fill_rgb(red, green, blue);
    }
    if let Some(stroke) = path.stroke() {
        let [red, green, blue] = plain(stroke.paint(), stroke.opacity().get())?;
        let line = stroke.to_tiny_skia();
        content.set_stroke_rgb(red, green, blue).set_line_width(line.width).set_miter_limit(line.miter_limit);
        content.set_line_cap(match line.line_cap {
            LineCap::Butt => LineCapStyle::ButtCap,
            LineCap::Round => LineCapStyle::RoundCap,
            LineCap::Square => LineCapStyle::ProjectingSquareCap,
        });
        content.set_line_join(match line.line_join {
            LineJoin::Round => LineJoinStyle::RoundJoin,
            LineJoin::Bevel => LineJoinStyle::BevelJoin,
            LineJoin::Miter | LineJoin::MiterClip => LineJoinStyle::MiterJoin,
        });
        if let Some(dashes) = stroke.dasharray() {
            content.set_dash_pattern(dashes.iter().copied(), stroke.dashoffset());
        }
    }
    let mut last = [0.0; 2];
    for segment in path.data().segments() {
        match segment {
            PathSegment::MoveTo(to) => content.move_to(to.x, to.y),
            PathSegment::LineTo(to) => content.line_to(to.x, to.y),
            PathSegment::QuadTo(by, to) => {
                // a cubic curve whose control points are at two thirds of the way
                let third = |from: f32, by: f32| from + 2.0 / 3.0 * (by - from);
                let [from_x, from_y] = last;
                content.cubic_to(
                    third(from_x, by.x),
                    third(from_y, by.y),
                    third(to.x, by.x),
                    third(to.y, by.y),
                    to.x,
                    to.y,
                )
            }
            PathSegment::CubicTo(a, b, to) => content.cubic_to(a.x, a.y, b.x, b.y, to.x, to.y),
            PathSegment::Close => content.close_path(),
        };
        if let PathSegment::MoveTo(to)
        | PathSegment::LineTo(to)
        | PathSegment::QuadTo(_, to)
        | PathSegment::CubicTo(_, _, to) = segment
        {
            last = [to.x, to.y];
        }
    }
    let even_odd = path.fill().is_some_and(|fill| fill.rule() == FillRule::EvenOdd);
    match (path.fill().is_some(), path.stroke().is_some(), even_odd) {
        (true, true, false) => content.fill_nonzero_and_stroke(),
        (true, true, true) => content.fill_even_odd_and_stroke(),
        (true, false, false) => content.fill_nonzero(),
        (true, false, true) => content.fill_even_odd(),
        (false, true, _) => content.stroke(),
        (false, false, _) => content.end_path(),
    };
    content.restore_state();
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

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str =
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"2in\" height=\"1in\" viewBox=\"0 0 200 100\">";

    #[test]
    fn closed_form_a_page_has_the_size_and_the_paths_of_the_picture() {
        let svg = format!("{HEAD}<path fill=\"#ff0000\" d=\"M0 0H100V50Z\"/></svg>");
        let file = pdf(&svg, Width::Inches(3.5)).unwrap();
        let words = String::from_utf8_lossy(&file).split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.contains("/MediaBox [0 0 252 126]"), "{words}");
        // 192 px are 252 pt
        assert!(
            words.contains(
                "1.3125 0 0 -1.3125 0 126 cm q 0.96 0 0 0.96 0 0 cm 1 0 0 rg 0 0 m 100 0 l 100 50 l h f Q"
            ),
            "{words}"
        );
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
