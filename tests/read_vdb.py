# SPDX-License-Identifier: Apache-2.0
# read_vdb.py FILE: what OpenVDB's own Python module finds in a .vdb, one fact a line, for test_vdb_tools:
# "meta GRID KEY VALUE" (line ends in VALUE as blanks) and "voxel GRID I J K X [Y Z]" of each active one.
import sys

import pyopenvdb

grids, _ = pyopenvdb.readAll(sys.argv[1])
for grid in grids:
    print("type", grid.name, grid.valueTypeName)
    print("voxel_size", grid.name, *grid.transform.voxelSize())
    print("origin", grid.name, *grid.transform.indexToWorld((0, 0, 0)))
    print("background", grid.name, *(grid.background if grid.valueTypeName == "vec3s" else [grid.background]))
    for key, value in grid.metadata.items():
        print("meta", grid.name, key, str(value).replace("\n", " "))
    for item in grid.citerOnValues():
        if item.count != 1:
            sys.exit("an active tile")
        values = item.value if grid.valueTypeName == "vec3s" else [item.value]
        print("voxel", grid.name, *item.min, *(repr(float(value)) for value in values))
