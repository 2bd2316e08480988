# SPDX-License-Identifier: Apache-2.0
"""Files of drawn scenes: the scene, the clouds that it imports and its heights."""

import json
import os

from pictures import run
from scenes import draw_heights, draw_scene


def import_clouds(nephos, scene, folder, name):
    """Bakes the clouds that are to be imported to files of the folder and puts these in their places."""
    for i, cloud in enumerate(scene["clouds"]):
        stretch, deepen = cloud.pop("stretch", None), cloud.pop("deepen", None)
        emits, is_imported = cloud.pop("emits", False), cloud.pop("import", False)
        if emits:
            cloud["albedo"] = 0.8
        if not is_imported:
            continue
        file = f"{name}.{i}.vdb"
        alone = os.path.join(folder, f"{name}.{i}.bake.yaml")
        path = os.path.join(folder, file)
        if not os.path.exists(path):
            parts = {key: scene[key] for key in ("terrain",) if key in scene}
            with open(alone, "w") as out:
                json.dump({"version": 1, "clouds": [cloud], **parts}, out)
            run(nephos, "bake", alone, "-o", path, "-q")
        placed = {"vdb": file}
        if stretch:
            placed["scale"] = stretch
        if deepen:
            placed["optical_depth"] = 20 * deepen
        if emits:
            placed["emission"] = {"flame": "density", "temperature": "none", "offset": "2500 K",
                                  "absorption": "0.002 1/m"}
        scene["clouds"][i] = placed


def write_heights(scene, folder, name):
    """Puts a file of the folder in the place of drawn heights."""
    field = scene.get("terrain", {}).get("heightfield")
    if not field:
        return
    heights = draw_heights(**field)
    heights.tofile(os.path.join(folder, name + ".raw"))
    scene["terrain"].update(heightfield=name + ".raw", raw={"size": list(heights.shape), "type": "float32"})


def write_scene(nephos, point, folder, name):
    """File of a drawn scene, and its kinds."""
    scene, kinds = draw_scene(point)
    write_heights(scene, folder, name)
    import_clouds(nephos, scene, folder, name)
    path = os.path.join(folder, name + ".yaml")
    with open(path, "w") as out:
        json.dump(scene, out, indent=1)
    return path, kinds
