"""Loads an accel and a brake map by the rules of Autoware's vehicle command converter and prints them as JSON.

Written from the documented rules: a table is at least two cells wide, its rows have one length, every cell is a number; along every column
the accel map rises strictly and the brake map falls strictly; both maps begin with the same row, the vehicle without pedal.
"""

import json
import sys


def load(path, rises):
    with open(path, encoding="utf-8") as file:
        table = [line.rstrip("\n").split(",") for line in file]
    assert table and len(table[0]) >= 2, "too small"
    assert all(len(row) == len(table[0]) for row in table), "ragged"
    speeds = [float(cell) for cell in table[0][1:]]
    pedals = [float(row[0]) for row in table[1:]]
    accels = [[float(cell) for cell in row[1:]] for row in table[1:]]
    assert len(pedals) >= 2, "interpolation needs two pedal positions"
    assert speeds == sorted(set(speeds)) and pedals == sorted(set(pedals)), "axes"
    assert pedals[0] == 0.0 and pedals[-1] <= 1.0, "pedal range"
    for above, below in zip(accels, accels[1:]):
        assert all(b > a if rises else b < a for a, b in zip(above, below)), "not strictly monotone"
    return {"corner": table[0][0], "columns": speeds, "rows": pedals, "values": accels}


accel, brake = load(sys.argv[1], True), load(sys.argv[2], False)
assert accel["values"][0] == brake["values"][0], "row 0 is not shared"
assert accel["columns"] == brake["columns"], "speeds"
print(json.dumps({"accel": accel, "brake": brake}))
