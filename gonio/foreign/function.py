"""A function of foreign code, called with arrays of directions and parameters."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from gonio.fields import Parameter
from gonio.foreign.declarations import Function
from gonio.foreign.expressions import Array, parse
from gonio.foreign.library import is_library
from gonio.foreign.materialx import is_materialx
from gonio.foreign.process import Running
from gonio.foreign.python_code import is_python
from gonio.foreign.roles import DIRECTIONS, Matched, environment
from gonio.foreign.source import ENDINGS, ForeignError, Source

# The least cosine that values with a cosine are divided by.
COSINE_MIN = 1e-12


@dataclass(frozen=True)
class Returns:
    """What foreign code gives back: factor · f · cos(theta_i)^cosine."""

    factor: float = 1.0
    cosine: int = 0
    told: bool = False
    """Whether the user has said so; else it is measured, or assumed."""

    def __str__(self) -> str:
        """Such as "pi f cos"."""
        name = {1.0: "", float(np.pi): "pi ", float(1 / np.pi): "f / pi"}.get(
            self.factor, f"{self.factor:.4g} "
        )
        text = name if name.startswith("f") else f"{name}f"
        return text + (" cos(theta_i)" if self.cosine else "")


class Valued(Protocol):
    """What can be identified: code, or what is left of it without some of its terms."""

    @property
    def returns(self) -> Returns:
        """The factor and the cosine of what it gives back."""
        ...

    @property
    def parameters(self) -> dict[str, Parameter]:
        """By name."""
        ...

    def raw(self, wi: Array, wo: Array, values: dict[str, Any] | None = None) -> Array:
        """What the code gives back, (n, 3)."""
        ...


RETURNS = {
    "f": Returns(1.0, 0, True),
    "f cos": Returns(1.0, 1, True),
    "pi f": Returns(float(np.pi), 0, True),
    "pi f cos": Returns(float(np.pi), 1, True),
}


def parse_returns(text: str) -> Returns:
    """What --returns says.

    Raises:
        ForeignError: something else than RETURNS.
    """
    key = " ".join(text.replace("*", " ").replace("·", " ").replace("π", "pi").lower().split())
    if key not in RETURNS:
        raise ForeignError(
            f"--returns {text!r} is not known; say one of {', '.join(map(repr, RETURNS))}."
        )
    return RETURNS[key]


# What would be taken for the name of a parameter.
NO_NUMBERS = {"nan", "inf", "infinity"}


def parse_map(texts: Iterable[str], option: str = "--map") -> dict[str, str]:
    """What --map says: "L=wi V=wo roughness=roughness^2", separated by spaces.

    Raises:
        ForeignError: something that is not NAME=FORMULA, or a name twice.
    """
    found: dict[str, str] = {}
    for text in texts:
        pieces = re.findall(
            r"([\w.]+)\s*=\s*((?:\([^()]*(?:\([^()]*\)[^()]*)*\)|[^\s=()]|\s*[-+*/^]\s*)+)", text
        )
        left = text
        for name, value in pieces:
            if name in found:
                raise ForeignError(f"{option} has {name} twice.")
            if value.strip("+-, ").lower() in NO_NUMBERS:
                raise ForeignError(f"{option} {name}={value} is no number; give a finite one.")
            found[name] = value.strip().rstrip(",")
            left = left.replace(name, "", 1).replace(value, "", 1)
        if not pieces or re.sub(r"[\s=,]", "", left):
            what = 'NAME=FORMULA; write "L=wi V=wo alpha=roughness^2"'
            if option == "--uniform":
                what = "NAME=NUMBER, such as anisotropy=0 or tint=(1, 0.5, 0)"
            raise ForeignError(f"{option} {text!r} is not {what}.")
    return found


def parse_uniforms(texts: Iterable[str]) -> dict[str, str]:
    """What --uniform says: "anisotropy=0", or "tint=(1, 0.5, 0)".

    Raises:
        ForeignError: something else, or a name twice.
    """
    found = parse_map(texts, "--uniform")
    for name, text in found.items():
        formula = parse(text)
        with np.errstate(all="ignore"):
            fixed = not formula.names and np.isfinite(formula.value({})).all()
        if not fixed:
            raise ForeignError(
                f"--uniform {name}={text} is not a finite number, or some as in (1, 0.5, 0); "
                f'--map "{name}={text}" sets it by a formula.'
            )
    return found


def parse_ranges(texts: Iterable[str]) -> dict[str, tuple[float, float]]:
    """What --range says: "roughness=0.01..1".

    Raises:
        ForeignError: something else.
    """
    found = {}
    for text in texts:
        match_ = re.fullmatch(r"\s*([\w.]+)\s*=\s*(\S+?)\.\.(\S+)\s*", text)
        try:
            if match_ is None:
                raise ValueError
            low, high = float(match_[2]), float(match_[3])
            if not low < high or not np.isfinite([low, high]).all():
                raise ValueError
        except ValueError:
            raise ForeignError(
                f"--range {text!r} is not NAME=LOW..HIGH, such as roughness=0.01..1."
            ) from None
        found[match_[1]] = (low, high)
    return found


@dataclass
class Foreign:
    """Foreign code that is ready to be called. `gonio.foreign.load` makes one."""

    source: Source
    function: Function
    matched: Matched
    running: Running
    returns: Returns = field(default_factory=Returns)
    label: str = ""
    """How it is called on the command line."""
    alias: str = ""
    """A name in place of its own, where that would be another's as well."""
    shipped: Foreign | None = None
    """The same with the half precision that it declares, if this one was made without."""
    textures: Mapping[str, str] = field(default_factory=dict)
    """Textures of its file that were not given, and a word for what they are taken for."""
    sampler: Foreign | None = None
    """What draws directions, with the densities that `density` has."""
    density: Foreign | None = None
    reflectance: Foreign | None = None
    """The directional albedo as the code has it."""

    @property
    def name(self) -> str:
        """File and function, such as "ggx.glsl#D" or "lobes.cpp#Ggx.eval"."""
        if self.alias:
            return self.alias
        if self.source.entry:
            return self.source.path.name
        owner = f"{self.function.owner}." if self.function.owner else ""
        return f"{self.source.path.name}#{owner}{self.function.name}"

    @property
    def parameters(self) -> dict[str, Parameter]:
        """Its parameters, by name."""
        return self.matched.parameters

    def defaults(self) -> dict[str, Any]:
        """Their default values."""
        return {name: p.default for name, p in self.parameters.items()}

    def renamed(self, old: str, new: str) -> Foreign:
        """The same code with another name for one of its parameters."""
        matched = replace(
            self.matched,
            leaves=tuple(
                (leaf, parse(re.sub(rf"\b{re.escape(old)}\b", new, expression.text)))
                for leaf, expression in self.matched.leaves
            ),
            parameters={(new if n == old else n): p for n, p in self.parameters.items()},
        )
        return replace(self, matched=matched)

    def rows(
        self,
        wi: Array,
        wo: Array,
        values: Mapping[str, Any],
        turn: Array | None = None,
        random: Array | None = None,
    ) -> NDArray[np.float32]:
        """The numbers that the code is given, (n, columns).

        Args:
            wi: towards the light, (n, 3).
            wo: towards the viewer.
            values: of parameters.
            turn: turns all directions, (3, 3).
            random: numbers of samples, (n, 2).
        """
        n = len(wi)
        given: dict[str, Any] = dict(environment(wi, wo))
        # Code has base_rho where a model has base.rho
        values = {name.replace(".", "_"): value for name, value in values.items()} | dict(values)
        if random is not None:
            # A third number that has nothing to do with the two
            third = np.modf(np.abs(np.sin(random @ [12.9898, 78.233])) * 43758.5453)[0]
            given |= {"u1": random[:, 0], "u2": random[:, 1], "u3": third}
        if turn is not None:
            given |= {name: given[name] @ turn.T for name in DIRECTIONS}
        for name, parameter in self.parameters.items():
            value = np.asarray(values.get(name, parameter.default), np.float64)
            if parameter.width == 3:
                given[name] = np.broadcast_to(
                    value[..., None] if value.ndim == 1 and value.shape != (3,) else value, (n, 3)
                )
            else:
                given[name] = np.broadcast_to(value, (n,))
        found = np.empty((n, self.matched.columns), np.float32)
        column = 0
        with np.errstate(all="ignore"):
            for leaf, expression in self.matched.leaves:
                value = np.asarray(expression.value(given), np.float64)
                if leaf.width > 1:
                    value = (
                        value[..., None]
                        if value.ndim == 1 and value.shape != (leaf.width,)
                        else value
                    )
                    if value.shape[-1:] == (3,) and leaf.width == 4:  # colours have an opacity of 1
                        value = np.concatenate([value, np.ones((*value.shape[:-1], 1))], -1)
                    value = np.broadcast_to(value, (n, leaf.width))
                    found[:, column : column + leaf.width] = value
                elif value.ndim > 1:
                    raise ForeignError(
                        f"{self.name}: {leaf.place} is one number, but {expression.text!r} is a vector."
                    )
                else:
                    found[:, column] = np.broadcast_to(value, (n,))
                column += leaf.width
        return found

    def raw(
        self,
        wi: Array,
        wo: Array,
        values: Mapping[str, Any] | None = None,
        turn: Array | None = None,
    ) -> Array:
        """What the code gives back, (n, 3).

        Args:
            wi: towards the light, unit, local frame, (n, 3).
            wo: towards the viewer.
            values: of parameters: numbers, colours, or arrays (n,) or (n, 3); others have their defaults.
            turn: a rotation (3, 3) into a world frame, for code that is given the normal.

        Raises:
            ForeignError: it does not come back, or crashes.
        """
        made = self.running.call(self.rows(wi, wo, values or {}, turn))
        return made[:, :3].astype(np.float64)

    def samples(
        self, wo: Array, random: Array, values: Mapping[str, Any] | None = None
    ) -> tuple[Array, Array]:
        """Directions (n, 3) and densities (n,) of a function that samples; below 0 if it has none."""
        up = np.tile([0.0, 0.0, 1.0], (len(wo), 1))
        made = self.running.call(self.rows(up, wo, values or {}, None, random)).astype(np.float64)
        return made[:, :3], np.where(np.isnan(made[:, 3]), -1.0, made[:, 3])

    def brdf(
        self,
        wi: Array,
        wo: Array,
        values: Mapping[str, Any] | None = None,
        turn: Array | None = None,
    ) -> Array:
        """The BRDF in 1/sr without the cosine, (n, 3); 0 below the horizon. Arguments as of `raw`."""
        above = (wi[:, 2] > 0) & (wo[:, 2] > 0)
        found = np.zeros((len(wi), 3))
        if not above.any():
            return found
        chosen = picked(values or {}, above)
        f = self.raw(wi[above], wo[above], chosen, turn) / self.returns.factor
        if self.returns.cosine:
            f = f / np.maximum(wi[above, 2:], COSINE_MIN)
        found[above] = f
        return found


