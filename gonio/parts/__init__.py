"""Pieces that several models share; none of them is a model, and none is registered."""
