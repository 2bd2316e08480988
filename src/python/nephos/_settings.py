# SPDX-License-Identifier: Apache-2.0
"""Keyword arguments as members of descriptions, docstrings from headers, and values as YAML."""
import ctypes
import difflib
import json
import math
import numbers
import operator
import os
import re
from typing import Union

from . import _declarations as c

Path = Union[str, bytes, os.PathLike]

_units = ("_m", "_s", "_m_s", "_per_m", "_bytes")
_hidden = {"struct_size", "progress", "progress_user", "tile", "tile_user", "log", "log_user", "reallocate",
           "reallocate_user", "is_interrupted", "interrupt_user", "load", "load_user", "error"}


# ---- Settings ----

def _list_names(kind):
    """Names of the members of a description that keyword arguments set, by their short names too."""
    fields = [name for name, _ in kind._fields_ if name not in _hidden]
    names = {name: name for name in fields}
    for name in fields:
        short = name[: -len("_count")] + "s" if name.endswith("_count") else name
        short = short[len("is_"):] if short.startswith("is_") else short
        for unit in _units:
            short = short[: -len(unit)] if short == name and name.endswith(unit) else short
        names.setdefault(short, name)
    return names


def _convert_number(name, kind, value):
    if kind is ctypes.c_bool:
        if not isinstance(value, (bool, numbers.Integral)) and type(value).__name__ not in ("bool_", "bool"):
            raise TypeError("%s is %r, must be True or False" % (name, value))
        return bool(value)
    if kind in (ctypes.c_double, ctypes.c_float):
        if isinstance(value, (str, bytes)) or not hasattr(value, "__float__"):
            raise TypeError("%s is %r, must be a number" % (name, value))
        return float(value)
    try:
        number = operator.index(value)
    except TypeError:
        raise TypeError("%s is %r, must be a whole number" % (name, value)) from None
    if kind(number).value != number:
        raise ValueError("%s is %d, which does not fit its %d bits" % (name, number, 8 * ctypes.sizeof(kind)))
    return number


def _convert_word(name, enum, value):
    words = c.ENUMS[enum]
    if isinstance(value, str) and value.replace("-", "_") in words:
        return words[value.replace("-", "_")]
    if isinstance(value, numbers.Integral) and int(value) in words.values():
        return int(value)
    raise ValueError("%s is %r, must be one of: %s" % (name, value, ", ".join(words)))


def encode_text(name, value):
    """A text or path as bytes."""
    try:
        data = os.fsencode(value)
    except TypeError:
        raise TypeError("%s is %r, must be a text or a path" % (name, value)) from None
    if b"\0" in data:
        raise ValueError("%s has a zero byte in it: %r" % (name, value))
    return data


def _set_array(struct, name, value):
    array = getattr(struct, name)
    try:
        values = list(value)
    except TypeError:
        raise TypeError("%s is %r, must be %d values" % (name, value, len(array))) from None
    if isinstance(value, (str, bytes)) or len(values) != len(array):
        raise ValueError("%s is %r, must be %d values" % (name, value, len(array)))
    for i, element in enumerate(values):
        if isinstance(array[i], ctypes.Array):
            _set_row(array[i], "%s[%d]" % (name, i), element)
        else:
            array[i] = _convert_number("%s[%d]" % (name, i), array._type_, element)


def _set_row(row, name, value):
    values = list(value)
    if len(values) != len(row):
        raise ValueError("%s is %r, must be %d values" % (name, value, len(row)))
    for i, element in enumerate(values):
        row[i] = _convert_number("%s[%d]" % (name, i), row._type_, element)


def _set_member(struct, name, kind, value):
    if name in struct.enums:
        setattr(struct, name, _convert_word(name, struct.enums[name], value))
    elif kind is ctypes.c_char_p:
        setattr(struct, name, encode_text(name, value))
    elif isinstance(kind, type) and issubclass(kind, ctypes.Array):
        _set_array(struct, name, value)
    elif isinstance(kind, type) and issubclass(kind, ctypes._SimpleCData) and kind is not ctypes.c_void_p:
        setattr(struct, name, _convert_number(name, kind, value))
    else:
        setattr(struct, name, value)


