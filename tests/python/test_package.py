# SPDX-License-Identifier: Apache-2.0
"""The package from outside: pip, the search for the library, type hints."""
import os
import subprocess
import sys

import pytest

import nephos

SOURCE = os.path.join(os.environ["NEPHOS_INCLUDE"], os.pardir, "src", "python")


def run(code, **environment):
    """Runs Python without the paths of this test."""
    rest = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "NEPHOS_LIBRARY")}
    return subprocess.run([sys.executable, "-c", code], env={**rest, **environment}, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True)


def test_pip_installs_the_folder(tmp_path):
    pytest.importorskip("pip")
    subprocess.run([sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-index", "--target", tmp_path,
                    "--disable-pip-version-check", SOURCE], check=True)
    done = run("import nephos, sys; print(nephos.__version__, nephos.__file__)", PYTHONPATH=str(tmp_path),
               NEPHOS_LIBRARY=nephos.lib._name)
    assert done.stdout.startswith(nephos.__version__ + " " + str(tmp_path)), done.stdout
    assert (tmp_path / "nephos" / "py.typed").exists()
    os.symlink(nephos.lib._name, tmp_path / "nephos" / "libnephos.so.0.1")  # beside the package
    done = run("import nephos; print(nephos.lib._name)", PYTHONPATH=str(tmp_path))
    assert done.stdout.startswith(str(tmp_path)), done.stdout


def test_a_missing_or_foreign_library_is_an_import_error(tmp_path):
    package = os.path.dirname(os.path.dirname(nephos.__file__))
    (tmp_path / "text.so").write_text("no library")
    for path in tmp_path / "absent.so", tmp_path / "text.so":
        done = run("import nephos", PYTHONPATH=package, NEPHOS_LIBRARY=str(path))
        assert "ImportError" in done.stdout and str(path) in done.stdout and "NEPHOS_LIBRARY" in done.stdout
    done = run("import nephos", PYTHONPATH=package, NEPHOS_LIBRARY="libm.so.6")
    assert "ImportError" in done.stdout and "has no function neph_" in done.stdout


def test_public_functions_have_type_hints():
    methods = [getattr(kind, name) for kind in (nephos.Image, nephos.Scene, nephos.Volume, nephos.Renderer)
               for name in vars(kind) if not name.startswith("_")]
    functions = [getattr(nephos, name) for name in nephos.__all__ if not isinstance(getattr(nephos, name), type)]
    for function in methods + functions:
        function = getattr(function, "fget", None) or function
        if function.__name__ != "get_render_desc":
            assert "return" in function.__annotations__, function
