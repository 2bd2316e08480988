# SPDX-License-Identifier: Apache-2.0
"""Camera's places on its way to the cloud in the middle of approach.yaml, for look.sh: number, position and look_at, from
3 km to 150 m before the surface, at distances that shrink by the same factor."""
import sys

import nephos
import numpy

FRAMES = 24
FAR_M, NEAR_M = 3000.0, 150.0

start, middle = numpy.array([-3000.0, -5000.0, 1400.0]), numpy.array([0.0, 0.0, 1800.0])
depth = numpy.array(nephos.Image.load(sys.argv[1])["Z"])
forward = (middle - start) / numpy.linalg.norm(middle - start)
surface = start + forward * depth[depth.shape[0] // 2, depth.shape[1] // 2]


def write(place):
    return "[" + ", ".join(f"{value:.3f} m" for value in place) + "]"


for frame in range(FRAMES):
    distance = FAR_M * (NEAR_M / FAR_M) ** (frame / (FRAMES - 1))
    print(f"{frame};{write(surface - distance * forward)};{write(surface)}")
