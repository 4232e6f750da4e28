"""Compilers as processes: finding them, running them, and saying what they refused."""

from __future__ import annotations

import ctypes.util
import importlib.util
import json
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from gonio.export.entry import Export
from gonio.export.tree import ExportError

Rows = npt.NDArray[np.float32]

# A compiler that takes longer has hung: the largest export takes a few seconds on a busy machine. Workers
# get this much and more for each job.
SECONDS = 300
SECONDS_PER_JOB = 60

# More processes at once than this make the rest of the machine unusable.
PROCESSES = 2

# Exports that are compiled as one text where that is possible: of so many, starting a compiler and reading
# its own headers is a small part.
BATCH = 16


class ProofError(ExportError):
    """A tool is missing, or an export does not compile or run; the first line says which and why."""


# By program or package: how to get it.
INSTALL = {
    "g++": "apt-get install g++ (or your system's compiler package)",
    "glslangValidator": "apt-get install glslang-tools",
    "spirv-opt": "apt-get install spirv-tools",
    "slangc": "pip install --no-deps slangtorch",
    "wgpu": "pip install wgpu, and without a GPU also apt-get install mesa-vulkan-drivers",
    "moderngl": "pip install moderngl, and apt-get install libegl1 libgl1",
    "nvrtc": "pip install nvidia-cuda-nvrtc-cu12, or NVIDIA's CUDA toolkit (no GPU needed)",
    "vulkan": "pip install vulkan",
    "radv": "apt-get install mesa-vulkan-drivers",
    "bpy": "pip install --no-deps bpy==5.0.1 with Python 3.11 (Blender, GPL-3)",
}

PACKAGES = frozenset({"wgpu", "moderngl", "vulkan", "bpy"})


def locate(tool: str) -> str | None:
    """Where a program or Python package is that INSTALL names; None if it is not installed."""
    if tool == "slangc":
        return slang_compiler()
    if tool == "nvrtc":
        return cuda_compiler()
    if tool in PACKAGES:
        found = importlib.util.find_spec(tool)
        return None if found is None else str(found.origin)
    return shutil.which(tool)


def program(name: str, purpose: str) -> str:
    """Path of an installed tool, or a ProofError that says how to get it."""
    found = locate(name)
    if found is None:
        raise ProofError(f"{name} is not installed, which {purpose}; {INSTALL[name]}.")
    return found


def slang_compiler() -> str | None:
    """slangc from the search path, or the one in the package slangtorch, which is not imported."""
    if found := shutil.which("slangc"):
        return found
    for folder in sys.path:
        candidate = Path(folder or ".") / "slangtorch" / "bin" / "slangc"
        if candidate.is_file():
            # Wheels do not always keep the permission to run
            if not candidate.stat().st_mode & 0o100:
                candidate.chmod(candidate.stat().st_mode | 0o111)
            return str(candidate)
    return None


def cuda_compiler() -> str | None:
    """NVIDIA's runtime compiler: the library of its package, or of an installed CUDA toolkit."""
    found = importlib.util.find_spec("nvidia")
    for place in (found.submodule_search_locations or ()) if found is not None else ():
        for file in sorted(Path(place).glob("cuda_nvrtc/*/*nvrtc*")):
            if re.match(r"(lib)?nvrtc(\.so\.\d+|64_\d+_0\.dll)$", file.name):
                return str(file)
    return ctypes.util.find_library("nvrtc")


