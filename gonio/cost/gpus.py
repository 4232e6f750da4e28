"""GPUs whose machine code can be made without having one, by the names of their chips."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gonio.messages import did_you_mean


class CostError(ValueError):
    """What cannot be measured, in one line that says why and what to do."""


@dataclass(frozen=True)
class Gpu:
    """A GPU for which code is compiled."""

    name: str
    """As the compiler knows it, such as "navi21" or "sm_86"."""
    vendor: str
    """ "amd" or "nvidia"."""
    products: str
    """Where it is found, for people."""
    older: str = ""
    """What compilers call it that are older than its name."""


GPUS = {
    gpu.name: gpu
    for gpu in (
        Gpu("tahiti", "amd", "Radeon HD 7970, 2012"),
        Gpu("polaris10", "amd", "Radeon RX 480, 2016"),
        Gpu("vega10", "amd", "Radeon RX Vega 64, 2017"),
        Gpu("navi10", "amd", "Radeon RX 5700 XT, 2019"),
        Gpu("navi21", "amd", "Radeon RX 6800 XT, 2020"),
        Gpu("navi31", "amd", "Radeon RX 7900 XTX, 2022", "gfx1100"),
        Gpu("sm_75", "nvidia", "GeForce RTX 20, 2018"),
        Gpu("sm_86", "nvidia", "GeForce RTX 30, 2020"),
        Gpu("sm_89", "nvidia", "GeForce RTX 40, 2022"),
        Gpu("sm_90", "nvidia", "H100, 2022"),
        Gpu("sm_120", "nvidia", "GeForce RTX 50, 2025"),
    )
}

USUAL = ("navi21", "sm_86")
"""What is measured when nothing is named."""


def chosen(names: Sequence[str]) -> list[Gpu]:
    """GPUs by name, each once; "all" is all of them, nothing the usual ones.

    Raises:
        CostError: a name that is not known.
    """
    wanted = [part.strip() for name in names for part in name.split(",")]
    if "all" in wanted:
        return list(GPUS.values())
    for name in wanted:
        if name not in GPUS:
            raise CostError(
                f"no GPU {name!r}; {did_you_mean(name, GPUS)}known are {', '.join(GPUS)}, all."
            )
    return [GPUS[name] for name in dict.fromkeys(wanted or USUAL)]
