"""Writes docs/field.md: shading code of others, judged. 'make field' runs it.

Everything is fetched into a folder of its own: packages of npm by 'npm pack', MaterialX by pip, and BRDF
Explorer's files from --brdf-explorer FOLDER. None of their code goes into gonio's repository; the page has
commands, numbers, pictures of differences, and a sentence on each.
"""

from __future__ import annotations

import argparse
import json
import re
import shutil
import subprocess
import tarfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from importlib import metadata
from pathlib import Path
from typing import Any

import gonio
from gonio import foreign
from gonio.foreign import maps

ROOT = Path(__file__).parent.parent

# Packages of npm, with the versions that the page was made of.
PACKAGES = {
    "three": "0.187.0",
    "@babylonjs/core": "9.35.0",
    "@khronosgroup/gltf-viewer": "1.1.0",
    "glsl-diffuse-oren-nayar": "1.0.2",
}

THREE = "package/src/renderers/shaders/ShaderChunk"
BABYLON = "package/Shaders/ShadersInclude"


@dataclass(frozen=True)
class Entry:
    """One function of the field."""

    title: str
    origin: str
    """Package and version, or a key of PACKAGES."""
    code: str
    """As on the command line; {field} is the folder of fetched files."""
    says: str
    """What the code says it is."""
    verdict: str
    """What it is, with {albedo}, {largest} and {at80} from the measurement."""
    model: str = ""
    """What it is compared with, and drawn over."""
    options: dict[str, Any] = field(default_factory=dict)
    """Of `gonio.foreign.load`."""
    energy: bool = True
    other: str = ""
    """Another target, which is compared with it."""
    identify: bool = False
    """Whether {identity} is asked for."""


EON_NODE = {"uniforms": ["energy_compensation=1"], "mapping": ["color=rho"]}

