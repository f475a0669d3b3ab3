//! As much XML as calibration data needs: elements, texts, comments; attributes are skipped.

use crate::import::error::TextFault;

/// An element with its children and the text directly in it.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct XmlElement {
    pub(crate) name: String,
    pub(crate) text: String,
    pub(crate) children: Vec<XmlElement>,
}

/// Nesting that is read: more than any calibration file has.
const DEEPEST: usize = 64;

impl XmlElement {
    /// The document's elements under one without a name.
    pub(crate) fn parse(text: &str) -> Result<Self, TextFault> {
        let mut open = vec![Self::default()];
        let mut rest = text;
        let line = |rest: &str| 1 + text[..text.len() - rest.len()].matches('\n').count() as u64;
        while let Some(start) = rest.find('<') {
            if let Some(element) = open.last_mut() {
                element.text.push_str(rest[..start].trim());
            }
            rest = &rest[start..];
            let (end, skipped) = match rest {
                comment if comment.starts_with("<!--") => ("-->", true),
                other => (">", other.starts_with("<?") || other.starts_with("<!")),
            };
            let length = rest.find(end).ok_or_else(|| TextFault::at(line(rest), "a tag is not closed"))?;
            let tag = &rest[1..length];
            if skipped {
                rest = &rest[length + end.len()..];
                continue;
            }
            if let Some(name) = tag.strip_prefix('/') {
                let closed = open.pop().filter(|e| e.name == name.trim() && !open.is_empty());
                let closed = closed.ok_or_else(|| TextFault::at(line(rest), format!("</{}> closes nothing", name.trim())))?;
                if let Some(parent) = open.last_mut() {
                    parent.children.push(closed);
                }
            } else {
                let alone = tag.ends_with('/');
                let name = tag.trim_end_matches('/').split_whitespace().next().unwrap_or_default().to_owned();
                let element = Self { name, ..Self::default() };
                if open.len() > DEEPEST {
                    return Err(TextFault::at(line(rest), "elements are nested too deeply"));
                }
                match open.last_mut() {
                    Some(parent) if alone => parent.children.push(element),
                    _ => open.push(element),
                }
            }
            rest = &rest[length + 1..];
        }
        match (open.pop(), open.is_empty()) {
            (Some(root), true) => Ok(root),
            (Some(unclosed), false) => Err(TextFault::whole(format!("<{}> is not closed", unclosed.name))),
            (None, _) => Err(TextFault::whole("it is empty")),
        }
    }

    /// The first child of that name.
    pub(crate) fn child(&self, name: &str) -> Option<&Self> {
        self.children.iter().find(|c| c.name == name)
    }

    /// All elements of that name, at any depth.
    pub(crate) fn all<'a>(&'a self, name: &str, found: &mut Vec<&'a Self>) {
        for child in &self.children {
            if child.name == name {
                found.push(child);
            }
            child.all(name, found);
        }
    }
}
