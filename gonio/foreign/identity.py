"""What code is, in a sentence: as a product of known terms, else as a model of the registry."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from gonio.check.report import NOTE, Finding, Report
from gonio.foreign import registry, sums, terms
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

    @property
    def exact(self) -> bool:
        """Whether one of them is equal but for roundings."""
        return (
            any(p.exact for p in self.products[:1])
            or any(m.exact for m in self.models[:1])
            or self.sum is not None
        )

    def lines(self) -> list[str]:
        """For people: the nearest first."""
        found: list[str] = []
        product = self.products[0] if self.products else None
        if product is not None and product.exact:
            found.append(f"{self.code} is: {product} (equal to {product.worst:.1g})")
            found += _remarks(product)
        elif self.sum is not None:
            at = "".join(f"{name} = {value:g}, " for name, value in self.sum.pinned.items())
            found.append(f"{self.code} is, {'at ' if at else ''}{at}a sum:")
            for k, (name, part) in enumerate(self.sum.parts, 1):
                by = f", by {name}" if name and name not in str(part) else ""
                found.append(f"  {k}{by}. {part} (equal to {part.worst:.1g})")
                found += [f"  {line}" for line in _remarks(part)]
        exact = any(m.exact for m in self.models[:1])
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
        if product is not None and not product.exact and product.misfit < FAR and self.sum is None:
            found.append(
                f"  as a product, nearest is: {product} (off by up to {product.worst:.2g})"
            )
            found += _remarks(product)
        return found or [f"{self.code} is like nothing that gonio knows"]

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
                {"by": name, "terms": list(p.terms), "constant": p.constant, "unusual": list(p.odd)}
                for name, p in (self.sum.parts if self.sum is not None else ())
            ],
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
        if self.sum is not None:
            misfit = max(p.misfit for _, p in self.sum.parts)
        elif self.models and not (first is not None and first.exact):
            misfit = self.models[0].misfit
        return Report(
            "identity",
            name,
            (Finding("nearest", misfit, NOTE, "; ".join(x.strip() for x in self.lines())),),
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
    products = terms.identify(foreign)
    label = foreign.label or foreign.name
    known = bool(products and products[0].exact)
    if not (known or thorough) and (same := registry.by_names(foreign, names)):
        return Identity(label, tuple(products), (same,))
    apart = None if known else sums.identify(foreign)
    found: list[registry.Found] = []
    if thorough or not (known or apart):
        found = registry.identify(foreign, names, thorough=thorough, progress=progress)
    return Identity(label, tuple(products), tuple(found), apart)
