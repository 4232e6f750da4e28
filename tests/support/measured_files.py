"""Small files of every measured format, written by hand from the formats' descriptions."""

from __future__ import annotations

import struct

import numpy as np

COSINES = np.cos(np.radians([10, 40, 70]))


def merl(shape: tuple[int, int, int] = (6, 5, 8)) -> bytes:
    values = np.linspace(0.1, 5, 3 * int(np.prod(shape)))
    values[7] = -1
    return struct.pack("<3i", *shape) + values.astype("<f8").tobytes()


def rgl(phis: int = 1) -> bytes:
    """A tensor file of constant facets and growing values."""
    n_t, side = 3, 4
    phi = np.linspace(-np.pi, np.pi, phis) if phis > 1 else np.zeros(1)
    fields = {
        "description": np.frombuffer(b"a test", np.uint8),
        "jacobian": np.ones(1, np.uint8),
        "phi_i": phi.astype("<f4"),
        "theta_i": np.array([0, 0.7, 1.4], "<f4"),
        "ndf": np.ones((side, side), "<f4"),
        "sigma": np.ones((side, side), "<f4"),
        "vndf": np.ones((phis, n_t, side, side), "<f4"),
        "luminance": np.ones((phis, n_t, side, side), "<f4"),
        "rgb": np.linspace(0.1, 1, phis * n_t * 3 * side * side, dtype="<f4").reshape(
            phis, n_t, 3, side, side
        ),
    }
    kinds = {"|u1": 1, "<f4": 10}
    head = 12 + 6 + sum(2 + len(n) + 11 + 8 * f.ndim for n, f in fields.items())
    text, body = b"tensor_file\0" + struct.pack("<BBI", 1, 0, len(fields)), b""
    for name, field in fields.items():
        text += struct.pack("<H", len(name)) + name.encode()
        text += struct.pack("<HBQ", field.ndim, kinds[field.dtype.str], head + len(body))
        text += struct.pack(f"<{field.ndim}Q", *field.shape)
        body += field.tobytes()
    return text + body


def mbsdf() -> bytes:
    numbers = np.arange(2 * 2 * 3 * 3, dtype="<f4").tobytes()
    grey = np.arange(12, dtype="<f4").tobytes()
    return (
        b'NVIDIA ARC MBSDF V1\nmanufacturer="somebody"\nMBSDF_DATA_REFLECTION=\n'
        + struct.pack("<3I", 1, 2, 3)
        + numbers
        + b"\nMBSDF_DATA_TRANSMISSION=\n"
        + struct.pack("<3I", 0, 2, 3)
        + grey
    )


ZEMAX = b"""# Sample: a plate
Source  Measured
Symmetry  PlaneSymmetrical
SpectralContent  Monochrome
ScatterType  BRDF
SampleRotation  1
0
AngleOfIncidence  2
0 30
ScatterAzimuth  3
0 90 180
ScatterRadial  2
0 40

Monochrome
DataBegin
TIS 0.5
0.5 0.1
0.5 0.2
0.5 0.3
TIS 0.6
0.6 0.11
0.6 0.22
0.6 0
DataEnd
"""

ASTM = b"""ASTM E1392
SAMPLE "a tile"
NUM_POINTS 2
VARS theta_i,phi_i,theta_s,phi_s,Red,Green,Blue
0.5,0.0,0.5,3.14159265,0.4,0.3,0.2
0.5,0.0,0.25,1.5707963,0.14,0.13,0.12
"""

PBRT = b"""# three bands
3 450 550 650
0.5 0 0.5 3.14159265 0.4 0.3 0.2
0.5 0 0.25 1.5707963 0.14 0.13 0.12
"""

FRED = b"""type bsdf_data
format angles=deg bsdf=value scale=2
30 0
0 0 0.1
30 0 0.25
30 180 0.05
60 0
60 0 0.75
"""

ALTA = b"""#ALTA_BEGIN_HEADER
#DIM 3 1
#PARAM_IN ISOTROPIC_TV_TL_DPHI
#PARAM_OUT INV_STERADIAN
#VS 1
#ALTA_END_HEADER
0.5 0.25 3.14159265 0.5 0.1
0.2 0.25 1.0 0.25 0.2
"""


def alta_binary() -> bytes:
    rows = np.array([[0.5, 0.25, np.pi, 0.5], [0.2, 0.25, 1.0, 0.25]])
    head = b"#DIM 3 1\n#PARAM_IN ISOTROPIC_TV_TL_DPHI\n#PARAM_OUT INV_STERADIAN\n#VS 0\n"
    head += b"#FORMAT binary\n#VERSION 0\n#PRECISION ieee754-double\n#SAMPLE_COUNT 2\n"
    return (
        head + b"#ENDIAN big\n#BEGIN_STREAM\n" + rows.astype(">f8").tobytes() + b"\n#END_STREAM\n"
    )


def _xml(structure: str, basis: str, data: str, names: str) -> bytes:
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<WindowElement xmlns="http://windows.lbl.gov"><Optical><Layer>
<Material><Name>a blind</Name></Material>
<DataDefinition><IncidentDataStructure>{structure}</IncidentDataStructure>{basis}</DataDefinition>
<WavelengthData><Wavelength unit="Integral">Visible</Wavelength><WavelengthDataBlock>
<WavelengthDataDirection>Reflection Front</WavelengthDataDirection>{names}
<ScatteringDataType>BRDF</ScatteringDataType><ScatteringData>
{data}
</ScatteringData></WavelengthDataBlock></WavelengthData></Layer></Optical></WindowElement>
""".encode()


def klems() -> bytes:
    """Five patches: the pole and a ring of four; in the pole's column 1 to 5, elsewhere 0.1."""
    blocks = "".join(
        f"<AngleBasisBlock><Theta>{t}</Theta><ThetaBounds><LowerTheta>{a}</LowerTheta>"
        f"<UpperTheta>{b}</UpperTheta></ThetaBounds><nPhis>{n}</nPhis></AngleBasisBlock>"
        for t, a, b, n in ((0, 0, 30, 1), (60, 30, 90, 4))
    )
    basis = f"<AngleBasis><AngleBasisName>five</AngleBasisName>{blocks}</AngleBasis>"
    rows = "\n".join(", ".join([str(o + 1)] + ["0.1"] * 4) for o in range(5))
    names = "<ColumnAngleBasis>five</ColumnAngleBasis><RowAngleBasis>five</RowAngleBasis>"
    return _xml("Columns", basis, rows, names)


def tree() -> bytes:
    """An isotropic tree of eight leaves, the fourth of which is cut once more."""
    leaf = "{ 9 8 7 6 5 4 3 2 }"
    leaves = " ".join(leaf if n == 3 else f"{{ {n}.5 }}" for n in range(8))
    return _xml("TensorTree3", "", f"{{ {leaves} }}", "")


CSV = b"""# a sheet
theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,r,g,b
30,0,30,180,0.5,0.4,0.3
30,0,60,90,0.05,0.04,0.03
"""

EXAMPLES: dict[str, bytes] = {
    "merl": merl(),
    "rgl": rgl(),
    "rgl_anisotropic": rgl(5),
    "mbsdf": mbsdf(),
    "zemax": ZEMAX,
    "astm": ASTM,
    "pbrt": PBRT,
    "fred": FRED,
    "alta": ALTA,
    "alta_binary": alta_binary(),
    "bsdf_xml": klems(),
    "bsdf_xml_tree": tree(),
    "csv": CSV,
}
