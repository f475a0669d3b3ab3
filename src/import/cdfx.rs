//! ASAM CDF 2.0: each instance of category `MAP` is a table; the first axis is the desired acceleration, the second the speed.

use crate::import::error::TextFault;
use crate::import::full_scale::FullScale;
use crate::import::imported::ImportedTable;
use crate::import::number::WrittenNumber;
use crate::import::unit_names;
use crate::import::xml::XmlElement;
use crate::map::Gear;

pub(crate) fn read(text: &str, full: FullScale) -> Result<Vec<ImportedTable>, TextFault> {
    let document = XmlElement::parse(text)?;
    let header = unit_names::of_header(text);
    let (mut instances, mut tables) = (Vec::new(), Vec::new());
    document.all("SW-INSTANCE", &mut instances);
    for instance in instances {
        if instance.child("CATEGORY").is_some_and(|c| c.text == "MAP") {
            tables.push(table(instance, header, full)?);
        }
    }
    if tables.is_empty() { Err(TextFault::whole("it holds no SW-INSTANCE of category MAP")) } else { Ok(tables) }
}

fn table(instance: &XmlElement, header: Option<[unit_names::Conversion; 2]>, full: FullScale) -> Result<ImportedTable, TextFault> {
    let name = instance.child("SHORT-NAME").map_or("", |n| n.text.as_str());
    let fault = |what: String| TextFault::whole(format!("{name}: {what}"));
    let missing = |what: &str| fault(format!("{what} is missing"));
    let numbers = |element: &XmlElement| -> Result<Vec<WrittenNumber>, TextFault> {
        let mut found = Vec::new();
        element.all("V", &mut found);
        found.iter().map(|v| WrittenNumber::parse(&v.text).ok_or_else(|| fault(format!("{:?} is not a finite number", v.text)))).collect()
    };
    let container = instance.child("SW-VALUE-CONT").ok_or_else(|| missing("SW-VALUE-CONT"))?;
    let axes = instance.child("SW-AXIS-CONTS").ok_or_else(|| missing("SW-AXIS-CONTS"))?;
    let [x, y] = axes.children.as_slice() else { return Err(fault(format!("{} axes instead of 2", axes.children.len()))) };
    let physical = |of: &XmlElement| of.child("SW-VALUES-PHYS").ok_or_else(|| missing("SW-VALUES-PHYS")).and_then(numbers);
    let unit = |of: &XmlElement| of.child("UNIT-DISPLAY-NAME").map_or(String::new(), |u| u.text.clone());
    let (accels, speeds, values) = (physical(x)?, physical(y)?, physical(container)?);
    if values.len() != accels.len() * speeds.len() {
        return Err(fault(format!("{} values for {} × {} breaks", values.len(), accels.len(), speeds.len())));
    }
    let [speed, torque] = match header {
        Some(conversions) => conversions,
        None => [unit_names::speed(&unit(y), full).map_err(fault)?, unit_names::torque(&unit(container), full).map_err(fault)?],
    };
    let gear = if name.to_ascii_uppercase().contains("REVERSE") { Gear::Reverse } else { Gear::Forward };
    let speeds: Vec<f64> = speeds.iter().map(|v| speed.0 * v.value + speed.1).collect();
    let accels: Vec<f64> = accels.iter().map(|a| a.value).collect();
    let values: Vec<WrittenNumber> = values.iter().map(|t| t.scaled(torque.0, torque.1)).collect();
    Ok(ImportedTable::of_matrix(gear, &speeds, &accels, &values))
}