ENTRIES = (
    Entry(
        "MaterialX: oren_nayar_diffuse_bsdf with energy compensation, GLSL",
        "materialx",
        "materialx#oren_nayar_diffuse_bsdf",
        "EON, the energy-preserving Oren-Nayar model (Portsmouth, Kutz, Hill).",
        "The cosine between light and viewer is cut at 0, so that what scatters forward is too bright: "
        "{at80} in the mirror direction at 80 degrees, roughness 1; the albedo reaches {albedo}, "
        "where EON has "
        "at most 1. Backwards it is EON. GLSL and Slang agree to {targets}.",
        "eon",
        EON_NODE,
        other="slang",
    ),
    Entry(
        "MaterialX: sheen_bsdf, mode conty_kulla, GLSL",
        "materialx",
        "materialx#sheen_bsdf",
        "Imageworks' sheen (Estevez and Kulla 2017).",
        "By itself it reflects up to {albedo} of the light, at grazing angles and small roughness.",
        "charlie",
        {"mapping": ["color=rho roughness=alpha"], "ranges": ["alpha=0.05..1"]},
    ),
    Entry(
        "MaterialX: sheen_bsdf as it is, roughness 0.3",
        "materialx",
        "materialx#sheen_bsdf",
        "Imageworks' sheen at the roughness that the node has by itself.",
        "With a white colour it reflects up to {albedo} of the light, at grazing angles.",
        options={"uniforms": ["roughness=0.3"]},
    ),
    Entry(
        "MaterialX: sheen_bsdf, roughness 0.077",
        "materialx",
        "materialx#sheen_bsdf",
        "The same at a smaller roughness.",
        "With a white colour it reflects up to {albedo} of the light. It passes 1 below a roughness of "
        "0.2.",
        options={"uniforms": ["roughness=0.077"]},
    ),
    Entry(
        "MaterialX: conductor_bsdf, GLSL and Slang",
        "materialx",
        "materialx#conductor_bsdf",
        "GGX with Smith's masking, Fresnel of a metal, and compensation of what multiple scattering "
        "loses.",
        "The largest albedo is {albedo}, at grazing angles where an index below 1 without extinction "
        "reflects everything: the compensation gives back a little more than was lost. GLSL and Slang "
        "agree to {targets}.",
        options={"ranges": ["roughness=0.05..1"], "uniforms": ["thinfilm_thickness=0"]},
        other="slang",
    ),
    Entry(
        "MaterialX: gltf_pbr, GLSL",
        "materialx",
        "materialx#gltf_pbr",
        "glTF 2.0's metallic-roughness material with its extensions.",
        "The largest albedo over all angles and parameters is {albedo}, {where}.",
        options={
            "ranges": ["roughness=0.1..1", "clearcoat_roughness=0.1..1", "sheen_roughness=0.1..1"],
            "uniforms": ["anisotropy_strength=0", "iridescence=0"],
        },
    ),
    Entry(
        "three.js: BRDF_EON",
        "three",
        "{field}/three.glsl#BRDF_EON",
        "EON with the paper's fitted albedo.",
        "It differs from EON with the fitted albedo by at most {largest}; the largest albedo is "
        "{albedo}.",
        "eon:albedo_form=fitted",
        {"defines": ["USE_DIFFUSE_ROUGHNESS"], "mapping": ["diffuseColor=rho"]},
    ),
    Entry(
        "three.js: BRDF_Sheen",
        "three",
        "{field}/three.glsl#BRDF_Sheen",
        "Imageworks' distribution with Neubelt and Pettineo's visibility.",
        "With alpha = sheenRoughness^2 it is charlie but for two cuts: sin^2 is at least 0.0078 "
        "(for half "
        "precision), so that it is not black in the mirror direction, and the visibility is at most "
        "1, which "
        "keeps grazing angles down; the largest albedo is {albedo} still. At sheenRoughness 0 it is "
        "not a number.",
        "charlie",
        {
            "defines": ["USE_SHEEN"],
            "mapping": ["sheenColor=rho sheenRoughness=sqrt(alpha)"],
            "ranges": ["alpha=0.05..1"],
        },
    ),
    Entry(
        "Babylon.js: diffuseBRDF_EON",
        "@babylonjs/core",
        "{field}/babylon.glsl#diffuseBRDF_EON",
        "EON with the paper's fitted albedo.",
        "It differs from EON with the fitted albedo by at most {largest}; the largest albedo is "
        "{albedo}.",
        "eon:albedo_form=fitted",
        {"mapping": ["albedo=rho"]},
    ),
    Entry(
        "Babylon.js: diffuseBRDF_Burley",
        "@babylonjs/core",
        "{field}/babylon.glsl#diffuseBRDF_Burley",
        "Burley's diffuse term (2012), whose colour is multiplied later.",
        "It differs from Burley's with a white colour by at most {largest}; the largest albedo is "
        "{albedo}, as large as Burley's own.",
        "burley_diffuse:rho=1",
        {"returns": "f"},
    ),
    Entry(
        "glTF-Sample-Renderer: BRDF_specularGGXAnisotropy",
        "@khronosgroup/gltf-viewer",
        "{field}/gltf.glsl#BRDF_specularGGXAnisotropy",
        "GGX with Smith's masking along two tangents (KHR_materials_anisotropy).",
        "At anisotropy 0 it should be the isotropic lobe of the same file. It is, but where the visibility "
        "term would be larger than 1: there it is cut, as for half precision, and darker, by up to so much "
        "of the value, by the larger angle: {bands}.",
        "{field}/gltf.glsl#BRDF_specularGGX",
        {
            "defines": ["MATERIAL_ANISOTROPY"],
            "uniforms": ["anisotropy=0"],
            "ranges": ["alphaRoughness=0.05..1"],
            "returns": "f",
        },
    ),
    Entry(
        "glTF-Sample-Renderer: BRDF_specularSheen",
        "@khronosgroup/gltf-viewer",
        "{field}/gltf.glsl#BRDF_specularSheen",
        "Imageworks' sheen with its masking (Estevez and Kulla 2017), alpha = sheenRoughness^2.",
        "The masking is Imageworks', cut at 1; the albedo reaches {albedo}.",
        options={"ranges": ["sheenRoughness=0.1..1"], "returns": "f"},
    ),
    Entry(
        "npm: glsl-diffuse-oren-nayar",
        "glsl-diffuse-oren-nayar",
        "{field}/glsl-diffuse-oren-nayar/package/index.glsl#orenNayarDiffuse",
        "The Oren-Nayar model, times the cosine.",
        "In Oren and Nayar's A (1994, Eq. 30) the term 0.5 sigma^2 / (sigma^2 + 0.33) is "
        "subtracted, and that "
        "of interreflection has a factor of 0.17; here the first is added and the factor is "
        "missing. The "
        "albedo reaches {albedo}.",
        "oren_nayar",
        {"mapping": ["roughness=sigma albedo=rho"], "returns": "f cos", "ranges": ["sigma=0..1.5"]},
    ),
)


