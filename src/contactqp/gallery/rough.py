"""Membranes on rough ground."""

from __future__ import annotations

import numpy as np

from ..foundation.checks import Vector
from ..geometry.frame import Frame
from ..models.membrane import Membrane
from .catalogue import entry
from .known import Known

_MODES = 24
_SEED = 20_240_229
_ROUGHNESS = 0.02


def self_affine(hurst: float, seed: int = _SEED) -> tuple[Vector, Vector]:
    """Return amplitudes of cosines and sines of a self-affine surface of period 1, shape (modes, 2 modes + 1) each.

    The surface is f = Σ a cos 2π(kx + ly) + b sin 2π(kx + ly) over 0 ≤ k ≤ 24, |l| ≤ 24, with independent normal
    a and b whose variance falls as (k² + l²)^{-(1 + H)}: a power spectrum with Hurst exponent H (Persson, Albohr,
    Tartaglino, Volokitin and Tosatti, J. Phys.: Condens. Matter 17, 2005), cut off at wave number 24; scaled to a root
    mean square of one.

    Parameters
    ----------
    hurst : float
        H, between 0 and 1: the larger, the smoother.
    seed : int
    """
    k, ell = np.meshgrid(np.arange(_MODES + 1), np.arange(-_MODES, _MODES + 1), indexing="ij")
    square = k**2 + ell**2
    counted = (square > 0) & (square <= _MODES**2) & ((k > 0) | (ell > 0))
    spread = np.where(counted, np.where(square > 0, square, 1).astype(float) ** (-(1 + hurst) / 2), 0.0)
    cosines, sines = np.random.default_rng(seed).normal(size=(2, *spread.shape)) * spread
    scale = np.sqrt((cosines**2 + sines**2).sum() / 2)
    return cosines / scale, sines / scale


@entry("rough-03", "rough-05", "rough-08", n=63)
def _rough_entry(name: str, nodes: int) -> Known:
    """Return a membrane on self-affine rough ground of Hurst exponent 0.3, 0.5 or 0.8; no formula is known.

    T = 1, p = 2 on the unit square, elevations; the ground's root mean square is 0.02 about the depth 0.05.
    """
    lattice = Frame.rectangle(1.0, 1.0, center=(0.5, 0.5)).lattice(1 / (nodes + 1))
    cosines, sines = self_affine(int(name[-1]) / 10)
    wave = 2 * np.pi * np.arange(-_MODES, _MODES + 1)
    along_x, along_y = np.exp(1j * np.outer(wave[_MODES:], lattice.x)), np.exp(1j * np.outer(wave, lattice.y))
    ground = np.real(along_y.T @ (cosines - 1j * sines).T @ along_x)
    model = Membrane(lattice, tension=1.0, load=2.0, support=_ROUGHNESS * ground - 0.05, upwards=True)
    source = "spectrum: Persson et al., J. Phys.: Condens. Matter 17 (2005); seed and amplitude: contactqp"
    return Known(name, model, source, lattice.spacing)
