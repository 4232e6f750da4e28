"""The choice of LLVM and backend, in processes of their own: Dr.Jit chooses once per process."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import drjit as dr
import pytest
from support.tolerances import SINGLE

import gonio
from gonio import backend

EVALUATE = "import gonio; print(gonio.Lambert().eval([0, 0, 1], [0, 0, 1])[0])"


def run(code: str, **environment: str) -> subprocess.CompletedProcess[str]:
    clean = {
        k: v for k, v in os.environ.items() if k not in {"DRJIT_LIBLLVM_PATH", "GONIO_BACKEND"}
    }
    return subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        env=clean | environment,
        timeout=120,
        check=False,
    )


@pytest.mark.parametrize(
    ("name", "version"),
    [
        ("libLLVM.so.23.1", 23),
        ("libLLVM-14.so.1", 14),
        ("libLLVM-15.so", 15),
        ("libLLVM.so.19.1", 19),
        ("libLLVM.dylib", None),
        ("LLVM-C.dll", None),
        ("libLLVM.so", None),
        ("libLLVM.17.dylib", 17),
    ],
)
def test_version_is_read_from_the_name(tmp_path: Path, name: str, version: int | None) -> None:
    assert backend.llvm_version(tmp_path / name) == version


def test_version_is_read_through_a_link(tmp_path: Path) -> None:
    (tmp_path / "libLLVM-14.so.1").touch()
    (tmp_path / "libLLVM.so").symlink_to(tmp_path / "libLLVM-14.so.1")
    assert backend.llvm_version(tmp_path / "libLLVM.so") == 14


def test_a_usable_llvm_is_in_force() -> None:
    assert dr.detail.llvm_version()[0] >= backend.LLVM_MINIMUM
    assert backend.available("llvm")
    assert Path(os.environ["DRJIT_LIBLLVM_PATH"]).exists()


@pytest.mark.parametrize("version", ["14", "15"])
def test_an_llvm_that_ends_the_process_is_refused(tmp_path: Path, version: str) -> None:
    library = tmp_path / f"libLLVM-{version}.so.1"
    library.touch()
    done = run("import gonio; gonio.use('llvm')", DRJIT_LIBLLVM_PATH=str(library))
    assert done.returncode == 1
    assert f"is LLVM {version}; 16 or newer is needed" in done.stderr.splitlines()[-1]
    done = run(EVALUATE, DRJIT_LIBLLVM_PATH=str(library))
    assert done.returncode == 0
    assert "computing in plain Python, which is slow: DRJIT_LIBLLVM_PATH" in done.stderr


def test_without_llvm_the_scalar_backend_computes_and_llvm_says_what_to_install() -> None:
    done = run(EVALUATE, DRJIT_LIBLLVM_PATH=backend.NO_LLVM + "-x")
    assert done.returncode == 0
    assert "computing in plain Python, which is slow: DRJIT_LIBLLVM_PATH" in done.stderr
    assert "does not exist" in done.stderr
    assert float(done.stdout) == pytest.approx(0.8 / 3.14159265, rel=SINGLE)
    done = run("import gonio; gonio.use('llvm')", DRJIT_LIBLLVM_PATH=backend.NO_LLVM + "-x")
    assert done.returncode == 1
    last = done.stderr.splitlines()[-1]
    assert "BackendError" in last
    assert "install" in last


def test_environment_variable_chooses_the_backend() -> None:
    code = "import gonio; from gonio import backend; print(backend.current())"
    assert run(code, GONIO_BACKEND="scalar").stdout.strip() == "scalar"
    assert run(code).stdout.strip() in {"llvm", "cuda"}
    done = run(code, GONIO_BACKEND="opencl")
    assert "GONIO_BACKEND got 'opencl'; allowed are llvm, cuda, scalar" in done.stderr


def test_an_unknown_backend_is_refused() -> None:
    with pytest.raises(ValueError, match="got 'gpu'; allowed are llvm, cuda, scalar"):
        gonio.use("gpu")


def test_cuda_without_a_gpu_is_refused_in_one_line() -> None:
    if backend.available("cuda"):
        gonio.use("cuda")
        gonio.use("llvm")
        return
    with pytest.raises(gonio.BackendError, match="no NVIDIA GPU with a driver here; use 'llvm'"):
        gonio.use("cuda")


def test_mitsuba_variant_fits_the_backend() -> None:
    assert backend.mitsuba_variant() in {"llvm_ad_rgb", "cuda_ad_rgb"}
    assert backend.mitsuba_variant("spectral") in {"llvm_ad_spectral", "cuda_ad_spectral"}


def test_importing_gonio_loads_only_the_core() -> None:
    code = (
        "import sys, gonio; "
        "print([m for m in ('mitsuba', 'matplotlib', 'click', 'torch', 'jax', 'trimesh', 'PIL')"
        " if m in sys.modules])"
    )
    assert run(code).stdout.strip() == "[]"
