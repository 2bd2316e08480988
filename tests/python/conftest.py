# SPDX-License-Identifier: Apache-2.0
"""Fixtures of the tests of the Python package: a small scene, and the program that renders it too."""
import os
import signal
import subprocess

import pytest

import nephos

SCENE = """\
version: 1
camera: {position: [0, -6 km, 1200 m], look_at: [0, 0, 2200 m], fov: 60 deg, resolution: [48, 27]}
sun: {elevation: 35 deg, azimuth: 120 deg}
clouds:
  - {name: field, bake: {preset: cumulus_humilis, seed: 7, extent: 2 km, voxel: 100 m}}
atmosphere: {tolerance: 0.1}
render: {samples: 2, quality: draft}
"""


@pytest.fixture(autouse=True)
def ctrl_c():
    """Ctrl-C raises KeyboardInterrupt also where a shell that runs the tests in the background ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def scene_path(tmp_path):
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE)
    return path


@pytest.fixture
def scene(scene_path):
    return nephos.load(scene_path)


@pytest.fixture
def program(tmp_path):
    """Runs the program in the folder of the test, and returns what it prints."""
    def run(*arguments):
        command = [os.environ["NEPHOS_PROGRAM"], *map(str, arguments)]
        done = subprocess.run(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        assert done.returncode == 0, done.stdout
        return done.stdout
    return run
