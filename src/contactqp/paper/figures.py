"""Pictures of the paper's example: sweeps against relaxation factors, contact maps, middle sections."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..foundation.loading import load_modules
from ..plotting.on_lattice import draw_frame_outline
from ..plotting.style import BLUE, CLEAR, CONTACT, GROUND, INK, new_figure, tidy
from .facts import MISPRINTED_LOAD, SURROGATE
from .sections import Section, middle_section, section_solutions

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..models.on_lattice import LatticeModel
    from ..solving.solution import Solution
    from .reproduction import Reproduction

_COLUMNS = 4


def plot_factor_curves(found: Reproduction) -> Figure:
    """Draw N against β for every load and both stopping rules, and mark the best factors and the paper's."""
    figure = new_figure(12.5, 6.2)
    both = figure.subplots(1, 2, sharey=True)
    colours = _colours(len(found.rows))
    for axes, rule, title in (
        (both[0], "step", "step rule: max|ω′ change| < 0.001"),
        (both[1], "residual", "residual rule: max|min(ω′, R′)| < 0.001"),
    ):
        for row, colour in zip(found.rows, colours, strict=True):
            found_scan = getattr(row, rule)
            axes.plot(found_scan.factors, found_scan.sweeps, ".-", color=colour, lw=1.3, ms=3)
            axes.plot(found_scan.best, [found_scan.least] * len(found_scan.best), "o", color=colour, ms=8, mec=INK)
            doubtful = row.paper.load == MISPRINTED_LOAD
            face = "white" if doubtful else CONTACT
            axes.plot(row.paper.factor, row.paper.sweeps, "D", ms=5, mfc=face, mec=CONTACT, mew=1.2, zorder=5)
            axes.annotate(
                f"{row.paper.load:.2f}",
                (found_scan.factors[0], found_scan.sweeps[0]),
                xytext=(-5, 0),
                textcoords="offset points",
                ha="right",
                va="center",
                fontsize="small",
                color=colour,
            )
        axes.set(yscale="log", xlabel="relaxation factor β", xlim=(0.92, 1.98), xticks=np.arange(1.0, 2.0, 0.1))
        axes.set_title(title, fontsize="medium")
        axes.set_yticks([20, 30, 50, 100, 200], labels=["20", "30", "50", "100", "200"])
        axes.minorticks_off()
        axes.annotate(
            "P′", (0.0, 1.0), xycoords="axes fraction", xytext=(12, -6), textcoords="offset points", color=INK
        )
        tidy(axes)
    both[0].set(ylabel="sweeps N")
    figure.legend(handles=_legend_of_curves(), loc="outside upper center", ncols=3, frameon=False, fontsize="small")
    _caption(figure, "PSOR row by row from ω = 0.")
    return figure


def plot_optimal_factors(found: Reproduction) -> Figure:
    """Draw theory's best relaxation factor against the load, with the scanned ones and the paper's."""
    figure = new_figure(9.5, 5.6)
    axes = figure.subplots()
    load = np.array([row.paper.load for row in found.rows])
    axes.plot(load, [row.optimal for row in found.rows], "-", color=INK, lw=1.6, label="theory, 2/(1 + √(1 - μ²))")
    for shift, rule, colour, marker, label in (
        (0.0, "long_run", INK, "x", "scanned, step rule, ε = 10⁻¹²"),
        (-0.0006, "step", BLUE, "o", "scanned, step rule, ε = 0.001"),
        (0.0006, "residual", GROUND, "s", "scanned, residual rule, ε = 0.001"),
    ):
        scans = [getattr(row, rule) for row in found.rows]
        for k, found_scan in enumerate(scans):
            axes.plot([load[k] + shift] * len(found_scan.best), found_scan.best, "-", color=colour, lw=2.2)
        abscissae = [load[k] + shift for k, each in enumerate(scans) for _ in each.best]
        ordinates = [factor for each in scans for factor in each.best]
        axes.plot(abscissae, ordinates, marker, color=colour, ms=6, label=label, ls="none")
    axes.plot(
        load, [row.paper.factor for row in found.rows], "D", ms=10, mfc="none", mec=CONTACT, label="the paper's β₀"
    )
    axes.set(xlabel="P′ = pΔ/T", ylabel="relaxation factor β", xticks=load)
    axes.set_title("The best relaxation factor", fontsize="medium")
    axes.legend(frameon=False, fontsize="small")
    tidy(axes)
    _caption(figure, "Joined marks: ties. μ: spectral radius of Jacobi's matrix on the final free set.")
    return figure


