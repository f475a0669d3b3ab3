"""Reads a calibration table with protobuf's own parser of the text format and looks places up in it as Apollo's longitudinal controller does.

The message is that of Apollo's public definition (a repeated `calibration` of speed, acceleration and command, all optional doubles); unknown fields,
repeated scalars and bad numbers are the parser's errors. The look-up is written from the documented rules: linear along acceleration within the two
neighbouring speeds, then between them; outside, the edge. Also judged: entries are unique, more acceleration needs more command, and no command
contradicts the sign of its acceleration.

usage: apollo.py TABLE… with places for each table on standard input as a JSON list of lists; prints the commands alike.
"""

import json
import sys

import numpy
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory, text_format

file = descriptor_pb2.FileDescriptorProto(name="calibration_table.proto", package="apollo.control", syntax="proto2")
info = file.message_type.add(name="ControlCalibrationInfo")
for number, name in enumerate(["speed", "acceleration", "command"], 1):
    info.field.add(name=name, number=number, type=descriptor_pb2.FieldDescriptorProto.TYPE_DOUBLE,
                   label=descriptor_pb2.FieldDescriptorProto.LABEL_OPTIONAL)
table = file.message_type.add(name="calibration_table")
table.field.add(name="calibration", number=1, type=descriptor_pb2.FieldDescriptorProto.TYPE_MESSAGE,
                label=descriptor_pb2.FieldDescriptorProto.LABEL_REPEATED, type_name=".apollo.control.ControlCalibrationInfo")
pool = descriptor_pool.DescriptorPool()
pool.Add(file)
Table = message_factory.GetMessageClass(pool.FindMessageTypeByName("apollo.control.calibration_table"))


def load(path):
    with open(path, encoding="utf-8") as text:
        entries = text_format.Parse(text.read(), Table()).calibration
    assert entries, "no entry"
    table = {}
    for entry in entries:
        assert all(entry.HasField(name) for name in ["speed", "acceleration", "command"]), "a field is missing"
        row = table.setdefault(entry.speed, {})
        assert entry.acceleration not in row, "entry stands twice"
        assert entry.acceleration * entry.command >= 0.0, "sign"
        row[entry.acceleration] = entry.command
    rows = {speed: tuple(map(numpy.array, zip(*sorted(row.items())))) for speed, row in sorted(table.items())}
    for speed, (_, commands) in rows.items():
        assert (numpy.diff(commands) > 0.0).all(), f"not monotone at speed {speed}"
    return rows


def look_up(rows, places):
    speeds = numpy.array(list(rows))
    found = []
    for speed, accel in places:
        k = int(numpy.clip(numpy.searchsorted(speeds, speed, side="right"), 1, len(speeds) - 1))
        near = speeds[k - 1:k + 1]
        found.append(float(numpy.interp(speed, near, [numpy.interp(accel, *rows[s]) for s in near])))
    return found


print(json.dumps([look_up(load(path), places) for path, places in zip(sys.argv[1:], json.load(sys.stdin), strict=True)]))
