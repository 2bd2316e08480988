# SPDX-License-Identifier: Apache-2.0
# A stereo camera makes two pictures, named by their eyes, or the one that is asked for.
cat >scene.yaml <<'END'
camera: {position: [0, 0, 2], look_at: [0, 10, 2], resolution: [4, 2], stereo: {interaxial: 10 cm}}
atmosphere: none
render: {samples: 1}
output: {image: "shot.%V.##.exr"}
END
nephos render scene.yaml -q | sed 's/, [0-9.]* s, .*//'
nephos info shot.left.01.exr | grep -w view
nephos info shot.right.01.exr | grep -w view
nephos render scene.yaml -q --set camera.stereo.eye=right -o one.%V.exr | sed 's/, [0-9.]* s, .*//'
nephos render scene.yaml -q -o one.exr || echo $?
nephos render scene.yaml -q --frames 1-2 -n --set "output.image=f.%V.#.exr"
# Both are exposed alike, by the light on the scene.
nephos render scene.yaml --progress none -v --set camera.look_at=[0,10,5] -o lit.%V.png 2>&1 | grep 'preview: exposed' >exposures
[ $(wc -l <exposures) = 2 ] && sort -u exposures | wc -l
