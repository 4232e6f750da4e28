"""Fitting a model's parameters to measured reflection, to another model, or to layers' ground truth.

    from gonio import fit, measured
    found = fit.fit(gonio.model("disney"), measured.load("paint.binary"))
    found.model, found.misfit, found.intervals, found.undetermined, found.regions

Bounded least squares (`scipy.optimize.least_squares`) from several starts; what is linear, as colours are,
is solved inside. All derivatives come from one kernel of Dr.Jit, in double precision. The metric decides
the answer: all three are reported. Intervals are those of a bootstrap over blocks of directions, because
what a model misses is no noise; how much of the misfit is noise is said apart.
"""

from gonio.fit.columns import CHANNELS, Column, columns, has
from gonio.fit.fitting import POINTS, Fit, fit
from gonio.fit.intervals import LEVEL
from gonio.fit.metrics import METRICS
from gonio.fit.misfit import Map, Noise, Region
from gonio.fit.problem import Problem
from gonio.fit.targets import measure

__all__ = [
    "CHANNELS",
    "LEVEL",
    "METRICS",
    "POINTS",
    "Column",
    "Fit",
    "Map",
    "Noise",
    "Problem",
    "Region",
    "columns",
    "fit",
    "has",
    "measure",
]
