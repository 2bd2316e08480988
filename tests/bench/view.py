# SPDX-License-Identifier: Apache-2.0
"""Latency of `nephos view`, by HTTP as its page has it: prints the table of docs/results/view.md.

    /usr/bin/python3 view.py NEPHOS [CLOUD.vdb]

NEPHOS     the program, beside its tests
CLOUD.vdb  wdas_cloud_sixteenth.vdb, for the last table

CPU seconds are those of the program, threads of the server included: other processes may compute meanwhile. Wall times
are medians, and hold on an idle machine alone. What is rebuilt is read in the log of a second view: with a verbose log
each picture bakes its clouds once more, with few voxels, for a prediction of its time."""
import json
import os
import random
import re
import statistics
import subprocess
import sys
import tempfile
import threading
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "view"))
from view_server import View  # noqa: E402

DISNEY = """version: 1
camera: {position: [0, -700 m, 1600 m], look_at: [0, 0, 1640 m], fov: 40 deg, resolution: [960, 540]}
sun: {elevation: 25 deg, azimuth: 10 deg}
clouds:
  - {vdb: CLOUD, up: y, optical_depth: 40, position: [0, 0, 1500 m], phase: {hg: 0.85}, albedo: 0.999995}
"""


def get_field():
    """The scene of samples/cumulus_field.yaml without the file of its cloud."""
    text = open(os.path.join(HERE, "..", "..", "samples", "cumulus_field.yaml")).read()
    return re.sub(r" *vdb: .*\n|output: .*\n", "", text)


def cpu_seconds(view):
    """CPU time of the program, by the clock of its process."""
    return time.clock_gettime((~view.process.pid << 3) | 2)


class Shown(dict):
    """Costs of an edit: seconds from its POST, and CPU seconds, until few pixels, all pixels, and all with the scene's
    samples and light of their own are on the page."""


def follow(view, holds):
    """The first state for which `holds` returns true; pictures are taken once each, as the page does."""
    state = {"number": 0, "marks": [[0], [0], [0]]}
    while not holds(state):
        state, _ = view.picture(state["number"])
    return state


def measure(view, *lines):
    """Sets keys once the view rests, and follows the picture until the scene's own is there."""
    view.wait_done(300)
    mark, start, cpu = len(view.messages), time.monotonic(), cpu_seconds(view)
    status, answer = view.set(*lines)
    assert status == 200, answer
    shown = Shown(answered_s=time.monotonic() - start)
    wanted = answer["wanted"]
    state = follow(view, lambda s: s["marks"][2][0] == wanted or (s.get("stage") == "done" and s["marks"][1][0] == wanted))
    for name, (generation, seconds, at_cpu) in zip(("few", "full", "final"), state["marks"]):
        if generation == wanted:
            shown[name], shown[name + "_s"] = at_cpu - cpu, seconds
    for unit in ("", "_s"):  # a scene with few samples has all of them in the first picture of all pixels
        shown.setdefault("final" + unit, shown["full" + unit])
    shown["log"] = view.messages[mark:]
    return shown


def median(costs, name):
    values = [c[name] for c in costs if name in c]
    return statistics.median(values) if values else float("nan")


def row(line, edit, goal, measured):
    print(f"| {line} | {edit} | {goal} | {measured} |", flush=True)


def describe(costs):
    return (f"{median(costs, 'few'):.2f} CPU s, {1e3 * median(costs, 'few_s'):.0f} ms; all {median(costs, 'full'):.2f} CPU s, "
            f"{median(costs, 'full_s'):.1f} s; final {median(costs, 'final'):.2f} CPU s, {median(costs, 'final_s'):.1f} s")


def count_lines(lines, pattern):
    return sum(bool(re.search(pattern, line)) for line in lines)


# ---- A drag ----

def drag(view, count, seconds):
    """Edits as a drag sends them, one request at a time, while another connection takes the pictures: numbers of edits
    whose pictures came, and seconds from the last edit to its full picture."""
    view.wait_done(300)
    seen, ended, wanted, start = set(), [0.0], [None], time.monotonic()

    def follow():
        after = 0
        while True:
            state, pixels = view.picture(after)
            after = state["number"]
            if pixels and state["edit"]:
                seen.add(state["generation"])
            if wanted[0] and state["generation"] == wanted[0] and state["level"] > 0 and state["complete"]:
                ended[0] = time.monotonic()
                return

    follower = threading.Thread(target=follow)
    follower.start()
    before = len(seen)
    for i in range(count):
        status, answer = view.set(f"camera.position=[{-3000 + 5 * i} m, {-12000 + 5 * i} m, 1600 m]", gesture=5)
        time.sleep(max(0.0, start + (i + 1) * seconds / count - time.monotonic()))
    released = time.monotonic()
    during = len(seen) - before
    wanted[0] = answer["wanted"]
    follower.join()
    return during, ended[0] - released


