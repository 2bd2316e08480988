#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Writes ball.nc: a small cloud of two time steps, in the names of MicroHH and in the classic format of NetCDF."""
import os

import numpy
from scipy.io import netcdf_file

SIZES = {"time": 2, "z": 10, "y": 10, "x": 12}
LINES = {"time": ("seconds since 2000-01-01 00:00:00", 60.0), "z": ("m", 40.0), "y": ("m", 50.0), "x": ("m", 50.0)}

path = os.path.join(os.path.dirname(os.path.abspath(__file__)), "ball.nc")
with netcdf_file(path, "w") as file:
    lines = {}
    for name, size in SIZES.items():
        unit, step = LINES[name]
        file.createDimension(name, size)
        variable = file.createVariable(name, "f", (name,))
        variable[:] = lines[name] = step * (numpy.arange(size) + (0.5 if name in "xy" else 0.0)) + (name == "z") * 620.0
        variable.units = unit
    t, z, y, x = numpy.meshgrid(*(lines[name] for name in SIZES), indexing="ij")
    radius = ((x - 280 - t) / 220) ** 2 + ((y - 250) / 200) ** 2 + ((z - 800) / 170) ** 2
    water = file.createVariable("ql", "f", tuple(SIZES))
    water[:] = 6e-4 * numpy.maximum(0.0, 1.0 - radius)
    water.units = "kg kg-1"
