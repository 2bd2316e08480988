# SPDX-License-Identifier: Apache-2.0
"""Checks, probes, reports, skies, effort: answers of the program."""
import csv
import io
import json
import time

import numpy
import pytest

import nephos


def test_check_has_the_findings_of_the_program(scene, scene_path, program, tmp_path):
    assert nephos.check(scene_path) == [] and nephos.check(scene) == []
    (tmp_path / "bad.exr").write_bytes(b"no picture")
    findings = nephos.check(tmp_path / "bad.exr")
    assert [finding.severity for finding in findings] == ["error"] and "bad.exr" in findings[0].file
    with pytest.raises(ValueError, match="a.txt"):
        nephos.check(tmp_path / "a.txt")


def test_probe_has_the_answers_of_the_program(program, tmp_path):
    cases = [{"quantity": "flux", "g": 0.85, "albedo": 1, "tau": tau, "mu0": 0.5} for tau in (1, 4)]
    rows = nephos.probe(cases, paths=4096)
    with open(tmp_path / "cases.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, list(cases[0]))
        writer.writeheader()
        writer.writerows(cases)
    printed = list(csv.DictReader(io.StringIO(program("probe", "slab", "cases.csv", "--paths", "4096", "-q"))))
    assert [row["R_out"] for row in rows] == [float(row["R_out"]) for row in printed]
    assert nephos.probe(tmp_path / "cases.csv", paths=4096) == rows
    sky = nephos.probe([{"quantity": "sky_radiance", "earth": "earth", "h_km": 0, "sun_zenith_deg": 30, "view_zenith_deg": 60,
                         "rel_azimuth_deg": 90}], "sky")
    assert sky[0]["b"] > sky[0]["r"] > 0
    for bad, error in (([], TypeError), ([7], TypeError), (tmp_path / "absent.csv", FileNotFoundError)):
        with pytest.raises(error):
            nephos.probe(bad)
    with pytest.raises(ValueError, match="slab, sky"):
        nephos.probe(cases, "cloud")


def test_a_report_of_a_path_and_of_a_function(scene_path, tmp_path):
    def make(context):
        return nephos.load(scene_path, context=context)
    for subject in scene_path, make:
        end = time.process_time() + 1
        report = nephos.report(subject, width=16, height=9, budget=60, quick=True,
                               progress=lambda _: time.process_time() < end)
        assert not report.is_complete and any(row["knob"] == "scene" for row in report.rows)
        assert report.describe()
    report.save(tmp_path)
    assert json.loads((tmp_path / "report.json").read_text()) and (tmp_path / "report.html").exists()
    with pytest.raises(FileNotFoundError):
        nephos.report(tmp_path / "absent.yaml", budget=1)
    with pytest.raises(ZeroDivisionError):
        nephos.report(lambda context: 1 / 0, budget=1)
    with pytest.raises(TypeError, match="given context"):
        nephos.report(lambda context: nephos.Scene(context=nephos.Context(thread_count=1)), budget=1)


def test_sky_effort_and_plan(scene):
    sky = nephos.sky(scene, width=32, height=16)
    assert sky.width == 32 and "disk.R" in sky and sky.attribute("nephos:sunDirection")
    assert json.loads(scene.explain("json")) and "sun" in scene.explain()
    effort = scene.choose_effort(target_error=0.2)
    assert effort["error"] > 0 and effort["integrator"] in ("march", "path")
    with pytest.raises(ValueError, match="plain, json"):
        scene.explain("xml")


def test_a_file_is_mended(scene, tmp_path, program):
    path, mended = tmp_path / "bad.nvdb", tmp_path / "mended.nvdb"
    nephos.bake(scene, path, cloud="field")
    data = numpy.fromfile(path, numpy.uint8)
    grid = data.tobytes().index(b"NanoVDB", 8)
    leaf = grid + 672 + int.from_bytes(data[grid + 672:grid + 680].tobytes(), "little")
    values = data[leaf + 96:leaf + 96 + 2048].view(numpy.float32)
    values[numpy.argmax(values > 0)] = numpy.nan
    data[grid + 8:grid + 16] = 0xff  # the checksum
    data.tofile(path)
    assert [finding.rule for finding in nephos.check(path)] == ["values.nan"]
    with pytest.raises(nephos.FileError, match="NaN"):
        nephos.Volume.load(path)
    assert nephos.mend(path, mended).strip() == "grid 'density': 1 value mended"
    assert not nephos.check(mended) and nephos.Volume.load(mended).info["value_max"] > 0
    assert "unchanged" in program("check", mended, "--fix", "-o", "again.nvdb")
    with pytest.raises(nephos.ArgumentError, match="must end in .nvdb"):
        nephos.mend(path, tmp_path / "mended.vdb")
    with pytest.raises(nephos.NotFoundError, match="absent.vdb"):
        nephos.mend(tmp_path / "absent.vdb", mended)


def test_scene_of_defaults_and_checks(scene, tmp_path):
    scene.check()
    assert not scene.is_animated and nephos.Scene()["sun.elevation"] == "35 deg"
    scene["terrain"] = {"heightfield": tmp_path / "absent.hgt"}
    with pytest.raises(nephos.Error, match="absent.hgt"):
        scene.check()
