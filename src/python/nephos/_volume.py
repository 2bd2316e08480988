# SPDX-License-Identifier: Apache-2.0
"""Volumes: scalar fields on voxel grids, from arrays, from lists of samples, from files, from presets of clouds."""
from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any, Callable, Optional, Sequence

from . import _declarations as c
from ._context import Object, Watch, call, create, get_context
from ._image import import_numpy
from ._library import lib, make_struct
from ._settings import Path, apply_settings, documented, encode_text, read_struct

if TYPE_CHECKING:
    import numpy
    from ._context import Context, Progress


def _make_floats(numpy, name, values):
    """Values as an array of float32; numbers that float32 cannot hold are refused."""
    if isinstance(values, numpy.ma.MaskedArray):
        raise TypeError("%s are a masked array: fill what is masked first" % name)
    array = numpy.asarray(values)
    if array.dtype == bool or not numpy.can_cast(array.dtype, numpy.float32, "same_kind"):
        if array.dtype != bool and not numpy.issubdtype(array.dtype, numpy.integer):
            raise TypeError("%s are of %s, must be of real numbers" % (name, array.dtype))
    with numpy.errstate(over="ignore"):
        return array.astype(numpy.float32, copy=False)


def _get_bytes(buffer):
    """A pointer to the bytes of a buffer, which keeps them, and their number. What cannot be pointed to is copied."""
    try:
        view = memoryview(buffer)
    except TypeError:
        raise TypeError("%r is no buffer: bytes, a memoryview or an array" % type(buffer).__name__) from None
    if view.readonly or not view.c_contiguous:
        data = buffer if isinstance(buffer, bytes) else view.tobytes()
        return ctypes.c_char_p(data), len(data)
    return (ctypes.c_char * view.nbytes).from_buffer(view), view.nbytes


def _make_coordinates(numpy, coordinates, count):
    array = numpy.asarray(coordinates)
    if array.shape != (count, 3):
        raise ValueError("coordinates are of the shape %s, must be of (%d, 3): i, j, k of each value"
                         % (array.shape, count))
    if not numpy.issubdtype(array.dtype, numpy.integer):
        raise TypeError("coordinates are of %s, must be of whole numbers" % array.dtype)
    limits = numpy.iinfo(numpy.int32)
    if count and (array.min() < limits.min or array.max() > limits.max):
        raise ValueError("coordinates reach from %d to %d, must fit 32 bits" % (array.min(), array.max()))
    return numpy.ascontiguousarray(array, numpy.int32)


def _read_pair(periodic):
    pair = [] if isinstance(periodic, (str, bytes)) or not hasattr(periodic, "__len__") else [bool(x) for x in periodic]
    if len(pair) != 2:
        raise ValueError("periodic is %r, must be two of True and False, along x and along y" % (periodic,))
    return pair


def _read_numbers(values, shapes, message):
    """Numbers as an array of float64 of one of the shapes."""
    numpy = import_numpy("Volume")
    try:
        array = numpy.array(values, numpy.float64)
    except (TypeError, ValueError):
        array = None
    if isinstance(values, (str, bytes)) or array is None or array.shape not in shapes:
        raise ValueError("%s, is %r" % (message, values))
    return array


def _set_transform(desc, voxel, origin, transform):
    """Index to world: edges of voxels and the place of index 0, or a matrix of 3 × 4."""
    if transform is not None:
        if voxel is not None or origin is not None:
            raise TypeError("transform replaces voxel and origin: give either")
        rows = _read_numbers(transform, [(3, 4), (4, 4)], "transform must have 3 or 4 rows of 4 numbers")
        if len(rows) == 4 and rows[3].tolist() != [0, 0, 0, 1]:
            raise ValueError("transform has %s for its fourth row, must have 0, 0, 0, 1" % rows[3].tolist())
    else:
        edges = _read_numbers(1 if voxel is None else voxel, [(), (3,)],
                              "voxel must be a length in metres or three of them")
        if not all(edge > 0 for edge in edges.flat):
            raise ValueError("voxel is %s, must be above 0 (a transform may mirror)" % edges.tolist())
        place = _read_numbers((0, 0, 0) if origin is None else origin, [(3,)],
                              "origin must be three coordinates in metres")
        rows = [[edges.flat[i % edges.size] if i == j else 0.0 for j in range(3)] + [place[i]] for i in range(3)]
    for i in range(3):
        for j in range(4):
            desc.index_to_world[i][j] = rows[i][j]