def measure_display(view):
    """Milliseconds from an edit of exposure to its pixels; none of them renders."""
    view.wait_done(300)
    times, generation = [], view.picture()[0]["generation"]
    for i in range(9):
        before, start = view.picture()[0]["number"], time.monotonic()
        view.set(f"output.exposure={-1 + 0.1 * i} EV")
        state, _ = view.picture(before)
        times.append(time.monotonic() - start)
        assert state["generation"] == generation
    view.set("output.exposure=auto")
    return 1e3 * statistics.median(times)


def measure_cancels(view, count):
    """The longest wait of an edit for the picture under way to end, by the stage that ended."""
    longest, dice = {}, random.Random(3)
    for i in range(count):
        view.set(f"clouds[0].bake.coverage={0.3 + 0.01 * (i % 20)}", f"sun.elevation={30 + i % 7} deg")
        wanted = view.picture()[0]["wanted"]
        view.wait(lambda s: s["generation"] == wanted, 60)
        time.sleep(dice.uniform(0.0, 2.0))
        stage = view.picture()[0]["stage"]
        view.set(f"camera.position=[-3 km, {-12000 + i} m, 1600 m]")
        wanted = view.picture()[0]["wanted"]
        state, _ = view.wait(lambda s: s["generation"] == wanted, 60)
        longest[stage] = max(longest.get(stage, 0.0), state["waited"])
    return longest


PASS_OPTIONS = ("--quality", "draft", "--resolution", "160x90", "--integrator", "path", "--samples", "2")


def count_rebuilt_by_passes(program, path):
    """Stages that are rebuilt behind the first picture of all pixels."""
    view, mark, state = View(program, path, *PASS_OPTIONS, "-v"), None, {"number": 0}
    while state.get("samples", 0) < 16 or not state["complete"]:
        state, _ = view.picture(state["number"])
        if mark is None and state["level"] > 0 and state["complete"]:
            mark = len(view.messages)
    count = count_lines(view.messages[mark:], "rebuilt")
    view.end()
    return count


def run_refinement(program, folder):
    """Samples of paths, which have no bias that more of them would not lower: stated noise, and CPU seconds of a pass."""
    path = os.path.join(folder, "paths.yaml")
    open(path, "w").write(get_field())
    view = View(program, path, *PASS_OPTIONS)
    passes, cpu, state = [], None, {"number": 0}
    while not passes or passes[-1][0] < 16:
        state, pixels = view.picture(state["number"])
        if state["level"] == 0 or not state["complete"] or not pixels or (passes and passes[-1][0] == state["samples"]):
            continue
        now = cpu_seconds(view)
        passes.append((state["samples"], state["noise"], now - (cpu or now)))
        cpu = now
    first = passes[0]
    row(10, "samples: stated noise over that of 1/sqrt(n), CPU s of the pass", "within 15 %, no stage before the integrator",
        ", ".join(f"{n}: {x / first[1] * (n / first[0]) ** 0.5:.2f}, {c:.2f}" for n, x, c in passes[1:])
        + f"; rebuilt: {count_rebuilt_by_passes(program, path)}")
    view.end()


FIELD_OPTIONS = ("--quality", "draft", "--resolution", "480x270")


def count_in_log(program, path):
    """Bakes of the pictures of few and of all pixels after an edit of the lens, and edits of the ground that reuse its
    heights, by the log."""
    view = View(program, path, *FIELD_OPTIONS, "-v")
    log = measure(view, "camera.focal_length=50 mm")["log"]
    ends = [i for i, line in enumerate(log) if "prediction: " in line]
    bakes = count_lines(log[:ends[1]] if len(ends) > 1 else log, "cloud field: re(built|baked)")
    reused = sum(count_lines(measure(view, f"terrain.albedo={value}")["log"], "terrain: rebuilt") == 0 for value in (0.10, 0.12, 0.14))
    view.end()
    return bakes, reused


