"""Elastic plates: what a sheet's material does to bending, stretching and folding, in SI."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Plate"]


@dataclass(frozen=True)
class Plate:
    """A thin elastic sheet, isotropic and equally thick everywhere, and its creases.

    Attributes
    ----------
    thickness_mm, density_kg_m3 : of the sheet.
    youngs_modulus_mpa, poissons_ratio : of its material.
    crease_stiffness_n : moment that turns a crease, per length and radian (N m / m).

    >>> card = Plate(0.36, 833.0, 4000.0, 0.3, 0.3)
    >>> round(card.grams_per_m2), round(1e3 * card.bending_stiffness_nm, 2)
    (300, 17.09)
    """

    thickness_mm: float
    density_kg_m3: float
    youngs_modulus_mpa: float
    poissons_ratio: float
    crease_stiffness_n: float

    @property
    def grams_per_m2(self) -> float:
        """Mass by area."""
        return self.thickness_mm * self.density_kg_m3

    @property
    def bending_stiffness_nm(self) -> float:
        """Moment per width and curvature of a wide plate: E t^3 / 12 (1 - nu^2)."""
        modulus, thickness = 1e6 * self.youngs_modulus_mpa, 1e-3 * self.thickness_mm
        return modulus * thickness**3 / (12 * (1 - self.poissons_ratio**2))

    @property
    def stretching_stiffness_n_m(self) -> float:
        """Tension per width and strain of a strip: E t."""
        return 1e3 * self.youngs_modulus_mpa * self.thickness_mm
