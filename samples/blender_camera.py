# SPDX-License-Identifier: Apache-2.0
"""Writes the camera of a shot as Nuke's .chan, which `camera.motion` of a scene reads, also: one line a frame.

    blender -b SHOT.blend -P samples/blender_camera.py -- CAMERA.chan

The frames are those of the scene, the camera the active one, with markers that bind others. Blender's world has z up;
the file has y up, x as it is and -z for Blender's y, which nephos takes for north. Angles are in degrees, rotations
first about z, then x, then y; the last column is the vertical angle of view.
"""
import math
import sys

import bpy
from bpy_extras.io_utils import axis_conversion


def write(path):
    scene = bpy.context.scene
    up = axis_conversion(from_forward="Y", from_up="Z", to_forward="-Z", to_up="Y").to_4x4()
    with open(path, "w", encoding="ascii") as file:
        for frame in range(scene.frame_start, scene.frame_end + 1):
            scene.frame_set(frame)
            camera = scene.camera.evaluated_get(bpy.context.evaluated_depsgraph_get())
            matrix = up @ camera.matrix_world
            turn = [math.degrees(angle) for angle in matrix.to_3x3().normalized().to_euler("ZXY")]
            # view_frame is the picture at the distance 1 / (2 tan(fov / 2)), whatever the sensor fits
            corners = camera.data.view_frame(scene=scene)
            height = corners[0].y - corners[1].y
            angle = math.degrees(2.0 * math.atan2(0.5 * height, -corners[0].z))
            numbers = [*matrix.to_translation(), *turn, angle]
            file.write("\t".join([str(frame)] + ["%.9g" % number for number in numbers]) + "\n")


write(sys.argv[sys.argv.index("--") + 1])