def main() -> None:
    """Fetch, measure, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--folder", type=Path, default=ROOT / "build" / "field", help="For what is fetched."
    )
    parser.add_argument(
        "--brdf-explorer", type=Path, help="The folder of BRDF Explorer's .brdf files."
    )
    parser.add_argument("--output", type=Path, default=ROOT / "docs" / "field.md")
    parser.add_argument("--only", help="Entries whose title has this word.")
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    entries = [*ENTRIES, *(_explorer(given.brdf_explorer) if given.brdf_explorer else ())]
    chosen = [e for e in entries if not given.only or given.only.lower() in e.title.lower()]
    if any(entry.origin in PACKAGES for entry in chosen):
        fetch(given.folder)
    pictures = given.output.parent / "images"
    # What is not measured now stays as it was
    parts = _sections(given.output)
    for number, entry in enumerate(chosen):
        print(f"{number + 1} of {len(chosen)}: {entry.title}", flush=True)
        parts[entry.title] = _section(entry, given.folder, pictures)
        known = [e.title for e in (*ENTRIES, *EXPLORER)]
        text = "\n\n".join([HEAD.strip(), *(parts[title] for title in known if title in parts)])
        given.output.write_text(text + "\n", encoding="utf-8")


def _sections(page: Path) -> dict[str, str]:
    """The sections of a page, by their titles."""
    if not page.is_file():
        return {}
    found = page.read_text(encoding="utf-8").split("\n## ")[1:]
    return {part.partition("\n")[0]: f"## {part.strip()}" for part in found}


def fetch(folder: Path) -> None:
    """npm's packages, unpacked; shaders that are strings of JavaScript as files."""
    for name, version in PACKAGES.items():
        plain = name.replace("@", "").replace("/", "-")
        target = folder / plain
        if target.is_dir():
            continue
        if shutil.which("npm") is None:
            raise SystemExit("npm is needed to fetch packages; apt-get install npm")
        subprocess.run(["npm", "pack", "--silent", f"{name}@{version}"], cwd=folder, check=True)
        with tarfile.open(folder / f"{plain}-{version}.tgz") as archive:
            archive.extractall(target, filter="data")
    chunks = ("common", "bsdfs", "lights_physical_pars_fragment")
    three = [_string(folder / "three" / THREE / f"{name}.glsl.js") for name in chunks]
    (folder / "three.glsl").write_text("\n".join(three), encoding="utf-8")
    bundle = (folder / "khronosgroup-gltf-viewer/package/dist/gltf-viewer.module.js").read_text(
        encoding="utf-8"
    )
    gltf = [_variable(bundle, name) for name in ("shaderFunctions", "brdfShader")]
    (folder / "gltf.glsl").write_text("\n".join(gltf), encoding="utf-8")
    names = ("helperFunctions", "pbrBRDFFunctions")
    babylon = [_string(folder / "babylonjs-core" / BABYLON / f"{name}.js") for name in names]
    (folder / "babylon.glsl").write_text("\n".join(babylon), encoding="utf-8")


def _variable(text: str, name: str) -> str:
    """The text that a variable of JavaScript has."""
    match = re.search(rf'var {name} = ("(?:\\.|[^"\\])*")', text)
    if match is None:
        raise SystemExit(f"there is no {name} in the package")
    return str(json.loads(match[1]))


def _string(path: Path) -> str:
    text = path.read_text(encoding="utf-8")
    return text[text.index("`") + 1 : text.rindex("`")]


