"""`gonio list --parts`: every public part is there, and nothing had to be listed by hand."""

from __future__ import annotations

import ast
import json
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

import gonio
from gonio import parts as parts_package
from gonio.cli import list as inventory
from gonio.cli import main
from gonio.parts import distribution

FOLDER = Path(parts_package.__file__).parent


@pytest.fixture(scope="module")
def listed() -> set[str]:
    return {f"{part.module.rpartition('.')[2]}.{part.name}" for part in inventory.found_parts()}


def run(*arguments: str) -> Any:
    return CliRunner().invoke(main, list(arguments))


def test_every_public_function_of_every_part_is_listed() -> None:
    """Counted in the text of the files."""
    written = {
        (f"gonio.parts.{path.stem}", node.name)
        for path in FOLDER.glob("*.py")
        for node in ast.parse(path.read_text(encoding="utf-8")).body
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_")
    }
    for Facets in (distribution.GGX, distribution.RoundGGX, distribution.Beckmann):
        methods = [name for name in vars(Facets) if not name.startswith("_")]
        methods = [name for name in methods if name not in Facets._fields]
        names = [Facets.__name__, *(f"{Facets.__name__}.{name}" for name in methods)]
        written |= {("gonio.parts.distribution", name) for name in names}
    listed = {
        (p.module, p.name) for p in inventory.found_parts() if p.module.startswith("gonio.parts.")
    }
    assert written <= listed
    assert {name for _, name in listed - written} >= {
        "BlinnPhong",
        "Gaussian.norm",
        "GTR1.D_narrow",
    }
    assert all(name[0].isupper() for _, name in listed - written)
    assert all(part.summary for part in inventory.found_parts())