def run(
    command: Sequence[str],
    folder: Path,
    seconds: float = SECONDS,
    environment: Mapping[str, str] | None = None,
) -> subprocess.CompletedProcess[str]:
    """Run a program to its end in a folder, with its output as text; its environment may be another."""
    try:
        return subprocess.run(
            command,
            cwd=folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=seconds,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise ProofError(f"{Path(command[0]).name} did not end within {seconds:g} s.") from None


def compile_with(
    command: Sequence[str], folder: Path, export: Export, text: str, line: str, offset: int = 0
) -> None:
    """Run a compiler; where it fails, raise a ProofError that quotes the line it complains about.

    Args:
        command: program and arguments.
        folder: where it runs.
        export: what is compiled.
        text: the text whose lines the compiler counts.
        line: regular expression with one group, the number of a line in the compiler's messages.
        offset: what to subtract from the numbers.
    """
    done = run(command, folder)
    if done.returncode != 0:
        raise refused(export, Path(command[0]).name, done.stdout + done.stderr, text, line, offset)


def refused(
    export: Export, compiler: str, message: str, text: str, line: str, offset: int = 0
) -> ProofError:
    """The error for a source that a compiler refused: its first complaint, and the line it means."""
    lines = text.splitlines()
    complaints = [m for m in message.splitlines() if re.search("error|ERROR", m)] or [
        m for m in message.splitlines() if m.strip()
    ]
    first = complaints[0].strip() if complaints else "no message"
    quoted = ""
    found = re.search(line, first) or re.search(line, message)
    if found:
        number = int(found[1]) - offset
        if 1 <= number <= len(lines):
            quoted = f"\n  line {number}: {lines[number - 1].strip()}"
    return ProofError(
        f"{export.entry.prefix} in {export.language}: {compiler} says: {first}{quoted}"
    )


Made = TypeVar("Made")


def side_by_side(
    work: Callable[[Export, Rows], Made], exports: Sequence[Export], rows: Sequence[Rows]
) -> list[Made | ProofError]:
    """Apply `work`, which waits for processes, to all exports, two at a time; keep refusals."""

    def attempt(export: Export, inputs: Rows) -> Made | ProofError:
        try:
            return work(export, inputs)
        except ProofError as error:
            return error

    with ThreadPoolExecutor(PROCESSES) as pool:
        return list(pool.map(attempt, exports, rows))


def in_batches(
    work: Callable[[Sequence[Export], Sequence[Rows]], Sequence[Made]],
    exports: Sequence[Export],
    rows: Sequence[Rows],
) -> list[Made | ProofError]:
    """Apply `work`, which waits for processes, to several exports at once, two such batches at a time.

    What is refused in company is tried alone, to know which export it is and what it says of that.
    """

    def attempt(numbers: Sequence[int]) -> list[Made | ProofError]:
        try:
            return list(work([exports[k] for k in numbers], [rows[k] for k in numbers]))
        except ProofError as error:
            if len(numbers) == 1:
                return [error]
            return [made for k in numbers for made in attempt([k])]

    count = len(exports)
    size = max(1, min(BATCH, -(-count // PROCESSES)))
    batches = [range(k, min(k + size, count)) for k in range(0, count, size)]
    with ThreadPoolExecutor(PROCESSES) as pool:
        return [made for batch in pool.map(attempt, batches) for made in batch]


@dataclass(frozen=True)
class Job:
    """A finished shader for a worker, with the rows it runs on."""

    export: Export
    text: str | bytes
    rows: Rows
    columns: int
    """Of the outputs."""
    line: str
    """Regular expression that finds a line's number in the complaints of the worker's compiler."""
    layout: dict[str, Any] = field(default_factory=dict)
    """What else the worker needs to know."""

    @property
    def tables(self) -> Rows | None:
        """What the shader reads besides its rows."""
        read = any(f in self.export.entry.reading for f in self.export.entry.functions)
        return self.export.buffer.rows() if read and self.export.buffer is not None else None


def run_worker(
    name: str, suffix: str, jobs: Sequence[Job], compiler: str, tool: str
) -> tuple[list[Rows | ProofError], str]:
    """Run shaders in processes of the script `name`; return their outputs and the device's name.

    Args:
        name: of a file beside this one.
        suffix: of the files with the shaders.
        jobs: one for each shader.
        compiler: whose complaints the process writes down, for people.
        tool: the package that the process uses, of INSTALL.
    """
    parts = [list(range(k, len(jobs), PROCESSES)) for k in range(PROCESSES)]
    outputs: dict[int, Rows | ProofError] = {}
    device = ""

    def work(numbers: list[int]) -> None:
        nonlocal device
        with tempfile.TemporaryDirectory(prefix="gonio-") as folder_name:
            folder = Path(folder_name)
            listing = []
            for number in numbers:
                file, text = f"{number}{suffix}", jobs[number].text
                words = text if isinstance(text, bytes) else text.encode("utf-8")
                (folder / file).write_bytes(words)
                np.save(
                    folder / f"{number}.npy", np.ascontiguousarray(jobs[number].rows, np.float32)
                )
                if (tables := jobs[number].tables) is not None:
                    np.save(folder / f"{number}.tables.npy", tables)
                facts = {"number": number, "file": file, "columns": jobs[number].columns}
                listing.append(facts | jobs[number].layout)
            (folder / "jobs.json").write_text(json.dumps(listing), encoding="utf-8")
            script = Path(__file__).with_name(name)
            # -P: the folder of the script is not searched for modules
            command = [sys.executable, "-P", str(script), str(folder)]
            done = run(command, folder, SECONDS + SECONDS_PER_JOB * len(numbers))
            if done.returncode != 0:
                last = (done.stderr.strip() or "no message").splitlines()[-1]
                reason = f"signal {-done.returncode}" if done.returncode < 0 else last
                raise ProofError(f"{tool} does not work here ({reason}); {INSTALL[tool]}.")
            device = (folder / "device").read_text(encoding="utf-8")
            for number in numbers:
                complaint = folder / f"{number}.error"
                job = jobs[number]
                if complaint.exists():
                    message = complaint.read_text(encoding="utf-8")
                    text = job.text if isinstance(job.text, str) else ""
                    outputs[number] = refused(job.export, compiler, message, text, job.line)
                else:
                    outputs[number] = np.load(folder / f"{number}.out.npy")

    with ThreadPoolExecutor(PROCESSES) as pool:
        list(pool.map(work, [part for part in parts if part]))
    return [outputs[number] for number in range(len(jobs))], device
