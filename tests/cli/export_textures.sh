# SPDX-License-Identifier: Apache-2.0
# Textures of a scene: files and their description, read by another program; refusals; nothing of a failure stays.
try() { nephos "$@" -q || echo "exit code $?"; }
cat >clouds.yaml <<'END'
version: 1
clouds:
  - {name: low, bake: {preset: altostratus, seed: 3, extent: 2 km, voxel: 100 m, coverage: 0.85}}
END
try export clouds.yaml --for textures --size 24 -o maps -n
test -e maps && echo "a dry run made a folder"
try export clouds.yaml --for textures --size 24 -o maps
try export clouds.yaml --for textures --size 24 --format raw --json -o raw | head -n 2
try export clouds.yaml --for textures --size 24 --format raw --json -o raw --frames 1-2
try export clouds.yaml --for textures
try export clouds.yaml --for textures --half -o maps
try export clouds.yaml --for textures --size 9 -o maps
try export clouds.yaml --size 32 -o low.vdb
try export clouds.yaml --for textures -o clouds.yaml/maps
cat >read.py <<'END'
"""Reads each texture by textures.json alone, .ktx2 behind its index of levels, and compares both formats."""
import json, struct
bytes_of = {"R8_UNORM": 1, "R8G8B8A8_UNORM": 4, "R16_SFLOAT": 2, "R16G16_SFLOAT": 4, "R16G16B16A16_SFLOAT": 8}
for texture, raw in zip(*(json.load(open(folder + "/textures.json"))["textures"] for folder in ("maps", "raw"))):
    data = open("maps/" + texture["file"], "rb").read()
    vulkan, = struct.unpack_from("<I", data, 12)
    size = [edge for edge in struct.unpack_from("<3I", data, 20) if edge]
    offset, length = struct.unpack_from("<2Q", data, 80)
    count = bytes_of[texture["format"]]
    for edge in size:
        count *= edge
    assert data[:12] == b"\xabKTX 20\xbb\r\n\x1a\n" and vulkan == texture["vk_format"] and size == texture["size"]
    assert offset + length == len(data) and length == count == texture["bytes"]
    assert data[offset:] == open("raw/" + raw["file"], "rb").read(), texture["name"]
    for channel in texture["channels"]:
        assert channel["meaning"] and channel["unit"] and channel["range"][0] <= channel["range"][1]
print("all are as described")
END
python3 read.py
cat >files.yaml <<'END'
version: 1
atmosphere: none
clouds:
  - {name: read, vdb: missing.vdb, extinction: 1 1/m}
END
nephos bake clouds.yaml -q -o missing.vdb
try export files.yaml --for textures -o few
# Night without a moon.
nephos export clouds.yaml -q --for textures --size 16 -o night --set 'sun.elevation=-40 deg' | grep sky || echo "no tables of the sky"
# A full disk: neither a texture nor the old description changes.
cp maps/textures.json before.json
(ulimit -f 512; trap '' XFSZ; nephos export clouds.yaml --for textures --size 16 -q -o maps) 2>&1 || echo "exit code $?"
cmp before.json maps/textures.json && ls -A maps | wc -l
