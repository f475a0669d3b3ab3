//! Tables as logs: CSV and Parquet of a drive give what the MCAP log of the same drive gives, and what is wrong with a table is named.
#![allow(clippy::unwrap_used, missing_docs)]

#[path = "common/program.rs"]
mod program;
#[path = "common/readers.rs"]
mod readers;

use parquet::basic::{Compression, ZstdLevel};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use pivot_cal::log::{Depth, Error, Recording, SignalMap, SignalName, Source, VehicleOverrides, read, read_bytes, survey};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

/// Names of the columns, with the units of the recording.
const COLUMNS: [(SignalName, &str); 7] = [
    (SignalName::Speed, "wheel_speed [m/s]"),
    (SignalName::Torque, "drive torque command (Nm)"),
    (SignalName::TorqueFeedback, "drive torque feedback (Nm)"),
    (SignalName::Angle, "steering_angle [rad]"),
    (SignalName::YawRate, "yaw_rate [rad/s]"),
    (SignalName::Gear, "gear"),
    (SignalName::Estop, "estop"),
];

/// The demo log as MCAP.
fn demo() -> Recording {
    read(Path::new(&program::repo("data/demo.mcap")), &Source::Detect, &VehicleOverrides::default(), &|_| {}).unwrap()
}

fn overrides(of: &Recording) -> VehicleOverrides {
    VehicleOverrides {
        wheelbase_m: Some(of.vehicle.wheelbase_m),
        wheel_radius_m: Some(of.vehicle.wheel_radius_m),
        test_angle_deg: Some(of.vehicle.test_angle_deg),
        torque_limit_nm: of.vehicle.torque_limit_nm,
        torque_full_scale_nm: of.vehicle.torque_full_scale_nm,
    }
}

/// A row per time: the values that are new then. A second value of one signal at one time is in a further row.
fn rows(of: &Recording) -> Vec<(i64, [Option<f64>; 7])> {
    let mut rows: BTreeMap<(i64, usize), [Option<f64>; 7]> = BTreeMap::new();
    for (k, (name, _)) in COLUMNS.iter().enumerate() {
        let signal = of.signals.get(*name).unwrap();
        let mut again = 0;
        for i in 0..signal.len() {
            again = if i > 0 && signal.time_ns[i] == signal.time_ns[i - 1] { again + 1 } else { 0 };
            rows.entry((signal.time_ns[i], again)).or_default()[k] = Some(signal.value[i]);
        }
    }
    rows.into_iter().map(|((time_ns, _), values)| (time_ns, values)).collect()
}

/// Seconds, milliseconds … with every digit.
fn time(time_ns: i64, decimals: u32) -> String {
    let unit = 10_i64.pow(decimals);
    if decimals == 0 { time_ns.to_string() } else { format!("{}.{:0width$}", time_ns / unit, time_ns % unit, width = decimals as usize) }
}

/// Wide CSV; `number` writes a number of the locale.
fn wide(of: &Recording, time_name: &str, decimals: u32, separator: char, number: impl Fn(String) -> String) -> String {
    let mut text = COLUMNS.iter().fold(time_name.to_owned(), |text, (_, name)| format!("{text}{separator}{name}")) + "\n";
    for (time_ns, values) in rows(of) {
        text += &number(time(time_ns, decimals));
        for value in values {
            let _ = write!(text, "{separator}{}", value.map_or(String::new(), |value| number(value.to_string())));
        }
        text.push('\n');
    }
    text
}

/// The values of a recording one by one, in order of time: time, column, value.
fn values(of: &Recording) -> Vec<(i64, &'static str, f64)> {
    let named = |(time_ns, values): (i64, [Option<f64>; 7])| {
        COLUMNS.iter().zip(values).filter_map(move |((_, name), value)| Some((time_ns, *name, value?))).collect::<Vec<_>>()
    };
    rows(of).into_iter().flat_map(named).collect()
}

fn long(of: &Recording) -> String {
    let values = values(of);
    values.iter().fold("timestamp,signal,value\n".to_owned(), |text, (time_ns, name, value)| text + &format!("{time_ns},{name},{value}\n"))
}

fn expect_same(table: Vec<u8>, name: &str, mcap: &Recording) -> Recording {
    let read = read_bytes(table, name, &Source::Detect, &overrides(mcap)).unwrap();
    assert_eq!(read.signals, mcap.signals, "{name}");
    assert_eq!((read.vehicle, read.loss.messages_lost, read.loss.places.len()), (mcap.vehicle, Some(0), 0), "{name}");
    read
}

