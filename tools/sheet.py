#!/usr/bin/env python3
"""Contact sheet of trees, rendered with Blender: one column a species, one row a seed and side.

    python3.11 -m venv venv && venv/bin/pip install -r tools/requirements.txt
    venv/bin/python tools/sheet.py sheet.png --deeptree target/release/deeptree

Sides are `grow` (trees of the growth model) and `generate` (trees of the networks). All trees of a
sheet have the same scale, roots stand on the ground line, and the camera is orthographic: `--view
front` looks along the ground, `--view top` straight down. Faces seen from behind show magenta with
`--check`: a sound mesh shows none.
"""

import argparse
import contextlib
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import bpy
from mathutils import Vector
from PIL import Image, ImageDraw, ImageFont

SPECIES = "beech corkscrew maple oak pine tulip walnut willow".split()
SIDES = {"grow": "growth model", "generate": "networks"}
PAPER, GROUND, INK, FAINT = (246, 244, 239), (226, 221, 210), (40, 36, 32), (120, 113, 104)
GAP, MARGIN, TITLE, FOOT = 10, 44, 34, 24  # pixels: around a tree, left, on top, below the ground
LABEL = 140  # pixels of the widest label: no column is narrower
DISTANCE = 100  # metres from the root to the camera


def arguments():
    def names(allowed):
        def parse(text):
            chosen = list(allowed) if text == "all" else text.split(",")
            for name in chosen:
                if name not in allowed:
                    raise argparse.ArgumentTypeError(f"{name} is none of {', '.join(allowed)}")
            return chosen

        return parse

    def seeds(text):
        return [int(seed) for seed in text.split(",")]

    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("out", type=Path, help="the PNG to write")
    parser.add_argument("--deeptree", required=True, help="the deeptree binary")
    parser.add_argument("--seeds", type=seeds, default=[1], help="e.g. 1,2 [1]")
    parser.add_argument("--species", type=names(SPECIES), default=SPECIES, help="e.g. oak,pine [all]")
    parser.add_argument("--sides", type=names(SIDES), default=list(SIDES), help="[grow,generate]")
    parser.add_argument("--samples", type=int, default=32, help="light paths a pixel [32]")
    parser.add_argument("--height", type=int, default=360, help="pixels of the tallest tree [360]")
    parser.add_argument("--view", choices=["front", "top"], default="front")
    parser.add_argument("--args", default="", help="more arguments for deeptree, e.g. --args='--age 20'")
    parser.add_argument("--check", action="store_true", help="show the backs of faces in magenta")
    return parser.parse_args()


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


