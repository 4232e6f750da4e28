"""What one figure, table, equation or number of a text states, beside what gonio computes."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, field


class Verdict(enum.Enum):
    """What became of an item; `Sheet.verdict` computes it from the lines."""

    AGREES = "agrees"
    TEXT_WRONG = "text wrong"
    SHOWN = "shown"
    NOT_COMPARABLE = "cannot be compared"
    DIFFERS = "gonio differs"


RELATIONS = ("=", "<=", ">=")


@dataclass(frozen=True)
class Line:
    """One number: the text's, ours, and what follows from the two."""

    what: str
    text: str
    """As the text prints it; empty if it has no number."""
    relation: str
    """What the text says about it: one of `RELATIONS`, or empty."""
    stated: float
    """The text's number; NaN if it has none."""
    ours: float
    within: float
    """Largest difference at which "=" holds."""
    proof: float | None
    """The right number, computed without gonio's models, where the text's is wrong."""
    why: str

    @property
    def difference(self) -> float:
        """Ours minus the text's."""
        return self.ours - self.stated

    @property
    def text_holds(self) -> bool:
        """Whether ours is as the text says."""
        return _holds(self.relation, self.ours, self.stated, self.within)

    @property
    def state(self) -> str:
        """ "holds", "text wrong", "fails", or "" for a number that is only shown."""
        if not self.relation:
            return ""
        if self.proof is None:
            return "holds" if self.text_holds else "fails"
        proven = abs(self.ours - self.proof) <= self.within
        return "text wrong" if proven and not self.text_holds else "fails"


def _holds(relation: str, ours: float, stated: float, within: float) -> bool:
    # A comparison with NaN is false, so that a model gone wrong never agrees.
    if relation == "<=":
        return ours <= stated
    if relation == ">=":
        return ours >= stated
    return abs(ours - stated) <= within


def printed(text: float | str) -> tuple[str, float]:
    """A number as a text prints it, and half a unit of its last digit."""
    if not isinstance(text, str):
        return f"{text:.6g}", 0.0
    digits = text.lower().partition("e")[0]
    decimals = len(digits.partition(".")[2])
    exponent = int(text.lower().partition("e")[2] or 0)
    return text, 0.5 * 10.0 ** (exponent - decimals)


@dataclass
class Sheet:
    """The lines of one item, filled by its function."""

    lines: list[Line] = field(default_factory=list)
    reasons: list[str] = field(default_factory=list)
    """Remarks on how something was compared or shown."""
    lacks: list[str] = field(default_factory=list)
    """What the text compares with and nobody here has: a console, a table that is lost."""

    def claim(
        self,
        what: str,
        relation: str,
        text: float | str,
        ours: float,
        *,
        within: float | None = None,
        why: str = "",
    ) -> None:
        """The text says that a number is equal to, at most or at least another.

        Args:
            what: the number's name.
            relation: "=", "<=" or ">=".
            text: the text's number; as a string, with the digits that it prints.
            ours: what gonio computes.
            within: the difference allowed for "="; by default half a unit of the last printed digit.
            why: the reason for that, or a remark.
        """
        self._add(what, relation, text, ours, within, None, why)

    def refute(
        self,
        what: str,
        relation: str,
        text: float | str,
        ours: float,
        *,
        proof: float,
        within: float,
        why: str,
    ) -> None:
        """As `claim`, where the text is wrong: `proof` is the right number, computed independently.

        The line says "text wrong" only while ours is `within` of the proof and not as the text says.
        """
        self._add(what, relation, text, ours, within, proof, why)

    def show(self, what: str, ours: float, why: str = "") -> None:
        """A number of which the text says nothing."""
        self.lines.append(Line(what, "", "", math.nan, float(ours), 0.0, None, why))

    def remark(self, text: str) -> None:
        """How something was compared or shown."""
        self.reasons.append(text)

    def lack(self, text: str) -> None:
        """What cannot be had, so that the text's numbers have nothing to stand beside."""
        self.lacks.append(text)

    def notes(self) -> list[str]:
        """What is lacking, the remarks, and the reasons of the lines, each of them once."""
        named: dict[str, list[str]] = {}
        for line in self.lines:
            if line.why:
                named.setdefault(line.why, []).append(line.what)
        whys = [f"{whats[0]}: {why}" if len(whats) == 1 else why for why, whats in named.items()]
        return [*self.lacks, *self.reasons, *whys]

    def _add(
        self,
        what: str,
        relation: str,
        text: float | str,
        ours: float,
        within: float | None,
        proof: float | None,
        why: str,
    ) -> None:
        if relation not in RELATIONS:
            raise ValueError(f"no relation {relation!r}; known are {', '.join(RELATIONS)}.")
        number, half_digit = printed(text)
        allowed = half_digit if within is None else within
        # Half a digit itself is a decimal fraction that binary numbers miss by their rounding.
        allowed *= 1 + 1e-9
        self.lines.append(
            Line(what, number, relation, float(text), float(ours), allowed, proof, why)
        )

    @property
    def verdict(self) -> Verdict:
        """Computed from the lines: one failing line is enough for `DIFFERS`.

        Without a claim it is `NOT_COMPARABLE` if something is lacking, else `SHOWN`.
        """
        states = {line.state for line in self.lines} - {""}
        if "fails" in states:
            return Verdict.DIFFERS
        if "text wrong" in states:
            return Verdict.TEXT_WRONG
        if states:
            return Verdict.AGREES
        return Verdict.NOT_COMPARABLE if self.lacks else Verdict.SHOWN