#[test]
fn every_form_of_csv_gives_the_signals_of_the_mcap_log() {
    let mcap = demo();
    let plain = |text: String| text;
    let comma = |text: String| text.replace('.', ",");
    let read = expect_same(wide(&mcap, "time [s]", 9, ',', plain).into_bytes(), "a.csv", &mcap);
    assert!(read.notes.is_empty() && read.clock_notes.is_empty(), "{:?} {:?}", read.notes, read.clock_notes);
    let spreadsheet = format!("\u{feff}{}", wide(&mcap, "Zeit (ms)", 6, ';', comma).replace('\n', "\r\n"));
    expect_same(spreadsheet.into_bytes(), "a.CSV", &mcap);
    expect_same(wide(&mcap, "t_us", 3, '\t', comma).into_bytes(), "a.tsv", &mcap);
    let nanoseconds = expect_same(long(&mcap).into_bytes(), "a.txt", &mcap);
    assert!(nanoseconds.notes.iter().any(|note| note.contains("column timestamp") && note.contains("ns")), "{:?}", nanoseconds.notes);
    // all rows of one signal before those of the next
    let text = long(&mcap);
    let mut lines: Vec<&str> = text.lines().skip(1).collect();
    lines.sort_by_key(|line| line.split(',').nth(1));
    expect_same(format!("timestamp,signal,value\n{}\n", lines.join("\n")).into_bytes(), "grouped.csv", &mcap);
}

/// A Parquet file with these columns in row groups of a thousand rows; text, numbers with holes, or times in ns.
fn parquet_of(schema: &str, columns: &[ParquetColumn], compression: Compression) -> Vec<u8> {
    let mut bytes = Vec::new();
    let properties = Arc::new(WriterProperties::builder().set_compression(compression).build());
    let mut writer = SerializedFileWriter::new(&mut bytes, Arc::new(parse_message_type(schema).unwrap()), properties).unwrap();
    let rows = columns.iter().map(ParquetColumn::len).max().unwrap();
    for from in (0..rows).step_by(1000) {
        let to = rows.min(from + 1000);
        let mut group = writer.next_row_group().unwrap();
        for column in columns {
            let mut open = group.next_column().unwrap().unwrap();
            match column {
                ParquetColumn::Times(times) => {
                    open.typed::<Int64Type>().write_batch(&times[from..to], None, None).unwrap();
                }
                ParquetColumn::Numbers(numbers) => {
                    let levels: Vec<i16> = numbers[from..to].iter().map(|value| i16::from(value.is_some())).collect();
                    let numbers: Vec<f64> = numbers[from..to].iter().copied().flatten().collect();
                    open.typed::<DoubleType>().write_batch(&numbers, Some(&levels), None).unwrap();
                }
                ParquetColumn::Texts(texts) => {
                    let texts: Vec<ByteArray> = texts[from..to].iter().map(|text| ByteArray::from(*text)).collect();
                    open.typed::<ByteArrayType>().write_batch(&texts, None, None).unwrap();
                }
            }
            open.close().unwrap();
        }
        group.close().unwrap();
    }
    writer.close().unwrap();
    bytes
}

