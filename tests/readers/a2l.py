"""Reads an A2L file with pya2l, and prints its maps, axes, units and symbols as JSON."""

import contextlib
import gc
import io
import json
import logging
import os
import sys
import warnings

gc.disable()
warnings.simplefilter("ignore")
logging.disable(logging.CRITICAL)
# the parser writes its progress to standard output
out = os.dup(1)
os.dup2(2, 1)

from pya2l import DB, model

with contextlib.redirect_stdout(io.StringIO()):
    # it leaves temporary files and a database where it works
    os.chdir(os.path.dirname(sys.argv[1]))
    session = DB().import_a2l(os.path.basename(sys.argv[1]), in_memory=False)

methods = {m.name: m for m in session.query(model.CompuMethod)}
layouts = {r.name: r for r in session.query(model.RecordLayout)}
axes = {a.name: a for a in session.query(model.AxisPts)}


def numbers(name):
    method = methods[name]
    factors = method.coeffs_linear
    return {"unit": method.unit, "scale": [factors.a, factors.b] if factors else None}


def axis(description):
    points = axes[description.axis_pts_ref.axisPoints]
    return {
        **numbers(description.conversion),
        "count": points.maxAxisPoints,
        "limits": [points.lowerLimit, points.upperLimit],
        "symbol": points.symbol_link.symbolName,
        "type": layouts[points.depositAttr if hasattr(points, "depositAttr") else points.deposit].axis_pts_x.datatype,
    }


maps = {}
for found in session.query(model.Characteristic):
    values = layouts[found.deposit].fnc_values
    maps[found.name] = {
        **numbers(found.conversion),
        "kind": found.type,
        "order": values.indexMode,
        "type": values.datatype,
        "limits": [found.lowerLimit, found.upperLimit],
        "symbol": found.symbol_link.symbolName,
        "x": axis(found.axis_descr[0]),
        "y": axis(found.axis_descr[1]),
    }
os.write(out, json.dumps(maps).encode())
