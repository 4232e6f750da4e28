"""Who may import whom: one way, without any circle. And that the numbers of tests have their reasons."""

from __future__ import annotations

import ast
import functools
import io
import re
import tokenize
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent / "gonio"

# From the bottom to the top. A room is a folder, or a file beside the folders. It imports from its floor
# and from those below. A new room goes where all that it needs is below.
FLOORS = (
    {
        "version",
        "files",
        "messages",
        "images",
        "notebook",
        "lang",
        "polynomials",
        "backend",
        "claims",
    },
    {"fields", "conversions", "table", "horizon", "class_body"},
    {"parts", "arrays"},
    {"albedos"},
    {"model"},
    {"models", "materials", "description", "lights", "reference", "plot", "measured"},
    {"export", "fit"},
    {"mitsuba", "doctor"},
    {"render", "check"},
    {"bake", "compare", "view", "foreign"},
    {"bench", "cluster"},
    {"cost"},
    {"reproduce"},
    {"cli"},
    {"__main__"},
)

# Libraries that one room alone may know.
ALONE = {
    "click": {"cli"},
    "difflib": {"messages"},  # so that one helper finds the name that somebody meant
    "distributed": {"cluster"},
    "pyarrow": {"cluster"},
}

# Rooms that know nothing of arrays, of Mitsuba, or of files.
PURE = {"models", "parts", "lang"}


def modules(root: Path) -> dict[str, Path]:
    """Files by the name that they are imported by."""
    return {
        ".".join(path.relative_to(root.parent).with_suffix("").parts).removesuffix(
            ".__init__"
        ): path
        for path in root.rglob("*.py")
    }


@functools.cache
def imports(path: Path) -> list[str]:
    """All that a file imports, at its top, inside functions, or for types only."""
    found: list[str] = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}:{node.lineno}: imports are absolute"
            found += [f"{node.module}.{alias.name}" for alias in node.names]
    return found


@functools.cache
def arrows(root: Path) -> dict[str, set[str]]:
    """Which modules of the package each module imports."""
    known = modules(root)

    def resolve(name: str) -> str | None:
        while name and name not in known:
            name = name.rpartition(".")[0]
        return name or None

    return {
        module: {
            target
            for name in imports(path)
            if (target := resolve(name)) not in (None, module, root.name)
        }
        for module, path in known.items()
    }  # type: ignore[return-value]


def circles(edges: dict[str, set[str]]) -> list[set[str]]:
    """Groups of modules that import each other, directly or by way of others."""

    def reached(start: str) -> set[str]:
        found: set[str] = set()
        waiting = [start]
        while waiting:
            for target in edges[waiting.pop()] - found:
                found.add(target)
                waiting.append(target)
        return found

    reach = {module: reached(module) for module in edges}
    groups = [
        {other for other in reach[module] if module in reach[other]}
        for module in edges
        if module in reach[module]
    ]
    return [group for n, group in enumerate(groups) if group not in groups[:n]]


def room(module: str) -> str:
    return module.split(".")[1]


def forbidden(edges: dict[str, set[str]]) -> list[str]:
    """Arrows that point upwards."""
    floor = {name: n for n, names in enumerate(FLOORS) for name in names}
    found = []
    for module, targets in edges.items():
        if module == "gonio":
            continue
        found += [
            f"{module} imports {target}"
            for target in sorted(targets)
            if floor[room(target)] > floor[room(module)]
        ]
    return found


def test_there_is_no_import_circle() -> None:
    assert circles(arrows(ROOT)) == []


def test_every_room_stands_on_a_floor() -> None:
    rooms = {room(module) for module in modules(ROOT) if module != "gonio"}
    assert rooms == set().union(*FLOORS)


def test_arrows_point_downwards() -> None:
    assert forbidden(arrows(ROOT)) == []


@pytest.mark.parametrize("library", ALONE)
def test_some_libraries_are_known_to_one_room(library: str) -> None:
    users = {
        room(module)
        for module, path in modules(ROOT).items()
        if any(name.partition(".")[0] == library for name in imports(path))
    }
    assert users == ALONE[library]


def test_models_and_parts_know_neither_arrays_nor_mitsuba() -> None:
    banned = ("gonio.arrays", "gonio.mitsuba", "gonio.render", "numpy", "torch", "jax", "drjit")
    for module, path in modules(ROOT).items():
        if module.split(".")[1:2] and room(module) in PURE and module != "gonio.lang":
            assert not [n for n in imports(path) if n.startswith(banned)], module


