"""Measured reflection: files of ten formats in one form, judged, converted, and used as models.

    from gonio import measured
    paint = measured.load("paint.binary")           # a Measurement: wi, wo, values, weights, ...
    measured.save("paint.bsdf", paint, "rgl")       # for other people's tools
    measured.save("eon.binary", gonio.model("eon"), "merl")
    measured.as_model("paint.binary").eval(wi, wo)  # a gonio.Model as any other

A format is one file in `gonio/measured/formats`, found by a file's content, not by its name.
"""

from gonio.measured.files import (
    format_for,
    is_data_file,
    is_named_like_data,
    load,
    load_parts,
    recognise,
    save,
    writers,
)
from gonio.measured.formats import formats
from gonio.measured.measurement import (
    DataError,
    Measurement,
    OfModel,
    Reflectance,
    measurement,
    reflectance,
)
from gonio.measured.model import as_model, model_class, source_of
from gonio.measured.source import Source

__all__ = [
    "DataError",
    "Measurement",
    "OfModel",
    "Reflectance",
    "Source",
    "as_model",
    "format_for",
    "formats",
    "is_data_file",
    "is_named_like_data",
    "load",
    "load_parts",
    "measurement",
    "model_class",
    "recognise",
    "reflectance",
    "save",
    "source_of",
    "writers",
]
