"""Run by Blender's own Python: import a .glb, play and pose it, and say where its vertices are.

Arguments: a JSON request and the .npz to write.  Of mien nothing is imported here.
"""

import json
import sys

import bpy
import numpy as np
from mathutils import Matrix

TO_BLENDER = Matrix(((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1)))


def meshes():
    found = [o for o in bpy.data.objects if o.type == "MESH" and o.name != "Icosphere"]
    return sorted(found, key=lambda o: o.name)


def vertices():
    """World positions of each mesh as Blender draws it, turned back to +Y up."""
    bpy.context.view_layer.update()
    graph = bpy.context.evaluated_depsgraph_get()
    found = {}
    for shown in meshes():
        evaluated = shown.evaluated_get(graph)
        flat = np.empty(3 * len(evaluated.data.vertices), np.float32)
        evaluated.data.vertices.foreach_get("co", flat)
        world = np.array(evaluated.matrix_world)
        points = flat.reshape(-1, 3) @ world[:3, :3].T + world[:3, 3]
        found[shown.name] = points[:, [0, 2, 1]] * [1, 1, -1]
    return found


def armatures():
    return [o for o in bpy.data.objects if o.type == "ARMATURE"]


def pose(shapes, motions):
    """Set shape keys, and move bones by world motions (+Y up), parents first."""
    for keys in bpy.data.shape_keys:
        for block in keys.key_blocks:
            block.slider_min, block.slider_max = -10, 10
            block.value = shapes.get(block.name, 0)
    for rig in armatures():
        rest = {bone.name: bone.matrix.copy() for bone in rig.pose.bones}
        for bone in rig.pose.bones:  # parents come first
            if bone.name in motions:
                motion = TO_BLENDER @ Matrix(motions[bone.name]) @ TO_BLENDER.inverted()
                bone.matrix = rig.matrix_world.inverted() @ motion @ rig.matrix_world @ rest[bone.name]
                bpy.context.view_layer.update()


def main(request_path, out):
    with open(request_path) as file:
        request = json.load(file)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=request["path"])
    arrays = {}
    for frame in request.get("frames", []):
        bpy.context.scene.frame_set(frame)
        arrays |= {f"frame {frame} {name}": points for name, points in vertices().items()}
    if not bpy.data.actions:  # what an animation holds cannot be posed
        arrays |= {f"rest {name}": points for name, points in vertices().items()}
        pose(request.get("shapes", {}), request.get("motions", {}))
        arrays |= {f"posed {name}": points for name, points in vertices().items()}
    said = {
        "bones": [bone.name for rig in armatures() for bone in rig.data.bones],
        "meshes": [o.name for o in meshes()],
        "groups": {o.name: [g.name for g in o.vertex_groups] for o in meshes()},
        "weights": {o.name: [sum(g.weight for g in v.groups) for v in o.data.vertices] for o in meshes()},
        "shapes": {
            o.name: [] if o.data.shape_keys is None else [k.name for k in o.data.shape_keys.key_blocks][1:]
            for o in meshes()
        },
        "actions": [action.name for action in bpy.data.actions],
        "materials": [m.name for m in bpy.data.materials],
    }
    np.savez(out, said=json.dumps(said), **arrays)


main(*sys.argv[-2:])
