#!/usr/bin/env python3
"""Opens files in Blender, says what is in them, and renders a picture of each.

    venv/bin/python tools/open_in_blender.py out/ oak.glb oak.gltf oak.obj oak.ply oak.usdz

The environment is that of tools/requirements.txt. Of an animation there is a picture of each of `--times`,
in shares of its length.
"""

import argparse
import contextlib
import json
import os
import sys
import time
from pathlib import Path

import bpy
from mathutils import Vector


@contextlib.contextmanager
def silence():
    """Keeps what Blender prints from file descriptor 1."""
    sys.stdout.flush()
    kept, null = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 1)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(kept, 1)
        os.close(kept)
        os.close(null)


def load(path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    kind = path.suffix.lower()
    if kind in (".glb", ".gltf"):
        bpy.ops.import_scene.gltf(filepath=str(path))
    elif kind == ".obj":
        bpy.ops.wm.obj_import(filepath=str(path))
    elif kind == ".ply":
        bpy.ops.wm.ply_import(filepath=str(path))
    else:
        bpy.ops.wm.usd_import(filepath=str(path))


def figures(path, seconds):
    """What there is: meshes as they are evaluated, copies counted one by one."""
    graph = bpy.context.evaluated_depsgraph_get()
    shown, low, high = 0, Vector([1e9] * 3), Vector([-1e9] * 3)
    for one in graph.object_instances:
        if one.object.type == "MESH":
            shown += 1
            for corner in one.object.bound_box:
                place = one.matrix_world @ Vector(corner)
                low = Vector(map(min, low, place))
                high = Vector(map(max, high, place))
    pictures = [(i.name, tuple(i.size)) for i in bpy.data.images if i.size[0] > 0 and i.has_data]
    return {
        "file": path.name,
        "seconds": round(seconds, 2),
        "objects": shown,
        "vertices": sum(len(o.data.vertices) for o in bpy.data.objects if o.type == "MESH"),
        "size": [round(s, 2) for s in high - low],
        "materials": {
            m.name: sorted(
                {l.to_socket.name for l in m.node_tree.links if l.to_node.type == "BSDF_PRINCIPLED"}
            )
            for m in bpy.data.materials
            if m.use_nodes and m.users
        },
        "pictures": sorted(pictures),
        "bones": sum(len(a.bones) for a in bpy.data.armatures),
        "animations": [(a.name, tuple(a.frame_range)) for a in bpy.data.actions],
    }


def studio(height, pixels, samples):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = samples
    scene.cycles.use_denoising = False
    scene.render.resolution_x = scene.render.resolution_y = pixels
    scene.view_settings.view_transform = "Standard"
    scene.world = bpy.data.worlds.new("sky")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.7, 0.8, 1.0, 1)
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.6
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy = 3.5
    sun.rotation_euler = Vector((0.55, 0.6, -0.6)).to_track_quat("-Z", "Y").to_euler()
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", 1.15 * height
    camera.location, camera.rotation_euler = (0, -100, 0.5 * height), (1.5707963, 0, 0)
    camera.data.clip_end = 200
    for thing in (sun, camera):
        scene.collection.objects.link(thing)
    scene.camera = camera
    return scene


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("out", type=Path, help="a folder for the pictures")
    parser.add_argument("files", type=Path, nargs="+")
    parser.add_argument("--pixels", type=int, default=400)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--times", default="0,0.25,0.5,0.75,1", help="of an animation")
    parser.add_argument("--no-pictures", action="store_true")
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    for path in args.files:
        began = time.monotonic()
        with silence():
            load(path)
        last = max((a.frame_range[1] for a in bpy.data.actions), default=None)
        if last is not None:
            bpy.context.scene.frame_set(round(last))
        found = figures(path, time.monotonic() - began)
        print(json.dumps(found), flush=True)
        if args.no_pictures:
            continue
        scene = studio(max(found["size"]), args.pixels, args.samples)
        times = [1.0] if last is None else [float(t) for t in args.times.split(",")]
        for t in times:
            if last is not None:
                scene.frame_set(round(t * last))
            scene.render.filepath = str(args.out / f"{path.name}-{t:g}.png")
            with silence():
                bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    main()
