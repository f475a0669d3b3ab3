"""Writes the table of a drive in the ways in which pandas and PyArrow do, and prints the files' names as JSON.

usage: tables.py WIDE.csv FOLDER

The table has its times in ns in the column `time_ns`, and holes.
"""

import json
import pathlib
import sys

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

source, folder = sys.argv[1], pathlib.Path(sys.argv[2])
table = pd.read_csv(source, float_precision="round_trip")
written = []


def path(name):
    """The place of a file that is written."""
    written.append(name)
    return folder / name


table.to_csv(path("counted.csv"))
dated = table.set_index(pd.to_datetime(table.pop("time_ns"), unit="ns", utc=True))
dated.index.name = None
dated.to_csv(path("dated.csv"))
dated.to_csv(path("semicolons.csv"), sep=";", decimal=",", index_label="timestamp")
dated.to_parquet(path("pandas.parquet"))
arrow = pa.Table.from_pandas(dated.reset_index(names="timestamp"), preserve_index=False)
pq.write_table(arrow, path("zstd.parquet"), compression="zstd", row_group_size=777, data_page_version="2.0")
long = dated.reset_index(names="timestamp").melt("timestamp", var_name="signal").dropna()
long["signal"] = long["signal"].astype("category")
long.to_parquet(path("long.parquet"), compression="snappy", index=False)
print(json.dumps(written))
