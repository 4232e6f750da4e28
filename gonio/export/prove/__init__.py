"""Proof that exports compute what their models do: `prove` compiles, runs and compares them."""

from gonio.export.prove.proof import ROWS, Proof, describe, prove, table
from gonio.export.prove.runners import each_way
from gonio.export.prove.tools import ProofError

__all__ = ["ROWS", "Proof", "ProofError", "describe", "each_way", "prove", "table"]
