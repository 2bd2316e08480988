# SPDX-License-Identifier: Apache-2.0
"""Generated declarations against the compiler: sizes, places of members, default initializers, constants, functions."""
import ctypes
import inspect
import os
import shutil
import subprocess

import pytest

import nephos
from nephos import c
from nephos._library import make_struct

INCLUDE = os.environ["NEPHOS_INCLUDE"]


def list_structs():
    return [kind for _, kind in inspect.getmembers(c, inspect.isclass)
            if issubclass(kind, ctypes.Structure) and kind.__name__.startswith("neph_")]


def list_constants():
    return sorted(name for name, value in vars(c).items()
                  if name.startswith("NEPH") and isinstance(value, int) and not isinstance(value, bool))


def write_program():
    """A C program that prints what the test compares, line by line."""
    lines = ["#include <nephos/nephos.h>", "#include <stdio.h>", "int main(void) {"]
    for kind in list_structs():
        name = kind.__name__
        lines.append('printf("%s %%zu\\n", sizeof(%s));' % (name, name))
        for field, _ in kind._fields_:
            lines.append('printf("%s.%s %%zu %%zu\\n", offsetof(%s, %s), sizeof(((%s *)0)->%s));'
                         % (name, field, name, field, name, field))
        if kind.default:
            lines += ["{ static const %s value = %s;" % (name, name.upper() + "_DEFAULT"),
                      'printf("default %s ");' % name,
                      "for (size_t i = 0; i < sizeof value; i++) printf(\"%02x\", ((const unsigned char *)&value)[i]);",
                      'printf("\\n"); }']
    lines += ['printf("%s %%lld\\n", (long long)(%s));' % (name, name) for name in list_constants()]
    return "\n".join(lines + ["return 0; }"])


def describe():
    lines = []
    for kind in list_structs():
        name = kind.__name__
        lines.append("%s %d" % (name, ctypes.sizeof(kind)))
        for field, _ in kind._fields_:
            place = getattr(kind, field)
            lines.append("%s.%s %d %d" % (name, field, place.offset, place.size))
        if kind.default:
            lines.append("default %s %s" % (name, bytes(make_struct(kind)).hex()))
    for name in list_constants():
        value = getattr(c, name)
        lines.append("%s %d" % (name, value - (1 << 64) if value >= 1 << 63 else value))
    return lines


def is_address(line):
    """A default that holds addresses, which differ from program to program."""
    name = line.split()[1] if line.startswith("default ") else ""
    return name in ("neph_atmosphere_desc", "neph_volume_dense_desc", "neph_volume_sparse_desc", "neph_report_desc")


@pytest.mark.skipif(not shutil.which("cc"), reason="no C compiler")
def test_structs_and_constants_are_those_of_the_compiler(tmp_path):
    (tmp_path / "layout.c").write_text(write_program())
    library = nephos.lib._name
    subprocess.run(["cc", "-std=c11", "-I", INCLUDE, "layout.c", library, "-Wl,-rpath," + os.path.dirname(library), "-o", "layout"], cwd=tmp_path, check=True)
    printed = subprocess.run([tmp_path / "layout"], stdout=subprocess.PIPE, text=True, check=True).stdout.splitlines()
    expected = describe()
    assert len(list_structs()) > 40 and len(list_constants()) > 150
    assert [line for line in printed if not is_address(line)] == [line for line in expected if not is_address(line)]


def test_every_exported_function_is_declared():
    marked = 0
    for name in os.listdir(os.path.join(INCLUDE, "nephos")):
        with open(os.path.join(INCLUDE, "nephos", name), encoding="utf-8") as file:
            marked += sum(line.startswith("NEPH_API ") for line in file)
    assert len(c.FUNCTIONS) + len(c.TABLES) == marked
    assert all(hasattr(nephos.lib, name) for name in c.FUNCTIONS)


def test_docstrings_are_those_of_the_headers():
    assert "to the bits of the whole" in nephos.merge.__doc__
    assert "sample_count: samples a pixel, 1 to 2²⁴" in nephos.render.__doc__
    assert "Trilinear samples" in nephos.Volume.sample.__doc__
    assert all(getattr(nephos, name).__doc__ for name in nephos.__all__)
