# SPDX-License-Identifier: Apache-2.0
"""Checks of files, probes and reports."""
from __future__ import annotations

import csv
import ctypes
import io
import json
import os
import tempfile
from typing import TYPE_CHECKING, Any, Callable, Iterable, Optional

from . import _declarations as c
from ._context import Context, Object, Watch, call, create, get_context, take_text
from ._errors import ArgumentError, Cancelled
from ._library import lib, make_struct
from ._scene import Scene, load
from ._settings import Path, apply_settings, documented, encode_text, read_struct

if TYPE_CHECKING:
    from ._context import Progress


class Finding:
    """One fault: `severity` ("note", "warning", "error"), `rule`, `file`, `grid`, `place`, `cause`, `remedy`,
    `frame_count`."""

    def __init__(self, struct):
        self.__dict__.update(read_struct(struct))

    def __repr__(self):
        return "<nephos.Finding %s %s: %s: %s>" % (self.severity, self.rule, self.file, self.cause)


@documented("neph_check_file", "neph_check_scene")
def check(subject: Path | Scene, *, frame: int = 1,
          progress: Optional[Callable[[Progress], Any]] = None) -> list[Finding]:
    """Checks a file, or a scene with all files that it names, and returns a list of findings; it is empty where all is
    well. While a scene is checked, no other call of its context may run."""
    is_scene = isinstance(subject, Scene)
    path = None if is_scene else encode_text("subject", subject)
    if path and not lib.neph_check_is_file(path):
        raise ArgumentError("%s is not of a kind that is checked, by its ending: docs/check.md lists them" % subject)
    context = subject.context if is_scene else Context()
    watch = Watch(progress)
    handle = create(context, c.neph_check, "neph_check_create", context._handle)
    try:
        lib.neph_check_set_progress(handle, watch.function, None)
        if is_scene:
            with subject._use:
                watch.call(context, "neph_check_scene", handle, subject._handle, int(frame))
        else:
            watch.call(context, "neph_check_file", handle, path)
        return [_get_finding(context, handle, i) for i in range(lib.neph_check_get_finding_count(handle))]
    finally:
        lib.neph_check_destroy(handle)


@documented("neph_check_mend_file")
def mend(path: Path, output: Path, *, context: Optional[Context] = None) -> str:
    """Writes a mended copy of a .vdb or .nvdb file, as `nephos check --fix` does, and returns what has changed in each
    grid."""
    context = get_context(context)
    return take_text(context, "neph_check_mend_file", context._handle, encode_text("path", path),
                     encode_text("output", output))


def _get_finding(context, handle, index):
    struct = make_struct(c.neph_finding)
    call(context, "neph_check_get_finding", handle, index, ctypes.byref(struct))
    return Finding(struct)


# ---- Probes ----

def _write_cases(cases, folder):
    """Path of a table of cases: a file as it is, or dicts written to one."""
    if isinstance(cases, (str, bytes, os.PathLike)):
        return encode_text("cases", cases)
    rows = list(cases)
    if not rows or not all(isinstance(row, dict) for row in rows):
        raise TypeError("cases must be a path, or a list of dicts, at least one")
    path = os.path.join(folder, "cases.csv")
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(dict.fromkeys(name for row in rows for name in row)))
        writer.writeheader()
        writer.writerows(rows)
    return os.fsencode(path)


def _read_cell(text):
    try:
        return float(text)
    except ValueError:
        return text


_probes = {"slab": (c.neph_probe_desc, "neph_probe_slab"), "sky": (c.neph_probe_sky_desc, "neph_probe_sky")}


@documented("neph_probe_slab", "neph_probe_sky", settings="neph_probe_desc")
def probe(cases: Path | Iterable[dict[str, Any]], kind: str = "slab", *,
          progress: Optional[Callable[[Progress], Any]] = None, context: Optional[Context] = None,
          **settings: Any) -> list[dict[str, Any]]:
    """Light of slabs of cloud ("slab") or of clear skies ("sky"), case by case. Cases are a .csv file or a list of dicts;
    the answer is a list of dicts."""
    if kind not in _probes:
        raise ValueError("kind is %r, must be one of: %s" % (kind, ", ".join(_probes)))
    context, watch = get_context(context), Watch(progress)
    desc = apply_settings(watch.attach(make_struct(_probes[kind][0])), settings, "probe()")
    with tempfile.TemporaryDirectory() as folder:
        text = take_text(context, _probes[kind][1], context._handle, _write_cases(cases, folder), ctypes.byref(desc),
                         watch=watch)
    return [{name: _read_cell(value) for name, value in row.items()} for row in csv.DictReader(io.StringIO(text))]


# ---- Reports ----

class Report(Object):
    """A sweep of settings of a scene, each measured against a reference. `rows` has the figures, `is_complete` says
    whether it was measured to its end."""

    __slots__ = ("is_complete",)

    @property
    def rows(self) -> list[dict[str, Any]]:
        """Settings and their measurements, as dicts."""
        return [self._get_row(i) for i in range(lib.neph_report_get_row_count(self._handle))]

    def _get_row(self, index):
        row = make_struct(c.neph_report_row)
        call(self.context, "neph_report_get_row", self._handle, index, ctypes.byref(row))
        return read_struct(row)

    @documented("neph_report_describe")
    def describe(self) -> dict[str, Any]:
        """All of the report but its pictures, as a dict."""
        return json.loads(take_text(self.context, "neph_report_describe", self._handle, c.NEPH_TEXT_JSON))

    @documented("neph_report_save")
    def save(self, folder: Path) -> None:
        """Writes the page and its data into a folder that exists."""
        call(self.context, "neph_report_save", self._handle, encode_text("folder", folder))


def _make_loader(subject, context, watch):
    """Function of the library that loads the scene of a report: from a path, or by a function that returns a Scene of
    the context that it is given."""
    def load_scene(_, out_scene):
        out_scene[0] = None
        result = [c.NEPH_ERROR_CANCELLED]

        def make():
            scene = subject(context) if callable(subject) else load(subject, context=context)
            if not isinstance(scene, Scene) or scene.context is not context:
                raise TypeError("the function of a report must return a new nephos.Scene of the given context")
            out_scene[0] = scene._handle
            scene._owner.handle = None  # the report destroys it
            result[0] = c.NEPH_OK
        watch.ask(make)
        return result[0]

    return c.neph_report_load_fn(load_scene)


@documented("neph_report_create", "neph_report_run", settings="neph_report_desc")
def report(subject: Path | Callable[[Context], Scene], *, progress: Optional[Callable[[Progress], Any]] = None,
           context: Optional[Context] = None, **settings: Any) -> Report:
    """Measures error against time over the settings of a scene: a path, or a function that makes the scene anew in the
    context that it is given. The scene is made once for each setting. A report that its progress callback has cancelled
    is returned with what was measured by then, `is_complete` being False."""
    if not callable(subject):
        encode_text("subject", subject)
    context, watch = get_context(context), Watch(progress)
    desc = apply_settings(watch.attach(make_struct(c.neph_report_desc)), settings, "report()")
    desc.load = loader = _make_loader(subject, context, watch)
    result = Report(create(context, c.neph_report, "neph_report_create", context._handle, ctypes.byref(desc),
                           watch=watch), context)
    try:
        watch.call(context, "neph_report_run", result._handle)
        result.is_complete = True
    except Cancelled:
        result.is_complete = False
    del loader
    return result
