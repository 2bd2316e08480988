# SPDX-License-Identifier: Apache-2.0
"""The shared library: where it is searched, and its functions with the types of the headers."""
import ctypes
import os
import sysconfig

from . import _declarations as c

_soname = "libnephos.so.%d.%d" % (c.NEPHOS_VERSION_MAJOR, c.NEPHOS_VERSION_MINOR)


def _list_places():
    """Paths of the library in the order of the search; a name without a folder goes to the system's loader."""
    if os.environ.get("NEPHOS_LIBRARY"):
        return [os.environ["NEPHOS_LIBRARY"]]
    package = os.path.dirname(os.path.abspath(__file__))
    library = os.path.dirname(os.path.dirname(os.path.dirname(package)))  # PREFIX/lib of PREFIX/lib/python3/…/nephos
    folders = [package, os.path.join(library, sysconfig.get_config_var("MULTIARCH") or ""), library]
    places = [os.path.join(folder, _soname) for folder in folders]
    return [place for place in places if os.path.exists(place)] + [_soname]


def _load():
    failures = []
    for place in _list_places():
        try:
            return ctypes.CDLL(place)
        except OSError as failure:
            failures.append(str(failure))
    raise ImportError(
        "%s: install libnephos, or set NEPHOS_LIBRARY to the path of %s" % ("; ".join(failures), _soname))


def _check_version(library):
    number = library.neph_version_get_number()
    if number // 1000 != c.NEPHOS_VERSION_NUMBER // 1000 or number < c.NEPHOS_VERSION_NUMBER:
        raise ImportError("libnephos is version %s, this package needs %d.%d.%d or a later one of %d.%d" % (
            library.neph_version_get_text().decode(), c.NEPHOS_VERSION_MAJOR, c.NEPHOS_VERSION_MINOR,
            c.NEPHOS_VERSION_PATCH, c.NEPHOS_VERSION_MAJOR, c.NEPHOS_VERSION_MINOR))


def _open():
    library = _load()
    for name, (result, arguments) in c.FUNCTIONS.items():
        try:
            function = getattr(library, name)
        except AttributeError:
            raise ImportError("%s has no function %s: it is older than this package" % (library._name, name)) from None
        function.restype, function.argtypes = result, arguments
    _check_version(library)
    return library


lib = _open()


def make_struct(kind):
    """A struct of the library with its default initializer."""
    struct = kind()
    _fill(struct, kind.default)
    return struct


def _fill(struct, values):
    types = dict(struct._fields_)
    for name, value in values.items():
        if isinstance(value, list) and issubclass(types[name], ctypes.Structure):
            value = dict(zip(dict(types[name]._fields_), value))
        if isinstance(value, dict):
            _fill(getattr(struct, name), value)
        elif isinstance(value, list):
            _fill_array(getattr(struct, name), value)
        elif isinstance(value, str):  # a table of the library
            table = c.TABLES[value[1:]].in_dll(lib, value[1:])
            setattr(struct, name, ctypes.cast(table, types[name]))
        elif value is not None:
            setattr(struct, name, value)


def _fill_array(array, values):
    for i, value in enumerate(values):
        if isinstance(value, list):
            _fill_array(array[i], value)
        else:
            array[i] = value
