# SPDX-License-Identifier: Apache-2.0
"""Renders, bakes and skies of scenes."""
from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any, Callable, Optional

from . import _declarations as c
from ._context import Object, Watch, create, get_context
from ._image import Image, import_numpy
from ._library import lib, make_struct
from ._scene import Scene
from ._settings import Path, apply_settings, documented, encode_text, read_struct

if TYPE_CHECKING:
    import numpy as np
    from ._context import Context, Progress


def check_scene(scene):
    if not isinstance(scene, Scene):
        raise TypeError("%r is no nephos.Scene: nephos.load reads one from a file" % (scene,))
    return scene


class Tile:
    """A finished part of a picture: `min` and `max` are its first pixel and one past its last, `tile["R"]` is a copy of
    its values. Valid only during the callback."""

    __slots__ = ("min", "max", "pass_index", "is_final", "_image")

    def __init__(self, struct):
        self.min, self.max = tuple(struct.min), tuple(struct.max)
        self.pass_index, self.is_final = struct.pass_index, struct.is_final
        self._image = struct.image

    def __getitem__(self, name: str) -> np.ndarray:
        numpy = import_numpy("tile[%r]" % (name,))
        if not self._image:
            raise ValueError("a tile is valid only during its callback: copy its values there")
        values = lib.neph_image_get_values(self._image, encode_text("name", name))
        if not values:
            raise KeyError("the tile has no channel %r" % (name,))
        shape = lib.neph_image_get_height(self._image), lib.neph_image_get_width(self._image)
        plane = numpy.ctypeslib.as_array(values, shape)
        return plane[self.min[1]:self.max[1], self.min[0]:self.max[0]].copy()


class _RenderWatch(Watch):
    """Callbacks of a render: progress and tiles."""

    def __init__(self, progress, tile):
        super().__init__(progress)
        if tile is not None and not callable(tile):
            raise TypeError("tile is %r, must be a function of one argument" % (tile,))
        self.tile = tile
        self.tile_function = c.neph_tile_fn(self._deliver)

    def attach(self, desc):
        if self.tile is not None:
            desc.tile = self.tile_function
        return super().attach(desc)

    def _deliver(self, _, tile):
        part = Tile(tile.contents)
        answer = self.ask(self.tile, part)
        part._image = None
        return answer


def _render(call_with, context, scene, progress, tile, settings, caller):
    watch = _RenderWatch(progress, tile)
    desc = watch.attach(check_scene(scene).get_render_desc(settings, caller))
    with scene._use:
        return Image(create(context, c.neph_image, *call_with, ctypes.byref(desc), watch=watch), context)


@documented("neph_render_image", settings="neph_render_desc")
def render(scene: Scene, *, progress: Optional[Callable[[Progress], Any]] = None,
           tile: Optional[Callable[[Tile], Any]] = None, **settings: Any) -> Image:
    """Renders one picture of a scene. Settings replace the scene's own: `samples=4`, `resolution=(96, 54)`, `frame=7`.

    progress: a function that receives a Progress several times a second; False from it ends the render.
    tile: a function that receives each finished Tile; False from it ends the render.
    """
    check_scene(scene)
    call_with = "neph_render_image", scene._handle
    return _render(call_with, scene.context, scene, progress, tile, settings, "render()")


class Renderer(Object):
    """Renders one picture after another and keeps caches that they share. One picture at a time; `cancel` may come from
    any thread."""

    __slots__ = ()

    @documented("neph_renderer_create")
    def __init__(self, context: Optional[Context] = None) -> None:
        context = get_context(context)
        super().__init__(create(context, c.neph_renderer, "neph_renderer_create", context._handle), context)

    @documented("neph_renderer_render", settings="neph_render_desc")
    def render(self, scene: Scene, *, progress: Optional[Callable[[Progress], Any]] = None,
               tile: Optional[Callable[[Tile], Any]] = None, **settings: Any) -> Image:
        """Renders one picture, as nephos.render does, and reuses the caches of earlier pictures."""
        check_scene(scene)
        call_with = "neph_renderer_render", self._handle, scene._handle
        return _render(call_with, self.context, scene, progress, tile, settings, "Renderer.render()")

    @documented("neph_renderer_cancel")
    def cancel(self) -> None:
        """Cancels the current picture."""
        self.context.check_process()
        lib.neph_renderer_cancel(self._handle)


@documented("neph_render_sky", settings="neph_sky_image_desc")
def sky(scene: Scene, *, progress: Optional[Callable[[Progress], Any]] = None, **settings: Any) -> Image:
    """The sky of a scene from its camera as a latitude-longitude picture."""
    watch = Watch(progress)
    desc = apply_settings(watch.attach(make_struct(c.neph_sky_image_desc)), settings, "sky()")
    with check_scene(scene)._use:
        return Image(create(scene.context, c.neph_image, "neph_render_sky", scene._handle, ctypes.byref(desc),
                            watch=watch), scene.context)


def _check_ending(path: Path) -> None:
    """Refuses a name that is no file of a volume, as the program does."""
    if not encode_text("path", path).lower().endswith((b".vdb", b".nvdb")):
        raise ValueError("path is %r, must end in .vdb or .nvdb" % (path,))


@documented("neph_scene_bake_file", settings="neph_bake_desc")
def bake(scene: Scene, path: Path, *, cloud: int | str = 0, frame: int = 1,
         progress: Optional[Callable[[Progress], Any]] = None, **settings: Any) -> None:
    """Bakes a procedural cloud of a scene, by its name or index, to a .vdb or .nvdb file. `Volume.bake` bakes one in
    memory."""
    _check_ending(path)
    watch = Watch(progress)
    desc = apply_settings(watch.attach(make_struct(c.neph_bake_desc)), settings, "bake()")
    with check_scene(scene)._use:
        watch.call(scene.context, "neph_scene_bake_file", scene._handle, scene.get_cloud(cloud), int(frame),
                   ctypes.byref(desc), encode_text("path", path))


@documented("neph_scene_export_cloud", settings="neph_export_desc")
def export(scene: Scene, path: Path, *, cloud: int | str = 0, frame: int = 1,
           progress: Optional[Callable[[Progress], Any]] = None, **settings: Any) -> dict[str, Any]:
    """Writes a cloud of a scene to a .vdb or .nvdb file in its place in the world, and returns what was written."""
    _check_ending(path)
    watch = Watch(progress)
    desc = apply_settings(watch.attach(make_struct(c.neph_export_desc)), settings, "export()")
    written, name = make_struct(c.neph_exported_cloud), encode_text("path", path)
    with check_scene(scene)._use:
        watch.call(scene.context, "neph_scene_export_cloud", scene._handle, scene.get_cloud(cloud), int(frame),
                   ctypes.byref(desc), name, ctypes.byref(written))
        return read_struct(written)
