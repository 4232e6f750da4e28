"""What is published: an archive and a wheel with all they need, that run in an empty environment."""

from __future__ import annotations

import ast
import email
import importlib.metadata
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import tomllib
import venv
import zipfile
from pathlib import Path

import numpy
import pytest
from PIL import Image

ROOT = Path(__file__).parent.parent
LEFT_BEHIND = shutil.ignore_patterns(
    ".git",
    ".venv",
    "__pycache__",
    "*.egg-info",
    "build",
    "dist",
    "demo",
    ".*_cache",
    ".hypothesis",
    "node_modules",
)
# Made by programs, or other people's: 'make test' fetches the latter.
NOT_OURS = {"__pycache__", "node_modules"}


def build(source: Path) -> Path:
    """The folder with the source archive of a source tree, and with the wheel that is made from it."""
    command = [sys.executable, "-m", "build", "--no-isolation", source]
    subprocess.run(command, check=True, capture_output=True, timeout=300)
    return source / "dist"


def missing_in_wheel(dist: Path) -> set[str]:
    """Files of the package that did not get into the wheel."""
    (wheel,) = dist.glob("*.whl")
    wanted = {
        path.relative_to(ROOT).as_posix()
        for path in (ROOT / "gonio").rglob("*")
        if path.is_file() and NOT_OURS.isdisjoint(path.parts)
    }
    return wanted - set(zipfile.ZipFile(wheel).namelist())


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the source tree, in which building leaves its traces."""
    folder = tmp_path_factory.mktemp("publish") / "source"
    shutil.copytree(ROOT, folder, ignore=LEFT_BEHIND)
    return folder


@pytest.fixture(scope="module")
def dist(source: Path) -> Path:
    """The folder with the source archive and the wheel."""
    return build(source)


@pytest.fixture(scope="module")
def programs(dist: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of programs of an environment that has the wheel, and its dependencies from this one."""
    folder = tmp_path_factory.mktemp("empty")
    venv.create(folder / "env", with_pip=False, symlinks=os.name != "nt")
    scheme = sysconfig.get_preferred_scheme("prefix") if os.name != "nt" else "nt"
    bases = {"base": str(folder / "env"), "platbase": str(folder / "env")}
    paths = sysconfig.get_paths(scheme, vars=bases)
    (wheel,) = dist.glob("*.whl")
    python = next(Path(paths["scripts"]).glob("python*"))
    # The environment's pip is this one's. What is beside NumPy here is importable there, behind its own
    # packages; the editable gonio of this environment is not, for its hook does not run there.
    install = [
        sys.executable,
        "-m",
        "pip",
        "--python",
        python,
        "install",
        "--no-deps",
        "--no-index",
    ]
    subprocess.run([*install, wheel], check=True, capture_output=True, timeout=120)
    beside = Path(numpy.__file__).parent.parent
    Path(paths["purelib"], "dependencies.pth").write_text(f"{beside}\n", encoding="utf-8")
    return Path(paths["scripts"])


