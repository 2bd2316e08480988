# SPDX-License-Identifier: Apache-2.0
"""Random edits during renders, by two clients at once: test_stress.py PROGRAM [EDITS]

Memory does not grow: that after the last half of the edits is at most 10 % above that after the first."""
import os
import random
import sys
import tempfile
import threading

from view_server import SCENE, Checks, View

check = Checks()
GROWTH_MAX = 1.1


def choose_edit(dice):
    """An edit of camera, ground, light or view; some are refused."""
    return dice.choice([
        lambda: f"camera.position=[{dice.uniform(-3e3, 3e3):.0f} m, -6 km, {dice.uniform(1500, 3500):.0f} m]",
        lambda: f"camera.fov={dice.uniform(-5, 90):.1f} deg",
        lambda: f"camera.resolution=[{dice.randint(16, 96)}, {dice.randint(9, 54)}]",
        lambda: f"terrain.albedo={dice.uniform(0, 1.1):.3f}",
        lambda: f"terrain.ridges.seed={dice.randint(0, 3)}",
        lambda: f"environment.radiance={dice.uniform(0, 0.2):.3f}",
        lambda: f"output.exposure={dice.uniform(-4, 4):.2f}",
        lambda: f"output.view={dice.choice(['camera', 'filmic', 'standard', 'raw'])}",
        lambda: f"render.samples={dice.randint(1, 8)}"])()


def edit(view, seed, count):
    dice = random.Random(seed)
    for i in range(count):
        kind = dice.random()
        if kind < 0.1:
            view.post(dice.choice(["/api/undo", "/api/redo"]))
        elif kind < 0.15:
            view.request("/api/show", dice.choice(["Z", "luminance", "A", ""]))
        elif kind < 0.17:
            view.post("/api/vary", "\n".join(f"terrain.ridges.seed={k}" for k in range(4)))
        elif kind < 0.2:
            view.post("/api/reload?keep=1")
        elif kind < 0.24:
            left, top = dice.uniform(0, 0.8), dice.uniform(0, 0.8)
            view.request("/api/region", dice.choice(["", f"{left} {top} {left + 0.2} {top + 0.2}"]))
        elif kind < 0.28:
            view.request("/api/focus", f"{dice.uniform(0, 1)} {dice.uniform(0, 1)}")
        elif kind < 0.3:
            view.post("/api/frame", str(dice.randint(1, 9)))
        else:
            view.set(choose_edit(dice), gesture=i // 10)
        if i % 3 == 0:
            view.picture()


def run_clients(view, seed, count):
    """Edits of two clients; memory once all is rendered."""
    clients = [threading.Thread(target=edit, args=(view, seed + i, count // 2)) for i in range(2)]
    for client in clients:
        client.start()
    for client in clients:
        client.join()
    view.request("/api/region", "")
    view.set("camera.resolution=[64, 36]", "render.samples=1", "terrain.ridges.seed=0")
    view.wait_done(60)
    return view.resident_bytes()


def main():
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 200
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "scene.yaml")
        open(path, "w").write(SCENE)
        view = View(os.path.abspath(sys.argv[1]), path)
        view.wait_done(60)
        run_clients(view, 1, count // 4)
        first = run_clients(view, 2, count // 4)
        second = run_clients(view, 4, count // 2)
        if not os.environ.get("NEPHOS_SANITIZE"):
            check("memory does not grow", second <= GROWTH_MAX * first, (first, second))
        view.set("camera.fov=33 deg")
        code, seconds = view.end()
        check("it ends as it should", code == 0, code)
        check("within a second", seconds < 1.0, seconds)
        unexpected = [m for m in view.messages if "WARNING: ThreadSanitizer" in m or "ERROR: AddressSanitizer" in m or "runtime error" in m]
        check("no sanitizer complains", not unexpected, unexpected)
    return check.failures > 0


if __name__ == "__main__":
    sys.exit(main())
