# SPDX-License-Identifier: Apache-2.0
"""Calls: errors as exceptions, callbacks, Ctrl-C, threads, forks."""
import concurrent.futures
import logging
import os
import signal
import subprocess
import sys
import threading
import time

import numpy
import pytest

import nephos

SLOW = {"samples": 100000, "integrator": "path"}  # minutes, if nothing ends it


# ---- Errors ----

def test_errors_carry_the_message_of_the_log(scene, tmp_path):
    with pytest.raises(nephos.NotFoundError, match="absent.yaml") as caught:
        nephos.load(tmp_path / "absent.yaml")
    assert isinstance(caught.value, FileNotFoundError) and isinstance(caught.value, nephos.Error)
    with pytest.raises(nephos.Error, match="sun.elevation"):
        scene["sun.elevation"] = "200 deg"
    with pytest.raises(nephos.Error, match="sun.elevatoin.*sun.elevation"):
        scene["sun.elevatoin"] = "20 deg"
    with pytest.raises(nephos.SceneError, match="2 errors|camera|clouds"):
        nephos.Scene("version: 1\ncamera: {fov: 900 deg}\nclouds: 7\n")
    (tmp_path / "damaged.exr").write_bytes(b"not a picture")
    with pytest.raises(nephos.FileError, match="damaged.exr"):
        nephos.Image.load(tmp_path / "damaged.exr")
    with pytest.raises(OSError, match="nowhere"):
        nephos.render(scene, samples=1).save(tmp_path / "nowhere" / "a.exr")


@pytest.mark.parametrize("settings, error, message", [
    ({"samples": -1}, ValueError, "does not fit"), ({"samples": 1.5}, TypeError, "whole number"),
    ({"samples": "4"}, TypeError, "whole number"), ({"samples": 0}, nephos.ArgumentError, "samples is 0, must be 1 to"),
    ({"sampels": 4}, TypeError, "but 'samples'"), ({"integrator": "trace"}, ValueError, "march, path"),
    ({"target_error": "low"}, TypeError, "a number"), ({"resolution": 7}, ValueError, "width and height"),
    ({"crop_max": (1, 2, 3)}, ValueError, "2 values"), ({"progress": 7}, TypeError, "a function"),
    ({"width": 1 << 40}, ValueError, "32 bits"), ({"tile": 7}, TypeError, "a function")])
def test_bad_settings_are_refused(scene, settings, error, message):
    with pytest.raises(error, match=message):
        nephos.render(scene, **settings)


def test_wrong_objects_are_refused(scene_path):
    for wrong in None, 7, str(scene_path):
        with pytest.raises(TypeError, match="nephos.Scene"):
            nephos.render(wrong)
        with pytest.raises(TypeError, match="nephos.Scene"):
            nephos.Renderer().render(wrong)
    with pytest.raises(TypeError):
        nephos.load(7)
    with pytest.raises(nephos.ArgumentError, match="context"):
        nephos.Renderer(nephos.Context(thread_count=1)).render(nephos.load(scene_path), samples=1)


def test_warnings_go_to_the_logger(scene, caplog):
    with caplog.at_level(logging.INFO, "nephos"):
        nephos.render(scene, samples=1)
        scene["sun.elevation"] = "-30 deg"
        nephos.render(scene, samples=1)
    assert any(record.levelno == logging.WARNING and "sun" in record.message for record in caplog.records)


# ---- Keys ----

def test_a_copy_is_edited_apart(scene):
    before = scene.values
    copy = scene.clone()
    copy.insert("clouds[0]", {"name": "first", "bake": {"preset": "stratus"}})
    assert copy.clouds == ["first"] + scene.clouds and scene.values == before
    del copy["clouds[0]"]
    assert copy.values == before
    copy.update({"sun.elevation": "5 deg", "camera.fov": None})
    assert copy["sun.elevation"] == "5 deg" and scene.values == before
    edited = copy.values
    with pytest.raises(nephos.Error, match="has no source"):
        copy.update({"sun.elevation": "6 deg", "clouds[%d].name" % len(copy.clouds): "x"})
    assert copy.values == edited


def test_a_scene_is_saved_with_its_comments(tmp_path):
    path = tmp_path / "scene.yaml"
    path.write_text("# mine\nsun: {elevation: 20 deg} # low\n")
    scene = nephos.load(path)
    scene["sun.elevation"] = "5 deg"
    assert scene.describe_edits() == "--set 'sun.elevation=5 deg'\n"
    scene.save(path)
    assert path.read_text() == scene.text == "# mine\nsun: {elevation: 5 deg} # low\n"


def test_keys_take_values_of_python(scene, tmp_path):
    scene["camera.position"] = ["0", "-5 km", "1200 m"]
    assert scene["camera.position"] == "[0 m, -5 km, 1.2 km]"
    scene["camera.position"] = numpy.array([0, -4000, 1200])
    assert scene["camera.position"] == "[0 m, -4 km, 1.2 km]"
    scene["render.samples"] = numpy.int64(3)
    scene["sun.limb_darkening"] = False
    scene["output.image"] = tmp_path / "a, b: [c].exr"
    scene["terrain"] = {"ridges": {"samples": 17}}
    assert scene["render.samples"] == "3" and scene["sun.limb_darkening"] == "false"
    assert "a, b: [c].exr" in scene["output.image"] and scene["terrain.ridges.samples"] == "17"
    assert "sun.elevation" in scene and "sun.height" not in scene
    with pytest.raises(KeyError, match="sun.height"):
        scene["sun.height"]
    with pytest.raises(ValueError):
        scene["sun.elevation"] = float("nan")
    with pytest.raises(TypeError):
        scene["sun.elevation"] = object()
    assert any(key["key"] == "sun.elevation" for key in nephos.schema("sun"))


