"""A virtual terrestrial laser scanner: a building in, an E57 file with the truth beside it out."""

from .demo import basin_mesh, demo_scene
from .faults import FAULTS
from .generate import Generated, generate
from .ifc import ifc_scene
from .meshes import mesh_scene
from .scanner import Scanner
from .scene import Scene
from .simulation import Parameters, simulate
from .solids import write_obj
from .stations import Setup

__all__ = [
    "FAULTS",
    "Generated",
    "Parameters",
    "Scanner",
    "Scene",
    "Setup",
    "basin_mesh",
    "demo_scene",
    "generate",
    "ifc_scene",
    "mesh_scene",
    "simulate",
    "write_obj",
]
