# SPDX-License-Identifier: Apache-2.0
"""Plots the radiance of a field of cumulus against the elevation of the sun.

    python3 samples/radiance_by_elevation.py [SCENE.yaml] [-o PLOT.png] [--steps N] [--resolution WIDTHxHEIGHT]

One renderer keeps clouds and tables from picture to picture. Pixels count as cloud where alpha is above a half.
"""
# %% Options
import argparse
import os

import matplotlib
import nephos
import numpy

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402, after the choice of a backend without a window

here = os.path.dirname(os.path.abspath(__file__))
parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("scene", nargs="?", default=os.path.join(here, "cumulus_field.yaml"))
parser.add_argument("-o", "--output", default="radiance_by_elevation.png")
parser.add_argument("--steps", type=int, default=12)
parser.add_argument("--resolution", default="96x54")
options = parser.parse_args()
resolution = tuple(int(side) for side in options.resolution.split("x"))

# %% Pictures
scene = nephos.load(options.scene)
scene["render.quality"] = "preview"
renderer = nephos.Renderer()
elevations = numpy.linspace(2, 80, options.steps)
means, deviations = [], []
for elevation in elevations:
    scene["sun.elevation"] = elevation
    image = renderer.render(scene, resolution=resolution, samples=2)
    pixels, error = image[["R", "G", "B"]], image.error
    cloud = image["A"] > 0.5
    means.append([pixels[cloud].mean(axis=0), pixels[~cloud].mean(axis=0)])
    deviations.append(error["error"]["value"] if error else numpy.nan)
    print("elevation %4.1f°: cloud %.4f, sky %.4f, error %.1f %%"
          % (elevation, means[-1][0][1], means[-1][1][1], 100 * deviations[-1]))

# %% Plot
means = numpy.array(means)  # step, cloud or sky, band
figure, axes = pyplot.subplots(figsize=(7, 4.5), layout="constrained")
for band, color in enumerate(("tab:red", "tab:green", "tab:blue")):
    axes.plot(elevations, means[:, 0, band], color=color, label="cloud, %s" % "RGB"[band])
    axes.plot(elevations, means[:, 1, band], color=color, linestyle="dashed", label="sky, %s" % "RGB"[band])
axes.set(xlabel="elevation of the sun (degrees)", ylabel="mean radiance (W m$^{-2}$ sr$^{-1}$ nm$^{-1}$)")
axes.legend()
figure.savefig(options.output, dpi=120)
print(options.output)
