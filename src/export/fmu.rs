//! The identified plant as functional mock-up units of FMI 2.0 and 3.0 for co-simulation.
//!
//! In: a map's Table 1. Out: one archive per version of the standard, with `modelDescription.xml`, C sources, and a binary for this machine where its
//! C compiler makes one. The C is a port of the plant that `verify` drives: the same torques give the same speeds.
//! Source: *Functional Mock-up Interface Specification* 2.0.4 and 3.0.1, Modelica Association.

mod binary;
mod data;
mod description;
mod variable;
mod zip;

use crate::export::file::File;
use crate::export::{ExportSettings, MapSource, Result, provenance};
use crate::map::sha256_hex;
use crate::sim::WorldSettings;
use binary::{Compiled, compiled};
use data::PlantData;
use description::{Version, token};

const HEADER: &str = include_str!("template/pivot_plant.h.in");
const SOURCE: &str = include_str!("template/pivot_plant.c.in");

/// The two units.
///
/// # Errors
/// A Table 1 without a forward map at the wheel angle.
pub(crate) fn files(source: &MapSource, settings: &ExportSettings) -> Result<Vec<File>> {
    let mut table1 = source.table1.clone();
    table1.vehicle.test_angle_deg = source.table2.vehicle.test_angle_deg;
    let world = WorldSettings::identified(&table1)?;
    let provenance: Vec<_> = provenance::lines(source).iter().map(|line| format!(" * {line}")).collect();
    let data = PlantData::new(&world)?.in_c();
    let [starts, checks] = variable::in_c(table1.vehicle.test_angle());
    let fill = |template: &str, token: &str| {
        template
            .replace("@PROVENANCE@", &provenance.join("\n"))
            .replace("@TOKEN@", token)
            .replace("@REFERENCES@", &variable::references())
            .replace("@STARTS@", &starts)
            .replace("@CHECKS@", &checks)
    };
    Version::ALL
        .into_iter()
        .map(|version| {
            let whole = format!("{data}{SOURCE}{HEADER}{}{}", version.source(), source.table2.generation);
            let token = token(&sha256_hex(whole.as_bytes()));
            let sources = [
                ("pivot_plant_data.h".to_owned(), format!("/*\n{}\n */\n{data}", provenance.join("\n"))),
                ("pivot_plant.h".to_owned(), fill(HEADER, &token)),
                ("pivot_plant.c".to_owned(), fill(SOURCE, &token)),
                (version.source_name().to_owned(), fill(version.source(), &token)),
            ];
            let mut entries = vec![("modelDescription.xml".to_owned(), version.model_description(source, &token).into_bytes())];
            if let Some(build) = version.build_description() {
                entries.push(("sources/buildDescription.xml".to_owned(), build.into_bytes()));
            }
            entries.extend(sources.iter().map(|(name, text)| (format!("sources/{name}"), text.clone().into_bytes())));
            let made = if settings.without_binary { Compiled::None("left out, as asked".to_owned()) } else { compiled(&sources) };
            let note = match made {
                Compiled::Binary { bytes, by } => match version.binary_path() {
                    Some(path) => {
                        entries.push((path.clone(), bytes));
                        format!("{path} by {by}")
                    }
                    None => "sources only: the standard has no name for this platform".to_owned(),
                },
                Compiled::None(why) => format!("sources only, no binary: {why}"),
            };
            Ok(File { note: Some(note), ..File::binary(version.file_name(), zip::archive(&entries)) })
        })
        .collect()
}
