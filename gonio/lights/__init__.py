"""Lights for shaders: one file each, written in the language of models and exported with them.

A light is a function of a model that gives the radiance towards the viewer. Its file has its name; this
folder is the list. `gonio.lights.catalogue.lights` finds them, `gonio export MODEL --lit` exports them.
"""
