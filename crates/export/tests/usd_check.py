"""Opens stages with usd-core and checks them. Arguments: files. Prints one JSON row a file."""

import json
import sys

from pxr import Usd, UsdGeom, UsdShade, UsdValidation


def meshes(stage):
    # Leaves are copies of prototypes: their meshes are prims like any other.
    return [UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]


def shader_input(material, name):
    """The file and the wrapping of the picture that an input of the surface reads, or none."""
    surface = material.ComputeSurfaceSource()[0]
    source = surface.GetInput(name).GetConnectedSource() if surface.GetInput(name) else None
    if not source:
        return None
    texture = UsdShade.Shader(source[0].GetPrim())
    path = texture.GetInput("file").Get()
    return {"resolved": bool(path.resolvedPath), "file": path.path}


def material_of(mesh):
    material = UsdShade.MaterialBindingAPI(mesh).ComputeBoundMaterial()[0]
    return {
        "name": material.GetPrim().GetName(),
        "color": shader_input(material, "diffuseColor"),
        "normal": shader_input(material, "normal"),
        "roughness": shader_input(material, "roughness"),
        "opacity": shader_input(material, "opacity"),
    }


def check(path):
    stage = Usd.Stage.Open(path)
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    problems = UsdValidation.ValidationContext(validators).Validate(stage)
    instancers = [UsdGeom.PointInstancer(p) for p in stage.Traverse() if p.IsA(UsdGeom.PointInstancer)]
    box = UsdGeom.BBoxCache(Usd.TimeCode.Default(), ["default"])
    bounds = box.ComputeWorldBound(stage.GetDefaultPrim()).ComputeAlignedRange()
    return {
        "file": path,
        "problems": [problem.GetErrorAsString() for problem in problems],
        "up": UsdGeom.GetStageUpAxis(stage),
        "meters_per_unit": UsdGeom.GetStageMetersPerUnit(stage),
        "validators": len(validators),
        "default_prim": stage.GetDefaultPrim().GetName(),
        "seed": str(stage.GetRootLayer().customLayerData["seed"]),
        "vertices": [len(mesh.GetPointsAttr().Get()) for mesh in meshes(stage)],
        "triangles": [len(mesh.GetFaceVertexCountsAttr().Get()) for mesh in meshes(stage)],
        "valid": all(
            UsdGeom.Mesh.ValidateTopology(
                mesh.GetFaceVertexIndicesAttr().Get(),
                mesh.GetFaceVertexCountsAttr().Get(),
                len(mesh.GetPointsAttr().Get()),
            )[0]
            for mesh in meshes(stage)
        ),
        "subdivision": [mesh.GetSubdivisionSchemeAttr().Get() for mesh in meshes(stage)],
        "materials": [material_of(mesh) for mesh in meshes(stage)],
        "leaves": [len(one.GetPositionsAttr().Get()) for one in instancers],
        "low": list(bounds.GetMin()),
        "high": list(bounds.GetMax()),
    }


for path in sys.argv[1:]:
    print(json.dumps(check(path)))
