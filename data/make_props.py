#!/usr/bin/env python3
"""Writes props.json: what stands along the invented pass of pass.csv. The project's own making."""
import json
import random

random.seed(3)


def place(s, t, heading=0.0):
    return {"place": {"road": "1", "s": round(s, 2), "t": round(t, 2), **({"heading": round(heading, 3)} if heading else {})}}


def turned(x, y, z, scale):
    return [scale, 0, 0, x, 0, scale, 0, y, 0, 0, scale, z, 0, 0, 0, 1]


posts = [place(s, side * 4.9, 0 if side < 0 else 3.1416) for s in range(10, 900, 25) for side in (-1, 1)]
trees = []
for _ in range(150):
    side = random.choice((-1, 1))
    scale = random.uniform(0.7, 1.5)
    tree = place(random.uniform(10, 900), side * random.uniform(8, 17), random.uniform(-3, 3))
    tree["transform"] = turned(0, 0, -0.8, scale)
    trees.append(tree)

scene = {
    "version": 1,
    "materials": {
        "post": {"base_color": [0.75, 0.75, 0.73], "roughness": 0.5},
        "black": {"base_color": [0.02, 0.02, 0.02], "roughness": 0.6},
        "reflector": {"base_color": [0.75, 0.35, 0.02], "roughness": 0.15},
        "steel": {"base_color": [0.55, 0.56, 0.58], "metallic": 1, "roughness": 0.35},
        "red": {"base_color": "#c4100c", "roughness": 0.4},
        "white": {"base_color": [0.85, 0.85, 0.85], "roughness": 0.4},
        "cone": {"base_color": "#ff5208", "roughness": 0.5},
        "bark": {"base_color": [0.09, 0.06, 0.04], "roughness": 0.9},
        "leaves": {"base_color": [0.06, 0.13, 0.03], "roughness": 0.85},
        "spruce": {"base_color": [0.03, 0.08, 0.035], "roughness": 0.9},
        "mirror": {"base_color": [0.95, 0.95, 0.95], "metallic": 1, "roughness": 0.02},
    },
    "objects": [
        {"type": "group", "name": "delineator", "instances": posts, "objects": [
            {"type": "cylinder", "from": [0, 0, -0.3], "to": [0, 0, 1], "radius": 0.06, "material": "post"},
            {"type": "cylinder", "from": [0, 0, 0.72], "to": [0, 0, 0.9], "radius": 0.062, "material": "black"},
            {"type": "box", "low": [-0.066, -0.02, 0.74], "high": [-0.05, 0.02, 0.88], "material": "reflector"}]},
        {"type": "group", "name": "round tree", "instances": trees[::3], "objects": [
            {"type": "cone", "from": [0, 0, 0], "to": [0, 0, 4], "radius_from": 0.28, "radius_to": 0.12, "material": "bark"},
            {"type": "ellipsoid", "center": [0, 0, 5], "radii": [2, 2, 2.6], "material": "leaves"},
            {"type": "ellipsoid", "center": [0.9, 0.5, 4.2], "radii": [1.4, 1.4, 1.5], "material": "leaves"},
            {"type": "ellipsoid", "center": [-0.7, -0.8, 4.5], "radii": [1.5, 1.3, 1.6], "material": "leaves"}]},
        {"type": "group", "name": "spruce", "instances": [t for i, t in enumerate(trees) if i % 3], "objects": [
            {"type": "cylinder", "from": [0, 0, 0], "to": [0, 0, 2], "radius": 0.16, "material": "bark"},
            {"type": "cone", "from": [0, 0, 1.3], "to": [0, 0, 5], "radius_from": 1.9, "material": "spruce"},
            {"type": "cone", "from": [0, 0, 3], "to": [0, 0, 7], "radius_from": 1.5, "material": "spruce"},
            {"type": "cone", "from": [0, 0, 5], "to": [0, 0, 9], "radius_from": 1.0, "material": "spruce"}]},
        {"type": "group", "name": "speed limit", "instances": [place(s, -5.3) for s in (62, 310, 560)], "objects": [
            {"type": "cylinder", "from": [0, 0, -0.5], "to": [0, 0, 2.9], "radius": 0.038, "material": "steel"},
            {"type": "cylinder", "from": [-0.06, 0, 2.5], "to": [-0.045, 0, 2.5], "radius": 0.375, "material": "red"},
            {"type": "circle", "center": [-0.062, 0, 2.5], "normal": [-1, 0, 0], "radius": 0.28, "material": "white"}]},
        {"type": "group", "name": "warning", "instances": [place(s, -5.4) for s in (90, 430)], "objects": [
            {"type": "cylinder", "from": [0, 0, -0.5], "to": [0, 0, 2.8], "radius": 0.038, "material": "steel"},
            {"type": "triangle", "vertices": [[-0.05, 0.47, 2.1], [-0.05, -0.47, 2.1], [-0.05, 0, 2.92]], "material": "red"},
            {"type": "triangle", "vertices": [[-0.055, 0.32, 2.19], [-0.055, -0.32, 2.19], [-0.055, 0, 2.74]], "material": "white"}]},
        {"type": "group", "name": "cone", "instances": [place(s, -0.4 - 0.05 * (s - 70)) for s in range(70, 112, 6)], "objects": [
            {"type": "box", "low": [-0.19, -0.19, 0], "high": [0.19, 0.19, 0.04], "material": "black"},
            {"type": "cone", "from": [0, 0, 0.04], "to": [0, 0, 0.72], "radius_from": 0.14, "radius_to": 0.025, "material": "cone"},
            {"type": "cone", "from": [0, 0, 0.36], "to": [0, 0, 0.52], "radius_from": 0.0865, "radius_to": 0.0605, "material": "white"}]},
        {"type": "group", "name": "traffic mirror", "place": {"road": "1", "s": 128, "t": 5.6, "heading": -0.35}, "objects": [
            {"type": "cylinder", "from": [0, 0, -0.5], "to": [0, 0, 2.6], "radius": 0.045, "material": "steel"},
            {"type": "quadric", "coefficients": [1, 1, 1, 0, 0, 0, 0, 0, 0, -1.44], "box": [[-1.3, -0.45, -0.45], [-1.05, 0.45, 0.45]],
             "transform": turned(1.0, 0, 2.3, 1), "material": "mirror"},
            {"type": "torus", "center": [-0.06, 0, 2.3], "axis": [1, 0, 0], "major_radius": 0.5, "minor_radius": 0.045, "material": "red"}]},
    ],
}

# One object a line, so that a fault's line says which.
with open("props.json", "w") as file:
    parts = ['{"version": 1, "materials": {']
    parts.append(",\n".join(f"  {json.dumps(k)}: {json.dumps(v)}" for k, v in scene["materials"].items()))
    parts.append('}, "objects": [')
    parts.append(",\n".join(f"  {json.dumps(o)}" for o in scene["objects"]))
    parts.append("]}\n")
    file.write("\n".join(parts))
