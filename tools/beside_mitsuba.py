#!/usr/bin/env python3
"""Renders the scene of the example `beside_mitsuba` with Mitsuba 3 and compares the pictures.

    python3 -m venv venv && venv/bin/pip install mitsuba numpy
    cargo run --release -p deeptree-render --example beside_mitsuba -- scene
    venv/bin/python tools/beside_mitsuba.py scene

Prints both means of red, green and blue, over the whole picture and over the tree's pixels, and how
far they are apart. Exit code 1 where a mean is off by more than 2 %.
"""

import json
import sys
from pathlib import Path

import mitsuba as mi
import numpy as np

folder = Path(sys.argv[1])
told = json.loads((folder / "scene.json").read_text())
mi.set_variant("llvm_ad_rgb" if "llvm" in sys.argv[2:] else "scalar_rgb")

T = mi.ScalarTransform4f
origin = np.array(told["from"])
target = origin + np.array(told["forward"])
size = told["size"]
scene = mi.load_dict(
    {
        "type": "scene",
        "integrator": {"type": "aov", "aovs": "what:shape_index",
                       "image": {"type": "path", "max_depth": 17, "rr_depth": 8}},
        "sensor": {
            "type": "perspective",
            "fov": float(np.degrees(told["angle"])),
            "fov_axis": "y",
            "to_world": T().look_at(origin=list(origin), target=list(target), up=told["up"]),
            "film": {"type": "hdrfilm", "width": size, "height": size, "pixel_format": "rgb",
                     "rfilter": {"type": "tent", "radius": 1.0}},
            "sampler": {"type": "independent", "sample_count": told["samples"]},
        },
        "dome": {"type": "constant", "radiance": {"type": "rgb", "value": told["dome"]}},
        "sun": {"type": "directional", "direction": [-x for x in told["sun"]],
                "irradiance": {"type": "rgb", "value": told["sun_irradiance"]}},
        "ground": {"type": "rectangle",
                   "to_world": T().rotate([1, 0, 0], -90).scale([1e4, 1e4, 1]),
                   "bsdf": {"type": "diffuse",
                            "reflectance": {"type": "rgb", "value": told["ground"]}}},
        # With `nonlinear` off, its diffuse part is ours where the boundary is smooth:
        # ρ (1 − E)(1 − E) / (π (1 − mean E)).
        "wood": {"type": "obj", "filename": str(folder / "wood.obj"),
                 "bsdf": {"type": "twosided", "inner": {
                     "type": "roughplastic", "distribution": "ggx", "alpha": told["alpha"],
                     "int_ior": 1.5, "ext_ior": 1.0, "nonlinear": False,
                     "diffuse_reflectance": {"type": "rgb", "value": told["albedo"]}}}},
    }
)
found = np.array(mi.render(scene))
theirs = found[:, :, :3]
loaded = mi.Bitmap(str(folder / "ours.exr")).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32)
ours = np.array(loaded)

index = found[:, :, -1]
ground = round(float(index[-1, 0]), 3)
tree = np.abs(index - ground) > 1e-3

worst = 0.0
for name, mask in [("picture", np.ones_like(tree)), ("tree", tree)]:
    a, b = ours[mask].mean(axis=0), theirs[mask].mean(axis=0)
    off = a / b - 1
    worst = max(worst, float(np.abs(off).max()))
    print(f"{name:8} ours {a.round(5)} Mitsuba {b.round(5)} off {(100 * off).round(2)} %")
print(f"pixels of the tree: {tree.mean():.3f}")
blocks = lambda x: x.reshape(size // 16, 16, size // 16, 16, 3).mean(axis=(1, 3))
print(f"blocks of 16 pixels: off {100 * np.abs(blocks(ours) / blocks(theirs) - 1).mean():.2f} % on average, "
      f"{100 * np.abs(blocks(ours) / blocks(theirs) - 1).max():.2f} % at most")
sys.exit(worst > 0.02)
