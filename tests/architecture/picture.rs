//! The picture of the floors in a document.
//!
//! Under the heading `## Floors` stands a fenced block for the rooms of the package, under `## Inside NAME` one for
//! what lies within the room `NAME`. Each line of a block is a floor, the top one first: names with one space between
//! them, two spaces or more, and what they are for.

use std::collections::BTreeSet;

/// The floors of one block.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Picture {
    /// The room that is drawn; empty for the whole package.
    pub(crate) inside: String,
    pub(crate) floors: Vec<Vec<String>>,
}

impl Picture {
    /// How far down `room` is: 0 on the top floor.
    pub(crate) fn floor(&self, room: &str) -> Option<usize> {
        self.floors.iter().position(|floor| floor.iter().any(|name| name == room))
    }

    /// All that is drawn.
    pub(crate) fn rooms(&self) -> BTreeSet<&str> {
        self.floors.iter().flatten().map(String::as_str).collect()
    }
}

/// The pictures that `document` draws.
pub(crate) fn pictures(document: &str) -> Result<Vec<Picture>, String> {
    let mut pictures = Vec::new();
    let mut lines = document.lines();
    let mut inside = None;
    while let Some(line) = lines.next() {
        let block = line.starts_with("```");
        if let Some(heading) = line.strip_prefix("## ") {
            inside = if heading == "Floors" { Some("") } else { heading.strip_prefix("Inside ") };
        } else if block && let Some(inside) = inside.take() {
            let drawn = lines.by_ref().take_while(|line| *line != "```");
            pictures.push(picture(inside, drawn)?);
        } else if block {
            lines.by_ref().take_while(|line| *line != "```").for_each(drop);
        }
    }
    Ok(pictures)
}

fn picture<'a>(inside: &str, lines: impl Iterator<Item = &'a str>) -> Result<Picture, String> {
    let floors = lines.map(floor).collect::<Result<Vec<_>, _>>()?;
    let picture = Picture { inside: inside.to_owned(), floors };
    if picture.floors.is_empty() || picture.rooms().len() < picture.floors.iter().flatten().count() {
        return Err(format!("the picture {inside:?} draws nothing, or a room twice"));
    }
    Ok(picture)
}

fn floor(line: &str) -> Result<Vec<String>, String> {
    let (names, what) = line.split_once("  ").ok_or_else(|| format!("no two spaces and no description: {line:?}"))?;
    let names: Vec<_> = names.split(' ').map(str::to_owned).collect();
    let word = |name: &String| !name.is_empty() && name.chars().all(|c| c == '_' || c.is_ascii_alphanumeric());
    if what.trim().is_empty() || !names.iter().all(word) {
        return Err(format!("not names, two spaces and a description: {line:?}"));
    }
    Ok(names)
}
