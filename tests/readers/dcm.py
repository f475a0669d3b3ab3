"""Reads a DCM file with dcmReader and prints its maps and constants as JSON."""

import json
import logging
import sys

from dcmReader.dcm_reader import DcmReader


class Complaints(logging.Handler):
    """Everything that the reader complains about."""

    def __init__(self):
        super().__init__(logging.WARNING)
        self.found = []

    def emit(self, record):
        self.found.append(record.getMessage())


complaints = Complaints()
logging.getLogger().addHandler(complaints)
reader = DcmReader()
reader.read(sys.argv[1])
maps = {}
for found in reader.get_characteristic_maps():
    rows = list(found.values)
    columns = list(found.values[rows[0]])
    maps[found.name] = {
        "rows": rows,
        "columns": columns,
        "values": [[found.values[r][c] for c in columns] for r in rows],
        "units": [found.unit_y, found.unit_x, found.unit_values],
    }
curves = {}
for found in reader.get_characteristic_lines():
    x = list(found.values)
    curves[found.name] = {"x": x, "values": [found.values[e] for e in x], "units": [found.unit_x, found.unit_values]}
constants = {p.name: [p.value, p.unit] for p in reader.get_parameters()}
print(json.dumps({"maps": maps, "constants": constants, "curves": curves, "complaints": complaints.found}))
