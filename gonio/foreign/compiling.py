"""Compiling foreign code for the process that it runs in."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from gonio.export.prove import tools
from gonio.export.prove.native import FLAGS
from gonio.foreign.complaints import refused
from gonio.foreign.library import wrapper
from gonio.foreign.source import ForeignError, Source

CUDA = Path(__file__).with_name("cuda")
METAL = Path(__file__).with_name("metal")
OSL = Path(__file__).with_name("osl_words.h")


def compiled(
    source: Source, text: str, folder: Path, include: Sequence[str | Path], defines: Sequence[str]
) -> tuple[str, Path]:
    """The kind of worker (gonio/foreign/_worker.py) and its file.

    Args:
        source: what it was made of.
        text: with the harness.
        folder: where files are written.
        include: folders with headers.
        defines: macros, NAME or NAME=VALUE.

    Raises:
        ForeignError: it does not compile, or a tool is missing.
    """
    try:
        return _compiled(source, text, folder, include, defines)
    except tools.ProofError as error:
        raise ForeignError(str(error)) from None


def _compiled(
    source: Source, text: str, folder: Path, include: Sequence[str | Path], defines: Sequence[str]
) -> tuple[str, Path]:
    language = source.language
    if language in ("glsl", "essl", "brdf"):
        tools.program("moderngl", "runs GLSL")
        (folder / "shader.frag").write_text(text, encoding="utf-8")
        return "opengl", folder / "shader.frag"
    if language == "python":
        (folder / "job.json").write_text(text, encoding="utf-8")
        return "python", folder / "job.json"
    if language == "wgsl":
        tools.program("wgpu", "compiles and runs WGSL")
        (folder / "shader.wgsl").write_text(text, encoding="utf-8")
        return "webgpu", folder / "shader.wgsl"
    gxx = tools.program("g++", "compiles what is to be run")
    folders = [str(Path(p).resolve()) for p in (source.path.parent, *include)]
    options = [f"-I{p}" for p in folders] + [f"-D{d}" for d in defines]
    more: list[str] = []
    if language in ("hlsl", "slang"):
        slangc = tools.program("slangc", "compiles Slang and HLSL to C++")
        (folder / "code.slang").write_text(text, encoding="utf-8")
        command = [slangc, "code.slang", "-target", "cpp", "-o", "code.cpp"]
        for p in folders:
            command += ["-I", p]
        _run([*command, *(f"-D{d}" for d in (*source.macros, *defines))], folder, source)
        options = []
    else:
        if language == "library":
            return "native", _linked(gxx, source, text, folder)
        (folder / "code.cpp").write_text(text, encoding="utf-8")
        kinds = {
            "cuda": ["-include", str(CUDA / "cuda_runtime.h"), f"-I{CUDA}"],
            "msl": ["-fsingle-precision-constant", "-Wno-attributes", "-x", "c++", f"-I{METAL}"],
            "osl": ["-include", str(OSL), "-fsingle-precision-constant"],
        }
        more = kinds.get(language, [])
        if language in ("cpp", "cuda"):  # members of classes are set, private ones too
            more = [*more, "-fno-access-control"]
        if source.path.suffix == ".c":  # C converts pointers that C++ does not
            more = ["-fpermissive"]
        more = [*more, "-Dmain=gonio_unused_main"]
    command = [gxx, *FLAGS, "-w", *more, *options, "code.cpp", "-o", "library.so"]
    _run(command, folder, source)
    return "native", folder / "library.so"


def _linked(gxx: str, source: Source, text: str, folder: Path) -> Path:
    """A library of calls into the user's compiled library: as C declares the function, or as C++ does."""
    library = source.path.resolve()
    options = [str(library), f"-Wl,-rpath,{library.parent}", "-Wl,--no-undefined"]
    said = ""
    for head in wrapper(source):
        (folder / "code.cpp").write_text(head + text, encoding="utf-8")
        command = [gxx, *FLAGS, "-w", "code.cpp", "-o", "library.so", *options]
        done = tools.run(command, folder)
        if done.returncode == 0:
            return folder / "library.so"
        said = said or done.stdout + done.stderr
    if "undefined reference" in said:
        raise ForeignError(
            f"{source.path} has no function {source.entry!r}; 'nm -D' shows what it has."
        )
    lines = [line for line in said.splitlines() if "error" in line] or ["no message"]
    raise ForeignError(f"{source.path} cannot be called so: {lines[0].strip()}")


def _run(command: Sequence[str], folder: Path, source: Source) -> None:
    done = tools.run(command, folder)
    if done.returncode != 0:
        raise refused(source, done.stdout + done.stderr)
