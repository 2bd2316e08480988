# SPDX-License-Identifier: Apache-2.0
"""Draws scenes, renders them by both integrators and prints what the march errs by."""

import argparse
import json
import os
import sys
import tempfile
from collections import deque
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy

from drawn import write_scene
from pictures import Refused, calibrate, compute_regions, render, run
from report import print_page
from scenes import draw_points

SPREAD = 0.02  # relative standard error of a region's reference below which it counts as resolved
SEEDS = 4
SAMPLES_FIRST = 8
COVER_LEAST = 0.02  # mean opacity of clouds in a picture that shows some
DIM = 0.01  # luminance over the picture's mean below which a pixel says nothing of relative errors
HALF_WEIGHT_NOISE = 0.05  # noise at which a pixel and those around it have equal weight in the scale
LUMINANCE = numpy.array([0.2126, 0.7152, 0.0722])  # of Rec. 709, ITU-R BT.709


class Traced(NamedTuple):
    """A picture by path: its luminance, the samples of a pixel, and the noise that it states."""
    luminance: numpy.ndarray
    samples: int
    noise: float


def choose_cache(options, folder, name):
    """Options of a scene's renders by which they share bakes, tables and light."""
    return ("--cache", os.path.join(folder, name + ".cache")) if options.shared else ()


def render_reference(nephos, scene, stem, common, limit):
    """Mean of the reference's regions, their relative standard errors, its CPU seconds, the picture of each seed, and
    the noise that pictures state and show. Samples double until the regions that see anything are resolved, or the
    limit on CPU seconds is reached."""
    samples, seconds, sums, pictures, weight, traced = SAMPLES_FIRST, 0.0, 0.0, 0.0, 0, []
    while True:
        parts = []
        for seed in range(SEEDS):
            picture, _, facts = render(nephos, scene, f"{stem}.path{samples}.{seed}.exr", *common, "--integrator", "path",
                                       "--samples", samples, "--set", f"render.seed={1000 * samples + seed}")
            parts.append(picture)
            traced.append(Traced(picture @ LUMINANCE, samples, facts["noise"]))
            seconds += facts["cpu_seconds"]
        pictures = pictures + samples * numpy.stack(parts).astype(numpy.float64)
        sums = sums + samples * numpy.stack([compute_regions(part) for part in parts])
        weight += samples
        means = sums / weight
        mean = means.mean(0)
        with numpy.errstate(divide="ignore", invalid="ignore"):
            error = means.std(0, ddof=1) / numpy.sqrt(SEEDS) / mean
        is_seen = mean.max(1) > 1e-3 * mean.max()
        is_resolved = (error < SPREAD).all(1) & is_seen
        if is_resolved.sum() >= 0.85 * is_seen.sum() or 3.0 * seconds > limit:
            return mean, error, is_resolved, is_seen, seconds, pictures / weight, compare_noise(traced)
        samples *= 2


def compute_scale(mean, error):
    """Luminance that a pixel's differences are relative to: where its own is noisy, that of the eight around it
    (docs/error.md)."""
    padded, one = numpy.pad(mean, 1), numpy.pad(numpy.ones_like(mean), 1)
    shifts = [(slice(y, y + mean.shape[0]), slice(x, x + mean.shape[1])) for y in range(3) for x in range(3)]
    around = (sum(padded[s] for s in shifts) - mean) / (sum(one[s] for s in shifts) - 1.0)
    weight = 1.0 / (1.0 + (error / numpy.maximum(around, 1e-300) / HALF_WEIGHT_NOISE) ** 2)
    return weight * mean + (1.0 - weight) * around


def compare_noise(traced):
    """Noise that each traced picture states, and that which it shows against the mean of all others."""
    out = []
    for own in traced:
        others = [t for t in traced if t is not own]
        weights = numpy.array([t.samples for t in others]) / sum(t.samples for t in others)
        mean = sum(w * t.luminance for w, t in zip(weights, others))
        variance = sum((w * (t.luminance - mean)) ** 2 for w, t in zip(weights, others)) * len(others) / (len(others) - 1)
        scale = compute_scale(mean, numpy.sqrt(variance))
        is_bright = scale > DIM * mean.mean()
        square = (((own.luminance - mean) ** 2 - variance) / scale ** 2)[is_bright].mean()
        out.append((own.noise, max(square, 0.0) ** 0.5))
    return out


def compare_pixels(marches, paths):
    """Bias of a pixel, its bounds of three deviations, and its error, as docs/error.md defines them. Products of
    differences by two seeds of each integrator hold no noise."""
    marches, paths = [m @ LUMINANCE for m in marches], [p @ LUMINANCE for p in paths]
    mean = 0.5 * (marches[0] + marches[1])
    is_bright = mean > DIM * mean.mean()
    products = [((paths[a] - marches[0]) * (paths[b] - marches[1]) / mean ** 2)[is_bright].mean()
                for a in range(len(paths)) for b in range(len(paths)) if a != b]
    noise2 = (0.5 * (marches[0] - marches[1]) ** 2 / mean ** 2)[is_bright].mean()
    bias2, deviation = max(numpy.mean(products), 0.0), numpy.std(products, ddof=1) / len(paths) ** 0.5
    bounds = [max(bias2 + sign * 3 * deviation, 0.0) ** 0.5 for sign in (-1, 1)]
    return bias2 ** 0.5, bounds, (bias2 + noise2) ** 0.5