# ---- Callbacks ----

def test_progress_rises_and_ends_at_one(scene):
    seen = []
    nephos.render(scene, progress=lambda p: seen.append((p.fraction, p.stage)))
    fractions = [fraction for fraction, _ in seen]
    assert fractions == sorted(fractions) and 0.9 < fractions[-1] <= 1 and all(stage for _, stage in seen)


def test_false_from_progress_cancels(scene):
    with pytest.raises(nephos.Cancelled):
        nephos.render(scene, progress=lambda p: False, **SLOW)


def test_an_exception_in_a_callback_ends_the_render_and_comes_out(scene):
    def fail(_):
        raise ZeroDivisionError("mine")
    for callback in "progress", "tile":
        begin = time.monotonic()
        with pytest.raises(ZeroDivisionError, match="mine"):
            nephos.render(scene, **{callback: fail}, samples=2000)
        assert time.monotonic() - begin < 20
    assert nephos.render(scene, samples=1).width == 48


def test_tiles_cover_the_picture(scene):
    copy, kept = numpy.zeros((27, 48), numpy.float32), []
    def take(tile):
        copy[tile.min[1]:tile.max[1], tile.min[0]:tile.max[0]] = tile["R"]
        kept.append(tile)
    image = nephos.render(scene, tile=take)
    assert (copy == image["R"]).all()
    with pytest.raises(ValueError, match="only during its callback"):
        kept[0]["R"]


def test_a_scene_in_use_cannot_be_changed(scene):
    def change(_):
        scene["sun.elevation"] = "20 deg"
    with pytest.raises(nephos.Error, match="in use"):
        nephos.render(scene, progress=change)
    scene["sun.elevation"] = "20 deg"


def test_a_callback_may_use_the_library(scene):
    seen = []
    nephos.render(scene, progress=lambda p: seen.append(nephos.Volume(numpy.ones((2, 2, 2))).sample([1, 1, 1])))
    assert seen and set(float(value) for value in seen) == {1.0}


# ---- Ctrl-C ----

def test_ctrl_c_ends_a_render(scene):
    sent = []
    def send():
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)
    for settings in SLOW, {"resolution": (1920, 1080), "samples": 4096}:
        timer = threading.Timer(0.6, send)
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            nephos.render(scene, **settings)
        # Half a second on a quiet machine; ten times that where others compute.
        assert time.monotonic() - sent[-1] < 5
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_an_exception_of_a_signal_handler_ends_a_render(scene):
    def fail(number, frame):
        raise ZeroDivisionError("alarm")
    previous = signal.signal(signal.SIGALRM, fail)
    try:
        for _ in range(3):
            signal.setitimer(signal.ITIMER_REAL, 0.2)
            with pytest.raises(ZeroDivisionError, match="alarm"):
                nephos.render(scene, **SLOW)
    finally:
        signal.signal(signal.SIGALRM, previous)


def test_cancel_comes_from_another_thread(scene):
    renderer = nephos.Renderer()
    threading.Timer(0.4, renderer.cancel).start()
    with pytest.raises(nephos.Cancelled):
        renderer.render(scene, **SLOW)
    assert renderer.render(scene, samples=1).width == 48


# ---- Threads and forks ----

def render_alone(path):
    context = nephos.Context(thread_count=1)
    return nephos.Renderer(context).render(nephos.load(path, context=context), samples=2)["R"].tobytes()


def test_four_threads_give_the_same_bits(scene_path):
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        pictures = set(pool.map(render_alone, [scene_path] * 4))
    assert pictures == {nephos.render(nephos.load(scene_path), samples=2)["R"].tobytes()}


def test_threads_may_share_a_scene(scene):
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        pictures = pool.map(lambda _: nephos.render(scene, samples=1)["R"].tobytes(), range(4))
    assert len(set(pictures)) == 1


def test_errors_of_two_threads_are_not_mixed(tmp_path):
    def load(number):
        for _ in range(20):
            with pytest.raises(nephos.NotFoundError, match="absent%d.yaml" % number):
                nephos.load(tmp_path / ("absent%d.yaml" % number))
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        list(pool.map(load, range(2)))


def test_a_forked_child_renders_with_objects_of_its_own(scene, scene_path):
    image = nephos.render(scene, samples=1)
    read, write = os.pipe()
    child = os.fork()
    if not child:
        try:
            with pytest.raises(nephos.Error, match="before a fork"):
                nephos.render(scene, samples=1)
            again = nephos.render(nephos.load(scene_path), samples=1)
            os.write(write, b"same" if (again["R"] == image["R"]).all() else b"other")
        finally:
            os._exit(0)
    os.close(write)
    assert os.read(read, 10) == b"same"
    assert os.waitpid(child, 0)[1] == 0
    assert nephos.render(scene, samples=1)["R"].tobytes() == image["R"].tobytes()


def test_a_program_ends_while_a_thread_renders(scene_path):
    code = ("import sys, threading, time, nephos; scene = nephos.load(sys.argv[1])\n"
            "work = lambda: nephos.render(scene, samples=100000, integrator='path', progress=lambda p: None)\n"
            "threading.Thread(target=work, daemon=True).start(); time.sleep(0.5)")
    done = subprocess.run([sys.executable, "-c", code, scene_path], stderr=subprocess.PIPE, text=True, timeout=60)
    assert done.returncode == 0 and done.stderr == ""
