# SPDX-License-Identifier: Apache-2.0
# Height fields by GDAL: what info says of one, and what a dry run says of those that cannot be meant.
try() { nephos "$@" || echo "exit code $?"; }

write_grid() { printf 'ncols 3\nnrows 2\nxllcorner %s\nyllcorner 3796000\ncellsize 1000\nNODATA_value -9999\n%s\n' "$2" "$3" >"$1"; }
write_grid a.asc 392000 '900.5 -9999 700
500 400 300'
write_grid b.asc 395000 '700.5 800 900
300 400 500'
write_grid voids.asc 392000 '-9999 -9999 -9999
-9999 -9999 -9999'
echo 'no picture' >text.tif
echo '<VRTDataset rasterXSize="3" rasterYSize="2"><SRS>EPSG:32611</SRS>
<GeoTransform>392000, 1000, 0, 3798000, 0, -1000</GeoTransform>
<VRTRasterBand dataType="Float32" band="1"><NoDataValue>-9999</NoDataValue><UnitType>ft</UnitType><SimpleSource>
<SourceFilename relativeToVRT="1">a.asc</SourceFilename></SimpleSource></VRTRasterBand></VRTDataset>' >feet.vrt
head -c 18 /dev/zero >field.r16
cat >scene.yaml <<'END'
version: 1
camera: {position: [0, 0, 3 km], look_at: [0, 9 km, 1 km], resolution: [16, 9]}
sun: {elevation: 20 deg}
terrain: {heightfield: a.asc}
output: {image: out.exr}
END
try info feet.vrt
try info --json feet.vrt
try info a.asc
dry() { echo "$@" | sed 's/--set //g'; try render scene.yaml -n -q "$@"; }
dry --set terrain.crs=EPSG:32611
dry --set terrain.width=30km
dry
dry --set terrain.crs=EPSG:32611 --set terrain.width=30km
dry --set terrain.heightfield=?.asc --set terrain.crs=EPSG:32611
dry --set 'terrain.heightfield=./{a,b}.asc' --set terrain.crs=EPSG:32611
dry --set 'terrain.heightfield=./{a,x}.asc'
dry --set terrain.heightfield=x?.asc
dry --set terrain.heightfield=text.tif
dry --set terrain.heightfield=missing.tif
dry --set terrain.heightfield=field.r16
dry --set terrain.heightfield=field.r16 --set terrain.raw.size=[3,3]
dry --set terrain.heightfield=field.r16 --set terrain.raw.size=[3,4]
try render scene.yaml -q --set terrain.heightfield=voids.asc --set terrain.crs=EPSG:32611
try render scene.yaml -q --set terrain.heightfield=?.asc --set terrain.crs=EPSG:32611 --set terrain.vertical_unit=foot

# Ground of another place, or in no file
here='place={latitude: 34.3 deg, longitude: -118.2 deg}'
dry --set terrain.crs=bogus
dry --set terrain.crs=EPSG:4326
dry --set terrain.crs=EPSG:4978
dry --set terrain.crs=EPSG:32633 --set "$here"
cp field.r16 bare.bil
dry --set terrain.heightfield=bare.bil
try render scene.yaml -q --set terrain.crs=EPSG:32611 --set "$here"
try render scene.yaml -q --set terrain.crs=EPSG:32633 --set "$here"
write_grid far.asc 492000 '700.5 800 900
300 400 500'
try render scene.yaml -q --set 'terrain.heightfield=./{a,far}.asc' --set terrain.crs=EPSG:32611
python3 -c 'import zipfile; z = zipfile.ZipFile("two.zip", "w"); z.write("a.asc"); z.write("b.asc")'
dry --set terrain.heightfield=two.zip --set terrain.crs=EPSG:32611
dry --set terrain.heightfield=frame.%04k.asc
