# SPDX-License-Identifier: Apache-2.0
"""Volumetric clouds under a physical sky: the library nephos from Python.

    import nephos
    scene = nephos.load("scene.yaml")
    scene["sun.elevation"] = "20 deg"
    image = nephos.render(scene, samples=4)
    image["R"]                 # numpy array of float32, without a copy
    image.save("scene.exr")

Messages of the library go to the logger "nephos"; its errors are exceptions, of nephos.Error. `nephos.c` and
`nephos.lib` are the structs and functions of the C headers.
"""
from . import _declarations as c
from ._context import Context, Progress
from ._errors import (ArgumentError, Cancelled, Error, FileError, InputOutputError, InternalError, LimitError,
                      NotFoundError, OutOfMemoryError, SceneError, UnsupportedError)
from ._image import Image, compare, merge
from ._library import lib
from ._render import Renderer, Tile, bake, export, render, sky
from ._scene import Scene, load, schema
from ._tools import Finding, Report, check, mend, probe, report
from ._volume import Volume

__version__ = lib.neph_version_get_text().decode()

__all__ = [
    "ArgumentError", "Cancelled", "Context", "Error", "FileError", "Finding", "Image", "InputOutputError",
    "InternalError", "LimitError", "NotFoundError", "OutOfMemoryError", "Progress", "Renderer", "Report", "Scene",
    "SceneError", "Tile", "UnsupportedError", "Volume", "bake", "check", "compare", "export", "load", "mend", "merge",
    "probe", "render", "report", "schema", "sky",
]
