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


def measure_ground(luminance, octaves=4):
    """Standard deviation of log luminance, in %, in the finest octaves of lit ground, which is brighter than half of the
    median."""
    log = numpy.log(numpy.maximum(luminance, 1e-9))
    lit = ndimage.binary_erosion(luminance > 0.5 * numpy.median(luminance), iterations=2)
    out = []
    for octave in range(octaves):
        finer, log = log, ndimage.gaussian_filter(log, 0.75 * 2**octave)
        out.append(100 * (finer - log)[lit].std())
    return out


def measure_haze():
    """Mean L*a*b* of the preview's ring 2° from the sun."""
    rgb = nephos.Image.load(f"{sys.argv[1]}/haze.png")[["R", "G", "B"]].astype(float)
    y, x = numpy.indices(rgb.shape[:2])
    angle = numpy.hypot(x - 100, y - 56) * 20 / 201
    return compute_lab(rgb[abs(angle - 2) < 0.2]).mean(0)


def measure_dusk():
    """Largest step of the mean green of previews by the meter from degree to degree of a sinking sun."""
    means = [255 * nephos.Image.load(f"{sys.argv[1]}/low{e}.png")["G"].astype(float).mean() for e in range(6, -3, -1)]
    return abs(numpy.diff(means)).max()


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


def measure_base(alpha, below=14, above=40):
    """Median width, in pixels, in which alpha goes from 0.1 to 0.9 at the bases in base.exr, up columns with clear sky
    below and cloud above them. The ground's horizon is 17 pixels below the middle."""
    middle, widths, rows = alpha.shape[0] // 2, [], numpy.arange(-below, above, 0.1)
    for column in alpha.T:
        if column[middle + below] > 0.02 or column[middle - above] < 0.98:
            continue
        profile = numpy.interp(middle - rows, numpy.arange(len(column)), column)  # from below upwards
        dense = rows[profile > 0.9][0]
        widths.append(dense - rows[(profile < 0.1) & (rows < dense)][-1])
    return numpy.median(widths)


def compute_lab(rgb):
    """CIELAB under D65 of sRGB in 0 to 1."""
    light = numpy.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    xyz = light @ numpy.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]).T
    root = numpy.cbrt(xyz / [0.9505, 1.0, 1.0890])
    return numpy.stack([116 * root[..., 1] - 16, 500 * (root[..., 0] - root[..., 1]),
                        200 * (root[..., 1] - root[..., 2])], -1)


def measure_popping(frames=24):
    """Root mean square changes of luminance between successive frames of the approach: the largest over the median, and
    the largest over the mean of those before and after it. The first counts the way of the outline out of the picture
    too; the second is of frames that stand out."""
    pictures = [load(f"approach{frame}")[1] for frame in range(frames)]
    changes = numpy.array([numpy.sqrt(((b - a) ** 2).mean()) for a, b in zip(pictures, pictures[1:])])
    return changes.max() / numpy.median(changes), (2 * changes[1:-1] / (changes[:-2] + changes[2:])).max()


def measure_angles(shape):
    """Angle from the sun at each pixel of noon.yaml, in degrees."""
    forward = numpy.array([2.6, 5.4, 1.0]) / numpy.linalg.norm([2.6, 5.4, 1.0])
    right = numpy.cross(forward, [0, 0, 1]) / numpy.linalg.norm(numpy.cross(forward, [0, 0, 1]))
    y, x = numpy.indices(shape)
    scale = 2 * numpy.tan(numpy.radians(25)) / shape[1]
    ray = (forward + (x + 0.5 - shape[1] / 2)[..., None] * scale * right
           + (shape[0] / 2 - y - 0.5)[..., None] * scale * numpy.cross(right, forward))
    elevation, azimuth = numpy.radians([55, 100])
    sun = [numpy.cos(elevation) * numpy.sin(azimuth), numpy.cos(elevation) * numpy.cos(azimuth), numpy.sin(elevation)]
    return numpy.degrees(numpy.arccos(ray @ sun / numpy.linalg.norm(ray, axis=-1)))


def measure_preview():
    """Distance from neutral and mean component of the brightest tenth of opaque cloud; mean of G of sky 60° away."""
    alpha = numpy.array(nephos.Image.load(f"{sys.argv[1]}/noon.exr")["A"])
    rgb = nephos.Image.load(f"{sys.argv[1]}/noon.png")[["R", "G", "B"]].astype(float)
    opaque = (alpha > 0.98) & (numpy.indices(alpha.shape)[0] < alpha.shape[0] * 0.8)  # above the ground
    colours = compute_lab(rgb[opaque])
    bright = colours[:, 0] >= numpy.percentile(colours[:, 0], 90)
    mean = colours[bright].mean(0)
    sky = (alpha < 0.01) & (abs(measure_angles(alpha.shape) - 60) < 2)
    return numpy.hypot(mean[1], mean[2]), 255 * rgb[opaque][bright].mean(), 255 * rgb[sky].mean(0)[1]


near, far = load("near"), load("far")
edge = measure_edge(near[0])
contrast = measure_contrast(*far)
print("| criterion | value | limit |")
print("| --- | --- | --- |")
print(f"| edge of alpha from 0.1 to 0.9, voxels of 20 m at 3.1 m a pixel | {edge * METRES_A_PIXEL:.1f} m | ≤ 5 m |")
print(f"| contrast of log luminance, finest octave at 7 m a pixel | {contrast[0]:.2f} % | ≥ 1.0 % |")
print(f"| second octave | {contrast[1]:.2f} % | ≥ 1.5 % |")
print(f"| radiance 0.7° over 6.7° from the sun in clear air | {measure_aureole(load('sky')[1]):.2f} | ≥ 5 |")
print(f"| the same in hazy air | {measure_aureole(load('haze')[1]):.2f} | ≥ 5 |")
_, a, b = measure_haze()
print(f"| preview of hazy air 2° from the sun: a*, b* | {a:.1f}, {b:.1f} | not both below 0 (cyan) |")
print(f"| exposure by the meter, largest step of mean green, a degree of a sun from 6° to -2° | {measure_dusk():.0f} of 255 "
      "| ≤ 25 |")
ground = measure_ground(load("ground")[1])
print(f"| contrast of log luminance of lit ground, octaves from the finest | "
      f"{', '.join(f'{value:.1f}' for value in ground)} % | ≥ 5 % each |")
print(f"| error at a tilted horizon, 4 samples | {measure_horizon(load('horizon'), load('horizon_mean')):.3f} | ≤ 0.10 |")
neutral, cloud, sky = measure_preview()
print(f"| preview at noon: ΔE*ab of the brightest tenth of opaque cloud from neutral | {neutral:.2f} | ≤ 2 |")
print(f"| its sRGB | {cloud:.0f} | about 245 |")
print(f"| sRGB of sky 60° from the sun beside it, green | {sky:.0f} | 130 to 170 |")
print(f"| clear sky in the 2° between a deck and the ground | {100 * (load('deck')[0] < 0.5).mean():.0f} % | 0 % |")
print(f"| edge of alpha at bases of cumulus, from 0.1 to 0.9, voxels of 20 m at 4.5 m a pixel | "
      f"{measure_base(load('base')[0]):.1f} px | ≤ 2 px |")
largest, sudden = measure_popping()
print(f"| approach from 3 km to 150 m in 24 frames: largest change over the median | {largest:.2f} | ≤ 1.5 |")
print(f"| its largest change over the mean of its neighbours | {sudden:.2f} | ≤ 1.5 |")
