#!/usr/bin/env python3
"""Renders the scene of the example `beside_mitsuba` with Mitsuba 3 and compares the pictures.

    python3 -m venv venv && venv/bin/pip install mitsuba numpy
    cargo run --release -p deeptree-render --example beside_mitsuba -- scene 0.7
    venv/bin/python tools/beside_mitsuba.py scene            # the same scattering
    venv/bin/python tools/beside_mitsuba.py scene plastic    # Mitsuba's own rough plastic

It needs LLVM, which DRJIT_LIBLLVM_PATH names where there are several: 22 works, 14 and 15 do not
know `fmaximum`.

Both renderers must scatter light at the wood alike, or the pictures tell nothing. By default the
scattering is written out here once more, from its formula, on Mitsuba's microfacets and Fresnel
terms. Mitsuba's own `roughplastic` is the same only for smooth boundaries: what its microfacets
shadow is lost, and its masking is separable where ours depends on both heights. For both, the share
of light that a body of albedo 1 gives out again is printed; 1 is right.

Prints both means of red, green and blue, over the whole picture and over the tree's pixels, and how
far they are apart. Exit code 1 where a mean is off by more than 2 %.
"""

import json
import sys
from pathlib import Path

import drjit as dr
import mitsuba as mi
import numpy as np

folder = Path(sys.argv[1])
plastic = "plastic" in sys.argv[2:]
told = json.loads((folder / "scene.json").read_text())
mi.set_variant("llvm_ad_rgb")
INDEX = 1.5


