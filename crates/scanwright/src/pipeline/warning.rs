use crate::brep::close::{AssumedFace, Assumption, OpenHole};
use crate::brep::{Issue, IssueCode};
use crate::condition::Support;
use crate::mesh::Mesh;
use crate::segment::{RegionId, Segmentation};

/// What a [`Warning`] is about. The names are stable and documented in `docs/output.md`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[non_exhaustive]
pub enum Code {
    /// Lengths were taken as millimetres because nothing said otherwise.
    #[serde(rename = "W_UNITS_ASSUMED")]
    UnitsAssumed,
    /// A supporting table was recognized and taken away.
    #[serde(rename = "W_SUPPORT_REMOVED")]
    SupportRemoved,
    /// More than one type of surface describes a region about equally well.
    #[serde(rename = "W_AMBIGUOUS_TYPE")]
    AmbiguousType,
    /// A region that no analytic surface describes.
    #[serde(rename = "W_FREEFORM")]
    Freeform,
    /// Part of a region became flat faces, one per triangle.
    #[serde(rename = "W_FACETS")]
    Facets,
    /// Triangles of the part that belong to no region.
    #[serde(rename = "W_UNEXPLAINED")]
    Unexplained,
    /// A face was invented where the scan saw nothing.
    #[serde(rename = "W_ASSUMED_FACE")]
    AssumedFace,
    /// A region became no face: its neighbours were extended over it.
    #[serde(rename = "W_FACE_DROPPED")]
    FaceDropped,
    /// A face that no region was found for was put between two others.
    #[serde(rename = "W_FACE_ADDED")]
    FaceAdded,
    /// An edge or corner lies off its surfaces by more than the tolerance.
    #[serde(rename = "W_GAP")]
    Gap,
    /// A solid could not be closed.
    #[serde(rename = "W_OPEN")]
    Open,
    /// Our own check refused something about a solid.
    #[serde(rename = "W_INVALID")]
    Invalid,
    /// No solid was made.
    #[serde(rename = "W_NO_SOLID")]
    NoSolid,
}

impl Code {
    /// All codes.
    pub const ALL: [Self; 13] = [
        Self::UnitsAssumed,
        Self::SupportRemoved,
        Self::AmbiguousType,
        Self::Freeform,
        Self::Facets,
        Self::Unexplained,
        Self::AssumedFace,
        Self::FaceDropped,
        Self::FaceAdded,
        Self::Gap,
        Self::Open,
        Self::Invalid,
        Self::NoSolid,
    ];

    /// The stable name.
    pub fn name(self) -> &'static str {
        match self {
            Self::UnitsAssumed => "W_UNITS_ASSUMED",
            Self::SupportRemoved => "W_SUPPORT_REMOVED",
            Self::AmbiguousType => "W_AMBIGUOUS_TYPE",
            Self::Freeform => "W_FREEFORM",
            Self::Facets => "W_FACETS",
            Self::Unexplained => "W_UNEXPLAINED",
            Self::AssumedFace => "W_ASSUMED_FACE",
            Self::FaceDropped => "W_FACE_DROPPED",
            Self::FaceAdded => "W_FACE_ADDED",
            Self::Gap => "W_GAP",
            Self::Open => "W_OPEN",
            Self::Invalid => "W_INVALID",
            Self::NoSolid => "W_NO_SOLID",
        }
    }

    /// The kind of fallback this warning stands for, if it is one.
    pub fn fallback(self) -> Option<Fallback> {
        match self {
            Self::Freeform => Some(Fallback::Freeform),
            Self::Facets => Some(Fallback::Facets),
            Self::Open | Self::Invalid | Self::NoSolid => Some(Fallback::Open),
            Self::UnitsAssumed
            | Self::SupportRemoved
            | Self::AmbiguousType
            | Self::Unexplained
            | Self::AssumedFace
            | Self::FaceDropped
            | Self::FaceAdded
            | Self::Gap => None,
        }
    }
}

/// Less than a closed solid of analytic faces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Fallback {
    /// A shell that is not closed, or no solid.
    Open,
    /// A face without an analytic surface.
    Freeform,
    /// Flat faces, one per triangle of the scan.
    Facets,
}

impl Fallback {
    /// Name for people and the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Freeform => "freeform",
            Self::Facets => "facets",
        }
    }
}

