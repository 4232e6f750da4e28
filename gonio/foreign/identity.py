"""What code is, in a sentence: as a product of known terms, else as a model of the registry."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from gonio.check.report import NOTE, Finding, Report
from gonio.foreign import partly, registry, sums, terms, widths
from gonio.foreign.function import Foreign

Progress = Callable[[int, int], None]

# Products and models that are farther away than this are no answer.
FAR = 0.2


@dataclass(frozen=True)
class Identity:
    """What code is, as far as can be told."""

    code: str
    products: tuple[terms.Product, ...]
    models: tuple[registry.Found, ...]
    sum: sums.Sum | None = None
    """Products that the code is the sum of."""
    partly: partly.Partly | None = None
    """The code, or the last part of the sum, but for one unknown term."""

    @property
    def exact(self) -> bool:
        """Whether one of them is equal but for roundings."""
        return (
            any(p.exact for p in self.products[:1])
            or any(m.exact for m in self.models[:1])
            or (self.sum is not None and self.sum.exact)
        )

    def lines(self) -> list[str]:
        """For people: the nearest first."""
        found: list[str] = []
        product = self.products[0] if self.products else None
        if product is not None and product.exact:
            found.append(f"{self.code} is: {product} (equal to {product.worst:.1g})")
            found += _remarks(product)
        exact = any(m.exact for m in self.models[:1])
        if not found and self.sum is not None and (self.sum.exact or not exact):
            found += self._summed(self.sum)
        if not found and self.partly is not None and not exact:
            found.append(f"{self.code} is {self.partly}")
        near = [m for m in self.models if m.misfit < FAR]
        if self.models and not near and not found:
            found.append(
                f"{self.code} is like nothing that gonio knows; the nearest, {self.models[0].model.name}, "
                f"is {self.models[0].misfit:.2g} away"
            )
        for k, model in enumerate(near):
            state = (
                "is" if model.exact else "is no model of gonio's; nearest is" if k == 0 else "or"
            )
            # What is not the model has numbers that mean nothing
            text = str(model) if exact else model.named
            found.append(f"{self.code} {state} {text} (misfit {model.misfit:.2g})")
            if model.exact:
                break
        if (
            product is not None
            and not product.exact
            and product.misfit < FAR
            and self.sum is None
            and self.partly is None
        ):
            found.append(
                f"  as a product, nearest is: {product} (off by up to {product.worst:.2g})"
            )
            found += _remarks(product)
        return found or [f"{self.code} is like nothing that gonio knows"]

    def _summed(self, parts: sums.Sum) -> list[str]:
        """The parts of a sum, one line each."""
        at = "".join(f"{name} = {value:g}, " for name, value in parts.pinned.items())
        last = "" if parts.exact else ", one part of which is not known"
        found = [f"{self.code} is, {'at ' if at else ''}{at}a sum{last}:"]
        for k, (name, part) in enumerate(parts.parts, 1):
            by = f", by {name}" if name and name not in str(part) else ""
            if part.exact:
                found.append(f"  {k}{by}. {part} (equal to {part.worst:.1g})")
            elif self.partly is not None:
                found.append(f"  {k}{by}. {self.partly}")
                continue
            elif part.misfit < FAR:
                found.append(f"  {k}{by}. nearest is: {part} (off by up to {part.worst:.2g})")
            else:
                found.append(f"  {k}{by}. like no product that gonio knows")
                continue
            found += [f"  {line}" for line in _remarks(part)]
        return found

    def data(self) -> dict[str, Any]:
        """As plain data that JSON can hold."""
        return {
            "code": self.code,
            "exact": self.exact,
            "products": [
                {
                    "terms": list(p.terms),
                    "constant": p.constant,
                    "misfit": p.misfit,
                    "unusual": list(p.odd),
                }
                for p in self.products
            ],
            "sum": [
                {
                    "by": name,
                    "terms": list(p.terms),
                    "constant": p.constant,
                    "misfit": p.misfit,
                    "unusual": list(p.odd),
                }
                for name, p in (self.sum.parts if self.sum is not None else ())
            ],
            "partly": None
            if self.partly is None
            else {
                "terms": list(self.partly.terms),
                "unknown": self.partly.kind,
                "of": self.partly.of,
                "values": [list(v) for v in self.partly.values],
            },
            "models": [
                {
                    "model": m.model.name,
                    "text": str(m),
                    "returns": m.factor,
                    "misfit": m.misfit,
                    "parameters": m.relations,
                }
                for m in self.models
            ],
        }

    def report(self, name: str) -> Report:
        """As a report of `gonio check`."""
        first = self.products[0] if self.products else None
        misfit = first.misfit if first is not None and first.exact else float("nan")
        if self.sum is not None and self.sum.exact:
            misfit = max(p.misfit for _, p in self.sum.parts)
        elif self.models and not (first is not None and first.exact):
            misfit = self.models[0].misfit
        return Report(
            "identity",
            name,
            (
                Finding(
                    "nearest",
                    misfit,
                    NOTE,
                    "; ".join(x.strip() for x in self.lines()).replace(":; ", ": "),
                ),
            ),
        )


def _remarks(product: terms.Product) -> list[str]:
    return [f"  unusual, and mostly a mistake: {odd}" for odd in product.odd] + [
        f"  note: {remark}" for remark in product.remarks
    ]


def identify(
    foreign: Foreign,
    names: Iterable[str] = (),
    *,
    thorough: bool = False,
    progress: Progress | None = None,
) -> Identity:
    """Find out what code is.

    Args:
        foreign: a function that is running.
        names: of models to try; all if empty.
        thorough: try models with all options, and even if the code is a product of known terms.
        progress: called with what is done and what there is to do.
    """
    products = widths.identify(foreign)
    label = foreign.label or foreign.name
    known = bool(products and products[0].exact)
    if not (known or thorough) and (same := registry.by_names(foreign, names)):
        return Identity(label, tuple(products), (same,))
    apart = None if known else sums.identify(foreign)
    exact = known or (apart is not None and apart.exact)
    but_one = None if exact else partly.identify(foreign if apart is None else apart.last)
    found: list[registry.Found] = []
    if thorough or not exact:
        known = but_one is not None and not thorough
        found = registry.identify(
            foreign, names, thorough=thorough, partly=known, progress=progress
        )
    return Identity(label, tuple(products), tuple(found), apart, but_one)
