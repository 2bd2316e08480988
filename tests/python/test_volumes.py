# SPDX-License-Identifier: Apache-2.0
"""Volumes of arrays and of lists of samples: every kind of array, and what is refused."""
import numpy
import pytest

import nephos

RANDOM = numpy.random.default_rng(3).random((9, 10, 11), numpy.float32)
PLACES = numpy.argwhere(numpy.ones_like(RANDOM)) * 20.0


def sample(volume):
    return volume.sample(PLACES + 3.0).tobytes()


@pytest.mark.parametrize("array", [
    numpy.asfortranarray(RANDOM), RANDOM.astype(numpy.float64), numpy.repeat(RANDOM, 2, 1)[:, ::2],
    RANDOM[::-1][::-1], RANDOM.astype(">f4"), RANDOM.tolist()], ids="fortran double strided flipped swapped list".split())
def test_arrays_of_any_layout_make_one_volume(array):
    assert sample(nephos.Volume(array, voxel=20)) == sample(nephos.Volume(RANDOM, voxel=20))


def test_samples_are_at_their_places():
    volume = nephos.Volume(RANDOM, voxel=(20, 20, 20), origin=(1000, 0, 0), precision="float", name="smoke")
    assert (volume.sample(PLACES + (1000, 0, 0)) == RANDOM.reshape(-1)).all()
    assert volume.sample([1020, 40, 60]) == RANDOM[1, 2, 3]
    assert volume.info["name"] == "smoke" and volume.info["bounds_max_m"] == [1160, 180, 200]
    assert nephos.Volume(RANDOM, voxel=numpy.array([20, 10, 5])).info["bounds_max_m"] == [160, 90, 50]
    moved = nephos.Volume(RANDOM, transform=[[20, 0, 0, 0], [0, 20, 0, 0], [0, 0, 20, 5]], precision="float")
    assert moved.sample([20, 40, 65]) == RANDOM[1, 2, 3]


def test_a_sparse_volume_has_the_bits_of_the_array():
    field = numpy.where(RANDOM > 0.7, RANDOM, 0)
    coordinates = numpy.argwhere(field)
    order = numpy.random.default_rng(4).permutation(len(coordinates))
    for places in coordinates, coordinates[order], coordinates.astype(numpy.int16):
        values = field[tuple(places.T)]
        sparse = nephos.Volume(values, coordinates=places, voxel=20)
        assert sample(sparse) == sample(nephos.Volume(field, voxel=20))
        assert sparse.info["active_voxel_count"] == len(coordinates)


def test_float16_bool_and_integers_are_taken():
    assert nephos.Volume(numpy.ones((2, 2, 2), numpy.float16)).sample([1, 1, 1]) == 1
    assert nephos.Volume(numpy.ones((2, 2, 2), bool)).sample([1, 1, 1]) == 1
    assert nephos.Volume(numpy.full((2, 2, 2), 7, numpy.int64)).sample([1, 1, 1]) == 7


@pytest.mark.parametrize("array, error, message", [
    (numpy.zeros((2, 2)), ValueError, "three axes"),
    (numpy.zeros((0, 2, 2)), ValueError, "none of length 0"),
    (numpy.full((2, 2, 2), numpy.nan), nephos.ArgumentError, "nan at \\(0, 0, 0\\), must be finite"),
    (numpy.full((2, 2, 2), 1e300), nephos.ArgumentError, "inf at"),
    (-numpy.ones((2, 2, 2)), nephos.ArgumentError, "-1 at \\(0, 0, 0\\)"),
    (numpy.ones((2, 2, 2)) * 1j, TypeError, "real numbers"),
    (numpy.full((2, 2, 2), "x"), TypeError, "real numbers"),
    (numpy.full((2, 2, 2), None), TypeError, "real numbers"),
    (numpy.ma.masked_array(numpy.ones((2, 2, 2))), TypeError, "masked"), (7, ValueError, "three axes"), (None, TypeError, "real numbers")])
def test_bad_arrays_are_refused(array, error, message):
    with pytest.raises(error, match=message):
        nephos.Volume(array)


@pytest.mark.parametrize("values, coordinates, error, message", [
    ([1], [[0, 0]], ValueError, "\\(1, 3\\)"), ([1, 2], [[0, 0, 0]], ValueError, "\\(2, 3\\)"),
    ([], numpy.zeros((0, 3), int), ValueError, "one value at least"), ([[1]], [[0, 0, 0]], ValueError, "one axis"),
    ([1], [[0.5, 0, 0]], TypeError, "whole numbers"), ([1], [[1 << 40, 0, 0]], ValueError, "32 bits"),
    ([1, 2], [[1, 2, 3]] * 2, nephos.ArgumentError, "twice"),
    ([1], [[1 << 30, 0, 0]], nephos.LimitError, "farther"),
    ([numpy.inf], [[0, 0, 0]], nephos.ArgumentError, "finite")])
def test_bad_lists_are_refused(values, coordinates, error, message):
    with pytest.raises(error, match=message):
        nephos.Volume(values, coordinates=coordinates)


