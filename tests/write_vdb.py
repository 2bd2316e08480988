# SPDX-License-Identifier: Apache-2.0
# write_vdb.py FOLDER: files of OpenVDB's own Python module, for test_vdb_kinds.
import sys

import pyopenvdb


def make_box(kind, name, low, high, value, voxel):
    grid = kind()
    grid.name = name
    grid.fill(low, high, value)
    grid.transform = pyopenvdb.createLinearTransform(voxel)
    return grid


def write(name, *grids):
    pyopenvdb.write(sys.argv[1] + "/" + name, list(grids))


ball = pyopenvdb.createLevelSetSphere(radius=10, voxelSize=0.5, halfWidth=4)
ball.name = "surface"
write("ball.vdb", ball)

fog = make_box(pyopenvdb.FloatGrid, "Smoke", (0, 0, 0), (15, 15, 15), 0.25, 1.0)
write("both.vdb", ball, fog)

mark = make_box(pyopenvdb.BoolGrid, "mark", (0, 0, 0), (15, 15, 15), True, 1.0)
write("mark.vdb", mark)

density = make_box(pyopenvdb.FloatGrid, "DENSITY", (0, 0, 0), (15, 15, 15), 0.5, 1.0)
finer = make_box(pyopenvdb.FloatGrid, "fuel", (0, 0, 0), (31, 31, 31), 0.125, 0.5)
write("parts.vdb", density, fog, finer)

view = pyopenvdb.FloatGrid()
view.name = "density"
view.fill((0, 0, 0), (31, 31, 31), 1.0)
view.transform = pyopenvdb.createFrustumTransform((0, 0, 0), (31, 31, 31), 0.5, 1.0, 1.0)
write("view.vdb", view)
