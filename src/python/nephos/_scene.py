# SPDX-License-Identifier: Apache-2.0
"""Scenes: read from YAML, changed key by key."""
from __future__ import annotations

import ctypes
import json
import threading
from typing import TYPE_CHECKING, Any, Iterator, Mapping, Optional

from . import _declarations as c
from ._context import Object, Watch, call, create, get_context, take_text
from ._errors import Error
from ._library import lib, make_struct
from ._settings import Path, apply_settings, documented, encode_text, read_struct, write_yaml
from ._volume import Volume

if TYPE_CHECKING:
    from ._context import Context


class _Use:
    """Calls that read a scene may run at the same time; one that changes it must be alone."""

    __slots__ = ("lock", "readers")

    def __init__(self):
        self.lock = threading.RLock()
        self.readers = 0

    def __enter__(self):
        with self.lock:
            self.readers += 1

    def __exit__(self, *_):
        with self.lock:
            self.readers -= 1

    def change(self, function, *arguments):
        with self.lock:
            if self.readers:
                raise Error("the scene is in use by a render or another call, and cannot be changed until that ends")
            return function(*arguments)


class Scene(Object):
    """Camera, light, air, clouds and ground, and how to render them. `scene[key]` is the value of a key of
    docs/scene-format.md as YAML, `scene[key] = value` sets it: a text is YAML with its unit, such as "20 deg"; numbers,
    True, False, lists and dicts are written as YAML."""

    __slots__ = ("_use",)

    @documented("neph_scene_create", "neph_scene_load_text")
    def __init__(self, text: Optional[str] = None, *, name: str = "scene", context: Optional[Context] = None) -> None:
        """A scene with every key at its default, or of a text of YAML."""
        context = get_context(context)
        if text is None:
            handle = create(context, c.neph_scene, "neph_scene_create", context._handle)
        else:
            handle = create(context, c.neph_scene, "neph_scene_load_text", context._handle, encode_text("text", text),
                            encode_text("name", name))
        self._adopt(handle, context)

    def _adopt(self, handle, context):
        super().__init__(handle, context)
        self._use = _Use()

    def _change(self, name, *arguments):
        self._use.change(call, self.context, name, self._handle, *arguments)

    # ---- Keys ----

    @documented("neph_scene_set")
    def __setitem__(self, key: str, value: Any) -> None:
        """Sets a key as the scene file would."""
        name, data = encode_text("key", key), encode_text("value", write_yaml(value))
        self._change("neph_scene_set", name, data)

    @documented("neph_scene_unset")
    def __delitem__(self, key: str) -> None:
        """Takes a key away, so that it has its default, or an element of a list: `del scene["clouds[1]"]`."""
        self._change("neph_scene_unset", encode_text("key", key))

    @documented("neph_scene_insert")
    def insert(self, key: str, value: Any) -> None:
        """Inserts an element into a list: `scene.insert("clouds[0]", {"name": "fog", "bake": {}})`."""
        self._change("neph_scene_insert", encode_text("key", key), encode_text("value", write_yaml(value)))

    @documented("neph_scene_set_keys")
    def update(self, values: Mapping[str, Any]) -> None:
        """Sets keys in order, or takes away those whose value is None: all of them, or none where one is wrong or the
        scene that results could not be rendered."""
        items = [(encode_text("key", key), None if value is None else encode_text("value", write_yaml(value)))
                 for key, value in dict(values).items()]
        keys, texts = ((ctypes.c_char_p * (len(items) + 1))(*(item[i] for item in items), None) for i in (0, 1))
        self._change("neph_scene_set_keys", keys, texts, len(items))

    @documented("neph_scene_clone")
    def clone(self) -> Scene:
        """A copy, which may change while this scene renders."""
        with self._use:
            handle = create(self.context, c.neph_scene, "neph_scene_clone", self._handle)
        copy = Scene.__new__(Scene)
        copy._adopt(handle, self.context)
        return copy

    @documented("neph_scene_save")
    def save(self, path: Path) -> None:
        """Writes the text that the scene was read from, with its edits, comments kept."""
        with self._use:
            call(self.context, "neph_scene_save", self._handle, encode_text("path", path))

    @property
    def text(self) -> str:
        """The text that `save` writes."""
        with self._use:
            return take_text(self.context, "neph_scene_get_text", self._handle)

    @documented("neph_scene_describe_edits")
    def describe_edits(self, format: str = "plain") -> str:
        """Keys that differ from the text that the scene was read from, as options of the program, or as JSON."""
        with self._use:
            return take_text(self.context, "neph_scene_describe_edits", self._handle, _get_format(format))

    def __getitem__(self, key: str) -> str:
        """Value of a key as YAML, in the form that setting it takes."""
        try:
            return self.values[key]
        except KeyError:
            raise KeyError("%r is no key of the scene that has one value: scene.values lists them" % (key,)) from None

    def __contains__(self, key: object) -> bool:
        return key in self.values

    def __iter__(self) -> Iterator[str]:
        return iter(self.values)

    def __repr__(self):
        return "<nephos.Scene of %d clouds>" % lib.neph_scene_get_cloud_count(self._handle)

    @property
    def values(self) -> dict[str, str]:
        """Every key of the scene with its value, defaults and presets resolved, as a dict of texts."""
        return json.loads(self.describe("json"))["values"]

    @documented("neph_scene_describe")
    def describe(self, format: str = "plain") -> str:
        """Every key with its value as text."""
        with self._use:
            return take_text(self.context, "neph_scene_describe", self._handle, _get_format(format))

    @documented("neph_scene_check", "neph_scene_check_files")
    def check(self) -> None:
        """Checks keys together, and that every file which the scene reads can be opened; `nephos.check(scene)` looks
        into them as well."""
        with self._use:
            call(self.context, "neph_scene_check", self._handle)
            call(self.context, "neph_scene_check_files", self._handle)

    @documented("neph_scene_set_frame")
    def set_frame(self, frame: int) -> None:
        """Sets the frame in which the scene is described and checked."""
        self._change("neph_scene_set_frame", int(frame))

    @property
    def is_animated(self) -> bool:
        """Whether any key changes from frame to frame."""
        return lib.neph_scene_is_animated(self._handle)

    # ---- Clouds ----

    @property
    def clouds(self) -> list[str]:
        """Names of the clouds."""
        count = lib.neph_scene_get_cloud_count(self._handle)
        return [lib.neph_scene_get_cloud_name(self._handle, i).decode("utf-8", "replace") for i in range(count)]

    @documented("neph_scene_add_volume", settings="neph_placement_desc")
    def add(self, volume: Volume, **settings: Any) -> int:
        """Adds a volume as a cloud, and returns its index. Values are extinction in 1/m unless `density_unit` and
        `density_value` say otherwise."""
        if not isinstance(volume, Volume):
            raise TypeError("%r is no nephos.Volume" % (volume,))
        desc = apply_settings(make_struct(c.neph_placement_desc), settings, "Scene.add()")
        index = ctypes.c_uint()
        self._change("neph_scene_add_volume", volume._handle, ctypes.byref(desc), ctypes.byref(index))
        return index.value

    def get_cloud(self, cloud: int | str) -> int:
        """Index of a cloud by its name or index."""
        names = self.clouds
        if isinstance(cloud, str) and cloud in names:
            return names.index(cloud)
        if isinstance(cloud, int) and not isinstance(cloud, bool) and 0 <= cloud < len(names):
            return cloud
        raise ValueError("cloud is %r, must be the index or name of one: %s" % (cloud, ", ".join(names) or "none"))

    # ---- Effort ----

    @documented("neph_scene_choose_effort", settings="neph_effort")
    def choose_effort(self, **settings: Any) -> dict[str, Any]:
        """Chooses settings for `target_error` or `time_limit`, as `nephos render` does, sets them in the scene, and
        returns them with predictions. Give the same target and limit to the render."""
        watch = Watch()
        desc = watch.attach(self.get_render_desc(settings, "Scene.choose_effort()"))
        effort = make_struct(c.neph_effort)
        self._use.change(watch.call, self.context, "neph_scene_choose_effort", self._handle, ctypes.byref(desc),
                         ctypes.byref(effort))
        return read_struct(effort)

    @documented("neph_render_explain", settings="neph_render_desc")
    def explain(self, format: str = "plain", **settings: Any) -> str:
        """The plan of a render: stages that it needs and leaves out, and why."""
        desc = self.get_render_desc(settings, "Scene.explain()")
        with self._use:
            return take_text(self.context, "neph_render_explain", self._handle, ctypes.byref(desc), _get_format(format))

    def get_render_desc(self, settings, caller):
        """The scene's own render settings, changed by keyword arguments."""
        settings = dict(settings)
        desc = make_struct(c.neph_render_desc)
        with self._use:
            call(self.context, "neph_scene_get_render_desc", self._handle, ctypes.byref(desc))
        is_whole = tuple(desc.crop_min) == (0, 0) and tuple(desc.crop_max) == (desc.width, desc.height)
        resolution = settings.pop("resolution", None)
        if resolution is not None:
            try:
                settings["width"], settings["height"] = resolution
            except (TypeError, ValueError):
                raise ValueError("resolution is %r, must be width and height" % (resolution,)) from None
        apply_settings(desc, settings, caller)
        if is_whole and "crop_max" not in settings:
            desc.crop_max[0], desc.crop_max[1] = desc.width, desc.height
        return desc


def _get_format(format):
    formats = c.ENUMS["neph_text_format"]
    if format not in formats:
        raise ValueError("format is %r, must be one of: %s" % (format, ", ".join(formats)))
    return formats[format]


@documented("neph_scene_load")
def load(path: Path, *, context: Optional[Context] = None) -> Scene:
    """Reads a scene file."""
    context, scene = get_context(context), Scene.__new__(Scene)
    scene._adopt(create(context, c.neph_scene, "neph_scene_load", context._handle, encode_text("path", path)), context)
    return scene


@documented("neph_schema_describe")
def schema(key: Optional[str] = None, *, context: Optional[Context] = None) -> list[dict[str, Any]]:
    """Keys of scenes below `key`, or all: a list of dicts with type, unit, range, default and meaning."""
    context = get_context(context)
    name = None if key is None else encode_text("key", key)
    text = take_text(context, "neph_schema_describe", context._handle, name, c.NEPH_TEXT_JSON)
    return json.loads(text)["keys"]