# BRDF Explorer's files that are models of their own; those of single terms (d_, f_, g_) and the two that
# show angles and vectors are no BRDFs.
EXPLORER = (
    Entry(
        "BRDF Explorer: cooktorrance.brdf, as it opens",
        "",
        "cooktorrance.brdf",
        "Cook and Torrance's model (1982), with switches for its Fresnel term and its masking, both on.",
        "{identity} The switch of the masking is inverted: what is on leaves it out. The albedo grows "
        "without bound towards the horizon: {albedo} at a cosine of 1e-6.",
        options={"returns": "f", "ranges": ["m=0.05..0.3"]},
        identify=True,
    ),
    Entry(
        "BRDF Explorer: cooktorrance.brdf with include_G=0",
        "",
        "cooktorrance.brdf",
        "Cook and Torrance's model (1982) without its masking.",
        "{identity} This has the masking. Beckmann's distribution has no 1 / pi here, and nothing divides "
        "by 4, or by Cook and Torrance's pi, so that it is 4 pi times as bright as Torrance and Sparrow's "
        "model: the albedo reaches {albedo}.",
        options={"returns": "f", "ranges": ["m=0.05..0.3"], "uniforms": ["include_G=0"]},
        identify=True,
    ),
    Entry(
        "BRDF Explorer: walter.brdf",
        "",
        "walter.brdf",
        "GGX (Walter et al. 2007) over Lambert.",
        "{identity} The albedo reaches {albedo} where both weights are 1, as a plain sum does.",
        options={"returns": "f", "ranges": ["alphaG=0.1..1"]},
        identify=True,
    ),
    Entry(
        "BRDF Explorer: orennayar.brdf",
        "",
        "orennayar.brdf",
        "The full model of Oren and Nayar (1994, Eqs. 30 and 31), sigma in degrees.",
        "Straight along the normal, where an azimuth is 0 / 0, it is not a number. Elsewhere it is the "
        "model: 999 of 1000 random pairs of directions differ by at most {typical}, which is the driver's "
        "arc cosine. The albedo reaches {albedo}, as the model's own.",
        "oren_nayar",
        {
            "mapping": ["sigma=57.295779513*sigma"],
            "ranges": ["sigma=0.02..1.5"],
            "returns": "f",
        },
    ),
    Entry(
        "BRDF Explorer: disney.brdf",
        "",
        "disney.brdf",
        "Burley's principled model (2012), whose colour is taken to the power of 2.2.",
        "With the masking of the highlight's own width, as its author later had it, it is the model: "
        "999 of 1000 random pairs of directions and parameters differ by at most {typical}.",
        "disney:masking=anisotropic",
        {
            "mapping": [
                "baseColor=base_color^0.45454545 specularTint=specular_tint sheenTint=sheen_tint "
                "clearcoatGloss=clearcoat_gloss"
            ],
            "ranges": ["roughness=0.1..1", "base_color=0.02..1"],
            "returns": "f",
        },
    ),
    Entry(
        "BRDF Explorer: ward.brdf",
        "",
        "ward.brdf",
        "Ward's model (1992) as in Walter's notes (2005).",
        "It differs from gonio's, in the form of 1992, by at most {largest}. Its highlight grows without "
        "bound towards the horizon, as Ward's does: at cosines of 1e-6 the albedo is {albedo}.",
        "ward:form=ward",
        {
            "mapping": ["Cs=specular Cd=rho"],
            "ranges": ["alpha_x=0.05..1", "alpha_y=0.05..1"],
            "returns": "f",
        },
    ),
    Entry(
        "BRDF Explorer: ashikhman_shirley.brdf",
        "",
        "ashikhman_shirley.brdf",
        "Ashikhmin and Shirley's model (2000), with one exponent unless a switch says otherwise.",
        "With two exponents it is the model: 999 of 1000 random pairs of directions and parameters "
        "differ by at most {typical}. Where the half vector is the normal, 0 is divided by 0. The "
        "albedo reaches {albedo}.",
        "ashikhmin_shirley",
        {
            "mapping": ["nu=shininess_x nv=shininess_y Rs=f0 Rd=rho"],
            "ranges": ["shininess_x=1..1000", "shininess_y=1..1000"],
            "uniforms": ["isotropic=0"],
            "returns": "f",
        },
    ),
    Entry(
        "BRDF Explorer: minnaert.brdf",
        "",
        "minnaert.brdf",
        "Minnaert's model.",
        "It differs from gonio's with a white colour by at most {largest}.",
        "minnaert:rho=1",
        {"returns": "f"},
    ),
    Entry(
        "BRDF Explorer: modifiedphong.brdf",
        "",
        "modifiedphong.brdf",
        "Phong's lobe with Lafortune and Willems' factor (n + 2) / (2 pi).",
        "{identity} The albedo reaches {albedo}.",
        options={"returns": "f"},
        identify=True,
    ),
    *(
        Entry(
            f"BRDF Explorer: {name}.brdf",
            "",
            f"{name}.brdf",
            says,
            "{identity} The albedo reaches {albedo}. Exchanging light and viewer changes it, by up to "
            "{reciprocity} of its value.",
            options={"returns": "f"},
            identify=True,
        )
        for name, says in (
            ("blinnphong", "Blinn's lobe, divided by N.L unless a switch says otherwise."),
            ("phong", "Phong's lobe, divided by N.L unless a switch says otherwise."),
        )
    ),
    *(
        Entry(
            f"BRDF Explorer: {name}.brdf",
            "",
            f"{name}.brdf",
            says,
            "The albedo reaches {albedo}; exchanging light and viewer {reciprocal}.",
            options={"returns": "f"},
        )
        for name, says in (
            (
                "blinn",
                "Blinn's model (1977) with a Gaussian, divided by N.L unless a switch says otherwise.",
            ),
            (
                "compare",
                "A lobe whose terms are chosen by switches; as it opens, GGX without masking.",
            ),
            ("dAniso", "Disney's anisotropic highlight after Kajiya and Kay (1989)."),
            ("edwards06", "Edwards and others' halfway vector disk (2006)."),
            ("lambert", "Lambert's model."),
            ("schlick", "Schlick's Fresnel term alone (1994)."),
            ("stretchedphong", "Phong's lobe, divided by a power of the larger cosine."),
        )
    ),
)


