"""What code is, in a sentence: as a product of known terms, else as a model of the registry."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from gonio.check.report import NOTE, Finding, Report
from gonio.foreign import registry, terms
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

    @property
    def exact(self) -> bool:
        """Whether one of them is equal but for roundings."""
        return any(p.exact for p in self.products[:1]) or any(m.exact for m in self.models[:1])

    def lines(self) -> list[str]:
        """For people: the nearest first."""
        found: list[str] = []
        product = self.products[0] if self.products else None
        if product is not None and product.exact:
            found.append(f"{self.code} is: {product} (equal to {product.worst:.1g})")
            found += [f"  unusual, and mostly a mistake: {odd}" for odd in product.odd]
        for k, model in enumerate(self.models):
            state = "is" if model.exact else "is nearest to" if k == 0 else "or to"
            found.append(f"{self.code} {state} {model} (misfit {model.misfit:.2g})")
            if model.exact:
                break
        if product is not None and not product.exact and product.misfit < FAR:
            found.append(
                f"  as a product, nearest is: {product} (off by up to {product.worst:.2g})"
            )
            found += [f"  unusual, and mostly a mistake: {odd}" for odd in product.odd]
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
        if self.models and not (first is not None and first.exact):
            misfit = self.models[0].misfit
        return Report(
            "identity",
            name,
            (Finding("nearest", misfit, NOTE, "; ".join(x.strip() for x in self.lines())),),
        )


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
    found: list[registry.Found] = []
    if thorough or not (products and products[0].exact):
        found = registry.identify(foreign, names, thorough=thorough, progress=progress)
    return Identity(foreign.label or foreign.name, tuple(products), tuple(found))
