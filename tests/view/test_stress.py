# SPDX-License-Identifier: Apache-2.0
"""Random edits during renders, by two clients at once: test_stress.py PROGRAM [EDITS]

Both clients save, and drop connections amid answers. Memory does not grow: that after the last half of the edits is at
most 10 % above that after the first. What an allocator holds back for its threads differs by 50 % from run to run, and
is left out. No edit is lost: the last one accepted is the one whose picture stays."""
import os
import random
import socket
import struct
import sys
import tempfile
import threading
import time

from view_server import SCENE, Checks, View

check = Checks()
GROWTH_MAX = 1.1
PATIENCE_S = 600  # CPU seconds for a picture: a sanitizer renders twenty times slower

# A cloud and a hill under sun and air: each stage of a render runs. Tables of air are coarse and samples few, so
# that a picture takes less than half a CPU second.
CLOUDY = """camera: {position: [0, -4 km, 700 m], look_at: [0, 0, 1 km], resolution: [32, 18]}
sun: {elevation: 30 deg}
atmosphere: {tolerance: 0.1}
clouds: [{name: a, bake: {preset: cumulus_humilis, seed: 3, extent: 1 km, voxel: 100 m}}]
terrain: {ridges: {samples: 33, relief: 200 m}}
render: {quality: draft, samples: 1, target_error: 0.5}
"""


def choose_edit(dice, is_cloudy):
    """An edit of camera, ground, light or view, and of the cloud; some are refused."""
    edits = [
        lambda: f"camera.position=[{dice.uniform(-3e3, 3e3):.0f} m, -6 km, {dice.uniform(1500, 3500):.0f} m]",
        lambda: f"camera.fov={dice.uniform(-5, 90):.1f} deg",
        lambda: f"camera.resolution=[{dice.randint(16, 96)}, {dice.randint(9, 54)}]",
        lambda: f"terrain.albedo={dice.uniform(0, 1.1):.3f}",
        lambda: f"terrain.ridges.seed={dice.randint(0, 3)}",
        lambda: f"output.exposure={dice.uniform(-4, 4):.2f}",
        lambda: f"output.view={dice.choice(['camera', 'filmic', 'standard', 'raw'])}",
        lambda: f"render.samples={dice.randint(1, 8)}"]
    if is_cloudy:
        edits += [
            lambda: f"sun.elevation={dice.uniform(-20, 95):.1f} deg",
            lambda: f"clouds[0].bake.coverage={dice.uniform(0.2, 0.8):.2f}",
            lambda: f"clouds[0].bake.center=[{dice.uniform(-500, 500):.0f} m, 0 m]",
            lambda: f"atmosphere.haze={dice.choice(['clear', 'hazy', 'thick'])}"]
    else:
        edits.append(lambda: f"environment.radiance={dice.uniform(0, 0.2):.3f}")
    return dice.choice(edits)()


def drop(view, data):
    """A client that is killed: its connection is reset amid a request or an answer."""
    with socket.create_connection((view.host, view.port), 10) as client:
        client.sendall(data)
        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))


def drop_some(view, dice):
    head = f"Host: 127.0.0.1:{view.port}\r\nX-Nephos-Token: {view.token}\r\n"
    edit = "camera.roll=2 deg"
    drop(view, dice.choice([
        f"GET /api/picture?after=0 HTTP/1.1\r\n{head}\r\n", f"GET /api/picture?after=0 HTTP/1.1\r\n{head}",
        f"POST /api/set HTTP/1.1\r\n{head}Content-Length: {len(edit)}\r\n\r\n{edit}",
        f"POST /api/set HTTP/1.1\r\n{head}Content-Length: 100\r\n\r\n{edit}"]).encode())


def save(view, dice):
    """Saves the scene or the picture; a new file is removed."""
    path, body = dice.choice([("/api/save", ""), ("/api/save_copy", ""), ("/api/save_picture", "png"), ("/api/save_picture", "exr")])
    _, answer = view.post(path, body)
    if path != "/api/save" and answer["file"]:
        os.unlink(answer["file"])