def run_field(program, folder):
    path = os.path.join(folder, "field.yaml")
    open(path, "w").write(get_field())
    bakes, reused = count_in_log(program, path)
    view = View(program, path, *FIELD_OPTIONS)
    state = follow(view, lambda s: s["marks"][0][0])
    row("", "start", "", f"{state['marks'][0][2]:.2f} CPU s, {state['marks'][0][1]:.2f} s")
    view.wait_done(300)
    costs = [measure(view, f"camera.position=[-3 km, {-12000 + 50 * i} m, 1600 m]") for i in (1, 2, 3, 4, 5)]
    row(1, "camera by 50 m", "0.09 CPU s, 80 ms; all 1.2 CPU s, 0.9 s", describe(costs))
    drags = [drag(view, 40, 2.0) for _ in range(3)]
    row(2, "drag of the camera: 40 edits in 2 s", "20 pictures, all 1.2 s after the last",
        f"{statistics.median(d[0] for d in drags)} pictures ({', '.join(str(d[0]) for d in drags)}), all "
        f"{statistics.median(d[1] for d in drags):.1f} s after the last")
    view.set("camera.position=[-3 km, -12 km, 1600 m]")
    for value, goal in ((50, "no bake; all 1.6 CPU s"), (35, "all reused")):
        cost = measure(view, f"camera.focal_length={value} mm")
        row(3, f"focal length to {value} mm", goal, describe([cost]) + (f"; bakes of few and all: {bakes}" if value == 50 else ""))
    costs = [measure(view, f"sun.elevation={35 - i} deg") for i in (1, 2, 3)]
    row(4, "sun by 1 degree", "0.30 CPU s, 220 ms; all 1.6 CPU s", describe(costs))
    view.set("sun.elevation=35 deg")
    row(5, "exposure", "30 ms, no stage", f"{measure_display(view):.0f} ms, no stage")
    costs = [measure(view, f"clouds[0].bake.coverage={value}") for value in (0.5, 0.31, 0.49)]
    row(6, "coverage by 0.2", "0.9 CPU s", describe(costs))
    costs = [measure(view, f"terrain.albedo={value}") for value in (0.10, 0.12, 0.14)]
    row(7, "albedo of the ground by 0.02", "heights reused; 0.30 CPU s; all 1.7 CPU s",
        f"heights reused in {reused} of 3; {describe(costs)}")
    longest = measure_cancels(view, 24)
    row(8, "longest wait for a picture to end, by stage", "100 ms",
        ", ".join(f"{stage} {1e3 * s:.0f} ms" for stage, s in sorted(longest.items(), key=lambda x: -x[1])))
    view.end()


TESTS = [(8, "cancels around the start of a call", "0 of 1000 lost", "test_renderer"),
         (9, "120 x 68, then 480 x 270 in one renderer", "all reused", "test_detail_height"),
         (10, "bits of further samples", "those of all at once", "test_kept_samples"),
         (11, "refusals; clients that drip or say nothing", "section 6", "test_server.py"),
         (12, "page in a browser", "15 s", "test_page.py"),
         (13, "comments and bytes that no edit touches", "stay", "test_scene_save"),
         (14, "an edit that the check refuses", "changes nothing", "test_server.py"),
         (15, "pixels of the page", "those of the PNG, to a step of 255", "test_server.py"),
         (16, "1000 random edits during renders", "memory grows by at most 10 %", "test_stress.py")]


def run_tests(program):
    """The lines that tests hold; each is run once."""
    ended = {}
    for line, what, goal, name in TESTS:
        if name not in ended:
            path = os.path.join(HERE, "..", "view", name) if name.endswith(".py") else os.path.join(os.path.dirname(program), name)
            if not os.path.exists(path):
                row(line, what, goal, f"`{name}` is not built")
                continue
            command = [sys.executable, "-B", path, program] if name.endswith(".py") else [path]
            start = time.monotonic()
            code = subprocess.run(command + (["1000"] if name == "test_stress.py" else []), capture_output=True, check=False).returncode
            ended[name] = f"{'passes' if code == 0 else 'skipped' if code == 77 else 'FAILS'} in {time.monotonic() - start:.0f} s"
        row(line, what, goal, f"`{name}` {ended[name]}")


def run_disney(program, cloud, folder):
    path = os.path.join(folder, "disney.yaml")
    open(path, "w").write(DISNEY.replace("CLOUD", os.path.abspath(cloud)))
    view = View(program, path, "--quality", "draft")
    state = follow(view, lambda s: s["marks"][0][0])
    row("Disney", "start", "", f"{state['marks'][0][2]:.2f} CPU s, {state['marks'][0][1]:.2f} s")
    view.wait_done(300)
    edits = [("camera by 5 m", "150 ms", "camera.position=[0, {} m, 1600 m]", (-705, -710, -715)),
             ("sun by 1 degree", "", "sun.elevation={} deg", (24, 23, 22)),
             ("optical depth", "", "clouds[0].optical_depth={}", (42, 44, 46))]
    for name, goal, key, values in edits:
        row("Disney", name, goal, describe([measure(view, key.format(value)) for value in values]))
    row("Disney", "exposure", "30 ms", f"{measure_display(view):.0f} ms, no stage")
    view.end()


def main():
    program = os.path.abspath(sys.argv[1])
    print("| line | edit | goal | few pixels; all pixels; those of nephos render |\n| --- | --- | --- | --- |")
    with tempfile.TemporaryDirectory() as folder:
        run_field(program, folder)
        run_refinement(program, folder)
        if len(sys.argv) > 2:
            run_disney(program, sys.argv[2], folder)
    run_tests(program)


if __name__ == "__main__":
    main()