def test_a_circle_inside_a_function_and_an_arrow_upwards_are_noticed(tmp_path: Path) -> None:
    root = tmp_path / "gonio"
    for name in ("parts", "models"):
        (root / name).mkdir(parents=True)
        (root / name / "__init__.py").write_text("", encoding="utf-8")
    (root / "__init__.py").write_text("", encoding="utf-8")
    (root / "parts" / "a.py").write_text(
        "def late():\n    from gonio.models import b\n", encoding="utf-8"
    )
    (root / "models" / "b.py").write_text("from gonio.parts.a import late\n", encoding="utf-8")
    edges = arrows(root)
    assert circles(edges) == [{"gonio.parts.a", "gonio.models.b"}]
    assert forbidden(edges) == ["gonio.parts.a imports gonio.models.b"]


def test_every_place_that_contributors_are_told_of_is_there() -> None:
    page = (ROOT.parent / "CONTRIBUTING.md").read_text(encoding="utf-8")
    places = re.findall(r"`((?:gonio|tests|tools|docs)/[\w./]*)`", page)
    assert len(places) > 25
    assert [place for place in places if not (ROOT.parent / place).exists()] == []


def test_every_room_says_in_its_first_line_what_it_is() -> None:
    rooms = [*ROOT.glob("*/__init__.py"), *ROOT.glob("*.py")]
    first = {path: path.read_text(encoding="utf-8").partition("\n")[0] for path in rooms}
    assert [path for path, line in first.items() if len(line) < 30 or line[:3] != '"""'] == []


TOLERANCES = {"rtol", "atol", "rel", "abs", "rel_tol", "abs_tol", "tolerance"}


def bare_tolerances(text: str) -> list[int]:
    """Lines with a tolerance that is a number without a name, and that no comment gives a reason for.

    The comment stands beside it, or above a block of statements that have tolerances.
    """
    tree = ast.parse(text)
    comments = {
        token.start[0]
        for token in tokenize.generate_tokens(io.StringIO(text).readline)
        if token.type == tokenize.COMMENT
    }
    simple = [n for n in ast.walk(tree) if isinstance(n, ast.stmt) and not hasattr(n, "body")]
    found, explained = [], set()
    for statement in sorted(simple, key=lambda n: n.lineno):
        given = [
            node.value
            for node in ast.walk(statement)
            if isinstance(node, ast.keyword) and node.arg in TOLERANCES
        ]
        first, last = statement.lineno, statement.end_lineno or statement.lineno
        if not given:
            continue
        if comments & set(range(first - 1, last + 1)) or first - 1 in explained:
            explained.add(last)
        else:
            found += [value.lineno for value in given if _is_bare(value)]
    return found


def _is_bare(value: ast.expr) -> bool:
    """Whether an expression has numbers, but no name; 0 alone needs none."""
    nodes = list(ast.walk(value))
    named = any(isinstance(node, ast.Name | ast.Attribute | ast.Call) for node in nodes)
    return not named and any(isinstance(node, ast.Constant) and node.value for node in nodes)


def test_every_tolerance_has_a_name_or_a_reason() -> None:
    tests = Path(__file__).parent
    found = [
        f"{path.relative_to(tests)}:{line}"
        for path in sorted(tests.rglob("*.py"))
        for line in bare_tolerances(path.read_text(encoding="utf-8"))
    ]
    assert not found, "name these tolerances (tests/support/tolerances.py), or say why they hold"


@pytest.mark.parametrize(
    ("text", "bare"),
    [
        ("assert a == approx(b, rel=1e-3)", [1]),
        ("close(a, b, rtol=2 * 1e-3, atol=0)", [1]),
        ("x = 1  # a reason\n\nclose(a, b, atol=1e-3)", [3]),
        ("if a:\n    # twice\n    x = 1\n    close(a, b, atol=1e-3)", [4]),
        ("assert a == approx(b, rel=1e-3)  # 1000 samples", []),
        ("# 1000 samples\nclose(a, b, rtol=1e-3)\nclose(c, d, rtol=1e-2)", []),
        ("close(a, b, rtol=2 * SINGLE, atol=0)", []),
        ("close(a, b, rtol=decimals(4))", []),
    ],
)
def test_a_bare_tolerance_is_noticed(text: str, bare: list[int]) -> None:
    assert bare_tolerances(text) == bare