/// Something the user should know about the result.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Warning {
    /// What it is about.
    pub code: Code,
    /// The region concerned, if it is one.
    #[serde(rename = "primitive")]
    pub region: Option<RegionId>,
    /// One sentence.
    pub text: String,
}

impl Warning {
    /// A warning about the whole result.
    pub fn new(code: Code, text: impl Into<String>) -> Self {
        Self { code, region: None, text: text.into() }
    }

    /// A warning about one region.
    pub fn about(code: Code, region: RegionId, text: impl Into<String>) -> Self {
        Self { code, region: Some(region), text: text.into() }
    }
}

/// Share of the part's area in no region above which it is worth a warning: junk and rounding along edges stay below.
const UNEXPLAINED_SHARE: f64 = 0.005;

/// What there is to say about the regions.
pub(super) fn of_segmentation(
    mesh: &Mesh,
    segmentation: &Segmentation,
    support: Option<&Support>,
) -> Vec<Warning> {
    let mut warnings = Vec::new();
    if let Some(support) = support {
        let n_table = support.on_table.iter().filter(|on| **on).count();
        let text = format!("a supporting table was taken away ({n_table} triangles)");
        warnings.push(Warning::new(Code::SupportRemoved, text));
    }
    for (i, primitive) in segmentation.primitives.iter().enumerate() {
        let region = RegionId(i as u32);
        if primitive.surface.is_none() {
            let text = "no plane, cylinder, cone, sphere or torus describes it";
            warnings.push(Warning::about(Code::Freeform, region, text));
        }
        if let Some(why) = &primitive.ambiguous {
            warnings.push(Warning::about(Code::AmbiguousType, region, why.clone()));
        }
    }
    warnings.extend(unexplained(mesh, segmentation, support));
    warnings
}

fn unexplained(mesh: &Mesh, segmentation: &Segmentation, support: Option<&Support>) -> Option<Warning> {
    let (mut part, mut without) = (0.0, 0.0);
    for (t, label) in segmentation.labels.iter().enumerate() {
        if support.is_some_and(|s| s.on_table[t]) {
            continue;
        }
        part += mesh.area(t);
        if label.is_none() {
            without += mesh.area(t);
        }
    }
    let share = if part > 0.0 { without / part } else { 0.0 };
    let text = || format!("{:.1} % of the part's area belongs to no surface", 100.0 * share);
    (share > UNEXPLAINED_SHARE).then(|| Warning::new(Code::Unexplained, text()))
}

/// What closing the scan's holes assumed, and what it left open.
pub(super) fn of_closing(assumed: &[AssumedFace], open: &[OpenHole]) -> Vec<Warning> {
    let of_face = |face: &AssumedFace| {
        let text = match face.assumption {
            Assumption::Extended => "extended into what the scanner did not see",
            Assumption::Support => "the bottom on the table, which the scanner did not see",
            Assumption::Cap => "a flat end that nothing shows",
        };
        Warning::about(Code::AssumedFace, face.region, text)
    };
    let of_hole = |hole: &OpenHole| {
        let text = format!("a hole with {} edges was left open: {}", hole.rim.len(), hole.reason);
        Warning::new(Code::Open, text)
    };
    assumed.iter().map(of_face).chain(open.iter().map(of_hole)).collect()
}

/// What could not be built as asked. Failed checks are reported with the solid that failed them.
pub(super) fn of_issue(issue: &Issue) -> Warning {
    let code = match issue.code {
        IssueCode::Empty => Code::NoSolid,
        IssueCode::OpenShell => Code::Open,
        IssueCode::FaceDropped => Code::FaceDropped,
        IssueCode::FaceAdded => Code::FaceAdded,
        IssueCode::CornerOff | IssueCode::GapLarge => Code::Gap,
        IssueCode::Freeform => Code::Freeform,
        IssueCode::Facets => Code::Facets,
    };
    Warning { code, region: issue.region, text: issue.message.clone() }
}

/// Both lists after each other; of two warnings about one region and code only the later, which knows more.
pub(super) fn without_repeats(mut earlier: Vec<Warning>, later: Vec<Warning>) -> Vec<Warning> {
    let said =
        |w: &Warning| later.iter().any(|l| l.code == w.code && l.region.is_some() && l.region == w.region);
    earlier.retain(|warning| !said(warning));
    earlier.extend(later);
    earlier
}
