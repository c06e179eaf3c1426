#!/usr/bin/env python3
"""Makes pass.csv and pass_dem.tif: an invented Alpine pass road and the mountains it crosses.

    python3 data/make_pass.py [FOLDER]

Only Python's standard library is used and every number follows from the seed, so the files come out the same anywhere.
The road is designed first, as a road engineer would: a sequence of straights and bends with clothoid transitions, and a
profile of grades. The mountains come second: ridged noise, carved by a main valley and by the trough that the road
follows, eroded by flowing water (implicit stream power law: Braun and Willett 2013), and bent to the road's height near
it, so that the road needs moderate cuts and fills only.
"""
import math
import os
import random
import struct
import sys
import zlib

SEED = 2005
ORIGIN = (46.5180, 8.4720)  # latitude, longitude of x = y = 0; the place is real, the landscape is not
POST_LATITUDE, POST_LONGITUDE = 0.00025, 0.00035  # degrees: 27.8 m x 26.9 m
MARGIN_M = 2100.0

HAIRPINS_UP, HAIRPINS_DOWN = 10, 4


# ---- the Earth -------------------------------------------------------------------------------------------------------

def metres_per_degree():
    """Of latitude and longitude at the origin, on the WGS84 ellipsoid."""
    a, e2 = 6378137.0, 6.69437999014e-3
    phi = math.radians(ORIGIN[0])
    w = math.sqrt(1 - e2 * math.sin(phi) ** 2)
    return math.radians(a * (1 - e2) / w ** 3), math.radians(a / w * math.cos(phi))


# ---- the road --------------------------------------------------------------------------------------------------------

def plan(rng):
    """Curvature and wished grade for every metre: a list of (curvature, grade)."""
    out = []

    def bend(radius, degrees, grade):
        length = max(1, round(abs(math.radians(degrees) * radius)))
        out.extend([(math.radians(degrees) / length, grade)] * length)

    def straight(length, grade):
        out.extend([(0.0, grade)] * round(length))

    def leg(length, grade):
        """A leg that sways and keeps its direction in sum."""
        sway = rng.choice((-1, 1)) * rng.uniform(7, 12)
        radius = rng.uniform(150, 240)
        bent = 4 * math.radians(abs(sway)) * radius
        rest = max(60.0, length - bent)
        part = rng.uniform(0.25, 0.4)
        straight(rest * part, grade)
        bend(radius, sway, grade)
        bend(radius, -2 * sway, grade)
        bend(radius, sway, grade)
        straight(rest * (1 - part), grade)

    def hairpins(count, side, length, grade, turn=159.0):
        for i in range(count):
            leg(length * rng.uniform(0.85, 1.15), grade * rng.uniform(0.93, 1.08))
            # A little counter-swing before the hairpin widens it, as surveyors do on steep slopes.
            swing = rng.uniform(6, 12)
            bend(60, -side * swing, 0.6 * grade)
            bend(rng.uniform(13.5, 17.0), side * (turn + 2 * swing), 0.55 * grade)
            bend(60, -side * swing, 0.6 * grade)
            side = -side
        return side

    # The valley floor, heading east-north-east, then up the sunny side.
    straight(160, 0.012)
    bend(320, 28, 0.02)
    straight(140, 0.03)
    bend(220, -40, 0.045)
    straight(180, 0.055)
    bend(160, 32, 0.06)
    side = hairpins(HAIRPINS_UP, 1, 330, 0.079)
    # The high traverse: long bends into the hanging valley, one steep ramp before the saddle.
    leg(300, 0.074)
    bend(90, 68 * side, 0.065)
    straight(160, 0.07)
    bend(210, -38, 0.075)
    straight(220, 0.085)
    bend(170, 46, 0.085)
    straight(150, 0.105)
    bend(240, -42, 0.09)
    straight(200, 0.06)
    bend(300, 22, 0.03)
    # The saddle.
    straight(160, 0.0)
    bend(260, -34, -0.03)
    straight(140, -0.06)
    bend(120, -50, -0.065)
    # And down on the shady side.
    hairpins(HAIRPINS_DOWN, 1, 360, -0.076)
    bend(140, 70, -0.065)
    straight(260, -0.06)
    bend(260, -36, -0.045)
    straight(260, -0.03)
    bend(400, 18, -0.02)
    straight(220, -0.015)
    return out


def smoothed(values, window):
    """Mean over a window that is narrowed towards the ends."""
    total = [0.0]
    for v in values:
        total.append(total[-1] + v)
    n, half = len(values), window // 2
    result = []
    for i in range(n):
        h = min(half, i, n - 1 - i)
        result.append((total[i + h + 1] - total[i - h]) / (2 * h + 1))
    return result