class CoatedBody(mi.BSDF):
    """A rough dielectric boundary over a diffuse body that gets all light the boundary does not
    reflect: f = F D G / (4 cos cos) + albedo (1 - E(o)) (1 - E(i)) / (pi (1 - mean E))."""

    KNOTS = 256

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        self.alpha = props["alpha"]
        self.albedo = mi.Color3f(props["albedo"])
        flags = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.DiffuseReflection
        self.m_components = [flags | mi.BSDFFlags.FrontSide]
        self.m_flags = self.m_components[0]
        self.facets = mi.MicrofacetDistribution(mi.MicrofacetType.GGX, self.alpha, True)
        self.tabulate()

    def tabulate(self):
        """E: the mean of F G / G1 over visible normals, from each of the knots."""
        n, draws = self.KNOTS, 64
        lane = dr.arange(mi.UInt32, n * draws * draws)
        knot, draw = lane // (draws * draws), lane % (draws * draws)
        cos = dr.maximum(mi.Float(knot) / (n - 1), 1e-4)
        wo = mi.Vector3f(dr.sqrt(1 - cos * cos), 0, cos)
        u = (mi.Point2f(mi.Float(draw // draws), mi.Float(draw % draws)) + 0.5) / draws
        half, _ = self.facets.sample(wo, u)
        wi = mi.reflect(wo, half)
        weight = mi.fresnel(dr.dot(wo, half), INDEX)[0] * self.masking(wo, wi, half)
        weight /= self.facets.smith_g1(wo, half)
        table = np.array(dr.select(wi.z > 0, weight, 0)).reshape(n, -1).mean(axis=1)
        mu = np.linspace(0, 1, n)
        self.mean = float(np.trapezoid(2 * mu * table, mu))
        self.table = mi.Float(table)

    def reflected(self, cos):
        x = dr.clip(cos, 0, 1) * (self.KNOTS - 1)
        low = dr.minimum(mi.UInt32(x), self.KNOTS - 2)
        t = x - mi.Float(low)
        pick = lambda i: dr.gather(mi.Float, self.table, i)
        return pick(low) * (1 - t) + pick(low + 1) * t

    def masking(self, wo, wi, half):
        """Smith's, for facets whose heights matter to both directions: 1 / (1 + L(o) + L(i))."""
        hidden = lambda w: 1 / dr.maximum(self.facets.smith_g1(w, half), 1e-6) - 1
        return 1 / (1 + hidden(wo) + hidden(wi))

    def scattered(self, wo, wi):
        half = dr.normalize(wo + wi)
        mirror = mi.fresnel(dr.dot(wo, half), INDEX)[0] * self.facets.eval(half)
        mirror *= self.masking(wo, wi, half) / (4 * wo.z * wi.z)
        passed = (1 - self.reflected(wo.z)) * (1 - self.reflected(wi.z)) / (1 - self.mean)
        return self.albedo * (passed * dr.inv_pi) + mirror

    def density(self, wo, wi):
        half = dr.normalize(wo + wi)
        mirror = self.facets.pdf(wo, half) / (4 * dr.dot(wo, half))
        return 0.5 * (mirror + wi.z * dr.inv_pi)

    def above(self, wo, wi, active):
        return active & (wo.z > 1e-6) & (wi.z > 1e-6)

    def sample(self, ctx, si, lobe, u, active=True):
        half, _ = self.facets.sample(si.wi, u)
        mirror = mi.reflect(si.wi, half)
        wi = dr.select(lobe < 0.5, mirror, mi.warp.square_to_cosine_hemisphere(u))
        ok = self.above(si.wi, wi, active)
        drawn = mi.BSDFSample3f(wi)
        drawn.pdf = dr.select(ok, self.density(si.wi, wi), 0)
        drawn.eta = 1.0
        drawn.sampled_type = mi.UInt32(+self.m_flags)
        drawn.sampled_component = 0
        weight = self.scattered(si.wi, wi) * wi.z / drawn.pdf
        return drawn, dr.select(ok & (drawn.pdf > 0), weight, 0)

    def eval(self, ctx, si, wi, active=True):
        ok = self.above(si.wi, wi, active)
        return dr.select(ok, self.scattered(si.wi, wi) * wi.z, 0)

    def pdf(self, ctx, si, wi, active=True):
        return dr.select(self.above(si.wi, wi, active), self.density(si.wi, wi), 0)

    def eval_pdf(self, ctx, si, wi, active=True):
        return self.eval(ctx, si, wi, active), self.pdf(ctx, si, wi, active)


mi.register_bsdf("coated_body", CoatedBody)


def wood(albedo):
    """The scattering of wood whose body has this albedo."""
    if plastic:
        # With `nonlinear` off, its diffuse part is that above where the boundary is smooth.
        return {"type": "roughplastic", "distribution": "ggx", "alpha": told["alpha"],
                "int_ior": INDEX, "ext_ior": 1.0, "nonlinear": False,
                "diffuse_reflectance": {"type": "rgb", "value": albedo}}
    return {"type": "coated_body", "alpha": told["alpha"], "albedo": albedo}


def given_out(cos):
    """What a body of albedo 1 gives out of the light from one direction."""
    bsdf, n = mi.load_dict(wood([1.0, 1.0, 1.0])), 1024
    lane = dr.arange(mi.UInt32, n * n)
    u = (mi.Point2f(mi.Float(lane // n), mi.Float(lane % n)) + 0.5) / n
    si = dr.zeros(mi.SurfaceInteraction3f, n * n)
    si.wi = mi.Vector3f(float(np.sqrt(1 - cos * cos)), 0, cos)
    wo = mi.warp.square_to_uniform_hemisphere(u)
    value = bsdf.eval(mi.BSDFContext(), si, wo) * dr.two_pi
    return float(np.array(value).mean())


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
        "wood": {"type": "obj", "filename": str(folder / "wood.obj"),
                 "bsdf": {"type": "twosided", "inner": wood(told["albedo"])}},
    }
)
found = np.array(mi.render(scene))
theirs = found[:, :, :3]
loaded = mi.Bitmap(str(folder / "ours.exr")).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32)
ours = np.array(loaded)

index = found[:, :, -1]
ground = round(float(index[-1, 0]), 3)
tree = np.abs(index - ground) > 1e-3

shares = ", ".join(f"{given_out(cos):.3f} at {cos}" for cos in (0.1, 0.3, 0.6, 1.0))
print(f"of albedo 1, {'roughplastic' if plastic else 'the body'} gives out {shares} (cosines)")
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
