# SPDX-License-Identifier: Apache-2.0
"""The server of `nephos view`, without a browser: test_server.py PROGRAM"""
import json
import os
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import zlib

from view_server import SCENE, Checks, View

check = Checks()


# ---- Refusals: the status of each, before any of a body is read ----

def check_refusals(view):
    port, post = view.port, "sun.elevation=20 deg"
    ask = lambda *arguments, **options: view.request(*arguments, **options)[0]
    foreign = [("Origin", "http://evil.example"), ("Origin", "null"), ("Origin", "http://127.0.0.1:1"),
               ("Origin", f"https://127.0.0.1:{port}"), ("Sec-Fetch-Site", "cross-site"), ("Sec-Fetch-Site", "same-site")]
    for name, value in foreign:
        check(f"{name} {value} is refused", ask("/api/set", post, headers={name: value}) == 403)
    for host in (f"evil.example:{port}", "127.0.0.1", f"127.0.0.1:{port + 1}", f"localhost.evil.example:{port}", ""):
        check(f"the host {host!r} is refused", ask("/api/values", headers={"Host": host}) == 421)
    check("localhost is this server", ask("/api/values", headers={"Host": f"localhost:{port}"}) == 200)
    check("so is any address of this machine", ask("/api/values", headers={"Host": f"0.0.0.0:{port}"}) == 200)
    check("its own origin is let in", ask("/api/values", headers={"Origin": view.base}) == 200)
    check("the page needs no token", ask("/", token=False) == 200)
    check("a link from another site opens the page", ask("/", token=False, headers={"Sec-Fetch-Site": "cross-site"}) == 200)
    check("no token", ask("/api/values", token=False) == 401)
    for token in ("00", view.token[:-1], view.token + "0", view.token[:-1] + ("1" if view.token[-1] != "1" else "2"), ""):
        check(f"the token {token!r} is wrong", ask("/api/values", headers={"X-Nephos-Token": token}) == 401)
    check("a token in the query does not count", ask(f"/api/values?token={view.token}", token=False) == 401)
    check("a preflight is refused", ask("/api/set", method="OPTIONS", headers={"Origin": "http://evil.example"}) == 403)
    check("DELETE is refused", ask("/api/set", method="DELETE") == 405)
    for path in ("/etc/passwd", "/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "/api/../main.c", "/api/set"):
        check(f"{path} is no page", ask(path) == 404)
    check("a long header is refused", ask("/api/values", headers={"X-A": "a" * 40000}) == 431)
    check("many headers are refused", ask("/api/values", headers={f"X-{i}": "a" for i in range(80)}) == 431)


def send_raw(view, data, limit=10):
    """First line of the answer to raw bytes; nothing where the connection is closed without one."""
    with socket.create_connection((view.host, view.port), limit) as client:
        client.sendall(data)
        try:
            return client.recv(200).split(b"\r\n")[0].decode()
        except ConnectionError:
            return ""


def check_malformed(view):
    head = f"Host: 127.0.0.1:{view.port}\r\nX-Nephos-Token: {view.token}\r\n"
    cases = [("a bare LF", "GET / HTTP/1.1\nHost: x\n\r\n\r\n", "400"), ("no path", f"GET HTTP/1.1\r\n{head}\r\n", "400"),
             ("HTTP/1.0", f"GET / HTTP/1.0\r\n{head}\r\n", "505"),
             ("a folded header", f"GET / HTTP/1.1\r\n{head}X-A: a\r\n b\r\n\r\n", "400"),
             ("a blank before the colon", f"GET / HTTP/1.1\r\n{head}X-A : a\r\n\r\n", "400"),
             ("a header twice", f"GET / HTTP/1.1\r\n{head}Host: evil.example\r\n\r\n", "400"),
             ("a NUL", f"GET /\0 HTTP/1.1\r\n{head}\r\n", "400"),
             ("a length that is no number", f"POST /api/set HTTP/1.1\r\n{head}Content-Length: 1x\r\n\r\n", "400"),
             ("a negative length", f"POST /api/set HTTP/1.1\r\n{head}Content-Length: -1\r\n\r\n", "400"),
             ("a body without a length", f"POST /api/set HTTP/1.1\r\n{head}\r\n", "411"),
             ("a body in chunks", f"POST /api/set HTTP/1.1\r\n{head}Transfer-Encoding: chunked\r\n\r\n", "411"),
             ("a body of 65537 bytes", f"POST /api/set HTTP/1.1\r\n{head}Content-Length: 65537\r\n\r\n", "413"),
             ("a body of 2^70 bytes", f"POST /api/set HTTP/1.1\r\n{head}Content-Length: {2**70}\r\n\r\n", "413")]
    for name, data, status in cases:
        line = send_raw(view, data.encode())
        check(f"{name} is refused by {status}", line.startswith(f"HTTP/1.1 {status} "), line)
    two = f"GET /api/edits HTTP/1.1\r\n{head}\r\nGET /api/nothing HTTP/1.1\r\n{head}\r\n"
    with socket.create_connection((view.host, view.port), 5) as client:
        client.sendall(two.encode())
        answers = b""
        while answers.count(b"HTTP/1.1 ") < 2:
            answers += client.recv(4096)
    check("two requests of one connection are both answered", b"200 OK" in answers and b"404 Not Found" in answers)
    check("a refused body of 5 MB does not lose the answer",
          send_raw(view, f"POST /api/set HTTP/1.1\r\n{head}Content-Length: 5000000\r\n\r\n".encode() + b"a" * 5000000)
          .startswith("HTTP/1.1 413 "))


def check_slow_clients(view):
    """A client that drips is cut, and 200 that say nothing do not keep another from its answer."""
    cut_after = []

    def drip():
        start = time.monotonic()
        with socket.create_connection((view.host, view.port), 20) as client:
            try:
                for byte in b"GET / HTTP/1.1\r\nX-A: " + b"a" * 1000:
                    client.sendall(bytes([byte]))
                    time.sleep(0.1)
            except ConnectionError:
                cut_after.append(time.monotonic() - start)

    dripping = threading.Thread(target=drip)
    dripping.start()
    silent = [socket.create_connection((view.host, view.port), 5) for _ in range(200)]
    for client in silent[::2]:
        client.sendall(f"GET /api/picture?after=0 HTTP/1.1\r\nHost: 127.0.0.1:{view.port}\r\n"
                       f"X-Nephos-Token: {view.token}\r\n\r\n".encode())
    start = time.monotonic()
    check("a client beside 200 others is answered within a second",
          view.request("/api/edits")[0] == 200 and time.monotonic() - start < 1.0, time.monotonic() - start)
    for client in silent:
        client.close()
    return dripping, cut_after


# ---- Edits ----

def check_edits(view):
    status, answer = view.set("terrain.albedo=0.5")
    check("an edit is taken", status == 200 and answer["refusal"] == "" and answer["undo"], answer)
    check("its value is in force", view.values()["terrain.albedo"] == "[0.5, 0.5, 0.5]", view.values()["terrain.albedo"])
    before = view.values()
    refused = [("terrain.albedo=7", 422, "must be"), ("terrain.albedo=", 422, ""), ("terrain.albdo=0.1", 403, ""),
               ("terrain.albedo=[&a 1, *a, *a]", 422, ""), ("terrain", 400, "KEY=VALUE"), ("=1", 400, "KEY=VALUE"),
               ("terrain.heightfield=/etc/passwd", 403, "--allow-files"), ("output.image=x.exr", 403, "--allow-files"),
               ("output={image: x.exr}", 403, "single keys"), ("output=image: x.exr", 403, "single keys"),
               ("clouds=[{name: a, vdb: /etc/passwd}]", 403, "single keys"), ("clouds[0].vdb=/etc/passwd", 403, "--allow-files"),
               ("clouds[00].vdb=/etc/passwd", 403, ""), ("clouds[0].name=\"x\"", 422, "")]
    for line, wanted, text in refused:
        status, answer = view.set("terrain.albedo=0.1", line)
        check(f"{line} is refused by {wanted}", status == wanted and text in answer["refusal"], (status, answer["refusal"]))
    check("a refused edit changes nothing", view.values() == before)
    status, answer = view.set("terrain.albedo=" + "x" * 60000)
    check("a value of 60 kB is refused", status == 422, status)
    status, answer = view.set("camera.focus_distance=100 m")
    check("a key that another rules out is named", status == 200 and "camera.focus_distance" in answer["notice"], answer)
    view.post("/api/undo")
    check("a word may stand for a section", view.set("water=none")[0] == 200)
    view.post("/api/undo")


def check_undo(view):
    start = view.values()
    for value in ("0.1", "0.2", "0.3"):
        view.set(f"terrain.albedo={value}", gesture=7)
    view.set("terrain.albedo=0.4", gesture=8)
    view.post("/api/undo")
    check("undo takes back a gesture", view.values()["terrain.albedo"] == "[0.3, 0.3, 0.3]")
    edits = json.loads(view.request("/api/edits")[1])["edits"]
    check("the edits are listed once a key", [edit["key"] for edit in edits] == ["terrain.albedo"], edits)
    view.post("/api/undo")
    check("undo takes back all edits of a gesture", view.values() == start)
    view.post("/api/redo")
    view.post("/api/redo")
    check("redo brings them back", view.values()["terrain.albedo"] == "[0.4, 0.4, 0.4]")
    check("nothing is left to redo", view.post("/api/redo")[0] == 409)
    view.post("/api/undo")
    view.set("camera.roll=1 deg")
    check("an edit ends what could be redone", view.post("/api/redo")[0] == 409)
    while view.post("/api/undo")[0] == 200:
        pass
    check("all is undone", json.loads(view.request("/api/edits")[1])["edits"] == [])


def check_lists(view):
    """Keys that go back to their defaults, clouds that come and go."""
    view.set("camera.roll=3 deg")
    status, answer = view.post("/api/unset", "camera.roll")
    check("a key goes back to its default", status == 200 and view.values()["camera.roll"] == "0 deg", answer)
    check("what is not given cannot be taken away", view.post("/api/unset", "camera.rol")[0] == 422)
    status, answer = view.post("/api/add_cloud", "fog")
    check("a cloud is added", status == 200 and view.values()["clouds[0].bake.preset"] == '"fog"', answer)
    view.post("/api/add_cloud", "fog")
    check("the second of a preset has another name", view.values()["clouds[1].name"] == '"fog 2"', view.values().get("clouds[1].name"))
    check("the first is removed", view.post("/api/unset", "clouds[0]")[0] == 200 and view.values()["clouds[0].name"] == '"fog 2"')
    before = view.values()
    for line in ("clouds[0].vdb=/etc/passwd", "clouds[1].vdb=x.vdb", "clouds[00].vdb=x.vdb", "clouds[0].name=a\rb: c"):
        view.set(line)
    check("no file can be named in a cloud", view.values() == before)
    check("a preset is a word", view.post("/api/add_cloud", "fog}, vdb: x.vdb, a: {b")[0] == 400)
    check("an unknown preset is refused", view.post("/api/add_cloud", "foggy")[0] == 422)
    while view.post("/api/undo")[0] == 200:
        pass
    check("all of it is undone", not [key for key in view.values() if key.startswith("clouds")])


# ---- Pictures ----

def read_png(path):
    """Rows of R, G, B of an 8-bit PNG."""
    data, position, packed = open(path, "rb").read(), 8, b""
    while position < len(data):
        size, kind = struct.unpack(">I4s", data[position:position + 8])
        if kind == b"IHDR":
            width, height = struct.unpack(">II", data[position + 8:position + 16])
        if kind == b"IDAT":
            packed += data[position + 8:position + 8 + size]
        position += size + 12
    raw, stride, rows = zlib.decompress(packed), 3 * width, [bytearray(3 * width)]
    for y in range(height):
        kind, line = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for i in range(stride):
            a, b, c = line[i - 3] if i >= 3 else 0, rows[-1][i], rows[-1][i - 3] if i >= 3 else 0
            p = a + b - c
            nearest = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            line[i] = (line[i] + [0, a, b, (a + b) // 2, nearest][kind]) & 255
        rows.append(line)
    return b"".join(bytes(row) for row in rows[1:])


def check_pictures(view, program, folder):
    view.set("camera.roll=3 deg")
    state, pixels = view.wait_done()
    check("the picture has the scene's size", len(pixels) == 4 * 64 * 36 and (state["width"], state["height"]) == (64, 36))
    check("the error is stated", 0 < state["error"] < 1 and state["noise"] <= state["error"] and state["seconds"] > 0)
    subprocess.run([program, "render", os.path.join(folder, "scene.yaml"), "--set", "camera.roll=3 deg", "--samples",
                    str(state["samples"]), "-o", os.path.join(folder, "a.png"), "-q"], check=True, stdout=subprocess.DEVNULL)
    png = read_png(os.path.join(folder, "a.png"))
    shown = bytes(x for i, x in enumerate(pixels) if i % 4 < 3)
    worst = max(abs(a - b) for a, b in zip(png, shown))
    check("the page shows the pixels of `nephos render`, to one step of 255", worst <= 1 and len(png) == len(shown), worst)

    status, values = view.request("/api/pixel?x=32&y=30")
    check("a pixel has its radiance and its depth", status == 200 and b'"R"' in values and b'"Z"' in values, values)
    check("no pixel is outside of the picture", view.request("/api/pixel?x=64&y=0")[1] == b"{}")

    generation = state["generation"]
    status, answer = view.set("output.exposure=-3")
    darker, dark = view.picture()
    check("exposure needs no render", answer["wanted"] == generation and darker["generation"] == generation, answer)
    check("three stops less are darker", sum(dark) < 0.7 * sum(pixels))
    view.post("/api/undo")

    later, _ = view.wait_done()
    start = time.monotonic()
    state, nothing = view.picture(after=later["number"])
    waited = time.monotonic() - start
    check("a picture that the page has is not sent again", nothing == b"" and 0.2 < waited < 1.0, (len(nothing), waited))


def check_channels(view, folder):
    beauty = view.wait_done()[1]
    names = json.loads(view.request("/api/channels")[1])
    check("the channels are listed", {"luminance", "A", "Z"} <= set(names), names)
    check("a channel is shown", view.request("/api/show", "Z")[0] == 200)
    state, pixels = view.picture()
    check("by a colour for each number", state["channel"] == "Z" and 0 < state["least"] < state["greatest"] and pixels != beauty, state)
    sky, ground = pixels[:3], pixels[-4:-1]
    check("what is infinite is black, what is near is blue", sky == b"\0\0\0" and ground[2] > ground[1], (sky, ground))
    check("no relative error without its channel", "relative_error" not in names, names)
    view.set("output.aovs=[standard_error]", "render.samples=4")
    view.wait_done()
    check("the relative error is listed", "relative_error" in json.loads(view.request("/api/channels")[1]))
    view.request("/api/show", "relative_error")
    state, pixels = view.picture()
    check("and is a share of the luminance", state["channel"] == "relative_error" and 0 <= state["least"] < state["greatest"] <= 1 and pixels != beauty, state)
    view.set("render.samples=1")
    state, _ = view.wait_done()
    check("an error takes two samples where the scene has one, and the page says so", state["level"] >= 1 and
          state["samples"] >= 2 and "takes 2" in state["message"] and state["channel"] == "relative_error", state)
    view.post("/api/undo")
    state, _ = view.wait_done()
    check("the message goes with its reason", state["message"] == "", state["message"])
    view.post("/api/undo")
    view.wait_done()
    view.request("/api/show", "nothing")
    check("a picture without the channel shows itself", view.picture()[1] == beauty)
    view.request("/api/show", "")
    for kind in ("png", "exr"):
        status, answer = view.post("/api/save_picture", kind)
        check(f"the picture is saved as {kind}", status == 200 and answer["file"] == os.path.join(folder, f"scene-2.{kind}") and
              os.path.getsize(answer["file"]) > 1000, answer)
    shown = bytes(x for i, x in enumerate(beauty) if i % 4 < 3)
    saved = read_png(os.path.join(folder, "scene-2.png"))
    check("it is that on the page", max(abs(a - b) for a, b in zip(saved, shown)) <= 1)


def get_variants(view, lines):
    """Sizes and pixels of the small pictures of other values."""
    view.wait_done()
    check("variants are taken", view.post("/api/vary", lines)[0] == 200)
    view.wait(lambda s: s["variants_left"] == 0)
    return view.request("/api/variants")[1].split(b"\n", 1)


def check_variants(view):
    view.wait_done()
    before = view.values()
    status, answer = view.post("/api/vary", "terrain.albedo=0.05\nterrain.albedo=0.9\ncamera.fov=200")
    check("a wrong variant is refused", status == 422 and "camera.fov" in answer["refusal"], answer)
    check("so are files", view.post("/api/vary", "terrain.heightfield=x.hgt")[0] == 403)
    check("and more than 16", view.post("/api/vary", "camera.roll=1 deg\n" * 17)[0] == 400)
    head, pixels = get_variants(view, "terrain.albedo=0.05\nterrain.albedo=0.9")
    check("each has a picture", json.loads(head)["sizes"] == [[112, 63]] * 2 and len(pixels) == 2 * 4 * 112 * 63, head)
    check("they differ", pixels[:len(pixels) // 2] != pixels[len(pixels) // 2:])
    check("the scene is as it was", view.values() == before)


def check_past(view):
    """A setting that was shown shows its picture again at once, bit by bit, without a render."""
    def save():
        file = view.post("/api/save_picture", "exr")[1]["file"]
        bits = open(file, "rb").read()
        os.unlink(file)
        return bits

    view.set("camera.roll=6 deg")
    state, pixels = view.wait_done()
    bits, first = save(), (pixels, state["samples"])
    view.set("camera.roll=9 deg")
    state, pixels = view.wait_done()
    other = (pixels, state["samples"])
    check("another setting is another picture", other[0] != first[0])
    back = [("undo", lambda: view.post("/api/undo")), ("redo", lambda: view.post("/api/redo")),
            ("a value set by hand", lambda: view.set("camera.roll=6 deg"))]
    for name, act in back:
        before, (pixels, samples) = view.picture()[0]["number"], other if name == "redo" else first
        _, answer = act()
        state, shown = view.wait(lambda s: s["generation"] == answer["wanted"])
        check(f"{name}: the picture is there at once, of all samples", state["number"] <= before + 2 and state["complete"] and
              state["samples"] == samples and state["stage"] == "done", state)
        check(f"{name}: it has its pixels", shown == pixels)
    check("and its bits", save() == bits)
    view.set("output.exposure=1")
    _, bright = view.wait_done()
    view.set("camera.roll=9 deg")
    view.wait_done()
    view.set("output.exposure=auto", "camera.roll=6 deg")
    state, shown = view.wait_done()
    check("another exposure has the same picture, developed anew", shown == first[0] and shown != bright, state)
    for _ in range(5):
        view.post("/api/undo")


def check_drag(view):
    """Edits faster than pictures: pictures of few pixels come all the time, and the last edit ends in a full one."""
    generations, count, end = set(), 0, time.monotonic() + 20
    while len(generations) < 10 and time.monotonic() < end:
        view.set(f"camera.position=[0, {-6000 - count} m, 2500 m]", gesture=99)
        generations.add(view.picture()[0]["generation"])
        count += 1
    check("a drag shows pictures", len(generations) >= 10, len(generations))
    view.set("camera.position=[0, -6590 m, 2500 m]", gesture=99)
    state, _ = view.wait_done()
    check("it ends in the last edit", "-6.59 km" in view.values()["camera.position"], view.values()["camera.position"])
    check("which is all pixels", state["level"] >= 1 and state["complete"])
    view.post("/api/undo")


# ---- The file ----

def write_scene(path, text):
    with open(path + ".new", "w") as file:
        file.write(text)
    os.replace(path + ".new", path)


def check_file(view, path):
    while view.post("/api/undo")[0] == 200:
        pass
    write_scene(path, SCENE.replace("samples: 129", "samples: 65"))
    view.wait(lambda s: view.values()["terrain.ridges.samples"] == "65", 5)
    write_scene(path, SCENE.replace("samples: 129", "samples: many"))
    state, _ = view.wait(lambda s: s["file_fault"], 5)
    check("a broken file is reported by line and column", "scene.yaml:6:" in state["file_fault"], state["file_fault"])
    check("and the last good scene stays", view.values()["terrain.ridges.samples"] == "65")
    view.set("camera.roll=2 deg")
    write_scene(path, SCENE.replace("samples: 129", "samples: 33"))
    state, _ = view.wait(lambda s: s["news"], 5)
    check("a file that changes under edits is not read", view.values()["terrain.ridges.samples"] == "65")
    status, answer = view.post("/api/reload?keep=1")
    check("it is read below the edits", status == 200 and not answer["news"] and not answer["file_fault"], answer)
    check("both are there", (view.values()["terrain.ridges.samples"], view.values()["camera.roll"]) == ("33", "2 deg"))
    write_scene(path, SCENE)
    view.wait(lambda s: s["news"], 5)
    view.post("/api/reload")
    check("or without the edits", view.values()["camera.roll"] == "0 deg" and view.values()["terrain.ridges.samples"] == "129")


def check_save(view, path):
    view.set("terrain.albedo=[0.1, 0.2, 0.3]", "camera.fov=40 deg")
    before = view.values()
    status, answer = view.post("/api/save_copy")
    check("a copy is saved beside the scene", status == 200 and os.path.basename(answer["file"]) == "scene-2.yaml", answer)
    check("the scene's file is untouched", open(path).read() == SCENE)
    status, answer = view.post("/api/save")
    saved = open(path).read()
    check("the scene is saved", status == 200 and saved == open(path.replace(".yaml", "-2.yaml")).read(), answer)
    check("its comments stay", saved.startswith("# A scene without air.\n") and "# uniform\n" in saved, saved)
    state, _ = view.picture()
    check("nothing is left to save", not state["edited"] and not state["news"], state)
    view.set("camera.roll=1 deg")
    write_scene(path, saved.replace("samples: 129", "samples: 65"))
    view.wait(lambda s: s["news"], 5)
    check("a file that has changed is not written over", view.post("/api/save")[0] == 409)
    view.post("/api/reload?keep=1")
    values = view.values()
    check("saved edits are in the file, the others on top", values["camera.roll"] == "1 deg" and values["camera.fov"] == "40 deg" and
          values["terrain.ridges.samples"] == "65" and values["terrain.albedo"] == before["terrain.albedo"])
    check("those can be saved", view.post("/api/save")[0] == 200 and "roll: 1 deg" in open(path).read())
    broken = SCENE.replace("samples: 129", "samples: many")
    write_scene(path, broken)
    view.wait(lambda s: s["file_fault"], 5)
    check("a file that cannot be read is not written over", view.post("/api/save")[0] == 409 and open(path).read() == broken)
    view.set("camera.roll=3 deg")
    view.post("/api/reload?keep=1")
    check("nor after a reading that failed", view.post("/api/save")[0] == 409 and open(path).read() == broken)
    os.symlink("nowhere/beyond.yaml", path.replace(".yaml", "-3.yaml"))
    status, answer = view.post("/api/save_copy")
    check("a copy has a name of its own, which no link has", os.path.basename(answer["file"]) == "scene-4.yaml", answer)
    write_scene(path, SCENE)
    view.post("/api/reload")
    check("a file that is mended is read", view.post("/api/save")[0] == 200)
    view.set("camera.roll=4 deg")
    os.unlink(path)
    check("a file that was removed is written anew", view.post("/api/save")[0] == 200 and "roll: 4 deg" in open(path).read())
    os.unlink(path)
    write_scene(path, SCENE)
    view.wait(lambda s: view.values()["camera.roll"] == "0 deg", 5)


def check_end(view):
    view.set("camera.roll=5 deg")
    code, seconds = view.end()
    check("Ctrl-C ends it within a second, as it should", code == 0 and seconds < 1.0, (code, seconds))
    errors = [message for message in view.messages if "warning: " not in message]
    check("it has complained of nothing", not errors, errors)


def check_bakes(program, folder):
    """A cloud that is baked to a file: the view bakes it in memory, and leaves the file alone."""
    path, cloud = os.path.join(folder, "baked.yaml"), os.path.join(folder, "cloud.vdb")
    write_scene(path, """camera: {position: [0, -3 km, 900 m], look_at: [0, 0, 1400 m], resolution: [32, 18]}
atmosphere: none
environment: {radiance: 0.1}
clouds: [{name: a, vdb: cloud.vdb, bake: {preset: cumulus_humilis, seed: 3, extent: 1 km, voxel: 50 m, coverage: 0.6}}]
render: {quality: draft}
""")
    view = View(program, path)
    _, before = view.wait_done(60)
    view.set("clouds[0].bake.seed=5")
    _, after = view.wait_done(60)
    check("a cloud that is baked to a file is shown", before != after)
    check("its file is not written", not os.path.exists(cloud))
    check("its key stays in the scene", cloud in view.values()["clouds[0].vdb"], view.values()["clouds[0].vdb"])
    view.end()


def check_no_picture(program, path):
    """A scene whose outputs have no picture: the view says so, and goes on."""
    view = View(program, path)
    view.wait_done()
    view.set("output.aovs=[depth]", "output.beauty=false")
    state, _ = view.wait(lambda s: s["message"], 20)
    check("a picture without colours is reported", state["message"])
    view.post("/api/undo")
    view.set("camera.roll=4 deg")
    state, _ = view.wait_done(60)
    check("the next edit is shown", state["generation"] == state["wanted"], state)
    check("it ends as ever", view.end()[0] == 0)


MAP_EDGE = 256


def check_region(view):
    """A part of the picture is rendered alone, over the few pixels of the whole."""
    view.set("camera.roll=1 deg")
    state, whole = view.wait_done()
    for body in ("0 0 1", "a", "0 0 2 1", "nan 0 1 1", "0 0 1 1 1"):
        check(f"the region {body!r} is refused", view.request("/api/region", body)[0] == 400)
    check("a region is taken", view.request("/api/region", "0.25 0.5 0.75 1")[0] == 200)
    state, pixels = view.wait_done(after=state["number"])
    rows = lambda picture, x0, x1: [picture[4 * (64 * y + x0):4 * (64 * y + x1)] for y in range(18, 36)]
    inside = zip(b"".join(rows(whole, 16, 48)), b"".join(rows(pixels, 16, 48)))
    check("it has the pixels of the whole picture, within a step or two", max(abs(a - b) for a, b in inside) <= 8)
    view.set("camera.roll=5 deg")
    state, pixels = view.wait_done()
    check("around it few pixels are shown", state["level"] >= 1 and len(pixels) == 4 * 64 * 36)
    _, values = view.request("/api/pixel?x=32&y=30")
    check("values are read inside of it", b'"Z"' in values, values)
    view.request("/api/show", "Z")
    state, channel = view.picture()
    read = lambda x, y: json.loads(view.request(f"/api/pixel?x={x}&y={y}")[1])["Z"]
    depths = [z for y in range(18, 36) for x in range(16, 48) if (z := read(x, y)) is not None]
    near = lambda a, b: abs(a - b) <= 1e-5 * b
    check("a channel has the range of the region", near(state["least"], min(depths)) and near(state["greatest"], max(depths)), state)
    row = rows(channel, 16, 48)[-1]
    check("and its pixels", len({row[i:i + 4] for i in range(0, len(row), 4)}) > 12)
    view.request("/api/show", "")
    state, pixels = view.picture()
    status, answer = view.post("/api/save_picture", "exr")
    check("the region is what is saved", status == 200 and os.path.getsize(answer["file"]) > 1000, answer)
    view.request("/api/region", "")
    _, again = view.wait_done(after=state["number"])
    check("the whole comes back", again != pixels)
    view.post("/api/undo")
    view.post("/api/undo")


def check_map(view, folder):
    """Coverage painted by a brush: the program chooses the name of its picture."""
    check("a scene without clouds has no map", view.request("/api/map?cloud=0")[0] == 422)
    view.post("/api/add_cloud", "cumulus_humilis")
    view.set("clouds[0].bake.extent=1 km", "clouds[0].bake.voxel=80 m")
    status, even = view.request("/api/map?cloud=0")
    check("the map begins as the cloud's coverage", status == 200 and len(even) == MAP_EDGE ** 2 and len(set(even)) == 1)
    for body in ("0.5 0.5", "a b c d e", "0.5 0.5 0.1 1 1 1"):
        check(f"the dab {body!r} is refused", view.post("/api/paint?cloud=0", body)[0] == 400)
    before = set(os.listdir(folder))
    status, answer = view.post("/api/paint?cloud=0&gesture=3", "0.25 0.5 0.1 1 0\n0.27 0.5 0.1 1 0")
    made = set(os.listdir(folder)) - before
    check("a stroke is taken, and one picture is made", status == 200 and len(made) == 1, (answer, made))
    path = os.path.join(folder, made.pop())
    header = open(path, "rb").read(29)
    check("it is a PNG of one channel of 16 bits", header[:8] == b"\x89PNG\r\n\x1a\n" and header[16:26] == struct.pack(">IIBB", MAP_EDGE, MAP_EDGE, 16, 0))
    check("it is the cloud's map", view.values()["clouds[0].bake.map.image"] == f'"{path}"')
    painted = view.request("/api/map?cloud=0")[1]
    at = lambda picture, x, y: picture[int(y * MAP_EDGE) * MAP_EDGE + int(x * MAP_EDGE)]
    check("the brush has emptied its place alone", at(painted, 0.25, 0.5) == 0 and at(painted, 0.75, 0.5) == even[0])
    _, first = view.wait_done(60)
    number = view.picture()[0]["wanted"]
    view.post("/api/paint?cloud=0&gesture=4", "0.75 0.5 0.1 1 0")
    check("the next stroke goes to the same file", set(os.listdir(folder)) - before == {os.path.basename(path)})
    check("and is rendered", view.picture()[0]["wanted"] > number)
    _, second = view.wait_done(60)
    check("though the scene names the same file as before", second != first)
    view.post("/api/unpaint?cloud=0")
    check("a stroke is taken back", view.request("/api/map?cloud=0")[1] == painted)
    state, _ = view.wait_done(60)
    check("the painted cloud is rendered", state["generation"] == state["wanted"] and not state["message"], state["message"])
    with open(path, "r+b") as file:  # by another program
        file.write(file.read())
    number = state["wanted"]
    os.utime(path, (1, 1))
    open(os.path.join(folder, "other.png"), "w").close()
    view.wait(lambda s: s["wanted"] > number, 5)
    view.wait_done(60)
    while view.post("/api/undo")[0] == 200:
        pass


def check_frames(program, folder):
    """Frames of an animation, by their numbers."""
    path = os.path.join(folder, "frames.yaml")
    write_scene(path, SCENE + "animate: {camera.position: {keys: [[1, [0, -6 km, 2500 m]], [9, [0, -6 km, 3300 m]]]}}\n")
    view = View(program, path, "--frames", "1-9x2")
    _, first = view.wait_done()
    check("the frames are listed", json.loads(view.request("/api/frames")[1]) == [1, 3, 5, 7, 9])
    check("a frame is a number", view.post("/api/frame", "many")[0] == 400)
    view.post("/api/frame", "9")
    state, last = view.wait_done()
    check("another frame is another picture", state["frame"] == 9 and last != first, state["frame"])
    check("values are those of the frame", view.values()["camera.position"] == "[0 m, -6 km, 3.3 km]", view.values()["camera.position"])
    variants = get_variants(view, "camera.roll=0 deg\ncamera.roll=1 deg")
    view.set("terrain.albedo=0.3")
    check("after an edit too", view.values()["camera.position"] == "[0 m, -6 km, 3.3 km]")
    view.post("/api/undo")
    check("and after its undo", view.values()["camera.position"] == "[0 m, -6 km, 3.3 km]")
    view.post("/api/frame", "1")
    check("the first comes back", view.wait_done()[1] == first)
    check("with its values", view.values()["camera.position"] == "[0 m, -6 km, 2.5 km]")
    check("variants are of the frame that is shown", get_variants(view, "camera.roll=0 deg\ncamera.roll=1 deg") != variants)
    check("a frame is no edit", json.loads(view.request("/api/edits")[1])["edits"] == [])
    for frame in (3, 5, 7, 9, 3, 5):
        view.post("/api/frame", str(frame))
    check("scrubbing ends in the last frame", view.wait_done()[0]["frame"] == 5)
    check("the view of frames ends", view.end()[0] == 0)


def check_bits(program, folder):
    """The final picture of the page has the bits of a render of the saved scene."""
    path = os.path.join(folder, "bits.yaml")
    write_scene(path, """camera: {position: [0, -5 km, 900 m], look_at: [0, 0, 1400 m], fov: 50 deg, resolution: [64, 36]}
sun: {elevation: 30 deg, azimuth: 140 deg}
clouds: [{name: a, bake: {preset: cumulus_humilis, seed: 3, extent: 2 km, voxel: 50 m}}]
terrain: {ridges: {samples: 65, relief: 300 m}}
output: {pixel_type: float, aovs: [clouds]}
render: {quality: draft, samples: 1}
""")
    view = View(program, path)
    view.wait_done(60)
    for edits in (["sun.elevation=31.5 deg"], ["sun.elevation=31.6 deg", "camera.position=[100 m, -5 km, 950 m]"],
                  ["terrain.albedo=0.25"], ["clouds[0].bake.coverage=0.5", "camera.fov=40 deg"]):
        view.set(*edits)
        state, _ = view.wait_done(60)
        _, answer = view.post("/api/save_picture", "exr")
        view.post("/api/save")
        alone = os.path.join(folder, "alone.exr")
        subprocess.run([program, "render", path, "--samples", str(state["samples"]), "-o", alone, "-q", "--set", "output.pixel_type=half"],
                       check=True, stdout=subprocess.DEVNULL)
        compared = subprocess.run([program, "compare", "--exact", answer["file"], alone], capture_output=True, text=True)
        check(f"{edits}: the picture has the bits of a render", compared.returncode == 0, compared.stdout + compared.stderr)
        os.unlink(answer["file"])
    view.end()


def check_two_pages(program, path):
    """Two clients see the same scene; one that is killed leaves the other its answers."""
    view = View(program, path)
    view.wait_done()
    dead = socket.create_connection((view.host, view.port), 5)
    dead.sendall(f"GET /api/picture?after=0 HTTP/1.1\r\nHost: 127.0.0.1:{view.port}\r\nX-Nephos-Token: {view.token}\r\n\r\n".encode())
    dead.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    dead.close()  # a reset while the pixels are sent
    view.set("camera.roll=2 deg")
    first, second = view.wait_done(), view.wait_done()
    check("two pages show the same", first[1] == second[1] and first[0]["edit"] == second[0]["edit"])
    view.process.kill()
    view.process.wait()


def check_allowed_files(program, path):
    view = View(program, path, "--allow-files")
    check("--allow-files lets the page name files", view.set("output.image=x.exr")[0] == 200)
    check("but no mappings", view.set("output={image: x.exr}")[0] == 403)
    view.end()


def main():
    program = os.path.abspath(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "scene.yaml")
        write_scene(path, SCENE)
        view = View(program, path)
        view.wait_done()
        dripping, cut_after = check_slow_clients(view)
        check_refusals(view)
        check_malformed(view)
        check_edits(view)
        check_undo(view)
        check_lists(view)
        check_pictures(view, program, folder)
        check_channels(view, folder)
        check_variants(view)
        check_past(view)
        check_drag(view)
        check_region(view)
        check_map(view, folder)
        check_file(view, path)
        check_save(view, path)
        dripping.join(20)
        check("a client that drips is cut within 15 s", cut_after and cut_after[0] < 15, cut_after)
        check_end(view)
        check_allowed_files(program, path)
        check_no_picture(program, path)
        check_bakes(program, folder)
        check_frames(program, folder)
        check_bits(program, folder)
        check_two_pages(program, path)
    return check.failures > 0


if __name__ == "__main__":
    sys.exit(main())
