//! A report: chapters of text, tables, charts and pictures, in one file of HTML.

pub mod chart;
mod html;
pub mod picture;

/// A document of chapters.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// What it is about.
    pub title: String,
    /// What was measured and how, in a few lines.
    pub facts: Vec<(String, String)>,
    /// The chapters, in their order.
    pub chapters: Vec<Chapter>,
}

/// What one experiment showed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Chapter {
    /// Names the chapter in links and files: lower case, no spaces.
    pub name: &'static str,
    /// Its heading.
    pub title: String,
    /// What it says, from top to bottom.
    pub blocks: Vec<Block>,
}

/// A part of a chapter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Block {
    /// A heading within the chapter.
    Heading(String),
    /// A paragraph.
    Text(String),
    /// Rows of cells below a header.
    Table {
        /// What the table shows.
        caption: String,
        /// Names of the columns.
        header: Vec<String>,
        /// Cells, row by row.
        rows: Vec<Vec<Cell>>,
    },
    /// A chart.
    Chart {
        /// What it shows.
        caption: String,
        /// A whole SVG element.
        svg: String,
    },
    /// A picture.
    Picture {
        /// What it shows.
        caption: String,
        /// A PNG file.
        png: Vec<u8>,
    },
}

/// A cell of a table.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Cell {
    /// What it says.
    pub text: String,
    /// How it is to be read.
    pub tone: Tone,
}

/// How a cell is to be read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tone {
    /// A figure like any other.
    #[default]
    Plain,
    /// Within its goal.
    Good,
    /// Outside of its goal.
    Bad,
    /// Not ours: the paper's figure, or a control.
    Quiet,
}

impl Chapter {
    /// A chapter that says nothing yet.
    #[must_use]
    pub fn new(name: &'static str, title: impl Into<String>) -> Self {
        Self { name, title: title.into(), blocks: Vec::new() }
    }

    /// Adds a heading.
    pub fn heading(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Heading(text.into()));
    }

    /// Adds a paragraph.
    pub fn text(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Text(text.into()));
    }

    /// Adds a table.
    pub fn table(&mut self, caption: impl Into<String>, header: &[&str], rows: Vec<Vec<Cell>>) {
        let header = header.iter().map(|&name| name.to_owned()).collect();
        self.blocks.push(Block::Table { caption: caption.into(), header, rows });
    }

    /// Adds a chart.
    pub fn chart(&mut self, caption: impl Into<String>, svg: String) {
        self.blocks.push(Block::Chart { caption: caption.into(), svg });
    }

    /// Adds a picture.
    pub fn picture(&mut self, caption: impl Into<String>, png: Vec<u8>) {
        self.blocks.push(Block::Picture { caption: caption.into(), png });
    }
}

impl Cell {
    /// A cell of this tone.
    #[must_use]
    pub fn new(text: impl Into<String>, tone: Tone) -> Self {
        Self { text: text.into(), tone }
    }
}

impl<T: Into<String>> From<T> for Cell {
    fn from(text: T) -> Self {
        Self::new(text, Tone::Plain)
    }
}
