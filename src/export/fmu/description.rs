//! `modelDescription.xml` of both versions of the standard, and how their archives differ.

use crate::export::MapSource;
use crate::export::fmu::variable::{Role, UNITS, VARIABLES, Variable, VariableKind, start_of};
use crate::map::WheelAngle;
use std::fmt::Write as _;

/// Name of the binary and of the sources' model.
const IDENTIFIER: &str = "pivot_plant";
/// The model's own step, and the step that is proposed [s].
const STEP_S: &str = "0.001";

/// Version of the standard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Version {
    /// FMI 2.0.
    Two,
    /// FMI 3.0.
    Three,
}

impl Version {
    /// Both.
    pub(crate) const ALL: [Self; 2] = [Self::Two, Self::Three];

    /// Name of the archive.
    pub(crate) fn file_name(self) -> &'static str {
        match self {
            Self::Two => "plant_fmi2.fmu",
            Self::Three => "plant_fmi3.fmu",
        }
    }

    /// Template of the source with the standard's functions.
    pub(crate) fn source(self) -> &'static str {
        match self {
            Self::Two => include_str!("../template/fmi2.c.in"),
            Self::Three => include_str!("../template/fmi3.c.in"),
        }
    }

    /// Name of that source.
    pub(crate) fn source_name(self) -> &'static str {
        match self {
            Self::Two => "fmi2.c",
            Self::Three => "fmi3.c",
        }
    }

    /// Place of the binary of this machine in the archive; `None` if the standard has no name for it.
    pub(crate) fn binary_path(self) -> Option<String> {
        let (os, arch) = (std::env::consts::OS, std::env::consts::ARCH);
        let platform = match (self, os, arch) {
            (Self::Two, "linux", "x86_64") => "linux64",
            (Self::Two, "linux", "x86") => "linux32",
            (Self::Two, "macos", "x86_64") => "darwin64",
            (Self::Three, "linux", "x86_64") => "x86_64-linux",
            (Self::Three, "linux", "aarch64") => "aarch64-linux",
            (Self::Three, "macos", "x86_64") => "x86_64-darwin",
            (Self::Three, "macos", "aarch64") => "aarch64-darwin",
            _ => return None,
        };
        let extension = if os == "macos" { "dylib" } else { "so" };
        Some(format!("binaries/{platform}/{IDENTIFIER}.{extension}"))
    }

    /// `buildDescription.xml`; version 2 has its list of sources in the description.
    pub(crate) fn build_description(self) -> Option<String> {
        (self == Self::Three).then(|| {
            format!(
                "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiBuildDescription fmiVersion=\"3.0\">\n  <BuildConfiguration \
                 modelIdentifier=\"{IDENTIFIER}\">\n    <SourceFileSet language=\"C99\">\n      <SourceFile name=\"pivot_plant.c\"/>\n      \
                 <SourceFile name=\"fmi3.c\"/>\n    </SourceFileSet>\n    <Library name=\"m\"/>\n  </BuildConfiguration>\n\
                 </fmiBuildDescription>\n"
            )
        })
    }

    /// `modelDescription.xml`.
    pub(crate) fn model_description(self, source: &MapSource, token: &str) -> String {
        let vehicle = &source.table2.vehicle;
        let verified = if source.proof.is_verified { "verified map" } else { "UNVERIFIED map" };
        let about = escaped(&format!(
            "Identified plant of a vehicle that pivots on its driven front wheel, at {} deg; {verified}, generation {}",
            vehicle.test_angle_deg, source.table2.generation
        ));
        let (version, token_name) = match self {
            Self::Two => ("2.0", "guid"),
            Self::Three => ("3.0", "instantiationToken"),
        };
        let mut text = format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription fmiVersion=\"{version}\" modelName=\"pivot-cal plant\" \
             {token_name}=\"{token}\" description=\"{about}\" generationTool=\"pivot-cal {}\" variableNamingConvention=\"flat\"",
            env!("CARGO_PKG_VERSION")
        );
        text.push_str(match self {
            Self::Two => " numberOfEventIndicators=\"0\">\n",
            Self::Three => ">\n",
        });
        let _ = match self {
            Self::Two => writeln!(
                text,
                "  <CoSimulation modelIdentifier=\"{IDENTIFIER}\" canHandleVariableCommunicationStepSize=\"true\" \
                 canNotUseMemoryManagementFunctions=\"true\" canGetAndSetFMUstate=\"true\" canSerializeFMUstate=\"true\">\n    \
                 <SourceFiles>\n      <File name=\"pivot_plant.c\"/>\n      <File name=\"fmi2.c\"/>\n    </SourceFiles>\n  </CoSimulation>"
            ),
            Self::Three => writeln!(
                text,
                "  <CoSimulation modelIdentifier=\"{IDENTIFIER}\" canGetAndSetFMUState=\"true\" canSerializeFMUState=\"true\" \
                 canHandleVariableCommunicationStepSize=\"true\" fixedInternalStepSize=\"{STEP_S}\"/>"
            ),
        };
        text.push_str("  <UnitDefinitions>\n");
        for (name, [kg, m, s, rad]) in UNITS {
            let mut base = String::new();
            for (unit, exponent) in [("kg", kg), ("m", m), ("s", s), ("rad", rad)] {
                if exponent != 0 {
                    let _ = write!(base, " {unit}=\"{exponent}\"");
                }
            }
            let _ = writeln!(text, "    <Unit name=\"{name}\"><BaseUnit{base}/></Unit>");
        }
        text.push_str("  </UnitDefinitions>\n");
        if self == Self::Two {
            text.push_str("  <LogCategories>\n    <Category name=\"logStatusError\"/>\n  </LogCategories>\n");
        } else {
            text.push_str("  <LogCategories>\n    <Category name=\"logStatusError\" description=\"errors\"/>\n  </LogCategories>\n");
        }
        let _ = writeln!(text, "  <DefaultExperiment startTime=\"0\" stopTime=\"10\" stepSize=\"{STEP_S}\"/>\n  <ModelVariables>");
        if self == Self::Three {
            let time = "    <Float64 name=\"time\" valueReference=\"0\" causality=\"independent\" variability=\"continuous\"/>";
            let _ = writeln!(text, "{time}");
        }
        let angle = vehicle.test_angle();
        for (k, variable) in VARIABLES.iter().enumerate() {
            text.push_str(&self.variable(variable, k + 1, angle));
        }
        text.push_str("  </ModelVariables>\n  <ModelStructure>\n");
        let outputs = VARIABLES.iter().enumerate().filter(|(_, v)| v.role == Role::Output).map(|(k, _)| k + 1);
        if self == Self::Two {
            let unknowns = outputs.fold(String::new(), |mut text, index| {
                let _ = writeln!(text, "      <Unknown index=\"{index}\"/>");
                text
            });
            let _ = writeln!(text, "    <Outputs>\n{unknowns}    </Outputs>");
            let _ = writeln!(text, "    <InitialUnknowns>\n{unknowns}    </InitialUnknowns>");
        } else {
            let outputs: Vec<usize> = outputs.collect();
            for name in ["Output", "InitialUnknown"] {
                for reference in &outputs {
                    let _ = writeln!(text, "    <{name} valueReference=\"{reference}\"/>");
                }
            }
        }
        text.push_str("  </ModelStructure>\n</fmiModelDescription>\n");
        text
    }

    fn variable(self, variable: &Variable, reference: usize, angle: WheelAngle) -> String {
        let (causality, initial) = match variable.role {
            Role::Input => ("input", ""),
            Role::Output => ("output", " initial=\"calculated\""),
            Role::Parameter => ("parameter", " initial=\"exact\""),
        };
        let variability = match (variable.role, variable.kind) {
            (Role::Parameter, _) => "fixed",
            (_, VariableKind::Real { .. }) => "continuous",
            _ => "discrete",
        };
        let has_start = variable.role != Role::Output;
        let (type_2, type_3, fields) = match variable.kind {
            VariableKind::Real { start, range, unit } => {
                let range = range.map_or(String::new(), |[low, high]| format!(" min=\"{low:?}\" max=\"{high:?}\""));
                let start = if has_start { format!(" start=\"{:?}\"", start_of(variable, start, angle)) } else { String::new() };
                ("Real", "Float64", format!(" unit=\"{unit}\"{range}{start}"))
            }
            VariableKind::Whole { start, range: [low, high] } => {
                ("Integer", "Int32", format!(" min=\"{low}\" max=\"{high}\" start=\"{start}\""))
            }
            VariableKind::Boolean => ("Boolean", "Boolean", " start=\"false\"".to_owned()),
        };
        let common = format!(
            "name=\"{}\" valueReference=\"{reference}\" causality=\"{causality}\" variability=\"{variability}\"{initial} description=\"{}\"",
            variable.name,
            escaped(variable.about)
        );
        match self {
            Self::Two => format!("    <ScalarVariable {common}>\n      <{type_2}{fields}/>\n    </ScalarVariable>\n"),
            Self::Three => format!("    <{type_3} {common}{fields}/>\n"),
        }
    }
}

/// The identifier by which description and binary know that they belong together, from a hash of the unit.
pub(crate) fn token(sha256: &str) -> String {
    let part = |from: usize, to: usize| sha256.get(from..to).unwrap_or_default();
    format!("{{{}-{}-{}-{}-{}}}", part(0, 8), part(8, 12), part(12, 16), part(16, 20), part(20, 32))
}

/// Text of an attribute.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
