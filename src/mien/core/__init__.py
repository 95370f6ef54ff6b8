"""The nouns: frozen dataclasses checked when they are made, and nothing else."""

from mien.core.anatomy import Anatomy, Cluster, Controls, Flexor, Labels, Muscle
from mien.core.clip import Clip
from mien.core.correctives import Correctives
from mien.core.correspondence import Correspondence
from mien.core.errors import FileError, InputError, MienError, MissingPackage, Note
from mien.core.examples import Examples
from mien.core.markers import Markers
from mien.core.mesh import Mesh, SurfacePoints
from mien.core.report import Report
from mien.core.rig import Blendshapes, Rig, Skeleton, Skin

__all__ = [
    "Anatomy",
    "Blendshapes",
    "Clip",
    "Cluster",
    "Controls",
    "Correctives",
    "Correspondence",
    "Examples",
    "FileError",
    "Flexor",
    "InputError",
    "Labels",
    "Markers",
    "Mesh",
    "MienError",
    "MissingPackage",
    "Muscle",
    "Note",
    "Report",
    "Rig",
    "Skeleton",
    "Skin",
    "SurfacePoints",
]
