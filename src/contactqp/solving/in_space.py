"""Interactive views in space by PyVista: the deflected shape over its support."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..foundation.loading import needed
from ..io.meshes import INSTALL, surface_of
from ..plotting.answers import headline
from ..plotting.style import BLUE, CONTACT, GROUND

if TYPE_CHECKING:
    from ..models.base import ContactModel
    from ..models.records import Answered

_RISE = 0.3
"""Height of the picture over its width in plan."""


def plotter_of(solution: Answered, model: ContactModel, title: str | None) -> Any:
    """Return a `pyvista.Plotter` that shows a solution; see `Solution.plot3d`."""
    pyvista = needed("pyvista", "plot3d(interactive=True)", INSTALL)
    shape = surface_of(solution, model)
    below = shape.copy()
    support = np.asarray(below.point_data["support_elevation"])
    heights = shape.points[:, 2]
    reach = float(np.ptp(heights)) or 1.0
    # A support that lies deep would flatten the shape, and one that is not there is left out.
    below.points[:, 2] = np.maximum(np.nan_to_num(support, nan=-np.inf), heights.min() - reach)
    below = below.extract_points(np.isfinite(support) & (support >= heights.min() - reach), adjacent_cells=False)
    shape.point_data["touches"] = np.asarray(shape.point_data["contact"], dtype=np.float64)
    plotter = pyvista.Plotter()
    width = 5 if shape.celltypes[0] == pyvista.CellType.LINE else 1
    plotter.add_mesh(
        *(shape,),
        scalars="touches",
        cmap=[BLUE, CONTACT],
        clim=(0.0, 1.0),
        nan_color=BLUE,
        interpolate_before_map=False,
        show_scalar_bar=False,
        line_width=width,
    )
    if below.n_cells:
        plotter.add_mesh(below, color=GROUND, opacity=0.5, line_width=width)
    plan = max(np.ptp(shape.points[:, :2], axis=0).max(), np.finfo(float).tiny)
    plotter.set_scale(zscale=float(_RISE * plan / reach))
    if np.ptp(shape.points[:, 1]):
        plotter.view_vector((-1.0, -1.6, 1.4))
    else:
        plotter.view_xz()
    plotter.add_legend(
        [["contact", CONTACT], ["free", BLUE], ["support", GROUND]], bcolor=None, size=(0.2, 0.12), face="rectangle"
    )
    plotter.add_title(headline(solution) if title is None else title, font_size=9)
    return plotter