class Volume(Object):
    """A scalar field on a voxel grid, with its place in the world. It never changes, and many scenes may share it.

    `Volume(array, voxel=20)` takes an array of three axes, x, y and z; `Volume(values, coordinates=ijk, voxel=20)` takes
    samples at places of the grid, an array of n × 3 whole numbers, and is 0 elsewhere. Values are copied.

    voxel: edge of a voxel in metres, or one for each axis; 1 unless it is given.
    origin: world coordinates of the sample (0, 0, 0), in metres; 0, 0, 0 unless it is given.
    transform: a matrix of 3 × 4 from indices to metres, in place of both.
    periodic: whether the array repeats along x, and along y: two of True and False.
    precision: "half" or "float".
    name: name of the grid.
    """

    __slots__ = ()

    @documented("neph_volume_create_dense", "neph_volume_create_sparse")
    def __init__(self, values: Any, *, coordinates: Any = None, voxel: float | Sequence[float] | None = None,
                 origin: Optional[Sequence[float]] = None, transform: Any = None,
                 periodic: tuple[bool, bool] = (False, False), precision: str = "half", name: str = "density",
                 context: Optional[Context] = None) -> None:
        context = get_context(context)
        numpy = import_numpy("Volume")
        array = _make_floats(numpy, "values", values)
        periodic = _read_pair(periodic)
        make = self._make_dense if coordinates is None else self._make_sparse
        desc, kept = make(numpy, array, coordinates, periodic)
        apply_settings(desc, {"precision": precision, "name": name}, "Volume()")
        _set_transform(desc, voxel, origin, transform)
        function = "neph_volume_create_" + ("dense" if coordinates is None else "sparse")
        super().__init__(create(context, c.neph_volume, function, context._handle, ctypes.byref(desc)), context)
        del kept

    @staticmethod
    def _make_dense(numpy, array, _, periodic):
        if array.ndim != 3 or not array.size:
            raise ValueError("values are of the shape %s, must be of three axes, x, y and z, none of length 0, unless "
                             "there are coordinates" % (array.shape,))
        if max(array.shape) >= 1 << 32:
            raise ValueError("values are of the shape %s: too many along an axis" % (array.shape,))
        array = numpy.asfortranarray(array)  # x fastest
        desc = make_struct(c.neph_volume_dense_desc)
        for axis in range(3):
            desc.size[axis] = array.shape[axis]
        desc.values = ctypes.cast(array.ctypes.data, ctypes.POINTER(ctypes.c_float))
        desc.is_periodic_x, desc.is_periodic_y = periodic
        return desc, array

    @staticmethod
    def _make_sparse(numpy, array, coordinates, periodic):
        if array.ndim != 1 or not array.size:
            raise ValueError("values are of the shape %s, must be of one axis, with one value at least, where there are "
                             "coordinates" % (array.shape,))
        if any(periodic):
            raise ValueError("a volume of coordinates cannot be periodic: give an array")
        array = numpy.ascontiguousarray(array)
        places = _make_coordinates(numpy, coordinates, len(array))
        desc = make_struct(c.neph_volume_sparse_desc)
        desc.sample_count = len(array)
        desc.coordinates = ctypes.cast(places.ctypes.data, ctypes.POINTER(ctypes.c_int32))
        desc.values = ctypes.cast(array.ctypes.data, ctypes.POINTER(ctypes.c_float))
        return desc, (array, places)

    @classmethod
    def _wrap(cls, handle, context):
        volume = cls.__new__(cls)
        Object.__init__(volume, handle, context)
        return volume

    @classmethod
    @documented("neph_volume_load", settings="neph_volume_load_desc")
    def load(cls, path: Path, *, progress: Optional[Callable[[Progress], Any]] = None,
             context: Optional[Context] = None, **settings: Any) -> Volume:
        """Reads one grid of a .vdb or .nvdb file."""
        context, watch = get_context(context), Watch(progress)
        desc = apply_settings(watch.attach(make_struct(c.neph_volume_load_desc)), settings, "Volume.load()")
        return cls._wrap(create(context, c.neph_volume, "neph_volume_load", context._handle, encode_text("path", path),
                                ctypes.byref(desc), watch=watch), context)

    @classmethod
    @documented("neph_volume_load_memory", settings="neph_volume_load_desc")
    def from_nanovdb(cls, buffer: Any, *, progress: Optional[Callable[[Progress], Any]] = None,
                     context: Optional[Context] = None, **settings: Any) -> Volume:
        """Reads one grid of a buffer: NanoVDB grids as a GridHandle has them, or the bytes of a .nvdb or .vdb file. Bytes,
        memoryviews and arrays of numpy are buffers."""
        context, watch = get_context(context), Watch(progress)
        desc = apply_settings(watch.attach(make_struct(c.neph_volume_load_desc)), settings, "Volume.from_nanovdb()")
        pointer, size = _get_bytes(buffer)
        return cls._wrap(create(context, c.neph_volume, "neph_volume_load_memory", context._handle, pointer, size,
                                ctypes.byref(desc), watch=watch), context)

    @classmethod
    @documented("neph_cloud_bake", "neph_cloud_get_preset", settings="neph_cloud_desc")
    def bake(cls, preset: Optional[str] = None, *, progress: Optional[Callable[[Progress], Any]] = None,
             context: Optional[Context] = None, **settings: Any) -> Volume:
        """Bakes a procedural cloud, of a preset such as "cumulus_mediocris" where one is named. Values are extinction in
        1/m."""
        context, watch = get_context(context), Watch(progress)
        cloud, desc = make_struct(c.neph_cloud_desc), watch.attach(make_struct(c.neph_bake_desc))
        if preset is not None:
            call(context, "neph_cloud_get_preset", context._handle, encode_text("preset", preset), ctypes.byref(cloud))
        apply_settings(cloud, settings, "Volume.bake()")
        return cls._wrap(create(context, c.neph_volume, "neph_cloud_bake", context._handle, ctypes.byref(cloud),
                                ctypes.byref(desc), watch=watch), context)

    @property
    def info(self) -> dict[str, Any]:
        """Contents of the volume as a dict: name, transform, box in metres, active voxels, range of values, memory."""
        info = make_struct(c.neph_volume_info)
        call(self.context, "neph_volume_get_info", self._handle, ctypes.byref(info))
        return read_struct(info)

    @documented("neph_volume_sample")
    def sample(self, positions: Any) -> numpy.ndarray:
        """Trilinear samples at world positions in metres: an array of n × 3, or one position."""
        numpy = import_numpy("Volume.sample")
        places = numpy.ascontiguousarray(positions, numpy.float64)
        if places.ndim < 1 or places.shape[-1] != 3:
            raise ValueError("positions are of the shape %s, must end in an axis of 3" % (places.shape,))
        values = numpy.zeros(places.shape[:-1], numpy.float32)
        self.context.check_process()
        lib.neph_volume_sample(self._handle, values.size,
                               ctypes.cast(places.ctypes.data, ctypes.POINTER(ctypes.c_double)),
                               ctypes.cast(values.ctypes.data, ctypes.POINTER(ctypes.c_float)))
        return values

    def __repr__(self):
        info = self.info
        return "<nephos.Volume %s: %d voxels>" % (info["name"], info["active_voxel_count"])
