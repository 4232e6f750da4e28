"""Makes the exports in tests/golden, and the one inside examples/webgpu.html, again: `make golden`.

They are there to be read when a change is reviewed; a test compares them with fresh ones.
"""

from __future__ import annotations

import re
from pathlib import Path

import gonio
from gonio.export.files import texts
from gonio.export.targets import TARGETS

ROOT = Path(__file__).parents[1]
GOLDEN = ROOT / "tests" / "golden"
EXAMPLE = ROOT / "examples" / "webgpu.html"

# CUDA is the C++ text with qualifiers.
LANGUAGES = [name for name in TARGETS if name != "cuda"]


def exports() -> dict[str, str]:
    """The text of every model in every language, by file name."""
    models = {name: gonio.model(name) for name in gonio.models()}
    return texts(models, LANGUAGES, together=False)


def with_export(page: str, text: str) -> str:
    """The example page with another export between its marks."""
    begin, end = "// ---- begin of the export\n", "// ---- end of the export"
    return re.sub(rf"({begin}).*?({end})", lambda m: m[1] + text + m[2], page, flags=re.S)


def main() -> None:
    """Write what has changed, and remove the files of models that are gone."""
    made = exports()
    GOLDEN.mkdir(exist_ok=True)
    for path in GOLDEN.iterdir():
        if path.name not in made:
            path.unlink()
    for name, text in made.items():
        (GOLDEN / name).write_text(text, encoding="utf-8")
    page = EXAMPLE.read_text(encoding="utf-8")
    EXAMPLE.write_text(with_export(page, made["eon.wgsl"]), encoding="utf-8")
    print(f"{len(made)} exports in {GOLDEN.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