def centre_line(rng):
    """The road at every metre: lists x, y, z, curvature."""
    moves = plan(rng)
    curvature = smoothed(smoothed([m[0] for m in moves], 13), 13)  # bends begin and end as clothoids
    grade = smoothed(smoothed([m[1] for m in moves], 61), 61)      # and grades change by vertical curves
    heading, x, y, z = math.radians(35), 0.0, 0.0, 1462.0
    xs, ys, zs = [], [], []
    for k, g in zip(curvature, grade):
        xs.append(x)
        ys.append(y)
        zs.append(z)
        heading += 0.5 * k
        x += math.cos(heading)
        y += math.sin(heading)
        heading += 0.5 * k
        z += g
    middle_x, middle_y = 0.5 * (min(xs) + max(xs)), 0.5 * (min(ys) + max(ys))
    return [v - middle_x for v in xs], [v - middle_y for v in ys], zs, curvature


def measured(rng, xs, ys, zs, curvature):
    """Survey points: dense in bends, sparse on straights, with the noise of a good receiver."""
    points, i = [], 0
    while i < len(xs):
        points.append((xs[i] + rng.gauss(0, 0.015), ys[i] + rng.gauss(0, 0.015), zs[i] + rng.gauss(0, 0.025)))
        ahead = max(abs(k) for k in curvature[i:i + 15])
        i += round(min(18.0, max(5.0, 0.9 / math.sqrt(ahead + 1e-4))) * rng.uniform(0.85, 1.1))
    return points


# ---- the mountains ---------------------------------------------------------------------------------------------------

class Noise:
    """Gradient noise in about [-1, 1] on a hashed lattice."""

    def __init__(self, seed):
        rng = random.Random(seed)
        self.order = list(range(256))
        rng.shuffle(self.order)
        self.order += self.order
        self.gradient = [(math.cos(2 * math.pi * i / 256), math.sin(2 * math.pi * i / 256)) for i in range(256)]

    def at(self, x, y):
        i, j = math.floor(x), math.floor(y)
        fx, fy = x - i, y - j
        i, j = i & 255, j & 255
        p = self.order

        def corner(di, dj):
            g = self.gradient[p[p[(i + di) & 255] + ((j + dj) & 255)]]
            return g[0] * (fx - di) + g[1] * (fy - dj)

        u = fx * fx * fx * (fx * (6 * fx - 15) + 10)
        v = fy * fy * fy * (fy * (6 * fy - 15) + 10)
        low = corner(0, 0) * (1 - u) + corner(1, 0) * u
        high = corner(0, 1) * (1 - u) + corner(1, 1) * u
        return 1.5 * (low * (1 - v) + high * v)

    def fractal(self, x, y, octaves):
        total, amplitude = 0.0, 1.0
        for _ in range(octaves):
            total += amplitude * self.at(x, y)
            amplitude *= 0.5
            x, y = 1.6 * x - 1.2 * y + 17.3, 1.2 * x + 1.6 * y - 9.1
        return total

    def ridged(self, x, y, octaves):
        """Sharp crests with smooth flanks, in about [0, 1]."""
        total, amplitude, weight, norm = 0.0, 1.0, 1.0, 0.0
        for _ in range(octaves):
            ridge = (1 - min(1.0, abs(self.at(x, y)))) ** 2
            total += amplitude * ridge * weight
            norm += amplitude
            weight = min(1.0, 1.6 * ridge)
            amplitude *= 0.5
            x, y = 1.6 * x - 1.2 * y + 5.2, 1.2 * x + 1.6 * y + 3.7
        return total / norm


def smooth_min(a, b, width):
    h = max(width - abs(a - b), 0.0) / width
    return min(a, b) - 0.25 * h * h * width


