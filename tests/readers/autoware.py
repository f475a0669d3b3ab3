"""Loads accel and brake maps with numpy by the rules of Autoware's vehicle command converter, looks pedals up, and prints all of it as JSON.

Written from the documented rules: a table is at least two cells wide, its rows have one length (numpy refuses ragged ones), every cell but the
corner is a number; along every column the accel map rises strictly and the brake map falls strictly; both maps begin with the same row, the vehicle
without pedal. A pedal is looked up by interpolating every row at the speed and then the pedals over these accelerations, with the edge outside.

usage: autoware.py ACCEL BRAKE [ACCEL BRAKE]… with a JSON list of places [speed, acceleration] per pair on standard input.
"""

import json
import sys

import numpy


def load(path, rises):
    table = numpy.atleast_2d(numpy.genfromtxt(path, delimiter=",", comments=None))
    assert table.shape[0] >= 3 and table.shape[1] >= 2, "too small"
    assert numpy.isnan(table[0, 0]) and not numpy.isnan(table).ravel()[1:].any(), "every cell but the corner is a number"
    speeds, pedals, accels = table[0, 1:], table[1:, 0], table[1:, 1:]
    assert (numpy.diff(speeds) > 0.0).all() and (numpy.diff(pedals) > 0.0).all(), "axes"
    assert pedals[0] == 0.0 and pedals[-1] <= 1.0, "pedal range"
    along = numpy.diff(accels, axis=0)
    assert (along > 0.0).all() if rises else (along < 0.0).all(), "not strictly monotone"
    return speeds, pedals, accels


def pedal(table, speed, accel):
    speeds, pedals, accels = table
    here = numpy.array([numpy.interp(speed, speeds, row) for row in accels])
    order = numpy.argsort(here)
    return float(numpy.interp(accel, here[order], pedals[order]))


found = []
paths = sys.argv[1:]
for accel_path, brake_path, places in zip(paths[0::2], paths[1::2], json.load(sys.stdin), strict=True):
    accel, brake = load(accel_path, True), load(brake_path, False)
    assert (accel[2][0] == brake[2][0]).all(), "row 0 is not shared"
    assert (accel[0] == brake[0]).all(), "speeds"
    shown = {name: dict(zip(["columns", "rows", "values"], (part.tolist() for part in table)))
             for name, table in [("accel", accel), ("brake", brake)]}
    # as the converter does: the accel pedal where it can give the acceleration, else the brake
    coast = [float(numpy.interp(speed, accel[0], accel[2][0])) for speed, _ in places]
    shown["pedals"] = [pedal(accel, v, a) if a >= c else -pedal(brake, v, a) for (v, a), c in zip(places, coast)]
    found.append(shown)
print(json.dumps(found))