def test_a_new_part_lists_itself(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = '"""Doubts.\\n\\nSource: Thomas, 33.\\n"""\n\ndef F_doubt():\n    """No light."""\n'
    parts = tmp_path / "gonio" / "parts"
    parts.mkdir(parents=True)
    (parts / "doubt.py").write_text(text.replace("\\n", "\n"), encoding="utf-8")
    monkeypatch.setattr(inventory, "ROOT", tmp_path / "gonio")
    expected = inventory.Part("F_doubt", "gonio.parts.doubt", "No light.", "Doubts.", "Thomas, 33.")
    assert inventory.found_parts() == [expected]


# What the specular, complete and layered models are made of, and where each can be found: a function of
# the list, or a model, or a model's parameter or option.
ROWS = {
    "D Blinn-Phong": "distribution.BlinnPhong",
    "D Beckmann": "distribution.Beckmann",
    "D GGX, isotropic and anisotropic": "distribution.GGX",
    "D Gaussian": "distribution.Gaussian",
    "D GTR1": "distribution.GTR1",
    "perceptual roughness": "conversions.alpha_from_perceptual",
    "G implicit": "masking.V_implicit",
    "G Neumann": "masking.V_neumann",
    "G Cook-Torrance": "masking.V_cook_torrance",
    "G Kelemen": "masking.V_kelemen",
    "G Smith": "masking.G1",
    "G Smith separable": "masking.V_smith",
    "G Smith height-correlated": "masking.V_smith_correlated",
    "G Smith GGX": "distribution.GGX.area",
    "G Smith Beckmann": "distribution.Beckmann.area",
    "G Smith Beckmann, Walter's fit": "masking.G1_walter",
    "G Smith for Blinn-Phong": "model torrance_sparrow distribution blinn_phong",
    "G1 Schlick": "masking.G1_schlick",
    "k Schlick-Beckmann": "masking.schlick_k_beckmann",
    "k Schlick-GGX": "masking.schlick_k_ggx",
    "k UE4": "masking.schlick_k_ue4",
    "F dielectric": "fresnel.F_dielectric",
    "F conductor": "fresnel.F_conductor",
    "F0 from the index": "fresnel.f0_from_eta",
    "index from F0": "fresnel.eta_from_f0",
    "F Schlick": "fresnel.F_schlick",
    "F Lazanyi": "fresnel.F_lazanyi",
    "metals": "metals.metal",
    "metals, spectral": "metals.spectra",
    "Torrance-Sparrow": "model torrance_sparrow",
    "energy compensation": "model torrance_sparrow compensation kulla_conty",
    "visible normals, GGX": "distribution.GGX.sample_visible",
    "visible normals, Beckmann": "distribution.Beckmann.sample_visible",
    "Phong": "model phong",
    "tri-Ace Blinn-Phong": "model triace_blinn_phong",
    "Disney 2012": "model disney",
    "metallic-roughness": "model metallic_roughness",
    "UE4": "model ue4",
    "UE4, image-based k": "model ue4 light image",
    "workflow conversion": "conversions.specular_from_metallic",
    "workflow conversion, back": "conversions.metallic_from_specular",
    "Unity BRDF1": "model unity_standard",
    "Unity BRDF2": "model unity_brdf2",
    "Weidlich-Wilkie": "model weidlich_wilkie",
    "layers: refraction": "interface.refract",
    "layers: absorption": "interface.attenuation",
    "layers: T12 t": "coat.through_facets",
    "layers: roughness clamp": "roughness.at_least_alpha",
    "layers: Fresnel both ways": "model weidlich_wilkie transmission both_ways",
    "layers: solid angle": "model weidlich_wilkie solid_angle compressed",
    "layers: internal reflections": "model weidlich_wilkie bounces diffuse",
    "layers: diffuse reflectance outside": "interface.diffuse_reflectance",
    "layers: diffuse reflectance inside": "interface.diffuse_reflectance_inside",
    "layers: environment reflection": "environment.coat_reflection",
    "layers: table of F": "tables.fresnel_table",
    "layers: table of D": "tables.distribution_table",
    "tri-Ace layered": "model triace_layered",
    "tri-Ace: linear absorption": "model triace_layered absorption linear",
    "tri-Ace: bottom Fresnel": "model triace_layered bottom_fresnel constant",
    "tri-Ace: F_trans": "model triace_layered top_transmission off",
    "tri-Ace: Eq. 7": "image_light.specular_image_absorption",
    "tri-Ace: Eq. 9": "image_light.diffuse_image_absorption",
    "tri-Ace: image-based light": "environment.layered_light",
    "tri-Ace: Eq. 27": "image_light.harmonic_dc_scale",
    "tri-Ace: Eq. 28": "image_light.harmonic_dc_scale_cheap",
    "tri-Ace: Eq. 29": "image_light.harmonic_linear_scale",
    "metallic paint": "model car_paint",
    "metallic paint: fading": "tilt.flake_normal",
    "metallic paint: map": "textures.flake_map",
    "skin: screen-space diffusion": "diffusion.diffuse_on_screen",
    "patina": "model patina",
    "patina: map": "textures.growth_map",
}


@pytest.mark.parametrize("row", ROWS)
def test_every_published_piece_can_be_pointed_at(row: str, listed: set[str]) -> None:
    kind, _, rest = ROWS[row].partition(" ")
    if kind != "model":
        assert kind in listed
        return
    name, *choice = rest.split()
    cls = gonio.models()[name]
    if choice:
        option: Any = cls.fields[choice[0]]
        assert choice[1] in option.values


def test_the_command_lists_parts_with_their_sources() -> None:
    result = run("list", "--parts")
    assert result.exit_code == 0
    assert "gonio.parts.fresnel: Fresnel reflectance and its approximations." in result.stdout
    assert "  F_lazanyi" in result.stdout
    assert "Source: Portsmouth, Kutz, Hill" in result.stdout
    rows = json.loads(run("list", "--parts", "--json").stdout)
    assert {"name", "module", "summary", "group", "source"} == set(rows[0])
    assert len(rows) == len(inventory.found_parts())


def test_the_plain_list_mentions_the_others_outside_of_its_output() -> None:
    result = run("list")
    assert "--parts" in result.stderr
    assert "--parts" not in result.stdout
    assert run("list", "--parts", "--materials").exit_code == 2
