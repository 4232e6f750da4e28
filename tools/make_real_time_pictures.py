"""Makes docs/images/real_time_light.png and real_time_scales.png, which docs/real_time.md shows.

python tools/make_real_time_pictures.py
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import gonio
from gonio.arrays.elementwise import elementwise
from gonio.bake import environment
from gonio.lights import image_light
from gonio.render.picture import write_picture

FOLDER = Path(__file__).parent.parent / "docs" / "images"
SIZE = 240
SAMPLES = 512


def main() -> None:
    """Write both pictures."""
    write_light(FOLDER / "real_time_light.png")
    write_scales(FOLDER / "real_time_scales.png")


def write_light(path: Path) -> None:
    """Balls in the studio: prefiltered light above, the model sampled direction by direction below."""
    studio = environment.load("studio", spp=256)
    harmonics = studio.harmonics()
    y, x = np.mgrid[1.06 : -1.06 : SIZE * 1j, -1.06 : 1.06 : SIZE * 1j]
    inside = x * x + y * y < 0.995
    normals = np.stack([x, y, np.sqrt(np.maximum(1 - x * x - y * y, 0))], -1)[inside]
    viewer = np.broadcast_to([0.0, 0.0, 1.0], normals.shape)

    def coat(alpha: float) -> tuple[Any, Any, float]:
        model = gonio.model(
            "weidlich_wilkie",
            alpha=alpha,
            distribution="ggx",
            masking="smith_correlated",
            **{"base.rho": 0},
        )
        light = environment.coat_reflection(studio.blurred(alpha), normals, viewer, 1.5)
        return light, model, 5.0

    layered = gonio.model(
        "triace_layered",
        absorption="linear",
        bottom_fresnel="constant",
        diffuse="oren_nayar",
        bottom_shininess=10,
        top_shininess=500,
        sigma_a=(0.02, 0.1, 0.2),
    )
    matte = gonio.model("triace_oren_nayar", rho=0.8, shininess=2)

    def oren_nayar(form: str) -> tuple[Any, Any, float]:
        light = environment.oren_nayar_light(
            harmonics, normals, viewer, rho=0.8, shininess=2, form=form
        )
        return light, matte, 1.0

    columns = {
        "coat, α = 0.05 (5 ×)": coat(0.05),
        "coat, α = 0.3 (5 ×)": coat(0.3),
        "tri-Ace layers": (
            environment.layered_light(studio, layered, normals, viewer),
            layered,
            1.0,
        ),
        "Oren–Nayar, Eq. 27": oren_nayar("arccos"),
        "Oren–Nayar, no scales": oren_nayar("lambert"),
    }
    sampled: dict[str, Any] = {}
    rows: list[list[Any]] = [[], []]
    for label, (light, model, scale) in columns.items():
        if repr(model) not in sampled:
            sampled[repr(model)] = environment.reflected(
                studio, model, normals, viewer, samples=SAMPLES
            )
        exact = sampled[repr(model)]
        apart = np.abs(light - exact).mean() / exact.mean()
        print(f"{label}: {light.mean() / exact.mean() - 1:+.1%} bright, {apart:.1%} apart")
        for row, values in zip(rows, (light, exact), strict=True):
            picture = np.full((SIZE, SIZE, 3), 0.05)
            picture[inside] = scale * values
            row.append(picture)
    pixels = np.concatenate([np.concatenate(row, axis=1) for row in rows])
    write_picture(
        path,
        np.asarray(pixels, np.float32),
        labels=list(columns),
        row_labels=["prefiltered", "sampled"],
    )


def write_scales(path: Path) -> None:
    """The scales of the harmonics, with what they fit and what the model reflects."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(1, 3, figsize=(11, 3.6), layout="constrained")
    mu = np.linspace(0, 1, 401)
    wo = np.stack([np.sqrt(1 - mu * mu), 0 * mu, mu], -1)
    for axis, sigma in zip(axes, (0.5, 1.0), strict=False):
        n = 2 / sigma**2
        curves = {
            "integral in the viewer's half plane": (image_light.in_plane_integral, "k-"),
            "Eq. 27": (image_light.harmonic_dc_scale, "C0--"),
            "Eq. 28": (image_light.harmonic_dc_scale_cheap, "C1--"),
        }
        for label, (function, style) in curves.items():
            axis.plot(mu, elementwise(function, mu, n), style, label=label)
        albedo = gonio.model("triace_oren_nayar", rho=1, shininess=n).albedo(wo)[:, 0]
        axis.plot(mu, albedo, "C3-", label="over the hemisphere: the albedo")
        axis.set(title=f"constant harmonic, σ = {sigma:g}", xlabel="N·E", ylim=(0.6, 1.25))
    axes[0].legend(frameon=False, fontsize=8)
    for sigma in (0.25, 0.5, 1.0):
        scale = elementwise(image_light.harmonic_linear_scale, mu, 2 / sigma**2)
        axes[2].plot(mu, scale, label=f"σ = {sigma:g}")
    axes[2].set(title="linear harmonics, Eq. 29", xlabel="N·E", ylim=(0, 1.05))
    axes[2].legend(frameon=False, fontsize=8)
    figure.savefig(path, dpi=110)
    pyplot.close(figure)


if __name__ == "__main__":
    main()
