"""Named dielectrics and their index of refraction at the sodium line (589.3 nm, 20 degrees Celsius).

Source: "CRC Handbook of Chemistry and Physics", 95th edition, 2014, sections 4 and 10; of glasses and
plastics the data sheets of their makers.
"""

from __future__ import annotations

from gonio.messages import did_you_mean

# n_D; of crystals with two indices the ordinary one.
INDICES = {
    "vacuum": 1.0,
    "air": 1.000277,
    "ice": 1.309,
    "water": 1.333,
    "ethanol": 1.3611,
    "fused_silica": 1.4585,
    "glycerol": 1.4746,
    "acrylic": 1.4914,
    "linseed_oil": 1.4795,
    "crown_glass": 1.5168,
    "salt": 1.5443,
    "quartz": 1.5442,
    "amber": 1.54,
    "pet": 1.575,
    "polycarbonate": 1.585,
    "polystyrene": 1.5905,
    "flint_glass": 1.6200,
    "calcite": 1.6584,
    "sapphire": 1.7682,
    "zircon": 1.925,
    "diamond": 2.4175,
}


def dielectric(name: str) -> float:
    """Index of a named dielectric over that of vacuum.

    Raises:
        ValueError: an unknown name.
    """
    key = name.strip().lower().replace(" ", "_").replace("-", "_")
    if key not in INDICES:
        did = did_you_mean(key, INDICES)
        raise ValueError(f"no dielectric {name!r}; {did}known are {', '.join(INDICES)}.")
    return INDICES[key]
