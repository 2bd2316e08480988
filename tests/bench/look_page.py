# SPDX-License-Identifier: Apache-2.0
"""Criteria of the look of pictures, for look.sh: prints the table."""
import sys

import nephos
import numpy
from scipy import ndimage

METRES_A_PIXEL = 3.1
LUMINANCE = numpy.array([0.2126, 0.7152, 0.0722])


def load(name):
    image = nephos.Image.load(f"{sys.argv[1]}/{name}.exr")
    return numpy.array(image["A"]), image[["R", "G", "B"]] @ LUMINANCE


def measure_edge(alpha, reach=20):
    """Median width, in pixels, in which alpha goes from 0.1 to 0.9 across the outline of 0.5."""
    gradient = numpy.array(numpy.gradient(ndimage.gaussian_filter(alpha, 1.5)))
    gradient /= numpy.linalg.norm(gradient, axis=0) + 1e-9
    inside = alpha > 0.5
    places = numpy.argwhere(inside & ~ndimage.binary_erosion(inside))[::3]
    steps = numpy.arange(-reach, reach, 0.1)
    middle, widths = len(steps) // 2, []
    for y, x in places:
        line = numpy.array([[y], [x]]) + gradient[:, y, x, None] * steps
        profile = ndimage.map_coordinates(alpha, line, order=1, mode="nearest")
        below = numpy.nonzero(profile[: middle + 15] < 0.1)[0]
        above = numpy.nonzero(profile[middle - 15 :] > 0.9)[0]
        if len(below) and len(above):
            widths.append(steps[middle - 15 + above[0]] - steps[below[-1]])
    return numpy.median(widths)


def measure_contrast(alpha, luminance, octaves=2):
    """Standard deviation of log luminance, in %, in the finest octaves inside of opaque cloud, the most extreme 2 %
    left out: edges of one cloud before another."""
    inside = ndimage.binary_erosion(alpha > 0.995, iterations=8)
    coarser, out = numpy.log(numpy.maximum(luminance, 1e-9)), []
    for octave in range(octaves):
        finer, coarser = coarser, ndimage.gaussian_filter(coarser, 0.75 * 2**octave)
        band = (finer - coarser)[inside]
        out.append(100 * band[abs(band) < numpy.percentile(abs(band), 98)].std())
    return out


def measure_aureole(luminance):
    """Radiance 0.7° from the sun over that 6.7° from it. The sun is in the middle of 201 × 113 pixels of 20°."""
    y, x = numpy.indices(luminance.shape)
    angle = numpy.hypot(x - 100, y - 56) * 20 / 201
    near, far = (luminance[abs(angle - ring) < 0.1].mean() for ring in (0.7, 6.7))
    return near / far


def measure_horizon(alpha, mean):
    """Root mean square error of pixels that the horizon cuts, of the difference between ground and sky."""
    (coverage, some), (truth, all_samples) = alpha, mean
    cut = (truth > 0.1) & (truth < 0.9)
    contrast = abs(all_samples[truth < 0.01].mean() - all_samples[truth > 0.99].mean())
    return numpy.sqrt(((some - all_samples)[cut] ** 2).mean()) / contrast


near, far = load("near"), load("far")
edge = measure_edge(near[0])
contrast = measure_contrast(*far)
print("| criterion | value | limit |")
print("| --- | --- | --- |")
print(f"| edge of alpha from 0.1 to 0.9, voxels of 20 m at 3.1 m a pixel | {edge * METRES_A_PIXEL:.1f} m | ≤ 5 m |")
print(f"| contrast of log luminance, finest octave at 7 m a pixel | {contrast[0]:.2f} % | ≥ 1.0 % |")
print(f"| second octave | {contrast[1]:.2f} % | ≥ 1.5 % |")
print(f"| radiance 0.7° over 6.7° from the sun in clear air | {measure_aureole(load('sky')[1]):.2f} | ≥ 5 |")
print(f"| error at a tilted horizon, 4 samples | {measure_horizon(load('horizon'), load('horizon_mean')):.3f} | ≤ 0.10 |")