def edit(view, seed, count, is_cloudy):
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
        elif kind < 0.34:
            drop_some(view, dice)
        elif kind < 0.37:
            save(view, dice)
        elif kind < 0.39 and is_cloudy:
            view.post("/api/toggle_cloud?cloud=0")
        else:
            view.set(choose_edit(dice, is_cloudy), gesture=i // 10)
        if i % 3 == 0:
            view.picture()


def run_clients(view, seed, count, path, scene):
    """Edits of two clients; memory once the scene is as it was at first."""
    faults = []

    def run(seed):
        try:
            edit(view, seed, count // 2, scene == CLOUDY)
        except Exception as fault:
            faults.append(repr(fault))

    clients = [threading.Thread(target=run, args=(seed + i,)) for i in range(2)]
    for client in clients:
        client.start()
    for client in clients:
        client.join()
    check("both clients have all answers", not faults, faults)
    view.request("/api/region", "")
    view.request("/api/show", "")
    open(path, "w").write(scene)
    view.post("/api/reload")
    if view.picture()[0]["hidden"]:
        view.post("/api/toggle_cloud?cloud=0")
    for lines in ["terrain.albedo=0.5"], ["terrain.ridges.samples=65"], ["camera.fov=35 deg"]:
        view.set(*lines)  # each renderer ends with light and ground of the same edits
        view.wait_rest(PATIENCE_S)
    return view.resident_bytes()


def check_memory(program, folder, scene, count):
    path = os.path.join(folder, f"memory-{count}.yaml")
    open(path, "w").write(scene)
    os.environ.update(MALLOC_ARENA_MAX="1", MALLOC_MMAP_THRESHOLD_="65536", MALLOC_TRIM_THRESHOLD_="65536")
    view = View(program, path)
    view.wait_rest(PATIENCE_S)
    run_clients(view, 1, count // 4, path, scene)
    first = run_clients(view, 3, count // 4, path, scene)
    second = run_clients(view, 5, count // 2, path, scene)
    if not os.environ.get("NEPHOS_SANITIZE"):
        check("memory does not grow", second <= GROWTH_MAX * first, (first, second))
    view.set("camera.fov=33 deg")
    end(view)


def check_lost(program, folder, rounds):
    """Bursts of edits while pictures are rendered, with files that change below them: each burst ends in the picture of
    its last edit, bit by bit."""
    path = os.path.join(folder, "lost.yaml")
    open(path, "w").write(SCENE + "render: {samples: 2, target_error: 0.5}\n")  # done with two samples
    view, dice = View(program, path), random.Random(7)
    pictures = {}
    edits = [(f"terrain.albedo={albedo}", roll) for albedo in (0.1, 0.4, 0.8) for roll in (0, 3)]
    for line, roll in edits:
        view.set(line, f"camera.roll={roll} deg")
        pictures[line, roll] = view.wait_rest(PATIENCE_S)[1]
    check("each edit has a picture of its own", len(set(pictures.values())) == len(edits))
    for i in range(rounds):
        for _ in range(dice.randint(1, 4)):
            line, roll = dice.choice(edits)
            status, answer = view.set(line, f"camera.roll={roll} deg")
            check("an edit is accepted", status == 200, answer)
            if dice.random() < 0.3:
                open(path, "a").write(f"# {i}\n")
            if dice.random() < 0.3:
                status, answer = view.post("/api/reload?keep=1")
                check("the file is read below the edits", status == 200, answer)
            if dice.random() < 0.3:
                view.set(f"output.exposure={dice.choice([0, 1])}")
                view.set("output.exposure=auto")
            time.sleep(dice.choice([0, 0, 0.005, 0.02, 0.05]))
        values = view.values()
        wanted = line.split("=")[1], f"{roll} deg"
        check("values are those of the last edit", (values["terrain.albedo"], values["camera.roll"]) ==
              (f"[{wanted[0]}, {wanted[0]}, {wanted[0]}]", wanted[1]), (i, wanted, values["terrain.albedo"], values["camera.roll"]))
        state, pixels = view.wait_rest(PATIENCE_S)
        check("the picture is that of the last edit", pixels == pictures[line, roll], (i, wanted, state))
    end(view)


def end(view):
    code, seconds = view.end()
    limit = 10.0 if os.environ.get("NEPHOS_SANITIZE") else 1.0
    check("it ends as it should", code == 0, code)
    check("at once", seconds < limit, seconds)
    complaints = [m for m in view.messages if "ThreadSanitizer" in m or "Sanitizer: " in m or "runtime error" in m]
    check("no sanitizer complains", not complaints, complaints and "".join(view.messages)[-20000:])


def main():
    count, program = int(sys.argv[2]) if len(sys.argv) > 2 else 200, os.path.abspath(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        check_memory(program, folder, SCENE, count // 2)
        check_memory(program, folder, CLOUDY, count - count // 2)
        # Each burst waits for its picture. A sanitizer takes twenty times longer, and has met the races before.
        check_lost(program, folder, count // 40 if os.environ.get("NEPHOS_SANITIZE") else count // 4)
    return check.failures > 0


if __name__ == "__main__":
    sys.exit(main())