class Landscape:
    def __init__(self, xs, ys, zs):
        self.noise = Noise(SEED)
        # The axis of the trough: the road with its hairpins averaged away, lengthened at both ends.
        step = 40
        window = 1501
        ax, ay, az = (smoothed(v, window)[::step] for v in (xs, ys, zs))
        lead = [(ax[0] - d * 0.8, ay[0] - d * 0.35, az[0] - 0.01 * d) for d in range(4000, 0, -step)]
        dx, dy = ax[-1] - ax[-12], ay[-1] - ay[-12]
        n = math.hypot(dx, dy)
        tail = [(ax[-1] + d * dx / n, ay[-1] + d * dy / n, az[-1] - 0.035 * d) for d in range(step, 5000, step)]
        self.axis = lead + list(zip(ax, ay, az)) + tail
        self.valley = (xs[0], ys[0] - 60.0, zs[0] - 6.0)
        self.buckets = {}
        for i in range(0, len(xs), 12):
            self.buckets.setdefault((int(xs[i] // 200), int(ys[i] // 200)), []).append((xs[i], ys[i], zs[i]))

    def base(self, x, y):
        warp_x = x + 260 * self.noise.fractal(x / 1500 + 31, y / 1500, 3)
        warp_y = y + 260 * self.noise.fractal(x / 1500, y / 1500 + 47, 3)
        peaks = 1700 + 1350 * self.noise.ridged(warp_x / 3000 + 0.35, warp_y / 3000 + 0.8, 6)
        spurs = self.noise.fractal(warp_x / 620 + 11.0, warp_y / 620 + 5.0, 4)  # gullies and ribs on every flank
        # The trough, U-shaped as glaciers leave it.
        best, height = 1e18, 0.0
        for px, py, pz in self.axis:
            d = (warp_x * 0.5 + x * 0.5 - px) ** 2 + (warp_y * 0.5 + y * 0.5 - py) ** 2
            if d < best:
                best, height = d, pz
        d = max(math.sqrt(best) - 70.0, 0.0)
        trough = height + 0.24 * d + d * d / 1700.0 + 85 * spurs * min(1.0, d / 500.0)
        # The main valley runs east and west along the southern edge.
        vx, vy, vz = self.valley
        across = y - vy - 0.10 * (x - vx) + 120 * self.noise.fractal(x / 2200, 7.7, 2)
        d = max(abs(across) - 220.0, 0.0)
        floor = vz + 0.012 * (x - vx) + 0.30 * d + d * d / 2600.0 + 110 * spurs * min(1.0, d / 500.0)
        return smooth_min(smooth_min(peaks, trough, 260.0), floor, 160.0)

    def road_near(self, x, y, reach):
        """Weighted height of the road around and distance from it; None where it is out of reach."""
        cx, cy, r = int(x // 200), int(y // 200), math.ceil(reach / 200)
        total, weight, least = 0.0, 0.0, 1e18
        for i in range(cx - r, cx + r + 1):
            for j in range(cy - r, cy + r + 1):
                for px, py, pz in self.buckets.get((i, j), ()):
                    d2 = (px - x) ** 2 + (py - y) ** 2
                    least = min(least, d2)
                    w = 1.0 / (d2 + 900.0) ** 1.5  # hairpins stand on an even slope, not on steps
                    total += w * pz
                    weight += w
        if least > reach * reach:
            return None
        return total / weight, math.sqrt(least)


def erode(rng, h, columns, rows, cell, rounds, strength, share):
    """Implicit stream power law with talus: valleys cut themselves in, slopes settle. share: of the full effect."""
    n = columns * rows
    offsets = [(dx, dy, math.hypot(dx, dy) * cell) for dx in (-1, 0, 1) for dy in (-1, 0, 1) if dx or dy]
    for _ in range(rounds):
        receiver, length = list(range(n)), [1.0] * n
        for y in range(rows):
            for x in range(columns):
                i = y * columns + x
                steepest = 0.0
                for dx, dy, distance in offsets:
                    u, v = x + dx, y + dy
                    if 0 <= u < columns and 0 <= v < rows:
                        # Water finds its way with some chance, else it would all run along the eight directions.
                        slope = (h[i] - h[v * columns + u]) / distance * rng.uniform(0.6, 1.0)
                        if slope > steepest:
                            steepest, receiver[i], length[i] = slope, v * columns + u, distance
        order = sorted(range(n), key=h.__getitem__)
        area = [1.0] * n
        for i in reversed(order):
            if receiver[i] != i:
                area[receiver[i]] += area[i]
        for i in order:
            r = receiver[i]
            if r != i:
                f = strength * share[i] * math.sqrt(area[i]) / length[i] * cell
                h[i] = (h[i] + f * h[r]) / (1 + f)
                h[i] = min(h[i], h[r] + 1.2 * length[i])  # nothing stands steeper than 50 degrees
        h = diffuse(h, columns, rows, 0.12)
    return h


def diffuse(h, columns, rows, amount):
    out = list(h)
    for y in range(1, rows - 1):
        for x in range(1, columns - 1):
            i = y * columns + x
            out[i] = h[i] + amount * (0.25 * (h[i - 1] + h[i + 1] + h[i - columns] + h[i + columns]) - h[i])
    return out


def mountains(xs, ys, zs, west, south, columns, rows, step_x, step_y):
    """Heights row by row from the south-west post."""
    land = Landscape(xs, ys, zs)
    reach = 480.0
    h, near = [], []
    for row in range(rows):
        for column in range(columns):
            x, y = west + column * step_x, south + row * step_y
            h.append(land.base(x, y))
            near.append(land.road_near(x, y, reach))
    gentle = [1.0 if n is None else 0.15 + 0.85 * (n[1] / reach) ** 2 for n in near]
    h = erode(random.Random(SEED), h, columns, rows, 0.5 * (step_x + step_y), 14, 0.009, gentle)
    h = diffuse(h, columns, rows, 0.25)
    # Near the road the ground is where the road is, give or take what a road builder moves.
    for i, n in enumerate(near):
        x, y = west + (i % columns) * step_x, south + (i // columns) * step_y
        rough = land.noise.fractal(x / 170.0 + 3.1, y / 170.0 + 8.6, 4)
        if n is None:
            h[i] += 7.0 * rough
            continue
        t = max(0.0, 1 - max(n[1] - 45.0, 0.0) / (reach - 45.0))
        t = t * t * (3 - 2 * t)
        h[i] += t * (n[0] - h[i]) + (7.0 * (1 - t) + 1.9 * t) * rough
    return h


# ---- the files -------------------------------------------------------------------------------------------------------

def write_geotiff(path, rows_north_first, west, north, step_x, step_y):
    """32-bit floats in WGS84 degrees, deflate with the floating-point predictor; west and north are of the corner."""
    height, width = len(rows_north_first), len(rows_north_first[0])
    data = bytearray()
    for row in rows_north_first:
        packed = struct.pack(">%df" % width, *row)
        planes = b"".join(packed[k::4] for k in range(4))
        data += bytes((planes[i] - (planes[i - 1] if i else 0)) & 255 for i in range(len(planes)))
    strip = zlib.compress(bytes(data), 9)
    keys = (1, 1, 0, 4, 1024, 0, 1, 2, 1025, 0, 1, 1, 2048, 0, 1, 4326, 2054, 0, 1, 9102)
    short, long_, double = 3, 4, 12
    tags = [(256, long_, (width,)), (257, long_, (height,)), (258, short, (32,)), (259, short, (8,)),
            (262, short, (1,)), (273, long_, (0,)), (277, short, (1,)), (278, long_, (height,)),
            (279, long_, (len(strip),)), (317, short, (3,)), (339, short, (3,)),
            (33550, double, (step_x, step_y, 0.0)), (33922, double, (0.0, 0.0, 0.0, west, north, 0.0)),
            (34735, short, keys)]
    codes = {short: "H", long_: "I", double: "d"}
    table_end = 8 + 2 + 12 * len(tags) + 4
    extra, entries, offset = b"", [], table_end
    sizes = [struct.calcsize("<%d%s" % (len(v), codes[t])) for _, t, v in tags]
    strip_at = table_end + sum(s + s % 2 for s in sizes if s > 4)
    for (tag, kind, values), size in zip(tags, sizes):
        if tag == 273:
            values = (strip_at,)
        packed = struct.pack("<%d%s" % (len(values), codes[kind]), *values)
        if size > 4:
            entries.append(struct.pack("<HHII", tag, kind, len(values), offset))
            extra += packed + b"\0" * (size % 2)
            offset += size + size % 2
        else:
            entries.append(struct.pack("<HHI", tag, kind, len(values)) + packed.ljust(4, b"\0"))
    with open(path, "wb") as f:
        f.write(b"II*\0" + struct.pack("<I", 8) + struct.pack("<H", len(tags)) + b"".join(entries) +
                struct.pack("<I", 0) + extra + strip)


def main():
    folder = sys.argv[1] if len(sys.argv) > 1 else os.path.dirname(os.path.abspath(__file__))
    rng = random.Random(SEED)
    per_latitude, per_longitude = metres_per_degree()
    xs, ys, zs, curvature = centre_line(rng)
    points = measured(rng, xs, ys, zs, curvature)
    with open(os.path.join(folder, "pass.csv"), "w", newline="\n") as f:
        f.write("lat,lon,height\n")
        for x, y, z in points:
            f.write("%.7f,%.7f,%.2f\n" % (ORIGIN[0] + y / per_latitude, ORIGIN[1] + x / per_longitude, z))

    step_x, step_y = POST_LONGITUDE * per_longitude, POST_LATITUDE * per_latitude
    columns = 2 * math.ceil((max(xs) + MARGIN_M) / step_x) + 1
    rows = 2 * math.ceil((max(ys) + MARGIN_M) / step_y) + 1
    west, south = -(columns // 2) * step_x, -(rows // 2) * step_y
    h = mountains(xs, ys, zs, west, south, columns, rows, step_x, step_y)
    lines = [[round(16 * v) / 16 for v in h[r * columns:(r + 1) * columns]] for r in range(rows - 1, -1, -1)]
    write_geotiff(os.path.join(folder, "pass_dem.tif"), lines,
                  ORIGIN[1] - (columns // 2 + 0.5) * POST_LONGITUDE, ORIGIN[0] + (rows // 2 + 0.5) * POST_LATITUDE,
                  POST_LONGITUDE, POST_LATITUDE)
    print("road: %d points, %.0f m, %.0f to %.0f m high; elevation: %d x %d posts, %.0f to %.0f m" %
          (len(points), len(xs), min(zs), max(zs), columns, rows, min(h), max(h)))


if __name__ == "__main__":
    main()