enum ParquetColumn {
    Times(Vec<i64>),
    Numbers(Vec<Option<f64>>),
    Texts(Vec<&'static str>),
}

impl ParquetColumn {
    fn len(&self) -> usize {
        match self {
            Self::Times(times) => times.len(),
            Self::Numbers(numbers) => numbers.len(),
            Self::Texts(texts) => texts.len(),
        }
    }
}

/// Wide Parquet with names as a controller's developer writes them, without brackets.
fn wide_parquet(of: &Recording, compression: Compression) -> Vec<u8> {
    let names = ["wheel_speed_mps", "torque_command_nm", "torque_feedback_nm", "steering_angle_rad", "yaw_rate", "gear", "estop"];
    let fields = names.iter().fold(String::new(), |text, name| text + &format!("optional double {name}; "));
    let schema = format!("message log {{ required int64 at (TIMESTAMP(NANOS, true)); {fields} }}");
    let rows = rows(of);
    let numbers = |k: usize| ParquetColumn::Numbers(rows.iter().map(|(_, values)| values[k]).collect());
    let times = ParquetColumn::Times(rows.iter().map(|(time_ns, _)| *time_ns).collect());
    parquet_of(&schema, &std::iter::once(times).chain((0..7).map(numbers)).collect::<Vec<_>>(), compression)
}

fn long_parquet(of: &Recording, compression: Compression) -> Vec<u8> {
    let schema = "message log { required int64 t_ns; required binary signal (UTF8); optional double value; }";
    let values = values(of);
    let columns = [
        ParquetColumn::Times(values.iter().map(|(time_ns, ..)| *time_ns).collect()),
        ParquetColumn::Texts(values.iter().map(|(_, name, _)| *name).collect()),
        ParquetColumn::Numbers(values.iter().map(|(.., value)| Some(*value)).collect()),
    ];
    parquet_of(schema, &columns, compression)
}

#[test]
fn parquet_in_wide_and_long_form_gives_the_signals_of_the_mcap_log() {
    let mcap = demo();
    let zstd = Compression::ZSTD(ZstdLevel::default());
    let read = expect_same(wide_parquet(&mcap, zstd), "a.parquet", &mcap);
    assert!(read.notes.is_empty(), "{:?}", read.notes);
    expect_same(wide_parquet(&mcap, Compression::UNCOMPRESSED), "no.name", &mcap);
    expect_same(long_parquet(&mcap, Compression::SNAPPY), "a.pq", &mcap);
}

#[test]
fn a_table_makes_the_map_that_the_mcap_log_makes() {
    let folder = tempfile::tempdir().unwrap();
    let (path, mcap) = (folder.path(), demo());
    std::fs::create_dir(path.join("logs")).unwrap();
    std::fs::write(path.join("logs/demo.csv"), wide(&mcap, "time [s]", 9, ',', |text| text)).unwrap();
    let vehicle = ["--wheelbase-m", "0.92", "--wheel-radius-m", "0.12"];
    let log = program::repo("data/demo.mcap");
    let (status, _, errors) = program::run(path, &[&["fit", &log, "--maps", "of_mcap"][..], &vehicle].concat());
    assert_eq!(status, 0, "{errors}");
    // the folder is searched for tables; the torque limit comes from the metadata of MCAP, which a table does not have
    let map = "[vehicle]\ntorque_limit_nm = 44.0\n[signals]\n";
    let lines = COLUMNS.iter().fold(map.to_owned(), |text, (signal, name)| text + &format!("{signal} = {{ path = '{name}' }}\n"));
    std::fs::write(path.join("signals.toml"), lines).unwrap();
    let of_table = [&["fit", "logs", "--signals", "signals.toml", "--maps", "of_table"][..], &vehicle].concat();
    let (status, _, errors) = program::run(path, &of_table);
    assert_eq!(status, 0, "{errors}");
    for file in ["table1.csv", "table1.reverse.csv"] {
        let of = |folder: &str| std::fs::read_to_string(path.join(folder).join(file)).unwrap();
        assert!(of("of_mcap") == of("of_table"), "{file} differs");
    }
    // what the log of the page and of the proof is
    let table1 = std::fs::read_to_string(path.join("of_table/table1.json")).unwrap();
    assert!(table1.contains("demo.csv"));
}

#[test]
fn pandas_and_pyarrow_write_logs() {
    let Some(python) = readers::python(&["pandas", "pyarrow"], "tables of pandas") else { return };
    let folder = tempfile::tempdir().unwrap();
    let mcap = demo();
    let csv = folder.path().join("wide.csv");
    std::fs::write(&csv, wide(&mcap, "time_ns", 0, ',', |text| text)).unwrap();
    let written = readers::read_with(&python, "tables.py", &[&csv, folder.path()], "");
    let files: Vec<&str> = written.as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
    assert_eq!(files.len(), 6);
    for name in files {
        let bytes = std::fs::read(folder.path().join(name)).unwrap();
        let read = read_bytes(bytes, name, &Source::Detect, &overrides(&mcap)).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(read.signals, mcap.signals, "{name}");
    }
}

/// A table of three signals at 50 Hz, with changed lines.
fn small(change: impl Fn(usize, String) -> String) -> String {
    let row = |k: usize| change(k, format!("{}.{:02},{},{},1.5708\n", k / 50, k % 50 * 2, 0.01 * k as f64, if k < 10 { 0 } else { 12 }));
    (0..200).fold("time [s],wheel_speed [m/s],torque_command [Nm],steering_angle [rad]\n".to_owned(), |text, k| text + &row(k))
}

fn read_small(text: &str) -> Result<Recording, Error> {
    let overrides = VehicleOverrides { wheelbase_m: Some(0.9), wheel_radius_m: Some(0.1), ..VehicleOverrides::default() };
    read_bytes(text.as_bytes().to_vec(), "small.csv", &Source::Detect, &overrides)
}

#[test]
fn rows_that_cannot_be_used_are_counted_with_their_lines() {
    let text = small(|k, row| match k {
        7 => "0.14,0.07\n".to_owned(),
        8 => row.replace("0.16,", "noon,"),
        9 => row.replace(",0,", ",broken,"),
        199 => row[..6].to_owned(), // the end of a logger that was switched off
        _ => row,
    });
    let read = read_small(&text).unwrap();
    assert_eq!((read.loss.messages_read, read.loss.messages_lost), (197, Some(3)));
    assert_eq!((read.signals.speed.len(), read.signals.torque.len()), (197, 196));
    let places: Vec<String> = read.loss.places.iter().map(|place| place.why.to_string()).collect();
    assert_eq!(places[..2], ["line 9 has 2 cell(s), the header 4", "the time in line 10 is \"noon\""]);
    assert_eq!(read.loss.places[0].offset, text.find("0.14,0.07\n").unwrap() as u64);
    assert!(read.loss.is_damaged() && places[2].starts_with("line 201"), "{places:?}");
    assert!(read.notes[0].contains("torque_command [Nm]: 1 cell(s) are no number, the first is \"broken\" in line 11"), "{:?}", read.notes);
}

#[test]
fn rows_out_of_order_are_sorted_and_a_clock_that_was_set_back_is_reported() {
    let sound = read_small(&small(|_, row| row)).unwrap();
    let text = small(|_, row| row);
    let mut lines: Vec<&str> = text.lines().collect();
    lines.swap(60, 62);
    assert_eq!(read_small(&lines.join("\n")).unwrap().signals, sound.signals);
    let text = small(|k, row| if k < 100 { row } else { row.replacen(&format!("{}.", k / 50), &format!("{}.", k / 50 - 1), 1) });
    let set_back = read_small(&text).unwrap();
    assert!(set_back.clock_notes.iter().any(|note| note.contains("set back by 1.0 s")), "{:?}", set_back.clock_notes);
}

#[test]
fn what_is_no_table_of_signals_is_an_error_that_says_what_to_do() {
    let error = |text: &str| read_small(text).unwrap_err().to_string();
    let text = small(|_, row| row);
    let cases: [(String, &[&str]); 9] = [
        (String::new(), &["empty"]),
        ("1,2,3\n4,5,6\n".to_owned(), &["no header", "line 1", "\"1,2,3\""]),
        (text.replace("time [s]", "clock"), &["no column holds the times", "[columns]", "\"clock\""]),
        (text.replace("wheel_speed [m/s]", "rotation"), &["no signal speed", "\"rotation\""]),
        (text.replace("[Nm]", "[A]"), &["no signal torque", "\"torque_command [A]\""]),
        (text.lines().next().unwrap().to_owned() + "\n", &["the log holds no message"]),
        (small(|_, row| row.replacen(|c: char| c.is_ascii_digit(), "noon ", 1)), &["begin with \"noon", "ISO 8601"]),
        (small(|_, row| row.replace(",12,", ",x,").replace(",0,", ",x,")), &["no signal torque", "are torque_command [Nm];"]),
        (small(|_, row| row.replace(",1.5708", ",")), &["angle", "gives no value", "all of its cells are empty"]),
    ];
    for (text, parts) in &cases {
        let found = error(text);
        assert!(parts.iter().all(|part| found.contains(part)), "{parts:?}: {found}");
    }
    let lost = read_small(&small(|k, row| if k == 0 { row } else { "x\n".to_owned() })).unwrap();
    assert_eq!((lost.loss.messages_lost, lost.loss.places.len()), (Some(199), 100), "only a hundred places are listed");
}

#[test]
fn a_signal_map_names_the_columns_of_a_table_and_the_unit_of_its_times() {
    let text = small(|_, row| row).replace("time [s],wheel_speed [m/s]", "clock,v");
    let map = |columns: &str| {
        let signals =
            "speed = { path = 'v', unit = 'km/h' }\ntorque = { path = 'torque_command' }\nangle = { path = 'steering_angle [rad]' }";
        let vehicle = "[vehicle]\nwheelbase_m = 0.9\nwheel_radius_m = 0.1\n";
        SignalMap::from_toml(&format!("{vehicle}[columns]\n{columns}\n[signals]\n{signals}"))
    };
    let map_read =
        |columns: &str| read_bytes(text.clone().into_bytes(), "a.csv", &Source::Map(map(columns).unwrap()), &VehicleOverrides::default());
    let recording = map_read("time = 'clock'\ntime_unit = 's'").unwrap();
    assert_eq!(recording.signals.speed.time_ns[1], 20_000_000);
    assert!((recording.signals.speed.value[100] - 1.0 / 3.6).abs() < 1e-12);
    assert_eq!(map_read("time = 'clock'\ntime_unit = 'ms'").unwrap().signals.speed.time_ns[1], 20_000);
    let words = text.replace(",12,", ",twelve,").replace(",0,1.5708", ",zero,1.5708").into_bytes();
    let error =
        read_bytes(words, "a.csv", &Source::Map(map("time = 'clock'").unwrap()), &VehicleOverrides::default()).unwrap_err().to_string();
    assert!(error.contains("torque_command [Nm] gives no value") && error.contains("200 are no number"), "{error}");
    assert!(map_read("time = 'klock'").unwrap_err().to_string().contains("\"klock\""));
    assert!(map("time_unit = 'km'").unwrap_err().to_string().contains("allowed are s, ms, us and ns"));
    assert!(map("zeit = 'clock'").unwrap_err().to_string().contains("\"time\""));
}

#[test]
fn a_damaged_parquet_file_is_an_error_or_a_counted_loss_and_never_a_panic() {
    let mcap = demo();
    let whole = wide_parquet(&mcap, Compression::SNAPPY);
    let read = |bytes: Vec<u8>| read_bytes(bytes, "a.parquet", &Source::Detect, &overrides(&mcap));
    assert!(matches!(read(whole[..whole.len() / 2].to_vec()), Err(Error::BrokenParquet { .. })));
    assert!(matches!(read(b"PAR1".to_vec()), Err(Error::BrokenParquet { .. })));
    let named = read_bytes(b"time,a\n".to_vec(), "a.parquet", &Source::Detect, &VehicleOverrides::default());
    assert!(named.unwrap_err().to_string().contains("PAR1"));
    let (mut lost, mut refused) = (0, 0);
    for k in 0..60 {
        let mut bytes = whole.clone();
        let at = k * (whole.len() - 8) / 60 + 4;
        bytes[at..at + 4].iter_mut().for_each(|byte| *byte ^= 0xa5);
        match read(bytes) {
            Ok(recording) => lost += u32::from(recording.loss.messages_lost > Some(0)),
            Err(_) => refused += 1,
        }
    }
    assert!(lost > 0, "{lost} {refused}");
}

#[test]
fn a_table_is_inspected_and_a_database_of_rosbag2_is_answered_with_its_conversion() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("small.csv");
    std::fs::write(&path, small(|_, row| row)).unwrap();
    let found = survey(&path, &Source::Detect, Depth::Everything, &|_| {}).unwrap();
    assert_eq!(found.table.as_deref(), Some("CSV, separated by ',', 4 columns, times in time [s] [s]"));
    assert_eq!((found.messages, found.topics.len(), found.signals.len()), (Some(200), 4, 3));
    let (status, out, errors) = program::run(folder.path(), &["inspect", "small.csv"]);
    assert!(
        status == 0 && out.contains("a table: CSV") && out.contains("200 row(s)") && out.contains("wheel_speed [m/s]"),
        "{out}{errors}"
    );
    std::fs::write(folder.path().join("bag.db3"), b"SQLite format 3\0and more").unwrap();
    let (status, _, errors) = program::run(folder.path(), &["inspect", "bag.db3"]);
    assert!(
        status == 1 && errors.contains("ros2 bag convert -i bag.db3 -o convert.yaml") && errors.contains("storage_id: mcap"),
        "{errors}"
    );
    assert!(errors.contains("mcap convert bag.db3 bag.mcap"), "{errors}");
}