def studio(samples, view):
    """An empty scene with a sun, a sky and an orthographic camera."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.film_transparent = True
    scene.render.image_settings.file_format = "PNG"
    scene.render.image_settings.color_mode = "RGBA"
    scene.view_settings.view_transform = "Standard"
    scene.cycles.samples = samples
    scene.cycles.max_bounces = 3
    scene.cycles.sample_clamp_direct = scene.cycles.sample_clamp_indirect = 2  # no white specks
    scene.cycles.use_denoising = False  # it smears twigs, and the samples antialias them anyway
    scene.cycles.use_adaptive_sampling = False

    scene.world = bpy.data.worlds.new("sky")
    scene.world.use_nodes = True
    background = scene.world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (0.80, 0.90, 1.0, 1)
    background.inputs["Strength"].default_value = 0.45

    sun = bpy.data.lights.new("sun", "SUN")
    sun.energy, sun.angle, sun.color = 3.5, 0.05, (1.0, 0.93, 0.82)
    sun = bpy.data.objects.new("sun", sun)
    sun.rotation_euler = Vector((0.55, 0.6, -0.6)).to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(sun)

    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.sensor_fit = "ORTHO", "HORIZONTAL"
    camera.data.clip_end = 2 * DISTANCE
    camera.rotation_euler = (0, 0, 0) if view == "top" else (1.5707963, 0, 0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    return scene


def magenta_backs():
    """A material that is grey on the front of faces and glows magenta on their backs."""
    material = bpy.data.materials.new("check")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    mix, back = nodes.new("ShaderNodeMixShader"), nodes.new("ShaderNodeEmission")
    back.inputs["Color"].default_value = (1, 0, 1, 1)
    nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.15, 0.15, 0.15, 1)
    links.new(nodes.new("ShaderNodeNewGeometry").outputs["Backfacing"], mix.inputs[0])
    links.new(nodes["Principled BSDF"].outputs[0], mix.inputs[1])
    links.new(back.outputs[0], mix.inputs[2])
    links.new(mix.outputs[0], nodes["Material Output"].inputs["Surface"])
    return material


class Tree:
    """The objects of a GLB file, hidden until rendered, and their rectangle in the picture."""

    def __init__(self, path, view, material=None):
        before = set(bpy.data.objects)
        with silence():
            bpy.ops.import_scene.gltf(filepath=str(path))
        self.objects = [o for o in bpy.data.objects if o not in before]
        meshes = [o for o in self.objects if o.type == "MESH"]
        corners = [o.matrix_world @ Vector(c) for o in meshes for c in o.bound_box]
        up = 1 if view == "top" else 2
        self.left, self.right = min(c[0] for c in corners), max(c[0] for c in corners)
        self.low, self.high = min(c[up] for c in corners), max(c[up] for c in corners)
        self.show(False)
        if material:
            for mesh in meshes:
                mesh.data.materials.clear()
                mesh.data.materials.append(material)

    def show(self, shown):
        for o in self.objects:
            o.hide_render = not shown


def render(scene, tree, frame, scale, view, path):
    """Renders the rectangle `frame` (left, right, low, high in metres) at `scale` pixels a metre."""
    left, right, low, high = frame
    width, height = round((right - left) * scale), round((high - low) * scale)
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.camera.data.ortho_scale = width / scale
    x, up = (left + right) / 2, (low + high) / 2
    scene.camera.location = (x, up, DISTANCE) if view == "top" else (x, -DISTANCE, up)
    scene.render.filepath = str(path)
    tree.show(True)
    with silence():
        bpy.ops.render.render(write_still=True)
    tree.show(False)
    return Image.open(path).convert("RGBA")


def main():
    args = arguments()
    began = time.monotonic()
    scene = studio(args.samples, args.view)
    material = magenta_backs() if args.check else None
    rows = [(seed, side) for seed in args.seeds for side in args.sides]

    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        trees = {}
        for seed, side in rows:
            for species in args.species:
                glb = folder / f"{species}-{seed}-{side}.glb"
                command = [args.deeptree, side, species, "--seed", str(seed), "-q", "-o", glb]
                if subprocess.run(command + args.args.split()).returncode != 0:
                    sys.exit(f"failed: {' '.join(map(str, command))}")
                trees[species, seed, side] = Tree(glb, args.view, material)

        # One scale, one height of rows; a column is as wide as its widest tree.
        low, high = min(t.low for t in trees.values()), max(t.high for t in trees.values())
        scale = args.height / (high - low)
        pad = GAP / scale
        columns = {}
        for species in args.species:
            here = [t for (name, _, _), t in trees.items() if name == species]
            left, right = min(t.left for t in here) - pad, max(t.right for t in here) + pad
            short = max(0, LABEL / scale - (right - left)) / 2
            columns[species] = (left - short, right + short)
        widths = [round((right - left) * scale) for left, right in columns.values()]
        tall = round((high - low + 2 * pad) * scale)
        total = MARGIN + sum(widths) + GAP

        sheet = Image.new("RGB", (total, TITLE + len(rows) * (tall + FOOT)), PAPER)
        draw = ImageDraw.Draw(sheet)
        font, small = ImageFont.load_default(17), ImageFont.load_default(12)
        x = MARGIN
        for species, width in zip(args.species, widths):
            draw.text((x + width / 2, TITLE / 2 + 4), species, INK, font, anchor="mm")
            x += width

        for row, (seed, side) in enumerate(rows):
            top = TITLE + row * (tall + FOOT)
            if args.view == "front":
                ground = top + round((high + pad) * scale)
                draw.rectangle((MARGIN, ground, total - GAP, top + tall), GROUND)
            strip = Image.new("RGB", (tall, MARGIN), PAPER)
            ImageDraw.Draw(strip).text(
                (tall / 2, MARGIN / 2), f"{SIDES[side]}, seed {seed}", INK, font, anchor="mm"
            )
            sheet.paste(strip.rotate(90, expand=True), (0, top))
            x = MARGIN
            for species, width in zip(args.species, widths):
                tree = trees[species, seed, side]
                left, right = columns[species]
                frame = (left, right, low - pad, high + pad)
                picture = render(scene, tree, frame, scale, args.view, folder / "tree.png")
                sheet.paste(picture, (x, top), picture)
                if args.view == "front":
                    size = f"{tree.high:.0f} m high, {tree.right - tree.left:.0f} m wide"
                else:
                    size = f"{tree.right - tree.left:.0f} by {tree.high - tree.low:.0f} m"
                draw.text((x + width / 2, top + tall + 11), size, FAINT, small, anchor="mm")
                x += width

    # Few colours besides browns and paper: a palette keeps the file small.
    sheet.quantize(128, dither=Image.Dither.NONE).save(args.out, optimize=True)
    print(
        f"{args.out}: {sheet.width} × {sheet.height}, {args.out.stat().st_size / 1000:.0f} kB, "
        f"{len(trees)} trees in {time.monotonic() - began:.1f} s"
    )


if __name__ == "__main__":
    main()
