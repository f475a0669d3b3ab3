"""Loads a calibration table as Apollo's longitudinal controller does and looks places up in it.

Written from the documented rules: entries by speed, then by acceleration; linear interpolation along acceleration within the two
neighbouring speeds, then between them; outside, the edge. Also judged: entries are unique, more acceleration needs more command, and no
command contradicts the sign of its acceleration. Reads places from standard input as JSON, prints commands as JSON.
"""

import bisect
import json
import re
import sys

with open(sys.argv[1], encoding="utf-8") as file:
    text = "\n".join(line.split("#")[0] for line in file)
number = r"(-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?)"
entry = re.compile(r"calibration\s*\{\s*speed:\s*" + number + r"\s+acceleration:\s*" + number + r"\s+command:\s*" + number + r"\s*\}")
assert not entry.sub("", text).strip(), "something beside calibration entries"
table = {}
for speed, accel, command in (map(float, found) for found in entry.findall(text)):
    row = table.setdefault(speed, {})
    assert accel not in row, "entry stands twice"
    assert accel * command >= 0.0, "sign"
    row[accel] = command
rows = [(speed, sorted(row.items())) for speed, row in sorted(table.items())]
for speed, row in rows:
    assert all(b[1] > a[1] for a, b in zip(row, row[1:])), f"not monotone at speed {speed}"


def along(points, x):
    places = [p[0] for p in points]
    if x <= places[0]:
        return points[0][1]
    if x >= places[-1]:
        return points[-1][1]
    k = bisect.bisect_right(places, x)
    (x0, y0), (x1, y1) = points[k - 1], points[k]
    return y0 + (y1 - y0) * (x - x0) / (x1 - x0)


def look_up(speed, accel):
    speeds = [r[0] for r in rows]
    if speed <= speeds[0]:
        return along(rows[0][1], accel)
    if speed >= speeds[-1]:
        return along(rows[-1][1], accel)
    k = bisect.bisect_right(speeds, speed)
    return along([(speeds[k - 1], along(rows[k - 1][1], accel)), (speeds[k], along(rows[k][1], accel))], speed)


print(json.dumps([look_up(*place) for place in json.load(sys.stdin)]))
