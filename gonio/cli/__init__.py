"""The command line: one file per command, each a few lines around a function that Python can call.

A file of this folder that defines `command` is a command, under the file's name. It loads when it is asked
for, so that `gonio list` starts quickly.
"""

from gonio.cli.program import main

__all__ = ["main"]
