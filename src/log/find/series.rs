//! Series names, as `PlotJuggler` shows them, turned into message paths: `/imu/twist/twist/angular/z` is `/imu/twist.twist.angular.z`.
//!
//! A name does not say where the topic ends. It is cut at each slash, the longest topic that the log has first, and the first cut
//! counts whose rest leads to a value. Two shortcuts: the last field of parallel arrays stands behind the element's name
//! (`/joint_states/front_drive_joint/velocity`), and a message of a single `data` is named by its topic alone. In what may follow
//! an index, `data.3` is `data[3]`.

use crate::log::extract::extractor::Extractor;
use crate::log::file::container::Container;
use crate::log::find::candidates::Candidates;
use crate::log::path::{Compare, Literal, MessagePath, PathStep, Test};
use crate::log::schema::Layout;
use crate::log::value::Raw;

/// Whether `path` can only be a message path: with fields behind the topic, and no slash in their names.
pub(crate) fn is_plain(path: &MessagePath) -> bool {
    !path.steps.is_empty() && !path.steps.iter().any(|step| matches!(step, PathStep::Field(name) if name.contains('/')))
}

/// The path that the series name `name` means in this log, and whether it leads to a value: if none does, the way behind the longest
/// topic. JSON, whose messages need not hold the same fields, is trusted to lead there. `None` when no topic is the beginning of the name.
pub(crate) fn path(name: &MessagePath, container: &Container, candidates: &Candidates<'_>) -> Option<(MessagePath, bool)> {
    let mut first = None;
    for (topic, behind) in cuts(&name.topic) {
        let behind = behind.iter().map(|segment| PathStep::Field((*segment).to_owned()));
        let steps: Vec<PathStep> = behind.chain(name.steps.iter().flat_map(single)).collect();
        let written = (topic == name.topic).then(|| name.steps.clone()); // JSON may have slashes in its names
        for (id, channel) in container.inventory.channels.iter().filter(|(_, channel)| channel.topic == topic) {
            let is_json = channel.message_encoding == "json";
            first.get_or_insert_with(|| {
                let as_written = written.clone().filter(|steps| is_json && !steps.is_empty());
                let way = as_written.unwrap_or_else(|| steps.clone());
                (MessagePath::new(topic.to_owned(), way), is_json && !is_plain(name))
            });
            let schema = container.inventory.schema(channel).map(AsRef::as_ref);
            let Ok(layout) = Layout::parse(&channel.message_encoding, schema) else { continue };
            let sample = candidates.samples.get(id).map(Vec::as_slice);
            let mut ways = written.clone().into_iter().chain([steps.clone()]).chain(parallel(&steps)).chain(alone(&steps));
            if let Some(steps) = ways.find(|steps| Extractor::leads(&layout, steps, sample, |raw| *raw != Raw::Missing)) {
                return Some((MessagePath::new(topic.to_owned(), steps), true));
            }
        }
    }
    first
}

/// Every way to cut `name` at a slash into a topic and the names behind it; the longest topic first.
pub(crate) fn cuts(name: &str) -> impl Iterator<Item = (&str, Vec<&str>)> {
    let ends = std::iter::once(name.len()).chain(name.rmatch_indices('/').map(|(at, _)| at).filter(|at| *at > 0));
    ends.map(|end| (&name[..end], name[end..].split('/').skip(1).collect()))
}

/// A step as single ones: a field's name may hold slashes, and a number as a name is an index.
fn single(step: &PathStep) -> Vec<PathStep> {
    let PathStep::Field(names) = step else { return vec![step.clone()] };
    let step = |name: &str| name.parse().map_or_else(|_| PathStep::Field(name.to_owned()), PathStep::Index);
    names.split('/').map(step).collect()
}

/// `joint/velocity` as the velocity of that joint. The joint's own name may hold slashes.
fn parallel(steps: &[PathStep]) -> Option<Vec<PathStep>> {
    let (PathStep::Field(array), element @ [_, ..]) = steps.split_last()? else { return None };
    let names = element.iter().map(|step| if let PathStep::Field(name) = step { Some(name.as_str()) } else { None });
    let with = Literal::Text(names.collect::<Option<Vec<_>>>()?.join("/"));
    let test = Test { field: vec!["name".into()], compare: Compare::Equal, with };
    Some(vec![PathStep::Field(array.clone()), PathStep::Filter(test)])
}

/// The only value of a message such as `std_msgs/Float64`.
fn alone(steps: &[PathStep]) -> Option<Vec<PathStep>> {
    steps.is_empty().then(|| vec![PathStep::Field("data".into())])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_topic_comes_first() {
        let found: Vec<_> = cuts("/a/b/c").collect();
        assert_eq!(found, [("/a/b/c", vec![]), ("/a/b", vec!["c"]), ("/a", vec!["b", "c"])]);
        assert_eq!(cuts("a").count(), 1);
    }
}
