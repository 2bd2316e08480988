# SPDX-License-Identifier: Apache-2.0
"""Images: channels as views of the library's own memory."""
from __future__ import annotations

import ctypes
import math
import os
import tempfile
from typing import TYPE_CHECKING, Any, Iterable, Iterator, Mapping, Optional

from . import _declarations as c
from ._context import Object, call, create, get_context
from ._library import lib, make_struct
from ._settings import Path, apply_settings, documented, encode_text, read_struct

if TYPE_CHECKING:
    import numpy
    from ._context import Context


def import_numpy(purpose):
    """Imports numpy on the first use of an array."""
    try:
        import numpy
    except ImportError:
        raise ImportError("%s needs numpy (python3-numpy)" % purpose) from None
    return numpy


def _restore(data):
    """The image of pickled bytes."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "image.exr")
        with open(path, "wb") as file:
            file.write(data)
        return Image.load(path)


class Image(Object):
    """A picture: channels of float32, rows from the top.

    `image["R"]` is a numpy array of height × width that shares the image's memory; `image.buffer("R")` is the same as a
    memoryview, without numpy. Both keep the memory for as long as they live, longer than the image if need be.
    """

    __slots__ = ()

    def __init__(self, handle=None, context=None):
        if not isinstance(handle, c.neph_image):
            raise TypeError("images come from renders, Image.load and Image.from_arrays")
        super().__init__(handle, context)

    @classmethod
    @documented("neph_image_load_exr", "neph_image_load_png")
    def load(cls, path: Path, context: Optional[Context] = None) -> Image:
        """Reads an .exr or a .png."""
        context, name = get_context(context), encode_text("path", path)
        function = "neph_image_load_png" if name.lower().endswith(b".png") else "neph_image_load_exr"
        return cls(create(context, c.neph_image, function, context._handle, name), context)

    @classmethod
    @documented("neph_image_create")
    def from_arrays(cls, channels: Mapping[str, Any], context: Optional[Context] = None) -> Image:
        """An image of arrays of one size, by the names of their channels; values are copied."""
        numpy, context = import_numpy("Image.from_arrays"), get_context(context)
        arrays = {name: numpy.asarray(array) for name, array in dict(channels).items()}
        shapes = {array.shape for array in arrays.values()}
        if len(shapes) != 1 or len(next(iter(shapes))) != 2:
            raise ValueError("channels must be arrays of one shape (height, width), are of %s" % sorted(shapes))
        height, width = shapes.pop()
        names = (ctypes.c_char_p * len(arrays))(*(encode_text("channel", name) for name in arrays))
        if max(height, width) > 65536:
            raise ValueError("an image of %d × %d pixels: must be 1 to 65536 a side" % (width, height))
        image = cls(create(context, c.neph_image, "neph_image_create", context._handle, width, height, len(names),
                           names), context)
        for name, array in arrays.items():
            if not numpy.can_cast(array.dtype, numpy.float32, "same_kind"):
                raise TypeError("channel %r is of %s, must be of real numbers" % (name, array.dtype))
            image[name][...] = array
        return image

    @property
    def width(self) -> int:
        return lib.neph_image_get_width(self._handle)

    @property
    def height(self) -> int:
        return lib.neph_image_get_height(self._handle)

    @property
    def channels(self) -> list[str]:
        """Names of the channels."""
        count = lib.neph_image_get_channel_count(self._handle)
        return [lib.neph_image_get_channel_name(self._handle, i).decode() for i in range(count)]

    def __contains__(self, name: object) -> bool:
        return name in self.channels

    def __iter__(self) -> Iterator[str]:
        return iter(self.channels)

    def __len__(self) -> int:
        return lib.neph_image_get_channel_count(self._handle)

    def __repr__(self):
        return "<nephos.Image %d × %d: %s>" % (self.width, self.height, " ".join(self.channels))

    @documented("neph_image_get_channel")
    def buffer(self, name: str) -> memoryview:
        """One channel as a memoryview of floats of the shape (height, width), without a copy."""
        if not isinstance(name, str):
            raise TypeError("%r is no name of a channel: %s" % (name, ", ".join(self.channels)))
        values = lib.neph_image_get_channel(self._handle, name.encode())
        if not values:
            raise KeyError("the image has no channel %r: %s" % (name, ", ".join(self.channels)))
        plane = (ctypes.c_float * (self.width * self.height)).from_address(ctypes.addressof(values.contents))
        plane.owner = self._owner  # the memory lives as long as the view
        return memoryview(plane).cast("B").cast("f", (self.height, self.width))

    def __getitem__(self, name: str | list[str] | tuple[str, ...]) -> numpy.ndarray:
        """One channel as a numpy array (height, width) of float32 without a copy; a list of names as a copy
        (height, width, channels)."""
        numpy = import_numpy("image[%r]" % (name,))
        if isinstance(name, (list, tuple)):
            if not name:
                raise ValueError("the list of channels is empty: %s" % ", ".join(self.channels))
            return numpy.stack([self[part] for part in name], axis=-1)
        return numpy.asarray(self.buffer(name))

    @documented("neph_image_get_attribute")
    def attribute(self, name: str, default: Optional[str] = None) -> Optional[str]:
        """A text attribute of the header, such as "nephos:sceneHash"."""
        value = lib.neph_image_get_attribute(self._handle, encode_text("name", name))
        return default if value is None else value.decode("utf-8", "replace")

    @documented("neph_image_set_attribute")
    def set_attribute(self, name: str, value: str) -> None:
        """Sets or replaces a text attribute of the header."""
        call(self.context, "neph_image_set_attribute", self._handle, encode_text("name", name),
             encode_text("value", value))

    @property
    def error(self) -> Optional[dict[str, Any]]:
        """Error that the header states, as docs/error.md defines it: error, noise and bias, each with its bounds; None
        where it is unknown."""
        figures = make_struct(c.neph_image_error)
        call(self.context, "neph_image_get_error", self._handle, ctypes.byref(figures))
        values = read_struct(figures)
        return values if math.isfinite(values["error"]["value"]) else None

    @property
    def has_deep(self) -> bool:
        """Whether the image has deep pixels."""
        return lib.neph_image_has_deep(self._handle)

    @documented("neph_image_save_exr", "neph_image_save_png", "neph_image_save_deep_exr", settings="neph_preview_desc")
    def save(self, path: Path, *, deep: bool = False, **settings: Any) -> None:
        """Writes an .exr, of halves unless `pixel_type="float"`, or, by its ending, a .png, with the settings of a
        preview. `deep=True` writes the deep pixels."""
        name = encode_text("path", path)
        desc = apply_settings(make_struct(c.neph_preview_desc), settings, "Image.save()")
        if name.lower().endswith(b".png"):
            return call(self.context, "neph_image_save_png", self._handle, name, ctypes.byref(desc))
        if not name.lower().endswith(b".exr"):
            raise ValueError("path is %r, must end in .exr or .png" % (path,))
        others = set(settings) - {"pixel_type"}
        if others:
            raise TypeError("an .exr has no setting %r, a .png has" % sorted(others)[0])
        function = "neph_image_save_deep_exr" if deep else "neph_image_save_exr"
        kind = desc.pixel_type if settings.get("pixel_type") is not None else c.NEPH_PIXEL_HALF
        call(self.context, function, self._handle, name, kind)

    @documented("neph_image_compute_exposure", settings="neph_preview_desc")
    def exposure(self, **settings: Any) -> float:
        """Brightening of a preview in stops, white balance apart."""
        desc = apply_settings(make_struct(c.neph_preview_desc), settings, "Image.exposure()")
        stops = ctypes.c_double()
        call(self.context, "neph_image_compute_exposure", self._handle, ctypes.byref(desc), ctypes.byref(stops))
        return stops.value

    @documented("neph_image_develop", settings="neph_preview_desc")
    def develop(self, **settings: Any) -> memoryview:
        """Pixels of a preview as a memoryview of bytes of the shape (height, width, 4): R, G, B, and 255.
        `numpy.asarray` makes an array of it without a copy."""
        desc = apply_settings(make_struct(c.neph_preview_desc), settings, "Image.develop()")
        width, height = self.width, self.height
        pixels = (ctypes.c_uint8 * (4 * width * height))()
        call(self.context, "neph_image_develop", self._handle, ctypes.byref(desc), 0, 0, width, height, pixels,
             4 * width)
        return memoryview(pixels).cast("B").cast("B", (height, width, 4))

    def __reduce__(self):
        """Pickles and copies the image as an OpenEXR of floats: every channel, and the attributes of its header."""
        if self.has_deep:
            raise TypeError("an image with deep pixels cannot be pickled: save it with deep=True")
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "image.exr")
            self.save(path, pixel_type="float")
            with open(path, "rb") as file:
                return _restore, (file.read(),)


@documented("neph_image_compare", "neph_image_compare_seeds")
def compare(image: Image, reference: Image, second: Optional[Image] = None) -> dict[str, Any]:
    """Difference of an image from a reference, as a dict of figures. `second` is a picture with another seed."""
    for picture in (image, reference) + ((second,) if second is not None else ()):
        if not isinstance(picture, Image):
            raise TypeError("%r is no nephos.Image" % (picture,))
    figures = make_struct(c.neph_image_difference)
    context = image.context
    if second is None:
        call(context, "neph_image_compare", context._handle, image._handle, reference._handle, ctypes.byref(figures))
    else:
        call(context, "neph_image_compare_seeds", context._handle, image._handle, second._handle, reference._handle,
             ctypes.byref(figures))
    return read_struct(figures)


@documented("neph_parts_merge")
def merge(paths: Iterable[Path], context: Optional[Context] = None) -> Image:
    """Joins parts of one picture, tiles and ranges of samples, to the bits of the whole."""
    if isinstance(paths, (str, bytes, os.PathLike)):
        raise TypeError("paths is %r, must be a list of paths" % (paths,))
    context = get_context(context)
    names = [encode_text("paths", path) for path in paths]
    array = (ctypes.c_char_p * (len(names) + 1))(*names, None)
    return Image(create(context, c.neph_image, "neph_parts_merge", context._handle, array, len(names), None), context)
