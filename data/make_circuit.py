#!/usr/bin/env python3
"""Makes circuit.csv: the anchors of roadgen's own fit to a measured circuit.

    build/release/bin/roadgen import be-1925.geojson -o spa.xodr
    data/make_circuit.py spa.xodr >data/circuit.csv

Reads the anchors (the ends of the segments) from the OpenDRIVE file and turns them from the file's local
east-north-up frame back into latitude and longitude on WGS84. Python's standard library only.
"""

import math
import sys
import xml.etree.ElementTree as xml

A = 6378137.0
E2 = (2 - 1 / 298.257223563) / 298.257223563


def ecef(lat, lon, h):
    n = A / math.sqrt(1 - E2 * math.sin(lat) ** 2)
    return ((n + h) * math.cos(lat) * math.cos(lon), (n + h) * math.cos(lat) * math.sin(lon),
            (n * (1 - E2) + h) * math.sin(lat))


def geodetic(x, y, z):
    p = math.hypot(x, y)
    lat = math.atan2(z, p * (1 - E2))
    for _ in range(10):
        n = A / math.sqrt(1 - E2 * math.sin(lat) ** 2)
        lat = math.atan2(z + E2 * n * math.sin(lat), p)
    return lat, math.atan2(y, x)


def main(path):
    root = xml.parse(path).getroot()
    data = {u.get("code"): u.get("value") for u in root.iter("userData")}
    lat0, lon0, h0 = (float(v) for v in data["roadgen:origin"].split())
    lat0, lon0 = math.radians(lat0), math.radians(lon0)
    origin = ecef(lat0, lon0, h0)
    east = (-math.sin(lon0), math.cos(lon0), 0)
    north = (-math.sin(lat0) * math.cos(lon0), -math.sin(lat0) * math.sin(lon0), math.cos(lat0))
    print("lat,lon")
    anchors = [(float(g.get("x")), float(g.get("y"))) for g in root.find("road").iter("geometry")]
    for x, y in anchors + anchors[:1]:
        lat, lon = geodetic(*(o + x * e + y * n for o, e, n in zip(origin, east, north)))
        print(f"{math.degrees(lat):.8f},{math.degrees(lon):.8f}")


main(sys.argv[1])
