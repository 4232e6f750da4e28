"""The pictures' stage: a shader ball built by code, its lights, and the user's own mesh or sky.

Everything here returns what `mitsuba.load_dict` takes. Axes: +y is up, the camera looks along -z
from the front, the ground is y = 0, lengths are in radii of the shader ball (it has radius 1).
Radiance is scaled so that a white diffuse surface facing the key light comes out just below 1.
"""

from gonio.scene.ball import (
    BALL_CENTRE,
    BEVEL,
    CORE_RADIUS,
    SHELL_INSIDE,
    pedestal,
    shell,
    sphere,
)
from gonio.scene.light import ENVIRONMENTS, HALF_MAX, IMAGE_FORMATS, environment_nodes
from gonio.scene.stage import MAX_PIXELS, TESTED, shader_ball
from gonio.scene.triangles import Triangles, lathe
from gonio.scene.user_mesh import MESH_FORMATS, MESH_RADIUS, load_mesh, on_stage, with_normals

__all__ = [
    "BALL_CENTRE",
    "BEVEL",
    "CORE_RADIUS",
    "ENVIRONMENTS",
    "HALF_MAX",
    "IMAGE_FORMATS",
    "MAX_PIXELS",
    "MESH_FORMATS",
    "MESH_RADIUS",
    "SHELL_INSIDE",
    "TESTED",
    "Triangles",
    "environment_nodes",
    "lathe",
    "load_mesh",
    "on_stage",
    "pedestal",
    "shader_ball",
    "shell",
    "sphere",
    "with_normals",
]
