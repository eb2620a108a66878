//! What a document is made of, whatever it is written as.

/// How good or bad news is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// As it should be.
    Good,
    /// To be looked at before the result is used.
    Look,
    /// Not what was asked for.
    Bad,
}

impl Level {
    /// One word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Good => "ok",
            Self::Look => "look",
            Self::Bad => "fails",
        }
    }
}

/// A document: a title and sections.
#[derive(Debug, Clone)]
pub struct Document {
    pub(super) title: String,
    /// What kind of document, of what and by what; one line.
    pub(super) subtitle: String,
    pub(super) sections: Vec<Section>,
}

#[derive(Debug, Clone)]
pub(super) struct Section {
    pub title: &'static str,
    /// Short name in addresses.
    pub anchor: &'static str,
    pub blocks: Vec<Block>,
}

#[derive(Debug, Clone)]
pub(super) enum Block {
    Heading(String),
    /// Our own words, in which backticks mean code.
    Text(String),
    /// Words of others, one line each.
    List(Vec<String>),
    Verdict(Verdict),
    Table(Table),
    Figures(Figures),
    Chart(Chart),
    Places(Vec<PlaceCard>),
}

/// The whole in one glance.
#[derive(Debug, Clone)]
pub(super) struct Verdict {
    pub level: Level,
    pub headline: String,
    pub facts: Vec<Fact>,
    pub points: Vec<Point>,
}

#[derive(Debug, Clone)]
pub(super) struct Fact {
    pub label: &'static str,
    pub value: String,
    pub remark: String,
    pub level: Option<Level>,
}

/// Something to know before the result is used.
#[derive(Debug, Clone)]
pub(super) struct Point {
    pub level: Level,
    pub text: String,
    pub regions: Vec<Reference>,
}

/// A region by its name; in HTML it leads to the region's row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Reference {
    pub id: u32,
    pub name: String,
    /// Whether the region has a row to lead to.
    pub listed: bool,
}

#[derive(Debug, Clone)]
pub(super) struct Table {
    /// First cell of its rows in CSV.
    pub name: &'static str,
    pub columns: Vec<Column>,
    pub rows: Vec<Row>,
    /// Said when there are no rows.
    pub empty: String,
}

#[derive(Debug, Clone)]
pub(super) struct Column {
    pub head: &'static str,
    pub unit: Option<String>,
    /// Whether its cells are numbers, set by their right end.
    pub number: bool,
}

impl Column {
    pub fn words(head: &'static str) -> Self {
        Self { head, unit: None, number: false }
    }

    pub fn number(head: &'static str, unit: &str) -> Self {
        let unit = if unit.is_empty() { None } else { Some(unit.to_owned()) };
        Self { head, unit, number: true }
    }

    /// Head and unit.
    pub fn title(&self) -> String {
        self.unit.as_ref().map_or_else(|| self.head.to_owned(), |unit| format!("{} ({unit})", self.head))
    }
}

#[derive(Debug, Clone)]
pub(super) struct Row {
    pub cells: Vec<Cell>,
    /// Shown at the row's start unless it is as it should be.
    pub level: Option<Level>,
    /// The region that the row is the row of.
    pub region: Option<u32>,
}

impl Row {
    pub fn new(cells: Vec<Cell>) -> Self {
        Self { cells, level: None, region: None }
    }
}

#[derive(Debug, Clone)]
pub(super) enum Cell {
    Text(String),
    Regions(Vec<Reference>),
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl Cell {
    /// Its text without links.
    pub fn text(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Regions(regions) => names(regions),
        }
    }
}

/// Names of regions, one after the other.
pub(super) fn names(regions: &[Reference]) -> String {
    regions.iter().map(|region| region.name.as_str()).collect::<Vec<_>>().join(", ")
}

/// Pictures in a grid.
#[derive(Debug, Clone)]
#[allow(clippy::struct_field_names, reason = "figures are what it holds")]
pub(super) struct Figures {
    pub columns: usize,
    pub figures: Vec<Figure>,
    /// Colors and what they mean.
    pub legend: Vec<(String, String)>,
}

#[derive(Debug, Clone)]
pub(super) struct Figure {
    pub png: Vec<u8>,
    pub size: (usize, usize),
    pub caption: String,
    /// What the picture shows, for those who do not see it.
    pub alt: String,
}

/// A histogram on a scale of colors, as SVG.
#[derive(Debug, Clone)]
pub(super) struct Chart {
    pub svg: String,
    pub caption: String,
}

/// A place that is weak.
#[derive(Debug, Clone)]
pub(super) struct PlaceCard {
    pub title: Reference,
    pub level: Level,
    pub reasons: Vec<String>,
    /// What would help.
    pub advice: Vec<String>,
    pub figure: Option<Figure>,
}
