# SPDX-License-Identifier: Apache-2.0
"""What `pip install src/python` builds: a wheel of the package and of declarations made from the headers beside it. It
needs no other package and no compiler. libnephos itself is not in it: NEPHOS_LIBRARY, or the system, has it."""
import base64
import hashlib
import os
import re
import tempfile
import zipfile

import generate

_here = os.path.dirname(os.path.abspath(__file__))
_include = os.path.join(_here, os.pardir, os.pardir, "include")
_metadata = """Metadata-Version: 2.1
Name: nephos
Version: %s
Summary: Volumetric clouds under a physical sky
License: Apache-2.0
Requires-Python: >=3.9
Provides-Extra: numpy
Requires-Dist: numpy; extra == "numpy"
"""
_wheel = "Wheel-Version: 1.0\nGenerator: nephos\nRoot-Is-Purelib: true\nTag: py3-none-any\n"


def _read_version():
    with open(os.path.join(_include, "nephos", "base.h"), encoding="utf-8") as file:
        return ".".join(re.findall(r"#define NEPHOS_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)", file.read()))


def _list_files():
    """Names in the wheel with their contents."""
    folder = os.path.join(_here, "nephos")
    for name in sorted(os.listdir(folder)):
        if name.endswith(".py") or name == "py.typed":
            with open(os.path.join(folder, name), "rb") as file:
                yield "nephos/" + name, file.read()
    with tempfile.TemporaryDirectory() as temporary:
        path = os.path.join(temporary, "_declarations.py")
        generate.Headers(_include).write(path)
        with open(path, "rb") as file:
            yield "nephos/_declarations.py", file.read()


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    version = _read_version()
    info = "nephos-%s.dist-info/" % version
    files = list(_list_files())
    files += [(info + "METADATA", (_metadata % version).encode()), (info + "WHEEL", _wheel.encode())]
    record = ""
    name = "nephos-%s-py3-none-any.whl" % version
    with zipfile.ZipFile(os.path.join(wheel_directory, name), "w", zipfile.ZIP_DEFLATED) as archive:
        for path, data in files:
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            record += "%s,sha256=%s,%d\n" % (path, digest, len(data))
            archive.writestr(path, data)
        archive.writestr(info + "RECORD", record + info + "RECORD,,\n")
    return name
