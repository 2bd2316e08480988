# SPDX-License-Identifier: Apache-2.0
"""Images: the bits of the program, views without a copy, lives of images and views."""
import copy
import gc
import os
import pickle
import subprocess
import sys

import numpy
import pytest

import nephos


def test_pictures_have_the_bits_of_the_program(scene, scene_path, program, tmp_path):
    scene["sun.elevation"] = "20 deg"
    scene["output.pixel_type"] = "float"
    program("render", scene_path, "-q", "--set", "sun.elevation=20 deg", "--set", "output.pixel_type=float",
            "--samples", "4", "-o", "shell.exr")
    image = nephos.render(scene, samples=4)
    other = nephos.Image.load(tmp_path / "shell.exr")
    assert sorted(image.channels) == sorted(other.channels)
    for name in image:
        assert image[name].tobytes() == other[name].tobytes(), name
    assert nephos.compare(image, other)["differing_count"] == 0
    assert image.error == other.error
    scene["render.samples"] = 4  # as the program sets it
    by_key = nephos.render(scene)
    assert by_key["R"].tobytes() == other["R"].tobytes()
    assert by_key.attribute("nephos:sceneHash") == other.attribute("nephos:sceneHash")


def test_a_resolution_is_that_of_the_program(scene, scene_path, program, tmp_path):
    program("render", scene_path, "-q", "--set", "output.pixel_type=float", "--resolution", "32x18", "-o", "shell.exr")
    image, other = nephos.render(scene, resolution=(32, 18)), nephos.Image.load(tmp_path / "shell.exr")
    assert image.width == 32 and image.height == 18
    assert nephos.compare(image, other)["differing_count"] == 0


def test_a_view_is_no_copy(scene):
    image = nephos.render(scene, samples=1)
    red = image["R"]
    assert red.dtype == numpy.float32 and red.shape == (27, 48) and red.flags.c_contiguous and not red.flags.owndata
    assert numpy.shares_memory(red, image["R"]) and not numpy.shares_memory(red, image["G"])
    red[3, 5] = 17
    assert image.buffer("R")[3, 5] == 17
    assert image[["R", "G"]].shape == (27, 48, 2)


def test_a_view_outlives_image_scene_and_renderer(scene_path):
    context = nephos.Context(thread_count=2)
    scene, renderer = nephos.load(scene_path, context=context), nephos.Renderer(context)
    image = renderer.render(scene, samples=1)
    red, expected = image["R"], image["R"].tobytes()
    del scene, renderer, context
    gc.collect()
    assert image["R"].tobytes() == expected
    del image
    gc.collect()
    others = [nephos.Image.from_arrays({"R": numpy.zeros((27, 48))}) for _ in range(20)]
    assert red.tobytes() == expected and len(others) == 20


def test_a_missing_channel_is_a_key_error(scene):
    image = nephos.render(scene, samples=1)
    with pytest.raises(KeyError, match="no channel 'Q': R, G, B, A, Z"):
        image["Q"]
    with pytest.raises(TypeError):
        image[0]
    assert "R" in image and "Q" not in image and len(image) == 5


def test_numpy_is_imported_only_where_it_is_asked_for(scene_path):
    code = ("import sys, nephos; image = nephos.render(nephos.load(sys.argv[1]), samples=1)\n"
            "assert image.buffer('R').shape == (27, 48); assert 'numpy' not in sys.modules\n"
            "image['R']; assert 'numpy' in sys.modules")
    subprocess.run([sys.executable, "-c", code, scene_path], check=True)


def test_images_are_pickled_and_copied(scene):
    image = nephos.render(scene, samples=1)
    image["R"][0, 0] = numpy.nan
    for other in pickle.loads(pickle.dumps(image)), copy.deepcopy(image):
        assert all(image[name].tobytes() == other[name].tobytes() for name in image)
        assert other.attribute("nephos:sceneHash") == image.attribute("nephos:sceneHash")
    for unpicklable in scene, nephos.Renderer(), nephos.Context(thread_count=1):
        with pytest.raises(TypeError, match="cannot be pickled"):
            pickle.dumps(unpicklable)


def test_images_of_arrays(tmp_path):
    values = numpy.arange(12.0).reshape(3, 4)
    image = nephos.Image.from_arrays({"Y": values[::-1].T, "Z": values.T.astype(numpy.float16)})
    assert image["Y"].tolist() == values[::-1].T.tolist() and image.width == 3
    image.set_attribute("comment", "mine")
    image.save(tmp_path / "y.exr", pixel_type="float")
    assert nephos.Image.load(tmp_path / "y.exr").attribute("comment") == "mine"
    image.save(tmp_path / "y.png", view="standard", exposure="fixed")
    assert nephos.Image.load(tmp_path / "y.png").channels == ["R", "G", "B"]
    for bad in {}, {"Y": numpy.zeros(3)}, {"Y": numpy.zeros((0, 3))}, {"Y": values, "Z": values.T}:
        with pytest.raises(ValueError):
            nephos.Image.from_arrays(bad)
    with pytest.raises(TypeError, match="complex"):
        nephos.Image.from_arrays({"Y": values * 1j})
    with pytest.raises(ValueError, match="exr or .png"):
        image.save(tmp_path / "y.jpg")
    with pytest.raises(TypeError, match="Image.load"):
        nephos.Image(3, 4)
    with pytest.raises(TypeError, match="has no setting 'view'"):
        image.save(tmp_path / "y.exr", view="raw")


def test_parts_are_merged_to_the_whole(scene, tmp_path):
    paths = [tmp_path / ("%d.npart" % i) for i in range(2)]
    for i, path in enumerate(paths):
        nephos.render(scene, tile_index=i, tile_count=2, part_path=path)
    assert nephos.compare(nephos.merge(paths), nephos.render(scene))["differing_count"] == 0
    with pytest.raises(FileNotFoundError, match="missing"):
        nephos.merge(paths[:1])
    with pytest.raises(TypeError):
        nephos.merge(os.fspath(paths[0]))


def test_pixels_of_a_preview_are_those_of_its_file(tmp_path):
    light = numpy.linspace(0, 2, 48 * 27, dtype=numpy.float32).reshape(27, 48)
    image = nephos.Image.from_arrays({"R": light, "G": light / 2, "B": light / 4})
    image.save(tmp_path / "picture.png", view="standard")
    saved = nephos.Image.load(tmp_path / "picture.png")
    pixels = numpy.asarray(image.develop(view="standard"))
    assert pixels.shape == (27, 48, 4) and (pixels[..., 3] == 255).all()
    assert abs(pixels[..., :3] - 255 * saved[["R", "G", "B"]]).max() <= 1.001  # dither is less than a step
    held = image.develop(view="standard", exposure="fixed", exposure_ev=image.exposure(view="standard"))
    assert held == image.develop(view="standard")