def plot_contact_maps(found: Reproduction) -> Figure:
    """Draw the support and the contact maps of all loads side by side, as Fig. 5 of the paper does."""
    load_modules("matplotlib.colors")
    from matplotlib.colors import ListedColormap

    maps = found.contact_maps
    rows = -(-(len(maps) + 1) // _COLUMNS)
    figure = new_figure(13.0, 2.5 * rows + 0.5)
    panels = figure.subplots(rows, _COLUMNS, sharex=True, sharey=True, squeeze=False).ravel()
    _draw_support(panels[0], figure, found.membrane)
    for axes, (load, contact) in zip(panels[1:], maps, strict=False):
        lattice = found.membrane.lattice
        grid = lattice.scatter(contact.astype(float))
        colours = ListedColormap([CLEAR, CONTACT])
        axes.pcolormesh(
            lattice.x, lattice.y, grid, cmap=colours, vmin=-0.5, vmax=1.5, shading="nearest", rasterized=True
        )
        draw_frame_outline(axes, found.membrane)
        name = "0" if load == 0 else f"{load:.2f}"
        axes.set_title(f"P′ = {name}: {np.count_nonzero(contact)} nodes settled", fontsize="medium")
    for axes in panels[: len(maps) + 1]:
        axes.set(aspect="equal", xticks=[-32, 0, 32], yticks=[-24, 0, 24])
        tidy(axes)
    for axes in panels[len(maps) + 1 :]:
        axes.set_visible(False)
    for axes in panels[-_COLUMNS:]:
        axes.set_xlabel("x/Δ")
    for axes in panels[::_COLUMNS]:
        axes.set_ylabel("y/Δ")
    _caption(figure, "Red: the membrane has settled.")
    return figure


def plot_sections(found: Reproduction) -> Figure:
    """Draw deflection and support, gap and reaction along the middle section, as Figs. 6-8 of the paper do."""
    chosen = section_solutions(found.path)
    figure = new_figure(4.3 * len(chosen) + 0.4, 7.2)
    grid = figure.subplots(3, len(chosen), sharex=True, sharey="row", squeeze=False, height_ratios=[2.4, 1.5, 1.5])
    for column, (load, solution) in enumerate(chosen):
        _draw_section(grid[:, column], middle_section(solution), solution)
        grid[0, column].set_title(f"P′ = {load:.2f}", fontsize="medium")
        grid[2, column].set_xlabel("x/Δ")
    grid[0, 0].invert_yaxis()
    for axes, label in zip(grid[:, 0], ("w′ = w/Δ, downwards", "ω′ = ω/Δ", "R′ = R/(TΔ)"), strict=True):
        axes.set_ylabel(label)
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=3, frameon=False, fontsize="small")
    _caption(figure, "Middle section y = 0.")
    return figure


def plot_touchdown(found: Reproduction) -> Figure:
    """Draw at which load each node settles: all contact maps in one picture."""
    figure = found.path.plot_touchdown()
    axes, scale = figure.axes
    axes.set(xlabel="x/Δ", ylabel="y/Δ", title="")
    scale.set_ylabel("P′ at which the node settles, middle of two loads")
    # The lower edge holds the legend.
    figure.suptitle(f"Between which loads of Table 1 each node settles.\n{SURROGATE}", fontsize="medium", color=INK)
    return figure


def _draw_section(axes: Any, section: Section, solution: Solution) -> None:
    shape, gaps, forces = axes
    left, right = section.frame
    floor = float(section.support.max())
    shape.fill_between(section.x, section.support, 1.12 * floor, color=GROUND, alpha=0.55, lw=0, label="support f/Δ")
    across = np.concatenate([[left], section.x, [right]])
    shape.plot(across, np.concatenate([[0.0], section.deflection, [0.0]]), color=BLUE, lw=1.8, label="membrane w′")
    settled = section.gap < section.reaction
    shape.plot(section.x[settled], section.deflection[settled], ".", color=CONTACT, ms=5, label="settled")
    gaps.plot(section.x, section.gap, ".-", color=INK, lw=1, ms=3)
    gaps.axhline(0, color=INK, lw=0.6)
    forces.vlines(section.x, 0, section.reaction, color=CONTACT, lw=1.6)
    forces.axhline(0, color=INK, lw=0.6)
    for each in axes:
        tidy(each)


def _draw_support(axes: Axes, figure: Figure, model: LatticeModel) -> None:
    lattice = model.lattice
    picture = axes.pcolormesh(
        lattice.x,
        lattice.y,
        lattice.scatter(model.support / lattice.spacing),
        cmap="cividis_r",
        shading="nearest",
        rasterized=True,
    )
    draw_frame_outline(axes, model)
    axes.set_title("the surrogate's depth f/Δ", fontsize="medium")
    inset = axes.inset_axes((1.02, 0.0, 0.04, 1.0))
    figure.colorbar(picture, cax=inset)
    inset.tick_params(labelsize="small")


def _colours(count: int) -> list[Any]:
    load_modules("matplotlib")
    from matplotlib import colormaps

    return list(colormaps["viridis_r"](np.linspace(0.15, 1.0, count)))


def _legend_of_curves() -> list[Any]:
    load_modules("matplotlib.lines")
    from matplotlib.lines import Line2D

    return [
        Line2D([], [], ls="none", marker="o", ms=8, color="0.6", mec=INK, label="best β (all ties)"),
        Line2D([], [], ls="none", marker="D", ms=5, color=CONTACT, label="β₀ and N of the paper"),
        Line2D(
            [], [], ls="none", marker="D", ms=5, mfc="white", mec=CONTACT, mew=1.2,
            label=f"the same at P′ = {MISPRINTED_LOAD:.2f}, probably a misprint",
        ),
    ]  # fmt: skip


def _caption(figure: Figure, text: str) -> None:
    figure.supxlabel(f"{text} {SURROGATE}", fontsize="small", color=INK)
