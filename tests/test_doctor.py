"""The doctor: finds what is there, says what to do about the rest, and never crashes."""

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from gonio import doctor
from gonio.doctor import findings, probes


def by_name(findings):
    return {f.name: f for f in findings}


@pytest.fixture(scope="module")
def here():
    return doctor.diagnose()


def test_versions_are_the_installed_ones(here):
    import drjit
    import numpy

    found = by_name(here)
    assert found["Dr.Jit"].value == drjit.__version__
    assert found["NumPy"].value == numpy.__version__
    assert found["Python"].value.startswith(sys.version.split()[0])


def test_a_compiled_backend_has_a_vector_width_and_threads(here):
    found = by_name(here)
    if found["LLVM"].status != "ok":
        pytest.skip("no LLVM on this machine")
    width = int(found["vector width"].value.split()[0])
    assert width in {4, 8, 16}
    assert int(found["threads"].value.split()[0]) >= 1
    assert doctor.can_compute(here)


def test_everything_that_is_missing_comes_with_advice(here):
    for finding in here:
        assert finding.status in doctor.SYMBOLS
        assert "\n" not in finding.value + finding.advice
        assert finding.status != "broken" or finding.advice


def test_what_is_optional_comes_with_the_extra_that_brings_it(monkeypatch):
    """The package's own list of extras is the judge."""
    project = Path(__file__).parents[1] / "pyproject.toml"
    extras = tomllib.loads(project.read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    monkeypatch.setattr(findings, "_version", lambda name: None)
    for name, (distribution, extra, _) in findings.OPTIONAL.items():
        brought = {re.match(r"[\w.-]+", needed)[0] for needed in extras[extra]}
        assert distribution in brought, name
        found = findings.optional(name)
        assert found.status == "absent"
        assert f"pip install 'gonio[{extra}]'" in found.advice


def test_the_report_has_a_mark_and_a_name_for_each(here):
    text = doctor.report(here)
    for finding in here:
        assert f"{doctor.SYMBOLS[finding.status]} {finding.name}" in text


def test_without_llvm_it_says_what_to_do(monkeypatch):
    monkeypatch.setenv("DRJIT_LIBLLVM_PATH", "/nonexistent")
    monkeypatch.setenv("CUDA_VISIBLE_DEVICES", "")
    found = doctor.diagnose()
    llvm = by_name(found)["LLVM"]
    assert llvm.status == "broken"
    assert llvm.value == "DRJIT_LIBLLVM_PATH=/nonexistent does not exist"
    assert llvm.advice.startswith("unset it, or ")
    assert by_name(found)["vector width"].status == "absent"
    assert not doctor.can_compute(found)


def test_an_llvm_that_is_no_library_is_reported(monkeypatch, tmp_path):
    broken = tmp_path / "libLLVM-19.so"
    broken.write_bytes(b"not a library")
    monkeypatch.setenv("DRJIT_LIBLLVM_PATH", str(broken))
    llvm = by_name(doctor.diagnose())["LLVM"]
    assert llvm.status == "broken"
    assert "does not load" in llvm.value
    assert llvm.advice


def test_an_unknown_backend_is_named_with_the_known_ones(monkeypatch):
    monkeypatch.setenv("GONIO_BACKEND", "opencl")
    found = doctor.diagnose()
    finding = by_name(found)["backend"]
    assert "'opencl'" in finding.value
    assert "llvm, cuda, scalar" in finding.advice
    assert not doctor.can_compute(found)


def test_a_probe_that_dies_is_a_finding_and_not_a_crash(monkeypatch):
    def start(name):
        code = "import os, signal; os.kill(os.getpid(), signal.SIGKILL)"
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        return subprocess.Popen([sys.executable, "-c", code], text=True, **pipes)

    monkeypatch.setattr(probes, "start", start)
    found = doctor.diagnose()
    assert by_name(found)["LLVM"].value == "the process was ended by signal 9"
    assert not doctor.can_compute(found)


def test_a_check_that_raises_is_a_finding_and_not_a_crash(monkeypatch):
    monkeypatch.setattr(probes, "start", lambda name: OSError("no more processes"))
    monkeypatch.setattr(findings, "kernel_cache", lambda: 1 / 0)
    found = by_name(doctor.diagnose())
    assert found["kernel cache"].status == "broken"
    assert "ZeroDivisionError" in found["kernel cache"].value
    assert "no more processes" in found["LLVM"].value


def test_the_kernel_cache_is_where_dr_jit_puts_it(monkeypatch, tmp_path):
    monkeypatch.delenv("DRJIT_CACHE_DIR", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    assert findings.kernel_cache().value.startswith(str(tmp_path / ".drjit"))
    folder = tmp_path / "kernels"
    folder.mkdir()
    (folder / "one.bin").write_bytes(bytes(1024))
    monkeypatch.setenv("DRJIT_CACHE_DIR", str(folder))
    assert findings.kernel_cache().value == f"{folder}, 1 files, 0.0 MiB"


@pytest.mark.skipif(sys.platform == "win32", reason="no HOME on Windows")
def test_without_a_home_there_is_no_kernel_cache(monkeypatch):
    monkeypatch.delenv("DRJIT_CACHE_DIR", raising=False)
    monkeypatch.delenv("HOME")
    finding = findings.kernel_cache()
    assert finding.status == "absent"
    assert "DRJIT_CACHE_DIR" in finding.advice


def test_the_command_ends_with_1_without_a_backend():
    env = {**os.environ, "DRJIT_LIBLLVM_PATH": "/nonexistent", "CUDA_VISIBLE_DEVICES": ""}
    program = Path(sys.executable).with_name("gonio")
    done = subprocess.run([program, "doctor"], env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "✗ LLVM" in done.stdout
    assert "✗ backend" in done.stdout
    assert "Traceback" not in done.stderr
