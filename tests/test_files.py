"""Places for files: what is wrong with one is said before the work, and nothing is left behind."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from gonio.cli import main
from gonio.files import check_place


def test_a_good_place_is_left_as_it_was(tmp_path: Path) -> None:
    (tmp_path / "old.png").write_text("old")
    assert check_place(tmp_path / "old.png") == tmp_path / "old.png"
    check_place(tmp_path / "new.png")
    assert [p.name for p in tmp_path.iterdir()] == ["old.png"]
    assert (tmp_path / "old.png").read_text() == "old"


@pytest.mark.parametrize(
    "command",
    [
        ["render", "eon"],
        ["series", "patina"],
        ["sheet"],
        ["scene", "s.xml"],
        ["compare", "eon", "lambert"],
        ["plot", "eon"],
        ["check", "eon", "--plot"],
        ["check", "eon", "--junit"],
        ["view", "eon", "--save"],
        ["bake", "blur", "studio", "--alpha", "0.3"],
        ["fit", "eon", "lambert"],
    ],
    ids=" ".join,
)
@pytest.mark.parametrize("place", ["none/x", "folder"])
def test_a_place_that_cannot_be_written_is_found_before_the_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: list[str], place: str
) -> None:
    def too_late(*_: object, **__: object) -> None:
        raise AssertionError("the work has begun")

    monkeypatch.chdir(tmp_path)
    for suffix in (".png", ".html", ".exr", ".toml", ".xml"):
        (tmp_path / f"folder{suffix}").mkdir()
    for name in (
        "gonio.render.sheets.compare",
        "gonio.render.sheets.write_sheet",
        "gonio.render.user_scene.render_scene",
        "gonio.compare.compare",
        "gonio.fit.fit",
        "gonio.view.variants.pool",
        "gonio.bake.environment.load",
        "gonio.cli._check_plan.check_subjects",
    ):
        monkeypatch.setattr(name, too_late)
    suffix = {"view": ".html", "bake": ".exr", "fit": ".toml"}.get(command[0], ".png")
    option = [] if command[-1].startswith("--") else ["-o"]
    result = CliRunner().invoke(main, [*command, *option, place + suffix])
    assert result.exit_code == 1
    assert "no folder" in result.output or "is a folder" in result.output
    assert not list(tmp_path.glob(".gonio-*"))


def test_a_file_in_the_place_of_the_folder_is_said(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("a file", encoding="utf-8")
    with pytest.raises(
        NotADirectoryError, match=r"out is a file; x\.png cannot be written into it"
    ):
        check_place(tmp_path / "out" / "x.png")
    with pytest.raises(FileNotFoundError, match="there is no folder"):
        check_place(tmp_path / "missing" / "x.png")
