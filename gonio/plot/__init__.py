"""Pictures and tables of models: lobes, albedos, and how well they are sampled.

    from gonio import plot
    plot.plot([gonio.Lambert(), gonio.EON(roughness=1)], "polar", "lobes.svg")
    plot.polar([gonio.EON(roughness=r) for r in (0, 0.5, 1)]).figure()      # a matplotlib Figure
    plot.albedo([gonio.EON(), gonio.QON()]).columns                         # the numbers

Angles are in degrees. Each kind of plot is a function that takes models and returns a `Plot`.
matplotlib loads when one is drawn; pyplot and its figures are not touched.
"""

from gonio.plot.cartesian import cartesian, scattering
from gonio.plot.errors import error
from gonio.plot.kinds import KINDS, albedo, plot, polar, surface
from gonio.plot.numbers import CHANNELS, RGB
from gonio.plot.output import SUFFIXES, Plot, check_output
from gonio.plot.panels import DEGREES, SIGNED, Curve, Panel, of_panels
from gonio.plot.sampling import sampling
from gonio.plot.terms import distribution, facet_terms, fresnel, masking, reflectances

__all__ = [
    "CHANNELS",
    "DEGREES",
    "KINDS",
    "RGB",
    "SIGNED",
    "SUFFIXES",
    "Curve",
    "Panel",
    "Plot",
    "albedo",
    "cartesian",
    "check_output",
    "distribution",
    "error",
    "facet_terms",
    "fresnel",
    "masking",
    "of_panels",
    "plot",
    "polar",
    "reflectances",
    "sampling",
    "scattering",
    "surface",
]
