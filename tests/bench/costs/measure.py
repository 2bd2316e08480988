# SPDX-License-Identifier: Apache-2.0
"""Renders of drawn and given scenes: measured seconds of each stage and memory, and the predictions of a plan."""

import json
import os
import re
import subprocess
import sys

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "population"))

import pictures  # noqa: E402
from drawn import write_scene  # noqa: E402
from pictures import Refused, run  # noqa: E402
from scenes import draw_points  # noqa: E402

# Resolution and further arguments of drawn scenes, in turn.
SETTINGS = (
    ("64x36", ()), ("96x54", ("--quality", "preview")), ("32x18", ("--integrator", "path", "--samples", "8")),
    ("96x54", ()), ("32x18", ()), ("96x54", ("--quality", "draft")),
    ("48x27", ("--integrator", "path", "--samples", "16")), ("64x36", ("--quality", "preview")),
)

STAGE = re.compile(r"([a-z ]+): predicted \S+ s of one core, measured (\S+) s")
CALIBRATED = re.compile(r"calibration: .* takes (\S+) s of one core")
WHOLE = re.compile(r"prediction: .*; measured (\S+) s")


def write_file_scene(file, folder):
    """Writes a scene of one cloud, a kilometre or so across, from a .vdb file; its voxels are made as long."""
    path = os.path.join(folder, "file." + os.path.splitext(os.path.basename(file))[0] + ".yaml")
    scene = {
        "version": 1,
        "camera": {"position": [0, -2500, 500], "look_at": [0, 0, 1000], "fov": "40 deg", "resolution": [160, 90]},
        "sun": {"elevation": "35 deg", "azimuth": "120 deg"},
        "clouds": [{"vdb": os.path.abspath(file), "voxel": "6 m", "optical_depth": 30, "position": [0, 0, 600]}],
    }
    with open(path, "w") as out:
        json.dump(scene, out, indent=1)
    return path


def render(nephos, scene, arguments, folder):
    """Measured seconds of one core, of all and by stage, and the peak of memory in bytes."""
    command = [nephos, "render", scene, *arguments, "-o", os.path.join(folder, "picture.exr"), "--json", "--progress",
               "none", "-v", "-v"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise Refused((done.stderr.strip().splitlines() or ["exit %d" % done.returncode])[-1])
    whole = WHOLE.findall(done.stderr)
    stages = {name.strip(): float(seconds) for name, seconds in STAGE.findall(done.stderr)}
    return {"seconds": float(whole[-1]), "stages": stages, "bytes": json.loads(done.stdout)["memory_bytes"]}


def calibrate(nephos, folder):
    """Measures this machine once: its file of factors, and seconds of the stages of NP_CALIBRATION_ROWS."""
    machine, kept = (os.path.join(folder, name) for name in ("machine.json", "calibration.json"))
    if not (os.path.exists(machine) and os.path.exists(kept)):
        messages = pictures.calibrate(nephos, machine)
        with open(kept, "w") as out:
            json.dump([float(text) for text in CALIBRATED.findall(messages)], out)
    return machine


def read_calibration(folder):
    with open(os.path.join(folder, "calibration.json")) as file:
        return json.load(file)


def explain(nephos, scene, arguments, machine):
    """Predicted seconds, bytes and units of work of each stage, by the factors of a machine."""
    arguments = (*arguments, "--machine", machine, "--explain", "--json", "-q")
    plan = json.loads(run(nephos, "render", scene, *arguments)[0])
    stages = {s["stage"]: {"seconds": s.get("seconds", 0.0), "bytes": s.get("bytes", 0.0), "units": s.get("units", {})}
              for s in plan["stages"] if s["needed"]}
    return {"seconds": plan["prediction"]["seconds"], "bytes": plan["prediction"]["bytes"], "stages": stages,
            "units": plan.get("units", {})}


def list_cases(nephos, options):
    """Name, scene, arguments and whether constants are fitted to it."""
    for i, point in enumerate(draw_points(int(options.seed, 16), max(options.count, 1))[:options.count]):
        name, (size, arguments) = f"{options.seed}.{i}", SETTINGS[i % len(SETTINGS)]
        yield name, write_scene(nephos, point, options.folder, name)[0], ("--resolution", size, *arguments), True
    for folder, suffix in ((options.scenes, ".yaml"), (options.files, ".vdb")):
        for file in sorted(os.listdir(folder)) if folder else []:
            if not file.endswith(suffix):
                continue
            path = os.path.join(folder, file)
            scene = write_file_scene(path, options.folder) if suffix == ".vdb" else path
            yield file, scene, ("--resolution", "96x54") if suffix == ".yaml" else (), False


def measure(nephos, options):
    """All cases that render, each measured once, with their predictions."""
    machine = calibrate(nephos, options.folder)
    for name, scene, arguments, is_fitted in list_cases(nephos, options):
        kept = os.path.join(options.folder, name + ".measured.json")
        try:
            if not os.path.exists(kept):
                found = render(nephos, scene, arguments, options.folder)
                with open(kept, "w") as out:
                    json.dump(found, out)
            with open(kept) as file:
                found = json.load(file)
            found["predicted"] = explain(nephos, scene, arguments, machine)
        except Refused as refusal:
            print(f"{name}: {refusal}", file=sys.stderr)
            continue
        found.update(name=name, is_fitted=is_fitted)
        print(f"{name}: {found['seconds']:.2f} s, predicted {found['predicted']['seconds']:.2f} s; "
              f"{1e-6 * found['bytes']:.0f} MB, predicted {1e-6 * found['predicted']['bytes']:.0f} MB", file=sys.stderr)
        yield found