def run(programs: Path, folder: Path, *arguments: str) -> str:
    """What `gonio` prints, run in a folder where there is no gonio."""
    clean = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "PYTHONHOME")}
    command = [str(programs / "gonio"), *arguments]
    done = subprocess.run(
        command, cwd=folder, env=clean, capture_output=True, text=True, timeout=240, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_every_file_of_the_package_is_in_the_wheel(dist: Path) -> None:
    assert missing_in_wheel(dist) == set()
    (wheel,) = dist.glob("*.whl")
    tops = {name.partition("/")[0] for name in zipfile.ZipFile(wheel).namelist()}
    assert {top for top in tops if not top.startswith("gonio-")} == {"gonio"}
    assert not any(name.endswith(".pyc") for name in zipfile.ZipFile(wheel).namelist())


def test_a_wheel_without_its_data_is_noticed(source: Path, dist: Path, tmp_path: Path) -> None:
    shutil.copytree(source, tmp_path / "source", ignore=LEFT_BEHIND)
    manifest = tmp_path / "source" / "MANIFEST.in"
    lines = manifest.read_text(encoding="utf-8").replace("graft gonio\n", "")
    manifest.write_text(lines, encoding="utf-8")
    lost = missing_in_wheel(build(tmp_path / "source"))
    assert {"gonio/description/bibliography.bib", "gonio/materials/gold.toml"} <= lost


def test_the_archive_has_all_that_the_tests_need(dist: Path) -> None:
    (archive,) = dist.glob("*.tar.gz")
    with tarfile.open(archive) as opened:
        packed = {name.partition("/")[2] for name in opened.getnames()}
    for folder in ("tests", "tools", "docs", "examples", "gonio", ".ci"):
        wanted = {
            path.relative_to(ROOT).as_posix()
            for path in (ROOT / folder).rglob("*")
            if path.is_file() and NOT_OURS.isdisjoint(path.parts)
        }
        assert wanted
        assert wanted - packed == set()
    assert {"LICENSE", "README.md", "Makefile", "constraints.txt", "CITATION.cff"} < packed


def test_the_version_stands_in_one_place(dist: Path) -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    (wheel,) = dist.glob("*.whl")
    assert wheel.name.startswith(f"gonio-{project['version']}-")
    texts = [*(ROOT / "gonio").rglob("*.py"), ROOT / "CITATION.cff", ROOT / "README.md"]
    quoted = re.compile(rf"(?<![\d.]){re.escape(project['version'])}(?![\d.])")
    assert [p.name for p in texts if quoted.search(p.read_text(encoding="utf-8"))] == []


def test_readers_of_a_package_index_can_follow_every_link(dist: Path) -> None:
    (wheel,) = dist.glob("*.whl")
    archive = zipfile.ZipFile(wheel)
    (name,) = (n for n in archive.namelist() if n.endswith(".dist-info/METADATA"))
    page = email.message_from_bytes(archive.read(name)).get_payload()
    links = re.findall(r"\]\(([^)]*)\)", page)
    assert len(links) == len(re.findall(r"\]\(", (ROOT / "README.md").read_text(encoding="utf-8")))
    assert [link for link in links if not link.startswith("https://")] == []
    own = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["urls"]
    places = [link.removeprefix(own["Repository"]) for link in links if own["Repository"] in link]
    files = [re.sub(r"^/(raw|blob)/main/|#.*", "", place) for place in places]
    assert len(files) > 30
    assert [file for file in files if not (ROOT / file).is_file()] == []
    pictures = [place for place in places if place.endswith(".png")]
    assert pictures
    assert all(place.startswith("/raw/") for place in pictures)


def test_the_licence_names_what_the_scripts_contain() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    heads = [
        path.read_text(encoding="utf-8").partition("*/")[0]
        for path in (ROOT / "gonio" / "view" / "web").glob("*.js")
    ]
    assert heads
    for sentence, licence in {
        "BSD 3-Clause License": "BSD-3-Clause",
        "Permission is hereby granted, free of charge": "MIT",
    }.items():
        assert any(sentence in head for head in heads) == (licence in project["license"])


def test_the_wheel_lists_and_exports(programs: Path, tmp_path: Path) -> None:
    assert "lacquered_walnut" in run(programs, tmp_path, "list", "--materials")
    shader = run(programs, tmp_path, "export", "eon", "--to", "wgsl")
    assert "fn eon_eval(params: Eon, wi: vec3f, wo: vec3f) -> vec3f" in shader
    assert importlib.metadata.version("gonio") in run(programs, tmp_path, "--version")


def test_the_wheel_renders(programs: Path, tmp_path: Path) -> None:
    run(programs, tmp_path, "render", "gold", "--size", "48", "--spp", "4", "-o", "gold.png")
    red, _, blue = (
        float(band)
        for band in numpy.asarray(Image.open(tmp_path / "gold.png"))[..., :3].mean((0, 1))
    )
    assert red > blue  # gold, not black and not grey


def test_the_wheel_checks(programs: Path, tmp_path: Path) -> None:
    found = run(programs, tmp_path, "check", "lambert", "--quick", "--only", "energy,reciprocity")
    assert "energy" in found


def test_every_test_file_says_what_it_proves() -> None:
    """CONTRIBUTING.md sends readers to these sentences."""
    for path in sorted((ROOT / "tests").glob("test_*.py")):
        docstring = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))
        assert docstring, path.name
        assert docstring.partition("\n")[0].endswith("."), path.name