def _explorer(folder: Path) -> Sequence[Entry]:
    """The .brdf files of BRDF Explorer in a folder, with what is known of them."""
    found = []
    places = {path.name: path for path in sorted(folder.rglob("*.brdf"))}
    for entry in EXPLORER:
        if (path := places.get(entry.code)) is None:
            raise SystemExit(f"{folder} has no {entry.code}; give BRDF Explorer's src/brdfs")
        found.append(replace(entry, origin="wdas/brdf", code=str(path)))
    return found


def _section(entry: Entry, folder: Path, pictures: Path) -> str:
    """Measure one entry and describe it."""
    code = foreign.load(entry.code.format(field=folder), **entry.options)
    found: dict[str, str] = {}
    shown = entry.code.format(field="build/field")
    if entry.origin == "wdas/brdf":
        shown = f"src/brdfs/{Path(entry.code).name}"
    commands = []
    options = _options(entry.options)
    if entry.energy:
        both = "{reciproc" in entry.verdict
        only = ["energy", "reciprocity"] if both else ["energy"]
        reports = foreign.check(code, "normal", only=only)  # as the command does
        measured = {f.what: f for r in reports for f in r.findings}
        if "relative difference" in measured:
            off = measured["relative difference"].measured
            found["reciprocity"] = f"{off:.2g}"
            changed = f"changes it by up to {off:.2g} of its value"
            found["reciprocal"] = changed if off > 1e-3 else "changes nothing"
        largest = measured["largest albedo"]
        found["albedo"] = f"{largest.measured:.3g}"
        found["where"] = f"at {(largest.replay or '').partition('wo = ')[2]}"
        commands.append(f"gonio check {shown}{options} --only {','.join(only)}")
    if entry.identify:
        said = foreign.identify(code, ["lambert"]).lines()
        found["identity"] = _sentence(said)
        commands.append(f"gonio compare {shown} --identify{options}")
    picture = ""
    if entry.model:
        name = entry.model.format(field=folder)
        options_of = {k: v for k, v in entry.options.items() if k in ("ranges", "returns")}
        model: Any = (
            foreign.load(name, **options_of) if "#" in name else gonio.materials.load_model(name)[0]
        )
        difference = foreign.compare(code, model)
        found["largest"] = f"{difference.largest:.2g}" if difference.largest else "a rounding"
        found["typical"] = f"{_typical(code, model):.1g}" if "{typical}" in entry.verdict else ""
        found["bands"] = ", ".join(
            f"{d:.2g} between {a:g} and {b:g} degrees" for a, b, d in difference.bands if d > 1e-3
        )
        if "{at80}" in entry.verdict:
            found["at80"] = f"{_forward(code, model):.3g} times too bright"
        name = "field_" + "".join(c if c.isalnum() else "_" for c in entry.title.lower()) + ".png"
        maps.write(pictures / name, [difference])
        beside = entry.model.format(field="build/field")
        picture = f"\n![where it differs from {beside}](images/{name})\n"
        commands.append(f"gonio compare {shown} {beside}{options} -o difference.png")
    if entry.other:
        other = foreign.load(f"{entry.code}@{entry.other}", **entry.options)
        apart = foreign.compare(code, other).largest
        found["targets"] = f"{apart:.2g}" if apart else "a rounding"
        commands.append(f"gonio compare {shown} {shown}@{entry.other}{options}")
    lines = "\n".join(f"    {command}" for command in commands)
    return (
        f"## {entry.title}\n\n{_origin(entry.origin)}\n\n{lines}\n{picture}\n"
        f"**It says:** {entry.says}\n\n**It is:** {entry.verdict.format(**found)}"
    )