def picked(values: Mapping[str, Any], rows: NDArray[np.bool_]) -> dict[str, Any]:
    """Values of some rows; numbers and colours that are the same for all stay as they are."""
    return {
        name: np.asarray(v)[rows]
        if np.ndim(v) and len(np.asarray(v)) == len(rows) and np.shape(v) != (3,)
        else v
        for name, v in values.items()
    }


def split(text: str) -> tuple[str, str | None]:
    """File and function of FILE#FUNCTION."""
    file, sign, function = text.rpartition("#")
    return (file, function or None) if sign else (text, None)


def is_foreign(text: str) -> bool:
    """Whether a text names foreign code: a file of one of its languages, with #FUNCTION or without."""
    known = Path(split(text)[0]).suffix.lstrip(".").lower() in ENDINGS
    return known or is_materialx(text) or is_library(text) or is_python(text)


def probe(count: int, seed: int = 0) -> tuple[Array, Array]:
    """Random pairs of directions above the horizon, half of them near the mirror direction."""
    rng = np.random.default_rng(seed)
    pairs = []
    for _ in range(2):
        z = rng.uniform(0.05, 1, count)
        phi = rng.uniform(0, 2 * np.pi, count)
        s = np.sqrt(1 - z * z)
        pairs.append(np.stack([s * np.cos(phi), s * np.sin(phi), z], -1))
    wi, wo = pairs
    near = wo * np.array([-1.0, -1.0, 1.0]) + 0.2 * wi
    near /= np.linalg.norm(near, axis=1, keepdims=True)
    wi = np.where((np.arange(count) % 2 == 0)[:, None], near, wi)
    return wi, wo
