# SPDX-License-Identifier: Apache-2.0
"""Scenes from points of the unit cube."""

import math

import numpy
from scipy.stats import qmc

# Presets of the bake with the height of their base and their usual voxel, m.
KINDS = (
    ("cumulus_humilis", 900, 30), ("cumulus_mediocris", 1000, 40), ("cumulus_congestus", 900, 50),
    ("stratocumulus", 1300, 60), ("stratus", 250, 40), ("nimbostratus", 800, 90), ("altocumulus_floccus", 3800, 50),
    ("altostratus", 3500, 120), ("cumulonimbus", 900, 120), ("cirrus", 8000, 120), ("fog", 0, 30),
    ("valley_stratus", 0, 50), ("altocumulus_lenticularis", 4000, 60), ("contrail", 9500, 60),
)

AXES = (
    "count", "kind", "kind2", "kind3", "voxel", "extent", "base", "imported", "elevation", "azimuth", "moon", "haze",
    "ground", "relief", "albedo", "place", "distance", "side", "height", "fov", "emission", "shape", "depth", "seed",
)


def draw_points(seed, count):
    """The first `count` points of a scrambled Sobol sequence, as one dictionary by axis each."""
    sampler = qmc.Sobol(len(AXES), scramble=True, seed=seed)
    points = sampler.random_base2(max(1, math.ceil(math.log2(count))))
    return [dict(zip(AXES, point)) for point in points[:count]]


def pick(u, values):
    return values[min(int(u * len(values)), len(values) - 1)]


def mix(u, low, high):
    return low + u * (high - low)


def mix_log(u, low, high):
    return low * (high / low) ** u


def draw_cloud(p, kind, number):
    """One cloud, and its middle, half width and height above sea level, m."""
    preset, base, voxel = kind
    voxel *= mix_log(p["voxel"], 0.8, 2.5)
    extent = mix_log(p["extent"], 5e3, 24e3)
    if preset in ("cumulus_congestus", "cumulonimbus"):
        extent = max(extent, 9e3)
    voxel = max(voxel, extent / 260)
    bake = {"preset": preset, "seed": 1 + int(p["seed"] * 1e6) + number, "extent": f"{extent:.0f} m",
            "voxel": f"{voxel:.1f} m"}
    if base > 0 and number == 0:
        base *= mix(p["base"], 0.7, 1.4)
        bake["base"] = f"{base:.0f} m"
    return {"bake": bake}, base, extent


def draw_ground(p):
    """Keys of the ground, and the height of its hills, m."""
    albedo = round(mix(p["albedo"], 0.0, 0.9), 3)
    kind = pick(p["ground"], ("flat", "flat", "ridges", "height field", "water", "snow"))
    if kind == "flat":
        return kind, {"atmosphere": {"ground_albedo": albedo}}, 0.0
    if kind == "snow":
        return kind, {"atmosphere": {"ground_albedo": round(mix(p["albedo"], 0.6, 0.9), 3)}}, 0.0
    if kind == "water":
        return kind, {"water": {"wind": f"{mix_log(p['relief'], 2, 15):.1f} m/s"}}, 0.0
    relief = mix(p["relief"], 200, 1800)
    if kind == "height field":
        field = {"seed": 1 + int(p["seed"] * 1e4), "relief": relief}
        return kind, {"terrain": {"heightfield": field, "width": "36 km", "albedo": albedo}}, relief
    ridges = {"seed": 1 + int(p["seed"] * 1e4), "relief": f"{relief:.0f} m", "samples": 257}
    return kind, {"terrain": {"ridges": ridges, "width": "36 km", "albedo": albedo}}, relief


def draw_heights(seed, relief, size=257):
    """Heights in m, the lowest 0: noise whose amplitude falls as the frequency to the power 1.8."""
    random = numpy.random.default_rng(seed)
    frequency = numpy.hypot(*numpy.meshgrid(numpy.fft.fftfreq(size), numpy.fft.rfftfreq(size), indexing="ij"))
    frequency[0, 0] = numpy.inf
    phases = numpy.exp(2j * math.pi * random.random(frequency.shape))
    heights = numpy.fft.irfft2(phases * frequency ** -1.8, (size, size))
    heights -= heights.min()
    return (relief / heights.max() * heights).astype("<f4")


