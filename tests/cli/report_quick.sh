# SPDX-License-Identifier: Apache-2.0
# A report of a tiny scene: its files, a page that parses, a reference that serves again; what is refused.
try() { code=0; "$@" || code=$?; echo "$code"; }
cat >scene.yaml <<'Y'
{camera: {resolution: [16, 16], position: [0, -3 km, 800 m], look_at: [0, 0, 1500 m]}, sun: {elevation: 40 deg},
 clouds: [{vdb: kept.vdb, bake: {preset: cumulus_humilis, extent: [2 km, 2 km], voxel: 200 m}}]}
Y
nephos report scene.yaml -q --quick --budget 1.5s | sed -E 's/[0-9.]+e?[+-]?[0-9]*/N/g' | head -n 2
ls -A . scene.report
cat >check.py <<'P'
import csv, json, sys, xml.dom.minidom
folder = sys.argv[1]
page = xml.dom.minidom.parse(folder + "/report.html")
report = json.load(open(folder + "/report.json"))
rows = list(csv.DictReader(open(folder + "/report.csv")))
images = page.getElementsByTagName("img")
ids = [e.getAttribute("id") for e in page.getElementsByTagName("*") if e.getAttribute("id")]
assert len(rows) == len(report["settings"]) and len(ids) == len(set(ids))
assert all(i.getAttribute("src").startswith("data:image/png;base64,iVBOR") for i in images)
assert not any(e.getAttribute("src").startswith("http") for e in page.getElementsByTagName("*"))
print(report["complete"], report["width"], report["height"], len(report["targets"]), rows[0]["knob"], rows[0]["setting"])
measured = sum(row["runs"] != "0" for row in rows)
has_plots = len(page.getElementsByTagName("svg")) > 0
print("pictures", len(images) >= 3, "plots", has_plots == (measured > 1), report["reference"]["given"])
P
python3 check.py scene.report
nephos report scene.yaml -q --quick --budget 1.2s --reference scene.report/reference.exr -o deep/er/again >/dev/null
python3 check.py deep/er/again
mkdir bare && ln -s "$(command -v nephos)" bare/nephos
PATH=$PWD/bare nephos report scene.yaml -q --quick --budget 1.2s --reference scene.report/reference.exr -o plain >/dev/null
grep -c 'gnuplot was not found' plain/report.html
try nephos report scene.yaml -q --quick --reference scene.report/reference.exr --resolution 8x8
try nephos report scene.yaml -q --reference nowhere.exr
try nephos report scene.yaml -q --budget soon
try nephos report - -q
try nephos report scene.yaml -q -o scene.yaml/report
try nephos report scene.yaml -q --set render.samples=0
# Stopped: nothing is left of a part of a reference; what was measured is, marked.
# stop STAGE OPTION...: a report that is stopped in a stage.
stop() {
  stage=$1
  shift
  : >log
  nephos report scene.yaml --progress lines --budget 1h "$@" 2>log >/dev/null &
  until grep -qs "^nephos: $stage" log; do sleep 0.02; done
  kill -TERM $!
  wait $! || echo "$?"
  grep -o 'cancelled: .*' log || true
}
stop reference -o nothing
stop samples --reference scene.report/reference.exr -o broken
grep -c 'is incomplete' broken/report.html
head -n 1 broken/report.csv
ls -A