@pytest.mark.parametrize("settings, error, message", [
    ({"voxel": 0}, ValueError, "above 0"), ({"voxel": (20, -1, 20)}, ValueError, "above 0"),
    ({"voxel": "20 m"}, ValueError, "length in metres"),
    ({"voxel": (1, 2)}, ValueError, "three of them"), ({"precision": "double"}, ValueError, "half, float"),
    ({"name": 7}, TypeError, "a text"), ({"name": "a\0b"}, ValueError, "zero byte"),
    ({"transform": [[1, 0, 0, 0]]}, ValueError, "3 or 4 rows"), ({"transform": "x"}, ValueError, "3 or 4 rows"),
    ({"transform": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [1, 0, 0, 1]]}, ValueError, "fourth row"),
    ({"origin": "abc"}, ValueError, "three coordinates"), ({"origin": 5}, ValueError, "three coordinates"),
    ({"periodic": True}, ValueError, "two of True and False"), ({"periodic": (1, 0, 1)}, ValueError, "two of True"),
    ({"voxel": float("nan")}, ValueError, "above 0"), ({"context": 7}, TypeError, "Context")])
def test_bad_settings_are_refused(settings, error, message):
    with pytest.raises(error, match=message):
        nephos.Volume(RANDOM, **settings)


def test_a_volume_is_rendered_where_it_stands():
    scene = nephos.Scene("version: 1\ncamera: {position: [0, -900 m, 1 km], look_at: [0, 0, 1 km]}")
    clear = nephos.render(scene, resolution=(16, 9), samples=1)["A"].copy()
    field = numpy.full((12, 12, 12), 0.05, numpy.float32)
    index = scene.add(nephos.Volume(field, voxel=20), name="block", position=(0, 0, 900))
    assert index == 0 and scene.clouds == ["block"]
    alpha = nephos.render(scene, resolution=(16, 9), samples=1)["A"]
    assert alpha[4, 8] > 0.9 and (alpha[0] == clear[0]).all()
    with pytest.raises(TypeError, match="nephos.Volume"):
        scene.add(field)


def list_buffers(data):
    array = numpy.frombuffer(data, numpy.uint8)
    return {"bytes": data, "bytearray": bytearray(data), "view": memoryview(data), "array": array.copy(),
            "halves": numpy.append(array, numpy.zeros(len(data) % 2, numpy.uint8)).view(numpy.int16),
            "odd": memoryview(bytearray(b"x" + data))[1:],
            "strided": numpy.repeat(array, 2)[::2]}


@pytest.mark.parametrize("ending", ["nvdb", "vdb"])
def test_buffers_of_grids_are_those_of_the_file(scene, tmp_path, ending):
    path = tmp_path / ("field." + ending)
    nephos.bake(scene, path, cloud="field")
    expected = nephos.Volume.load(path, precision="float")
    places = numpy.random.default_rng(5).uniform(expected.info["bounds_min_m"], expected.info["bounds_max_m"], (500, 3))
    for name, buffer in list_buffers(path.read_bytes()).items():
        volume = nephos.Volume.from_nanovdb(buffer, grid="density", precision="float")
        assert volume.info == expected.info, name
        assert (volume.sample(places) == expected.sample(places)).all()


def test_a_grid_without_its_file_is_read(scene, tmp_path):
    nephos.bake(scene, tmp_path / "field.nvdb", cloud="field")
    data = (tmp_path / "field.nvdb").read_bytes()
    grid = data[data.index(b"NanoVDB", 8):]
    assert nephos.Volume.from_nanovdb(grid).info == nephos.Volume.from_nanovdb(data).info
    # The checksum is taken out: it would be wrong before all else.
    grid = bytearray(grid[:8] + b"\xff" * 8 + grid[16:])
    for at in numpy.random.default_rng(6).integers(0, 1100, 100):
        kept, grid[at] = grid[at], grid[at] ^ 0x55
        try:
            nephos.Volume.from_nanovdb(grid)
        except nephos.Error as error:
            assert str(error).startswith("buffer: ")
        grid[at] = kept
    for size in 0, 7, 40, 700, len(grid) - 1:
        with pytest.raises(nephos.FileError, match="^buffer: .*the buffer ends at byte %d," % size):
            nephos.Volume.from_nanovdb(grid[:size])


@pytest.mark.parametrize("buffer, settings, error, message", [
    (None, {}, TypeError, "no buffer"), ("x", {}, TypeError, "no buffer"), (b"x" * 99, {}, nephos.FileError, "not a VDB"),
    (b"", {"grids": "x"}, TypeError, "but 'grid'"), (b"", {"grid": 7}, TypeError, "a text")])
def test_bad_buffers_are_refused(buffer, settings, error, message):
    with pytest.raises(error, match=message):
        nephos.Volume.from_nanovdb(buffer, **settings)


def test_baked_clouds(scene, tmp_path):
    volume = nephos.Volume.bake("cumulus_humilis", voxel=80, extent=(2000, 2000), seed=3)
    assert 0 < volume.info["value_max"] < 0.2
    nephos.bake(scene, tmp_path / "field.vdb", cloud="field")
    assert nephos.Volume.load(tmp_path / "field.vdb").info["active_voxel_count"] > 100
    written = nephos.export(scene, tmp_path / "placed.vdb")
    assert written["name"] == "field" and not written["is_empty"]
    assert nephos.Volume.load(tmp_path / "placed.vdb").info["active_voxel_count"] > 100
    with pytest.raises(ValueError, match="cumulus_mediocris"):
        nephos.Volume.bake("cumulus_minimis")
    with pytest.raises(ValueError, match="field"):
        nephos.bake(scene, tmp_path / "other.vdb", cloud="other")
    with pytest.raises(ValueError, match="must end in .vdb or .nvdb"):
        nephos.bake(scene, tmp_path / "field.txt", cloud="field")
    with pytest.raises(ValueError, match="must end in .vdb or .nvdb"):
        nephos.export(scene, tmp_path / "field.txt", cloud="field")
