# SPDX-License-Identifier: Apache-2.0
cat >scene.yaml <<'END'
camera: {resolution: [32, 18]}
atmosphere: none
environment: {radiance: 0.1}
terrain: {ridges: {samples: 65}}
END
nephos render scene.yaml -q -o a.exr
nephos render scene.yaml -q -o b.exr --set environment.radiance=0.2
nephos compare a.exr b.exr >/dev/null
nephos compare a.exr b.exr --max-rel-mse 10 -o d.exr >/dev/null
ls d.exr
try() { if nephos compare a.exr b.exr "$@" 2>/dev/null; then exit 99; else [ $? -eq 7 ]; fi; }
try --exact >/dev/null
try --max-rel-mse 1e-9 >/dev/null
nephos compare a.exr b.exr --json | grep -o '"[a-z0-9_]*"'
