//! ASAM CDF 2.0 (calibration data format): one instance of category `MAP` per gear with its axes and units, and the drive's constants of
//! category `VALUE`. X is the desired acceleration, Y the speed: a value group per speed, labelled with it.
//!
//! Source: ASAM MCD-2 CDF V2.0, document type `MSRSW` (`cdf_v2.0.0.sl.dtd`).

use crate::export::dcm::{LATERAL, LATERAL_WHAT, constants, name, what};
use crate::export::file::File;
use crate::export::lateral_source::LateralSource;
use crate::export::number::plain;
use crate::export::{MapSource, UserUnits, provenance};
use std::fmt::Write as _;

const HEAD: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<!DOCTYPE MSRSW PUBLIC "-//ASAM//DTD CALIBRATION DATA FORMAT:V2.0.0:LAI:IAI:XML:CDF200.XSD//EN" "cdf_v2.0.0.sl.dtd">
"#;

pub(crate) fn file(source: &MapSource, units: &UserUnits) -> File {
    let mut xml = Xml { text: HEAD.to_owned(), depth: 0 };
    // a comment may not hold two hyphens in a row
    let _ = writeln!(
        xml.text,
        "<!--\n{}\n-->",
        provenance::lines(source).into_iter().chain(units.line()).collect::<Vec<_>>().join("\n").replace("--", "- -")
    );
    xml.element("MSRSW", |xml| {
        xml.leaf("SHORT-NAME", "pivot_map");
        xml.leaf("CATEGORY", "CDF20");
        xml.nested(&["SW-SYSTEMS", "SW-SYSTEM"], |xml| {
            xml.leaf("SHORT-NAME", "pivot_map");
            xml.nested(&["SW-INSTANCE-SPEC", "SW-INSTANCE-TREE"], |xml| {
                xml.leaf("SHORT-NAME", "pivot_map");
                xml.leaf("CATEGORY", "NO_VCD");
                instances(xml, source, units);
            });
        });
    });
    File::new("pivot_map.cdfx", xml.text)
}

fn instances(xml: &mut Xml, source: &MapSource, units: &UserUnits) {
    for constant in constants(source).into_iter().chain(source.lateral.iter().flat_map(LateralSource::constants)) {
        xml.element("SW-INSTANCE", |xml| {
            xml.leaf("SHORT-NAME", &constant.name);
            xml.leaf("LONG-NAME", &constant.what);
            xml.leaf("CATEGORY", "VALUE");
            xml.element("SW-VALUE-CONT", |xml| {
                xml.leaf("UNIT-DISPLAY-NAME", constant.unit);
                xml.element("SW-VALUES-PHYS", |xml| xml.leaf("V", &plain(constant.value)));
            });
        });
    }
    for (gear, table) in &source.torque {
        let (x, y) = (table.accel_mps2().breaks(), table.speed_mps().breaks().iter().map(|v| units.speed(*v)).collect::<Vec<_>>());
        let torques: Vec<f64> = table.values().iter().map(|t| units.torque(*t)).collect();
        xml.element("SW-INSTANCE", |xml| {
            xml.leaf("SHORT-NAME", name(*gear));
            xml.leaf("LONG-NAME", &what(*gear));
            xml.leaf("CATEGORY", "MAP");
            xml.element("SW-VALUE-CONT", |xml| {
                xml.leaf("UNIT-DISPLAY-NAME", units.torque_name());
                xml.element("SW-ARRAYSIZE", |xml| {
                    for axis in [x, &y] {
                        xml.leaf("V", &axis.len().to_string());
                    }
                });
                xml.element("SW-VALUES-PHYS", |xml| {
                    for (speed, row) in y.iter().zip(torques.chunks(x.len())) {
                        xml.element("VG", |xml| {
                            xml.leaf("LABEL", &plain(*speed));
                            xml.values(row);
                        });
                    }
                });
            });
            xml.element("SW-AXIS-CONTS", |xml| {
                for (unit, axis) in [("m/s^2", x), (units.speed_name(), &y)] {
                    xml.element("SW-AXIS-CONT", |xml| {
                        xml.leaf("CATEGORY", "STD_AXIS");
                        xml.leaf("UNIT-DISPLAY-NAME", unit);
                        xml.element("SW-ARRAYSIZE", |xml| xml.leaf("V", &axis.len().to_string()));
                        xml.element("SW-VALUES-PHYS", |xml| xml.values(axis));
                    });
                }
            });
        });
    }
    if let Some(law) = &source.lateral {
        curve(xml, law);
    }
}

/// The curve of the lateral compensation.
fn curve(xml: &mut Xml, law: &LateralSource) {
    let (errors, angles) = (&law.file.curve.error_m, &law.file.curve.angle_rad);
    xml.element("SW-INSTANCE", |xml| {
        xml.leaf("SHORT-NAME", LATERAL);
        xml.leaf("LONG-NAME", LATERAL_WHAT);
        xml.leaf("CATEGORY", "CURVE");
        xml.element("SW-VALUE-CONT", |xml| {
            xml.leaf("UNIT-DISPLAY-NAME", "rad");
            xml.element("SW-ARRAYSIZE", |xml| xml.leaf("V", &angles.len().to_string()));
            xml.element("SW-VALUES-PHYS", |xml| xml.values(angles));
        });
        xml.nested(&["SW-AXIS-CONTS", "SW-AXIS-CONT"], |xml| {
            xml.leaf("CATEGORY", "STD_AXIS");
            xml.leaf("UNIT-DISPLAY-NAME", "m");
            xml.element("SW-ARRAYSIZE", |xml| xml.leaf("V", &errors.len().to_string()));
            xml.element("SW-VALUES-PHYS", |xml| xml.values(errors));
        });
    });
}

/// XML being written.
struct Xml {
    text: String,
    depth: usize,
}

impl Xml {
    fn line(&mut self, line: &str) {
        self.text.push_str(&"  ".repeat(self.depth));
        self.text.push_str(line);
        self.text.push('\n');
    }

    fn element(&mut self, name: &str, inside: impl FnOnce(&mut Self)) {
        self.line(&format!("<{name}>"));
        self.depth += 1;
        inside(self);
        self.depth -= 1;
        self.line(&format!("</{name}>"));
    }

    /// An element in an element in an element.
    fn nested(&mut self, names: &[&str], inside: impl FnOnce(&mut Self)) {
        for name in names {
            self.line(&format!("<{name}>"));
            self.depth += 1;
        }
        inside(self);
        for name in names.iter().rev() {
            self.depth -= 1;
            self.line(&format!("</{name}>"));
        }
    }

    fn leaf(&mut self, name: &str, text: &str) {
        let text = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
        self.line(&format!("<{name}>{text}</{name}>"));
    }

    /// Plain values, on one line.
    fn values(&mut self, values: &[f64]) {
        let line: Vec<_> = values.iter().map(|v| format!("<V>{}</V>", plain(*v))).collect();
        self.line(&line.concat());
    }
}
