//! The report as one page that needs nothing else.

use base64::prelude::{BASE64_STANDARD, Engine as _};
use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::{Block, Cell, Chapter, Report, Tone};

const STYLE: &str = include_str!("style.css");

impl Report {
    /// The report as HTML: styles, charts and pictures inside, no script.
    #[must_use]
    pub fn html(&self) -> String {
        html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    title { (self.title) }
                    style { (PreEscaped(STYLE)) }
                }
                body {
                    header {
                        h1 { (self.title) }
                        dl { @for (name, value) in &self.facts { dt { (name) } dd { (value) } } }
                        nav { ol {
                            @for chapter in &self.chapters {
                                li { a href={ "#" (chapter.name) } { (chapter.title) } }
                            }
                        } }
                    }
                    main { @for chapter in &self.chapters { (section(chapter)) } }
                }
            }
        }
        .into_string()
    }
}

fn section(chapter: &Chapter) -> Markup {
    html! {
        section id=(chapter.name) {
            h2 { (chapter.title) }
            @for part in &chapter.blocks { (block(part)) }
        }
    }
}

fn block(block: &Block) -> Markup {
    html! {
        @match block {
            Block::Heading(text) => h3 { (text) },
            Block::Text(text) => p { (text) },
            Block::Table { caption, header, rows } => div.wide {
                table {
                    caption { (caption) }
                    thead { tr { @for name in header { th { (name) } } } }
                    tbody { @for row in rows { tr { @for one in row { (cell(one)) } } } }
                }
            },
            Block::Chart { caption, svg } => figure {
                (PreEscaped(svg))
                figcaption { (caption) }
            },
            Block::Picture { caption, png } => figure {
                img alt=(caption) src={ "data:image/png;base64," (BASE64_STANDARD.encode(png)) };
                figcaption { (caption) }
            },
        }
    }
}

fn cell(cell: &Cell) -> Markup {
    let class = match cell.tone {
        Tone::Plain => None,
        Tone::Good => Some("good"),
        Tone::Bad => Some("bad"),
        Tone::Quiet => Some("quiet"),
    };
    html! { td class=[class] { (cell.text) } }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_escaped_and_what_is_drawn_is_inside() {
        let mut chapter = Chapter::new("table", "BL < BN");
        chapter.text("a & b");
        chapter.table("means", &["BL"], vec![vec![Cell::new("1 < 2", Tone::Bad)]]);
        chapter.chart("a chart", "<svg><g/></svg>".to_owned());
        chapter.picture("a picture", vec![0, 0, 0]);
        let report = Report { title: "trees".into(), facts: vec![], chapters: vec![chapter] };
        let page = report.html();
        for part in [
            "<h2>BL &lt; BN</h2>",
            "<p>a &amp; b</p>",
            "<td class=\"bad\">1 &lt; 2</td>",
            "<svg><g/></svg>",
            "src=\"data:image/png;base64,AAAA\"",
            "<a href=\"#table\">",
        ] {
            assert!(page.contains(part), "{part} in {page}");
        }
        assert!(!page.contains("http"), "the page asks for nothing from elsewhere");
    }
}
