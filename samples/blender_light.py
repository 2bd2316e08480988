# SPDX-License-Identifier: Apache-2.0
"""Lights a white sphere in Cycles with a latitude-longitude EXR, and prints what its top reflects as irradiance.

    blender -b -P samples/blender_light.py -- SKY.exr [PICTURE.png]

Diffuse, of albedo 1, so that irradiance is pi times the radiance straight above: of the four pixels about the top.
"""
import math
import sys

import bpy

SIZE = 64
arguments = sys.argv[sys.argv.index("--") + 1:]

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.engine = "CYCLES"
scene.cycles.device = "CPU"
scene.cycles.samples = 1024
scene.cycles.use_denoising = False
scene.cycles.use_adaptive_sampling = False
scene.cycles.sample_clamp_direct = 0
scene.cycles.sample_clamp_indirect = 0
scene.cycles.max_bounces = 1
scene.render.threads_mode = "FIXED"
scene.render.threads = 2
scene.render.resolution_x = scene.render.resolution_y = SIZE
scene.render.film_transparent = True
scene.view_settings.view_transform = "Standard"

world = bpy.data.worlds.new("sky")
scene.world = world
world.use_nodes = True
sky = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
sky.image = bpy.data.images.load(arguments[0])
sky.image.colorspace_settings.name = "Linear"
sky.interpolation = "Closest"
background = world.node_tree.nodes["Background"]
world.node_tree.links.new(sky.outputs["Color"], background.inputs["Color"])
world.cycles.sampling_method = "MANUAL"
world.cycles.sample_map_resolution = sky.image.size[0]

bpy.ops.mesh.primitive_uv_sphere_add(segments=128, ring_count=64, radius=1)
bpy.ops.object.shade_smooth()
white = bpy.data.materials.new("white")
white.use_nodes = True
tree = white.node_tree
tree.nodes.clear()
diffuse, output = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeOutputMaterial")
diffuse.inputs["Color"].default_value = (1, 1, 1, 1)
tree.links.new(diffuse.outputs["BSDF"], output.inputs["Surface"])
bpy.context.object.data.materials.append(white)

camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
camera.data.type = "ORTHO"
camera.data.ortho_scale = 2.2
camera.location = (0, 0, 10)
scene.collection.objects.link(camera)
scene.camera = camera

settings = scene.render.image_settings
settings.file_format, settings.color_depth = "OPEN_EXR", "32"
scene.render.filepath = arguments[0] + ".sphere.exr"
bpy.ops.render.render(write_still=True)
picture = bpy.data.images.load(scene.render.filepath)
picture.colorspace_settings.name = "Linear"
pixels = list(picture.pixels)

def average(c):
    middle = [SIZE // 2 - 2, SIZE // 2 - 1, SIZE // 2, SIZE // 2 + 1]
    values = [pixels[(y * SIZE + x) * 4 + c] for y in middle for x in middle]
    return sum(values) / len(values)

print("cycles irradiance", *("%.6g" % (math.pi * average(c)) for c in range(3)))

def get(x, y):
    return pixels[(y * SIZE + x) * 4]

# East, west, north, south of the sphere, 45 degrees down: which side is lit.
q = int(SIZE / 2 / 1.1 * math.sqrt(0.5))
h = SIZE // 2
print("cycles sides e w n s", *("%.4g" % (math.pi * get(x, y))
                                for x, y in ((h + q, h), (h - q, h), (h, h + q), (h, h - q))))