def draw_camera(p, base, extent, relief):
    """The camera's keys and the kind of its place."""
    place = pick(p["place"], ("ground", "ground", "between", "inside", "above"))
    distance = mix_log(p["distance"], 300, 60e3)
    turn = 2 * math.pi * p["side"]
    if place == "inside":
        distance = min(distance, 0.4 * extent)
    away = distance if place == "ground" else min(distance, 1.5 * extent)
    x, y = -away * math.sin(turn), -away * math.cos(turn)
    height = {"ground": relief + mix_log(p["height"], 2, 200), "between": max(0.8 * base, relief + 100),
              "inside": base + mix(p["height"], 100, 400), "above": base + mix_log(p["height"], 1500, 8000)}[place]
    look = base + 300 + mix(p["height"], -0.05, 0.05) * away
    fov = mix_log(p["fov"], 10, 100)
    if place == "ground" and away < 2 * base:
        fov = max(fov, 50)
    camera = {"position": [round(x), round(y), round(height)], "look_at": [0, 0, round(look)],
              "fov": f"{fov:.1f} deg", "resolution": [64, 36]}
    return place, camera


def draw_sun(p):
    """Half of the suns stand below 30 degrees."""
    u = p["elevation"]
    elevation = mix(u / 0.1, -6, 0) if u < 0.1 else mix((u - 0.1) / 0.4, 0, 30) if u < 0.5 else mix(2 * u - 1, 30, 90)
    sky = {"sun": {"elevation": f"{elevation:.2f} deg", "azimuth": f"{360 * p['azimuth']:.1f} deg"}}
    if p["moon"] < 0.1:
        sky["sun"]["elevation"] = "-25 deg"
        sky["moon"] = {"elevation": f"{mix(p['elevation'], 5, 80):.1f} deg", "azimuth": f"{360 * p['azimuth']:.1f} deg"}
    return sky


def draw_scene(point):
    """A scene as a dictionary, and its kinds of place: ground, camera, light, clouds."""
    p = point
    scene = {"version": 1}
    count = 1 + (p["count"] > 0.6) + (p["count"] > 0.85)
    clouds, base, extent = [], None, None
    for i, axis in enumerate(("kind", "kind2", "kind3")[:count]):
        cloud, own_base, own_extent = draw_cloud(p, pick(p[axis], KINDS), i)
        clouds.append(cloud)
        if base is None:
            base, extent = own_base, own_extent
    ground, keys, relief = draw_ground(p)
    scene.update(keys)
    if p["haze"] < 0.2:
        scene.setdefault("atmosphere", {})["preset"] = "earth-hazy"
    scene.update(draw_sun(p))
    place, camera = draw_camera(p, base, extent, relief)
    scene["camera"] = camera
    kinds = [f"ground {ground}", f"camera {place}", "light moon" if "moon" in scene else draw_light_kind(scene)]
    if p["shape"] < 0.08:
        kinds.append("stretched cloud")
        clouds[0]["stretch"] = [1, 1, round(mix_log(p["depth"], 0.1, 4), 3)]
    elif p["shape"] > 0.92:
        kinds.append("deep cloud")
        clouds[0]["deepen"] = round(mix_log(p["depth"], 3, 30), 2)
    if p["imported"] < 0.3 or "stretch" in clouds[0] or "deepen" in clouds[0]:
        clouds[0]["import"] = True
        kinds.append("imported cloud")
    if p["emission"] < 0.04:
        clouds[0]["emits"] = True
    scene["clouds"] = clouds
    return scene, kinds


def draw_light_kind(scene):
    elevation = float(scene["sun"]["elevation"].split()[0])
    return "light sun below 0" if elevation < 0 else "light sun 0 to 10" if elevation < 10 else "light sun above 10"
