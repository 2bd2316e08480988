#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# blender_camera.sh [NEPHOS]: moves a camera in Blender, writes it by blender_camera.py, and compares position, direction,
# roll and angle of view that nephos reads with Blender's own: 2 cm in a target 1 km away at most. Wants Blender.
set -eu
nephos=${1:-nephos}
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cat >"$work/shot.py" <<'END'
import math, sys
import bpy
from mathutils import Vector
sys.argv = ["", "--", sys.argv[-1]]
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.frame_start, scene.frame_end = 1, 3
scene.render.resolution_x, scene.render.resolution_y = 96, 54
camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
scene.collection.objects.link(camera)
scene.camera = camera
for frame in (1, 3):
    camera.location = (100 * frame, -300, 20 + 5 * frame)
    camera.rotation_euler = (1.4 + 0.1 * frame, 0.2 * frame, 0.5 - 0.3 * frame)
    camera.keyframe_insert("location", frame=frame)
    camera.keyframe_insert("rotation_euler", frame=frame)
camera.data.lens = 35
exec(compile(open(sys.argv[-1].rsplit("/", 1)[0] + "/blender_camera.py").read(), "camera", "exec"))
for frame in range(1, 4):
    scene.frame_set(frame)
    m = camera.matrix_world
    forward, up = (m.to_3x3() @ Vector(v) for v in ((0, 0, -1), (0, 1, 0)))
    right = forward.cross(Vector((0, 0, 1))).normalized()
    roll = math.degrees(math.atan2(up.dot(right), up.dot(right.cross(forward))))
    target = m.to_translation() + 1000 * forward
    print("pose", frame, *["%.6g" % v for v in (*m.to_translation(), *target, math.degrees(camera.data.angle), roll)])
END
cp "$here/blender_camera.py" "$work"
(cd "$work" && blender -b --python-exit-code 1 -P shot.py -- "$work/shot.chan") >"$work/log" 2>&1 || {
  cat "$work/log"
  exit 1
}
echo "camera: {resolution: [96, 54], motion: {file: shot.chan}}" >"$work/scene.yaml"
for frame in 1 2 3; do
  grep "^pose $frame " "$work/log"
  "$nephos" info "$work/scene.yaml" --frame "$frame" |
    awk '$1 ~ /^camera.(position|look_at|fov|roll):/ {
           for (i = 2; i <= NF; i++) { gsub(/[][,]/, "", $i); if ($i ~ /^-?[0-9]/) { v = $i; if ($(i + 1) ~ /^km/) v *= 1000; printf " %.6g", v } }
         } END { print "" }'
done | awk '/^pose/ { for (i = 3; i <= NF; i++) own[i - 2] = $i; next }
  { for (i = 1; i <= 8; i++) { off = $i - own[i]; if (off < 0) off = -off; if (off > worst) worst = off } count++ }
  END { printf "%d frames, largest difference %.2g\n", count, worst; exit !(count == 3 && worst < 0.02) }'
