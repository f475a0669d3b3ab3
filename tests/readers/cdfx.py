"""Validates a CDFX file against the DTD of ASAM CDF 2.0, reads it with asamint, and prints its maps and constants as JSON."""

import gc
import json
import logging
import pathlib
import sys
import tempfile

# asamint makes some 1600 classes of database tables: without collections in between it starts in two thirds of the time
gc.disable()

import asamint
from asamint.cdf import import_cdf
from asamint.cdf.walker import CdfWalker
from lxml import etree

path = sys.argv[1]
dtd = etree.DTD(str(pathlib.Path(asamint.__file__).parent / "data" / "dtds" / "cdf_v2.0.0.sl.dtd"))
valid = dtd.validate(etree.parse(path))


class Walker(CdfWalker):
    """Keeps every instance."""

    def __init__(self, database):
        super().__init__(database)
        self.found = []

    def on_instance(self, instance):
        self.found.append(instance)

    def on_header(self, *arguments, **names):
        pass


def numbers(values):
    return [float(value.phys) for value in values]


with tempfile.TemporaryDirectory() as folder:
    database = str(pathlib.Path(folder) / "map.msrswdb")
    import_cdf(xml_path=path, db_path=database, logger=logging.getLogger("cdf"))
    walker = Walker(database)
    walker.run()
    maps, curves, constants = {}, {}, {}
    for found in walker.found:
        unit = found.values.unit_display_name.value
        if found.category == "MAP":
            x, y = found.axes
            groups = found.values.values_phys
            assert [float(group.label) for group in groups] == numbers(y.values_phys), "labels are the rows"
            assert tuple(found.values.array_size.dimensions) == (len(x.values_phys), len(y.values_phys)), "array size"
            maps[found.short_name] = {
                "rows": numbers(y.values_phys),
                "columns": numbers(x.values_phys),
                "values": [numbers(group.values) for group in groups],
                "units": [y.unit_display_name, x.unit_display_name, unit],
            }
        elif found.category == "CURVE":
            (x,) = found.axes
            curves[found.short_name] = {
                "x": numbers(x.values_phys),
                "values": numbers(found.values.values_phys),
                "units": [x.unit_display_name, unit],
            }
        else:
            constants[found.short_name] = [numbers(found.values.values_phys)[0], unit]
print(json.dumps({"valid": valid, "errors": str(dtd.error_log), "maps": maps, "curves": curves, "constants": constants}))
