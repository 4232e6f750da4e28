"""The gallery of ready materials."""

from __future__ import annotations

from gonio.materials import library, load_material
from gonio.materials.material import Material
from gonio.materials.notation import settings_of
from site_pages.markdown import fence, page, plain
from site_pages.models import cards, put
from site_pages.pictures import Pictures
from site_pages.sources import Sources

FOLDER = "materials"


def write(sources: Sources, pictures: Pictures) -> None:
    """The gallery, and a page for each material."""
    rows = []
    for name, path in library().items():
        material = load_material(name)
        address = put(sources, pictures.ball(name))
        rows.append((name, name, plain(material.description), address))
        text = path.read_text(encoding="utf-8")
        sources.write(f"{FOLDER}/{name}.md", _page(material, text, address))
    hidden = "\n".join(["```{toctree}", ":hidden:", "", *library(), "```"])
    head = (
        "`gonio render NAME` renders one, `gonio export NAME --to wgsl` writes its shader, "
        "`NAME:alpha=0.3` changes it; [Materials](../docs/materials.md) tells how to write your own."
    )
    sources.write(f"{FOLDER}/index.md", page("# Ready materials", head, cards(rows), hidden))


def _page(material: Material, text: str, address: str) -> str:
    models = [material.model.name]
    models += [str(v) for path, v in settings_of(material.model) if path.endswith("base")]
    links = " over ".join(f"[{m}](../models/{m}.md)" for m in models)
    name = material.name
    return page(
        f"# {name}",
        plain(material.description),
        f"![{name} on the shader ball]({address})",
        f'{links} · <a href="../live.html#a={name}">try it live</a>',
        fence(text, "toml"),
        fence(f"gonio render {name}\ngonio export {name} --to glsl --embed -o {name}.glsl", "sh"),
    )