def measure(nephos, point, folder, name, options):
    """All that the page says of one scene; None: it shows no cloud, or its camera is in the ground. Each picture takes
    one thread, so that its CPU seconds are those that a plan predicts for one."""
    scene, kinds = write_scene(nephos, point, folder, name)
    stem, size = os.path.join(folder, name), ("--resolution", options.resolution, "-t", 1)
    common = (*size, *choose_cache(options, folder, name))
    _, cover, look = render(nephos, scene, stem + ".look.exr", *common, "--quality", "draft", "--samples", 1)
    if cover.mean() < COVER_LEAST or "below the ground" in look["messages"]:
        return None
    machine = ("--machine", options.machine) if options.machine else ()
    predicted = json.loads(run(nephos, "render", scene, *size, *machine, "--explain", "--json", "-q")[0])["prediction"]
    march, cover, facts = render(nephos, scene, stem + ".march.exr", *common)
    again, _, _ = render(nephos, scene, stem + ".again.exr", *common, "--set", "render.seed=77")
    reference, error, is_resolved, is_seen, seconds, paths, noise = render_reference(nephos, scene, stem, common,
                                                                                     options.limit)
    first, second = compute_regions(march), compute_regions(again)
    with numpy.errstate(divide="ignore", invalid="ignore"):
        bias = (0.5 * (first + second) / reference - 1.0)[is_resolved]
    true_bias, bounds, true_error = compare_pixels((march, again), paths)
    return {
        "name": name, "kinds": kinds, "bias": bias.tolist(), "error": error[is_resolved].tolist(),
        "place": numpy.flatnonzero(is_resolved).tolist(), "seen": int(is_seen.sum()),
        "true_bias": true_bias, "bias_bounds": bounds, "true_error": true_error,
        "path_noise": noise, "stated_bias": facts["bias"], "stated_error": facts["error"],
        "seconds": facts["cpu_seconds"], "predicted_seconds": predicted["seconds"],
        "bytes": facts["memory_bytes"], "predicted_bytes": predicted["bytes"],
        "bad": int((~numpy.isfinite(march) | (march < 0)).any(-1).sum()), "reference_seconds": seconds,
    }


def measure_if_allowed(nephos, point, folder, name, options):
    """Result of a scene, or the message by which the program refused it."""
    try:
        return measure(nephos, point, folder, name, options)
    except Refused as refusal:
        return str(refusal)


def measure_in_turn(nephos, folder, options):
    """Names and results of the drawn scenes in their order; those that follow are measured meanwhile."""
    drawn, waiting = max([4 * options.count] + [n + 1 for n in options.scenes or []]), deque()
    with ThreadPoolExecutor(options.jobs) as pool:
        for i, point in enumerate(draw_points(int(options.seed, 16), drawn)):
            if options.scenes and i not in options.scenes:
                continue
            name = f"{options.seed}.{i}"
            waiting.append((name, pool.submit(measure_if_allowed, nephos, point, folder, name, options)))
            if len(waiting) >= 4 * options.jobs:
                name, job = waiting.popleft()
                yield name, job.result()
        for name, job in waiting:
            yield name, job.result()


def measure_all(nephos, folder, options):
    """Results of the scenes, and those that the program refused, with its messages."""
    os.makedirs(folder, exist_ok=True)
    if options.machine and not os.path.exists(options.machine):
        calibrate(nephos, options.machine)
    results, refused = [], []
    for name, found in measure_in_turn(nephos, folder, options):
        if isinstance(found, str):
            refused.append((name, found))
            print(f"{name}: {found}", file=sys.stderr)
        elif found:
            results.append(found)
            worst = max((abs(b) for row in found["bias"] for b in row), default=0.0)
            print(f"{name}: {len(found['bias'])} of {found['seen']} regions resolved, worst {100 * worst:.1f} %, "
                  f"stated bias {100 * found['stated_bias']:.1f} %, true {100 * found['true_bias']:.1f} %, reference "
                  f"{found['reference_seconds']:.0f} CPU s", file=sys.stderr)
        if len(results) + len(refused) == options.count:
            break
    return results, refused


def main():
    parser = argparse.ArgumentParser(prog="population.sh")
    parser.add_argument("nephos")
    parser.add_argument("--seed", required=True)
    parser.add_argument("--count", type=int, required=True)
    parser.add_argument("--folder", help="for scenes and pictures; a temporary one by default")
    parser.add_argument("--limit", type=float, default=300.0)
    parser.add_argument("--page")
    parser.add_argument("--resolution", default="64x36", help="of the pictures")
    parser.add_argument("--scenes", type=lambda text: [int(n) for n in text.split(",")],
                        help="numbers of the draw, 0 the first, in place of all that show clouds")
    parser.add_argument("--machine", help="file of factors on predicted seconds, measured if it is not there")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="scenes at once, each on one thread")
    parser.add_argument("--shared", action="store_true", help="a cache for each scene, which seconds of the page leave out")
    parser.add_argument("--worst", type=float, help="fail where a resolved region errs by more; a share")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        results, refused = measure_all(os.path.abspath(options.nephos), options.folder or temporary, options)
    out = open(options.page, "w") if options.page else sys.stdout
    if any(r["bias"] for r in results):
        print_page(results, refused, options, out)
    else:
        print("no region is resolved: no page, raise --limit", file=sys.stderr)
    return check(results, refused, options.worst)


def check(results, refused, worst):
    """Exit status: 1 where a scene is refused, a pixel is not finite or negative, or a region errs by more."""
    is_wrong = refused or any(r["bad"] for r in results)
    largest = max((abs(b) for r in results for row in r["bias"] for b in row), default=0.0)
    return 1 if is_wrong or (worst is not None and (not results or largest > worst)) else 0


sys.exit(main())