def _sentence(lines: Sequence[str]) -> str:
    """What --identify says, without the name of the code."""
    first = lines[0].partition(" is")[2].lstrip(":, ")
    rest = [line.strip().partition(". ")[2] for line in lines[1:] if line.strip()[0].isdigit()]
    odd = [line.partition(": ")[2] for line in lines if "unusual" in line]
    text = f"It is {first}" + ("; and ".join(rest) and f" {'; and '.join(rest)}")
    return text + (f"; unusual is: {'; '.join(odd)}." if odd else ".")


def _forward(code: foreign.Foreign, model: Any) -> float:
    """How many times too bright code is in the mirror direction at 80 degrees, at the roughest."""
    import numpy as np

    a = np.radians(80)
    wi = np.array([[-np.sin(a), 0, np.cos(a)]])
    values = {n: p.high if p.width == 1 else (0.8,) * 3 for n, p in code.parameters.items()}
    known = {n: v for n, v in values.items() if n in model.fields}
    return float(
        code.brdf(wi, wi * [-1, 1, 1], values)[0, 0]
        / np.asarray(model.replace(**known).eval(wi, wi * [-1, 1, 1]))[0, 0]
    )


def _typical(code: foreign.Foreign, model: Any) -> float:
    """What 999 of 1000 values differ by at most, of the larger value, at random places."""
    import numpy as np

    from gonio.foreign.compared import evaluate

    rng = np.random.default_rng(1)
    z, phi = rng.uniform(0.02, 1, (2, 20000)), rng.uniform(0, 2 * np.pi, (2, 20000))
    s = np.sqrt(1 - z * z)
    wi, wo = np.stack([s * np.cos(phi), s * np.sin(phi), z], -1)
    known = {path for path, _, _ in model.parameters()}
    values = {
        name: p.low + (p.high - p.low) * rng.random((20000, 3) if p.width == 3 else 20000)
        for name, p in code.parameters.items()
    }
    f = code.brdf(wi, wo, values)
    g = evaluate(model, wi, wo, {n: v for n, v in values.items() if n in known})
    scale = np.maximum(np.maximum(np.abs(f), np.abs(g)), 1e-4)
    return float(np.nanquantile(np.abs(f - g) / scale, 0.999))


def _options(given: dict[str, Any]) -> str:
    words: dict[str, Callable[[Any], str]] = {
        "mapping": lambda v: "".join(f' --map "{x}"' for x in v),
        "ranges": lambda v: "".join(f" --range {x}" for x in v),
        "uniforms": lambda v: "".join(f" --uniform {x}" for x in v),
        "defines": lambda v: "".join(f" -D {x}" for x in v),
        "returns": lambda v: f' --returns "{v}"',
    }
    return "".join(words[name](value) for name, value in given.items())


def _origin(name: str) -> str:
    if name in PACKAGES:
        return f"`{name}` {PACKAGES[name]} of npm."
    if name == "wdas/brdf":
        return "BRDF Explorer, `src/brdfs` of github.com/wdas/brdf."
    if name == "materialx":
        return f"`materialx` {metadata.version('MaterialX')} of PyPI."
    return f"{name}."


HEAD = """
# The field: shading code of others, judged

Made by `make field`, which fetches the packages that are named (none of their code is in gonio), runs
the commands below, and writes this page. Every number is measured by these commands: `gonio check` searches
for the largest directional albedo over all angles and parameters, `gonio compare` for the largest
difference, of the larger value. Pictures: on the left both angles in the plane of incidence, then all
around the normal for the viewer with the largest difference, red where the code is too bright; on the right
the largest difference over a parameter.

These are good libraries, and most of what they do is right; a gain of energy in a corner of the parameters
may never be seen. What is said here is meant to be checked and, where it is a fault, to be mended.
"""

if __name__ == "__main__":
    main()
