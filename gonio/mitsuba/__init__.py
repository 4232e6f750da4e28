"""Every model as a Mitsuba 3 BSDF: importing this package registers `gonio_<name>`.

    import gonio.mitsuba          # before `import mitsuba`, so that a usable LLVM is found
    import mitsuba as mi
    mi.set_variant("llvm_ad_rgb")
    bsdf = mi.load_dict({"type": "gonio_eon", "roughness": 1.0})

Each parameter takes a number, an RGB colour, a spectrum or a texture, under the name it has in gonio;
options take their names. `mi.traverse` shows the parameters, and they are differentiable. The models
are one-sided, like Mitsuba's own `diffuse`: wrap them into `twosided` where backs are seen. What
textures hold is limited to the allowed range; a number outside it is an error.

`gonio_material` is a ready material or a material file by its name (see `gonio.mitsuba.named`), and models
with an index and an extinction take a metal by its name: `<string name="metal" value="Cu"/>`.

`gonio.mitsuba.node` makes the dict of a model, a material or a stack of layers. Only this package knows
Mitsuba's conventions: its `si.wi` is the viewer's, and its values hold the cosine.
"""

import os
import warnings

import mitsuba

from gonio.mitsuba import named
from gonio.mitsuba.nodes import node
from gonio.mitsuba.register import llvm_problem, register

__all__ = ["node", "register"]


def _register() -> None:
    register()
    named.register()


_register()
if "DRJIT_LIBLLVM_PATH" not in os.environ and (_problem := llvm_problem()):
    # gonio came too late to choose; the error that Mitsuba may raise does not say what helps.
    warnings.warn(_problem, stacklevel=2)
mitsuba.detail.add_variant_callback(lambda old, new: _register())
