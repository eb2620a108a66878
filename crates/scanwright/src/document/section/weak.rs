use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

use super::super::number::counted;
use super::super::page::{Block, Level, PlaceCard, Reference, Section};
use super::super::part::{Part, Sufficiency};
use super::super::pictures::Pictures;
use super::{references, spoken};

/// A place where the result rests on little, and what would help.
#[derive(Debug, Clone)]
pub struct WeakPlace {
    /// The region; `None` for what belongs to no region.
    pub id: Option<u32>,
    pub level: Level,
    pub reasons: Vec<String>,
    pub advice: Vec<String>,
    weaknesses: BTreeSet<Weakness>,
}

/// What is weak about a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Weakness {
    /// A face, or part of one, that nobody saw.
    Unseen,
    /// A face that was made up: no region of the scan stands behind it.
    Invented,
    /// A dimension of it is a guess.
    Guess,
    /// Its sizes are known less well than was asked.
    Insufficient,
}

impl WeakPlace {
    fn new(id: Option<u32>) -> Self {
        Self { id, level: Level::Look, reasons: Vec::new(), advice: Vec::new(), weaknesses: BTreeSet::new() }
    }

    /// Whether this is weak about it.
    pub fn has(&self, weakness: Weakness) -> bool {
        self.weaknesses.contains(&weakness)
    }

    fn add(&mut self, reason: String, advice: &str) {
        if !self.reasons.contains(&reason) {
            self.reasons.push(reason);
        }
        if !self.advice.iter().any(|a| a == advice) {
            self.advice.push(advice.to_owned());
        }
    }

    /// What belongs to no region and what nobody saw come first, then what has the most reasons.
    fn rank(&self) -> (usize, Reverse<usize>, Option<u32>) {
        let class = match (self.id, self.has(Weakness::Invented), self.has(Weakness::Unseen)) {
            (None, ..) => 0,
            (_, true, _) => 1,
            (_, _, true) => 2,
            _ => 3,
        };
        (class, Reverse(self.reasons.len()), self.id)
    }
}

/// Codes of warnings about a region that more scanning could mend.
const MENDABLE: [(&str, &str, &str); 4] = [
    ("W_ASSUMED_FACE", "not seen", "scan it from where the scanner reaches it"),
    ("W_FREEFORM", "no analytic surface", "scan it again more densely, or accept a freeform face"),
    ("W_FACETS", "no sound face", "scan it again more densely, with its borders"),
    ("W_FACE_DROPPED", "no face", "scan it again more densely"),
];

/// All weak places, the worst first.
pub fn weak_places(part: &Part) -> Vec<WeakPlace> {
    let mut places: BTreeMap<u32, WeakPlace> = BTreeMap::new();
    let mut at = |id: u32, reason: String, advice: &str, weakness: Option<Weakness>| {
        let place = places.entry(id).or_insert_with(|| WeakPlace::new(Some(id)));
        place.add(reason, advice);
        place.weaknesses.extend(weakness);
        if part.primitive(id).is_none() {
            place.weaknesses.insert(Weakness::Invented);
        }
    };
    for (code, word, advice) in MENDABLE {
        for warning in part.warnings_of(code) {
            let Some(id) = warning.primitive else { continue };
            let unseen = (code == "W_ASSUMED_FACE").then_some(Weakness::Unseen);
            at(id, format!("{word}: {}", warning.text), advice, unseen);
        }
    }
    for primitive in &part.primitives {
        if let Some(why) = &primitive.ambiguous {
            at(primitive.id, format!("type not certain: {why}"), "scan more of its arc or length", None);
        }
        if let Some(Sufficiency { uncertainty, missing: Some(missing) }) = &primitive.sufficiency {
            let within = super::super::number::short(*uncertainty);
            let reason = format!("sizes known within {within} {} only", part.unit());
            let advice = match (missing.arc, missing.points) {
                (Some(arc), _) => format!("scan about {:.0}° more of its arc", arc.to_degrees()),
                (None, Some(times)) => format!("about {times:.0} times as many points are needed"),
                (None, None) => "more of it must be seen".to_owned(),
            };
            at(primitive.id, reason, &advice, Some(Weakness::Insufficient));
        }
    }
    for dimension in part.dimensions.iter().flatten() {
        let Some(why) = &dimension.guess else { continue };
        for &id in &dimension.of {
            let reason = format!("{} is a guess: {why}", spoken(&dimension.kind));
            at(id, reason, "scan more of it", Some(Weakness::Guess));
        }
    }
    let mut places: Vec<WeakPlace> = places.into_values().collect();
    for warning in part.warnings_of("W_UNEXPLAINED") {
        let mut place = WeakPlace::new(None);
        place.add(warning.text.clone(), "scan it again, or see whether it is part of the part");
        places.push(place);
    }
    places.sort_by_key(WeakPlace::rank);
    places
}

/// "Scan here again".
pub fn section(part: &Part, places: &[WeakPlace], pictures: &Pictures) -> Section {
    if places.is_empty() {
        let text = "No place was found where more scanning is called for.".to_owned();
        return Section { title: "Scan here again", anchor: "weak", blocks: vec![Block::Text(text)] };
    }
    let card = |(k, place): (usize, &WeakPlace)| PlaceCard {
        title: match place.id {
            Some(id) => references(part, &[id]).remove(0),
            None => Reference { id: 0, name: "outside all regions".to_owned(), listed: false },
        },
        level: place.level,
        reasons: place.reasons.clone(),
        advice: place.advice.clone(),
        figure: pictures.weak.get(k).cloned().flatten(),
    };
    let cards: Vec<PlaceCard> = places.iter().enumerate().map(card).collect();
    let n_shown = cards.iter().filter(|card| card.figure.is_some()).count();
    let mut blocks = Vec::new();
    let shown = if n_shown == 0 {
        String::new()
    } else {
        " The place is marked in magenta, shining through what hides it, seen from where most of it is visible.".to_owned()
    };
    blocks.push(Block::Text(format!("{}, what nobody saw first.{shown}", counted(places.len(), "place"))));
    if let Some(missing) = pictures.missing.as_ref().filter(|_| n_shown == 0) {
        blocks.push(Block::Text(missing.clone()));
    }
    if n_shown > 0 && n_shown < cards.len() {
        let text = format!(
            "{} without a picture: no face of the part or triangle of the scan could be found for them, or they come \
             after the first {}.",
            counted(cards.len() - n_shown, "place"),
            super::super::pictures::MOST_PLACES
        );
        blocks.push(Block::Text(text));
    }
    blocks.push(Block::Places(cards));
    Section { title: "Scan here again", anchor: "weak", blocks }
}