def _set_presence(struct, types, name, given):
    """Sets the member has_NAME of a member NAME_m that is given."""
    for unit in ("",) + _units + ("_rad",):
        presence = "has_" + (name[: -len(unit)] if unit and name.endswith(unit) else name)
        if presence in types and presence not in given and presence != name:
            setattr(struct, presence, True)
            return


def apply_settings(struct, settings, caller):
    """Sets members of a description by keyword arguments; None leaves a member at its default."""
    names, types = _list_names(type(struct)), dict(struct._fields_)
    for key, value in settings.items():
        if key not in names:
            close = difflib.get_close_matches(key, names, 1)
            raise TypeError("%s has no setting %r%s" % (caller, key, ", but %r" % close[0] if close else
                                                        ", but: " + ", ".join(sorted(set(names.values())))))
        if value is not None:
            _set_member(struct, names[key], types[names[key]], value)
            _set_presence(struct, types, names[key], settings)
    return struct


# ---- Structs of results ----

def read_struct(struct):
    """Members of a struct that the library has filled, as a dict; nested structs are dicts, arrays are lists."""
    values = {}
    for name, _ in struct._fields_:
        if name == "struct_size":
            continue
        value = getattr(struct, name)
        if name in struct.enums:
            value = next((word for word, number in c.ENUMS[struct.enums[name]].items() if number == value), value)
        values[name] = _read_value(value)
    return values


def _read_value(value):
    if isinstance(value, ctypes.Structure):
        return read_struct(value)
    if isinstance(value, ctypes.Array):
        return [_read_value(element) for element in value]
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else value


# ---- Docstrings ----

def documented(*functions, settings=None):
    """Adds the text of the headers about functions of the library, and about members of a description."""
    def add(method):
        parts = [(method.__doc__ or "").strip()]
        for function in functions:
            parts.append("%s (%s):\n\n%s" % (function, c.HEADERS[function], c.DOCS[function]))
        if settings:
            kind = getattr(c, settings)
            rows = ["  %s: %s" % (name, kind.docs[name]) for name in dict.fromkeys(_list_names(kind).values())]
            parts.append("Settings:\n\n" + "\n".join(rows))
        method.__doc__ = "\n\n".join(part for part in parts if part)
        return method
    return add


# ---- YAML ----

_plain = re.compile(r"[^,\[\]{}#&*!|>'\"%@`:?\\\n]*(:[^ ,\[\]{}\n]+)?")


def _write_text(text):
    return text if text == text.strip() and text and _plain.fullmatch(text) else json.dumps(text, ensure_ascii=False)


def write_yaml(value, is_nested=False):
    """A value of Python in YAML's flow style. A text is YAML already; within lists and dicts it is quoted where it must
    be."""
    if isinstance(value, os.PathLike):
        return json.dumps(os.fspath(value), ensure_ascii=False)
    if isinstance(value, str):
        return _write_text(value) if is_nested else value
    if value is None:
        return "none"
    if hasattr(value, "tolist"):  # of numpy
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, numbers.Integral):
        return str(int(value))
    if isinstance(value, numbers.Real):
        if not math.isfinite(value):
            raise ValueError("a key cannot be %r" % (value,))
        return repr(float(value))
    if isinstance(value, dict):
        return "{%s}" % ", ".join("%s: %s" % (_write_text(str(k)), write_yaml(v, True)) for k, v in value.items())
    if isinstance(value, (list, tuple)):
        return "[%s]" % ", ".join(write_yaml(element, True) for element in value)
    raise TypeError("%r cannot be the value of a key: texts, numbers, True, False, None, lists and dicts can" % (value,))
