"""How Sphinx builds the site; `make docs` assembles the pages and calls it."""

import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from site_pages import docstrings  # noqa: E402

from gonio.version import __version__  # noqa: E402

project = "gonio"
author = copyright = "gonio contributors"
release = __version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx_design",
    "sphinx_copybutton",
]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}

exclude_patterns = ["README.md"]  # its first screen is part of the front page

myst_enable_extensions = ["colon_fence", "attrs_inline"]
myst_heading_anchors = 4
myst_links_external_new_tab = False

autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 88

html_theme = "furo"
html_title = "gonio"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False
pygments_style = "friendly"
pygments_dark_style = "monokai"
smartquotes_action = "qe"  # quotes and dots; two dashes begin an option

copybutton_exclude = ".linenos, .gp, .go"

# Signatures name types such as float32, which are fields of some class as well.
suppress_warnings = ["ref.python"]


def setup(app: object) -> None:
    """Docstrings are plain text."""
    app.connect("autodoc-process-docstring", docstrings.process)  # type: ignore[attr-defined]
