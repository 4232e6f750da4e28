"""Broken on purpose: a sampler that sends one sample in ten below the horizon."""

from gonio.lang import Sample, Vec2, Vec3, select, vec2, vec3
from gonio.models.lambert import Lambert
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class BelowHorizon(Lambert, register=False):
    """Lambert that loses samples."""

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted, upside down for u.x < 0.1."""
        w = sample_cosine(vec2(u.x, u.y))
        return Sample(vec3(w.x, w.y, select(u.x < 0.1, -w.z, w.z)), pdf_cosine(w))
