//! Any text as a map's CSV or JSON; what can be read is written and read again to the same.
#![no_main]

use libfuzzer_sys::fuzz_target;
use pivot_cal::map::{AccelTable, Matrix, Table1File, Table2File, TorqueTable};

fuzz_target!(|text: &str| {
    let _ = Table1File::from_json(text);
    let _ = Table2File::from_json(text);
    if let Ok(matrix) = Matrix::from_csv(text) {
        if let Ok(table) = AccelTable::from_matrix(matrix.clone()) {
            let again = AccelTable::from_matrix(Matrix::from_csv(&table.to_matrix().to_csv()).expect("it was written"));
            assert_eq!(again.expect("it was a table").values(), table.values());
        }
        let _ = TorqueTable::from_matrix(matrix);
    }
});
