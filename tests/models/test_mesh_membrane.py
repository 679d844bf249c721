"""Membranes on meshes of triangles: against closed forms, lattices and formulas, and what is refused in words."""

import meshio
import numpy as np
import pytest
import skfem
from hypothesis import given
from hypothesis import strategies as st
from meshes import assembled
from strategies import lattice_masks
from triangulations import deflection_of_disk, obtuse_rings, rings, split_lattice, touching

import contactqp as cq
from contactqp.geometry.triangles import TriangleMesh
from contactqp.models.varied import with_lift, with_load, with_tension

SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.5]]
FOUR = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]


def square(**changes):
    given = {"points": SQUARE, "triangles": FOUR, "tension": 2.0, "load": 3.0, "support": 0.1}
    return cq.MeshMembrane(**(given | changes))


def disk(refinements=4, **changes):
    given = {"tension": 1.0, "load": 4.0, "support": 0.5}
    return cq.MeshMembrane.from_skfem(skfem.MeshTri.init_circle(refinements), **(given | changes))


def test_a_node_in_a_square_by_hand():
    """The angles across each of four spokes are 45°: T (cot 45° + cot 45°)/2 = 2 each; a third of the area is 1/3."""
    model = square()
    np.testing.assert_allclose(model.problem.G.toarray(), [[8.0]], rtol=1e-14)
    np.testing.assert_allclose(model.node_area, [1 / 3], rtol=1e-14)
    solution = cq.solve(model)
    np.testing.assert_allclose(solution.reaction, [3.0 / 3 - 0.1 * 8], rtol=1e-12)
    np.testing.assert_allclose(solution.contact_pressure, solution.reaction * 3, rtol=1e-12)
    assert solution.max_slope == pytest.approx(0.2)
    assert repr(model) == "MeshMembrane(1 node, 4 triangles, 4 fixed points, tension=2, load=3, support=0.1)"
    assert model.describe(0) == "node 0 (point 4, x=0.5, y=0.5)"


@pytest.mark.filterwarnings("ignore::contactqp.ContactWarning")
@given(lattice_masks(), st.sampled_from([1.0, 0.1, 2.5]), st.integers(0, 2**32 - 1))
def test_on_a_lattice_cut_into_triangles_it_is_the_membrane(mask, spacing, seed):
    rng = np.random.default_rng(seed)
    lattice = cq.Lattice(mask, spacing, origin=(0.3, -0.7))
    fields = {
        "load": rng.uniform(-1, 2, lattice.size),
        "support": rng.uniform(0, 0.5, lattice.size),
        "ceiling": rng.uniform(-0.5, 0, lattice.size),
        "foundation": rng.uniform(0, 2, lattice.size),
        "frame_height": lambda x, y: 0.1 * x - 0.3 * y**2,
    }
    membrane = cq.Membrane(lattice, 1.7, **fields)
    points, triangles = split_lattice(lattice)
    inside = np.arange(len(points)) >= lattice.size
    on_mesh = cq.MeshMembrane(points, triangles, 1.7, fixed=inside, **fields)
    np.testing.assert_allclose(on_mesh.node_area, membrane.node_area, rtol=1e-12)
    expected = membrane.problem.G.toarray()
    np.testing.assert_allclose(on_mesh.problem.G.toarray(), expected, rtol=1e-12, atol=1e-12 * expected.max())
    assert on_mesh.problem.G.nnz == membrane.problem.G.nnz  # what is zero but for rounding is no entry
    scale = np.abs(membrane.problem.q).max()
    np.testing.assert_allclose(on_mesh.problem.q, membrane.problem.q, atol=1e-11 * scale)
    gaps = [cq.solve(model, tol=1e-9).gap for model in (on_mesh, membrane)]
    np.testing.assert_allclose(*gaps, atol=1e-8)


def test_stiffness_and_areas_are_those_of_linear_elements():
    points, triangles = obtuse_rings(5)
    tension = np.random.default_rng(1).uniform(0.5, 2.0, len(triangles))
    model = cq.MeshMembrane(points, triangles, 1.0, load=1.0, support=1.0)
    matrix, areas, places = assembled(points, triangles, ~np.isin(np.arange(len(points)), model.fixed))
    np.testing.assert_allclose(model.problem.G.toarray(), matrix.toarray(), atol=1e-12)
    np.testing.assert_allclose(model.node_area, areas, rtol=1e-12)
    np.testing.assert_array_equal(np.column_stack([model.node_x, model.node_y]), places)
    varied = cq.MeshMembrane(points, triangles, tension, load=1.0, support=1.0)
    heights = np.random.default_rng(2).normal(size=len(points))
    heights[model.fixed] = 0.0
    slopes = model.mesh.gradients(heights)
    energy = (tension * model.mesh.areas * (slopes**2).sum(axis=1)).sum()
    w = heights[model.free]
    assert w @ varied.problem.G @ w == pytest.approx(energy, rel=1e-12)
    assert w @ varied.pull(w) == pytest.approx(energy, rel=1e-12)
    by_function = cq.MeshMembrane(points, triangles, lambda x, y: 1 + x * x, load=1.0, support=1.0)
    np.testing.assert_allclose(by_function.tension, 1 + model.mesh.middles[:, 0] ** 2)


@pytest.mark.slow
@pytest.mark.parametrize("mesh", ["circles", "rings"])
def test_a_disk_over_a_floor_converges_with_second_order(mesh):
    """The largest error of several floors, as that of one depends on how its contact's rim lies between the nodes."""
    errors = []
    for k in (4, 7):
        circle = skfem.MeshTri.init_circle(k)
        points, triangles = (circle.p.T, circle.t.T) if mesh == "circles" else rings(2**k)
        found = []
        for floor in np.linspace(0.3, 0.7, 9):
            model = cq.MeshMembrane(points, triangles, 1.0, load=4.0, support=floor)
            solution = cq.solve(model, tol=1e-9)
            assert solution.status == "certified"
            exact = deflection_of_disk(model.node_x, model.node_y, 4.0, floor)
            found.append(np.abs(solution.deflection - exact).max())
        errors.append(max(found))
    assert np.log2(errors[0] / errors[1]) / 3 >= 1.9


@pytest.mark.parametrize("seed", [0, 1])
def test_obtuse_triangles_are_solved_and_certified(seed):
    errors = []
    for count in (8, 32):
        points, triangles = obtuse_rings(count, seed)
        model = cq.MeshMembrane(points, triangles, 1.0, load=4.0, support=0.5)
        assert model.edge_stiffness.min() < -0.01
        assert not model.problem.is_m_matrix
        solution = cq.solve(model, tol=1e-8)
        assert solution.status == "certified"
        assert solution.backend == "active-set"
        errors.append(np.abs(solution.deflection - deflection_of_disk(model.node_x, model.node_y, 4.0, 0.5)).max())
        assert abs(solution.force_balance.imbalance) < 1e-12
    assert errors[1] < errors[0] / 7
    assert np.sqrt(solution.contact_area.lower / np.pi) == pytest.approx(touching(4.0, 0.5), abs=0.03)


def test_the_sense_of_rotation_does_not_matter():
    turned = [corners[::-1] if k % 2 else corners for k, corners in enumerate(FOUR)]
    np.testing.assert_array_equal(square(triangles=turned).problem.G.toarray(), square().problem.G.toarray())


def test_forces_are_in_balance_with_all_parts():
    points, triangles = obtuse_rings(6)
    model = cq.MeshMembrane(
        *(points, triangles, lambda x, y: 2 + x),
        load=lambda x, y: np.where(x < 0, 4.0, -4.0),
        support=0.2,
        ceiling=-0.1,
        foundation=0.5,
        frame_height=lambda x, y: 0.05 * y,
    )
    solution = cq.solve(model)
    assert solution.status == "certified"
    balance = solution.force_balance
    assert solution.contact_lower.any()
    assert solution.contact_upper.any()
    assert balance.load == pytest.approx((model.load * model.node_area).sum())
    assert balance.ceiling == pytest.approx(-solution.reaction[solution.contact_upper].sum())
    assert balance.foundation == pytest.approx((0.5 * model.node_area * solution.deflection).sum())
    assert abs(balance.imbalance) < 1e-12
    np.testing.assert_allclose(solution.contact_pressure[solution.contact] * model.node_area[solution.contact],
                               solution.reaction[solution.contact])  # fmt: skip


def test_elevations_are_depths_turned_over():
    dome = cq.profiles.Paraboloid(depth=0.3, radius=3.0)
    down = disk(load=2.0, support=dome, frame_height=lambda x, y: 0.1 * x)
    up = disk(load=2.0, support=dome, frame_height=lambda x, y: -0.1 * x, upwards=True)
    np.testing.assert_array_equal(up.problem.q, down.problem.q)
    np.testing.assert_array_equal(cq.solve(up).deflection, -cq.solve(down).deflection)


@pytest.mark.parametrize(
    ("fixed", "expected"),
    [
        (None, [0, 1, 2, 3]),
        ("left", [0, 3]),
        (["left", "corner"], [0, 2, 3]),
        ([1, 0], [0, 1]),
        (np.array([False, True, False, False, True]), [1, 4]),
        (lambda x, y: y == 0, [0, 1]),
        (lambda x, y: x > 0.9 and y > 0.9, [2]),
    ],
)
def test_points_may_be_fixed_in_many_ways(fixed, expected):
    groups = {"left": [[0, 3]], "corner": [2]}
    model = square(fixed=fixed, groups=groups)
    np.testing.assert_array_equal(model.fixed, expected)
    assert cq.solve(model).status == "certified"


def test_a_boundary_that_is_not_fixed_is_free():
    """A strip that is held at x = 0 and x = 1 only hangs as a cable does: w = p x (1 - x) / 2T."""
    strip = skfem.MeshTri.init_tensor(np.linspace(0, 1, 11), np.linspace(0, 0.3, 4))
    model = cq.MeshMembrane.from_skfem(strip, 2.0, load=1.0, support=np.inf, fixed=lambda x, y: (x == 0) | (x == 1))
    x = model.node_x
    np.testing.assert_allclose(cq.solve(model, tol=1e-10).deflection, x * (1 - x) / 4, atol=1e-10)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"points": [[0, 0, 0]]}, r"points must have shape \(points, 2\), got \(1, 3\)"),
        ({"points": [*SQUARE[:4], [np.nan, 0.5]]}, r"points must be finite, but point 4 is \(nan, 0.5\)"),
        ({"triangles": [[0, 1]]}, r"triangles must have shape \(triangles, 3\), got \(1, 2\)"),
        ({"triangles": np.zeros((0, 3), dtype=int)}, "triangles must hold one or more"),
        ({"triangles": [*FOUR[:3], [3, 0, 5]]}, r"triangles\[3\] = \(3, 0, 5\): there are 5 points, numbered 0 to 4"),
        ({"triangles": [*FOUR, [0, 4, 4]]}, r"triangles\[4\] = \(0, 4, 4\) has no area: its corners lie in a line"),
        ({"triangles": [*FOUR, [0, 4, 2], [1, 3, 4]]}, r"triangles\[4\] = \(0, 4, 2\) has.*\(2 such triangles\)"),
        ({"points": [*SQUARE, [2, 2], [3, 3]]}, r"point 5 \(x=2, y=2\) and 1 more belongs to no triangle"),
        ({"triangles": [*FOUR, FOUR[0]]}, "the edge between the points 0 and 4 belongs to 3 triangles"),
        ({"fixed": []}, "fixed must name one point or more"),
        ({"fixed": "rim"}, r"the mesh has no group 'rim'; it has none"),
        ({"fixed": "edge", "groups": {"edges": [0]}}, r"the mesh has no group 'edge'; did you mean 'edges'\?"),
        ({"fixed": [7]}, "fixed names point 7, but there are 5 points"),
        ({"fixed": lambda x, y: x > 9}, r"fixed\(x, y\) is True at no point"),
        ({"fixed": lambda x, y: 2 * x}, r"fixed\(x, y\) must return True or False"),
        ({"fixed": range(5)}, "all 5 points are fixed: leave one free"),
        ({"triangles": FOUR[:1], "points": [*SQUARE[:2], *SQUARE[4:]] }, r"triangles\[0\] = \(0, 1, 4\): there are 3"),
        ({"tension": 0.0}, "tension must be > 0, got 0"),
        ({"tension": [1.0, 1.0, -1.0, 1.0]}, r"tension must be > 0, but tension\[2\] is -1"),
        ({"tension": [1.0, 2.0]}, r"tension must be a number or have shape \(4,\), got \(2,\)"),
        ({"load": [1.0, 2.0]}, r"load must be a number or have shape \(1,\) or \(5,\), got \(2,\)"),
        ({"load": np.nan}, r"load must be finite, but is nan at node 0 \(point 4"),
        ({"frame_height": np.inf}, r"frame_height must be finite, but is inf at point 0 \(x=0, y=0\)"),
        ({"ceiling": 0.2}, "ceiling must not lie below the support"),
        ({"groups": {"a": [[[1]]]}}, r"groups\['a'\] must hold points, shape \(k,\)"),
        ({"groups": {"a": [9]}}, r"groups\['a'\] names point 9, but there are 5 points"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_mesh_is_told(changes, told):
    with pytest.raises((ValueError, TypeError), match=told):
        square(**changes)


def test_a_part_without_a_fixed_point_is_told():
    points = [*SQUARE, *(np.add(SQUARE, [3, 0])).tolist()]
    triangles = [*FOUR, *(np.add(FOUR, 5)).tolist()]
    with pytest.raises(ValueError, match=r"1 part\(s\) of the mesh have no fixed point, among them that of point 5"):
        square(points=points, triangles=triangles, fixed=lambda x, y: (x < 2) & (y == 0))


def test_an_unknown_argument_is_told_with_the_one_that_was_meant():
    with pytest.raises(TypeError, match="MeshMembrane has no argument 'supports'; did you mean 'support'"):
        square(supports=1.0)


def test_load_paths_and_variations():
    model = disk(3)
    path = cq.trace(model, loads=[0.2, 0.6, 1.0])
    assert path.monotone
    np.testing.assert_allclose(path.solutions[-1].gap, cq.solve(model).gap, atol=1e-9)
    doubled = with_tension(model, 2.0)
    np.testing.assert_allclose(doubled.problem.G.toarray(), 2 * model.problem.G.toarray())
    assert doubled.tension == 2.0
    assert cq.trace(model, tensions=[1.0, 2.0]).solutions[-1].status == "certified"
    assert with_load(model, 2.0).load[0] == 8.0
    assert with_lift(model, 0.1).support[0] == pytest.approx(0.4)
    varying = disk(3, tension=lambda x, y: 1 + x**2)
    np.testing.assert_allclose(with_tension(varying, 2.0).tension, 2 * varying.tension)


def test_sensitivities_are_those_of_differences():
    points, triangles = obtuse_rings(6)
    given = {"load": 4.0, "support": 0.4, "frame_height": 0.05, "foundation": 0.3}

    def total(tension=1.0, **changes):
        model = cq.MeshMembrane(points, triangles, tension, **(given | changes))
        return cq.solve(model, tol=1e-11).reaction.sum()

    model = cq.MeshMembrane(points, triangles, 1.0, **given)
    gradient = cq.solve(model, tol=1e-11).sensitivity().adjoint(reaction=1.0)
    step = 1e-6
    for name, value in given.items():
        slope = (total(**{name: value + step}) - total(**{name: value - step})) / (2 * step)
        assert np.sum(gradient[name]) == pytest.approx(slope, rel=1e-4)
    slope = (total(1 + step) - total(1 - step)) / (2 * step)
    assert gradient["tension"] == pytest.approx(slope, rel=1e-4)


def test_patches_are_joined_by_edges_of_the_mesh():
    """Nodes across a diagonal touch each other, though in a mesh of squares no stiffness joins them."""
    mesh = skfem.MeshTri.init_tensor(np.linspace(0, 4, 5), np.linspace(0, 4, 5))
    model = cq.MeshMembrane.from_skfem(mesh, 1.0, load=1.0, support=1.0)
    ends = model._number[model.edges]
    diagonal = (np.abs(model.positions[model.edges[:, 0]] - model.positions[model.edges[:, 1]]) > 0.5).all(axis=1)
    one, other = ends[diagonal & (ends >= 0).all(axis=1)][0]
    contact = np.zeros(9, dtype=bool)
    contact[[one, other]] = True
    assert model.problem.G[one, other] == 0
    assert model.contact_patches(contact)[1] == 1
    solution = cq.solve(disk(3))
    assert solution.patches()["nodes"].tolist() == [solution.contact.sum()]
    assert solution.patches()["area"][0] == pytest.approx(solution.contact_area.lower)


def ring():
    """Return a meshio mesh of a ring as Gmsh writes it: physical groups, and points that no triangle uses."""
    points, triangles = rings(6)
    triangles = triangles[~(np.hypot(*points.T) < 0.25)[triangles].all(axis=1)]
    mesh = TriangleMesh(points[np.unique(triangles)], np.unique(triangles, return_inverse=True)[1].reshape(-1, 3))
    edges = np.unique(triangles)[mesh.edges[mesh.boundary]]
    outer = np.hypot(*points[edges].mean(axis=1).T) > 0.5
    cells = [("line", edges[outer]), ("line", edges[~outer]), ("triangle", triangles)]
    tags = [np.full(len(block), tag) for tag, (_, block) in zip((1, 2, 7), cells, strict=True)]
    data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
    told = {"rim": np.array([1, 1]), "hole": np.array([2, 1]), "fabric": np.array([7, 2])}
    places = np.column_stack([points, np.zeros(len(points))])
    return meshio.Mesh(places, cells, cell_data=data, field_data=told), len(mesh.points)


def test_gmsh_files_with_physical_groups(tmp_path):
    mesh, used = ring()
    file = tmp_path / "ring.msh"
    meshio.write(file, mesh, file_format="gmsh22", binary=False)
    whole = cq.MeshMembrane.from_meshio(file, 1.0, load=4.0, support=0.1)
    assert len(whole.positions) == used < len(mesh.points)
    assert set(whole.mesh.groups) == {"rim", "hole", "fabric"}
    np.testing.assert_allclose(np.hypot(*whole.positions[whole.mesh.points_of(["rim"])].T), 1.0)
    held = cq.MeshMembrane.from_meshio(str(file), 1.0, load=4.0, support=0.1, fixed="rim")
    assert held.size == whole.size + whole.mesh.points_of(["hole"]).size
    np.testing.assert_allclose(np.hypot(*held.positions[held.fixed].T), 1.0)
    assert cq.solve(held).status == "certified"
    again = cq.MeshMembrane.from_meshio(mesh, 1.0, load=4.0, support=0.1, fixed=["rim"])
    np.testing.assert_array_equal(again.problem.G.toarray(), held.problem.G.toarray())


SQUARE_BY_GMSH = """$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
2
1 3 "low"
2 9 "sheet"
$EndPhysicalNames
$Entities
1 1 1 0
5 0 0 0 0
1 0 0 0 1 0 0 1 3 0
1 0 0 0 1 1 0 1 9 1 1
$EndEntities
$Nodes
2 6 1 6
0 5 0 1
6
2 2 0
2 1 0 5
1
2
3
4
5
0 0 0
1 0 0
1 1 0
0 1 0
0.5 0.5 0
$EndNodes
$Elements
2 5 1 7
1 1 1 1
1 1 2
2 1 2 4
4 1 2 5
5 2 3 5
6 3 4 5
7 4 1 5
$EndElements
"""


def test_gmsh_files_of_version_4_1(tmp_path):
    """Point 6 is the centre of an arc, as it were."""
    file = tmp_path / "square.msh"
    file.write_text(SQUARE_BY_GMSH)
    model = cq.MeshMembrane.from_meshio(file, 2.0, load=3.0, support=0.1)
    np.testing.assert_allclose(model.problem.G.toarray(), [[8.0]])
    assert {name: len(cells) for name, cells in model.mesh.groups.items()} == {"low": 1, "sheet": 4}
    assert cq.MeshMembrane.from_meshio(file, 2.0, load=3.0, support=0.1, fixed="low").size == 3


def test_files_that_are_no_meshes_of_triangles_are_told(tmp_path, capsys):
    arguments = {"tension": 1.0, "load": 1.0, "support": 1.0}
    with pytest.raises(FileNotFoundError, match="there is no file"):
        cq.MeshMembrane.from_meshio(tmp_path / "none.msh", **arguments)
    broken = tmp_path / "broken.msh"
    broken.write_text("nothing")
    with pytest.raises(ValueError, match=r"broken\.msh: cannot be read as a mesh"):
        cq.MeshMembrane.from_meshio(broken, **arguments)
    assert capsys.readouterr() == ("", "")
    squares = meshio.Mesh([[0, 0], [1, 0], [1, 1], [0, 1]], {"quad": [[0, 1, 2, 3]]})
    with pytest.raises(ValueError, match=r"a mesh of triangles of three points is needed.*it has quad"):
        cq.MeshMembrane.from_meshio(squares, **arguments)
    raised = meshio.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 1]], {"triangle": [[0, 1, 2]]})
    with pytest.raises(ValueError, match="must lie in a plane of one z, but z goes from 0 to 1"):
        cq.MeshMembrane.from_meshio(raised, **arguments)
    with pytest.raises(TypeError, match=r"mesh must be a skfem\.MeshTri of straight triangles"):
        cq.MeshMembrane.from_skfem(skfem.MeshQuad(), **arguments)
    with pytest.raises(TypeError, match=r"mesh must be a skfem\.MeshTri of straight triangles"):
        cq.MeshMembrane.from_skfem(skfem.MeshTri2.init_circle(1), **arguments)


def test_names_of_sets_and_of_scikit_fem():
    cells = {"line": [[0, 1]], "triangle": FOUR}
    mesh = meshio.Mesh(SQUARE, cells, cell_sets={"low": [[0], []]}, point_sets={"top": [2, 3]})
    model = cq.MeshMembrane.from_meshio(mesh, 1.0, load=1.0, support=1.0, fixed=["low", "top"])
    np.testing.assert_array_equal(model.fixed, [0, 1, 2, 3])
    named = skfem.MeshTri().refined(2).with_boundaries({"left": lambda x: x[0] == 0})
    held = cq.MeshMembrane.from_skfem(named, 1.0, load=1.0, support=1.0, fixed="left")
    np.testing.assert_array_equal(held.positions[held.fixed][:, 0], 0.0)


def test_a_finer_mesh_of_the_same_membrane():
    def support(x, y):
        return 0.1 + x * y

    model = disk(2, support=support, load=np.linspace(1, 2, 25), tension=lambda x, y: 2 + x)
    marked = model.mesh.middles[:, 0] > 0.2
    finer = model.refined(marked)
    assert model.size < finer.size < model.refined().size
    assert finer.halving is not None
    np.testing.assert_array_equal(finer.positions[: len(model.positions)], model.positions)
    np.testing.assert_array_equal(finer.support, support(finer.node_x, finer.node_y))
    np.testing.assert_allclose(finer.mesh.areas.sum(), model.mesh.areas.sum())
    np.testing.assert_allclose(finer.tension, 2 + finer.mesh.middles[:, 0])
    old = finer.halving.ends[finer.free, 0] == finer.halving.ends[finer.free, 1]
    assert np.isin(finer.load[old], model.load).all()
    assert finer.load.min() >= 1.0
    assert finer.load.max() <= 2.0
    edge = np.unique(finer.edges[finer.mesh.boundary])
    np.testing.assert_array_equal(finer.fixed, edge)
    parents = finer.halving.parents
    np.testing.assert_allclose(np.bincount(parents, weights=finer.mesh.areas), model.mesh.areas, rtol=1e-12)


def test_what_was_given_as_arrays_is_carried_to_a_finer_mesh():
    tension = np.arange(1.0, 5.0)
    groups = {"low": [[0, 1]], "spot": [2], "sheet": [FOUR[1]]}
    heights = [0.0, 0.1, 0.2, 0.3]
    model = square(tension=tension, groups=groups, fixed=np.arange(4), frame_height=heights, support=np.array([0.2]))
    finer = model.refined()
    assert sorted(set(finer.tension.tolist())) == [1.0, 2.0, 3.0, 4.0]
    assert finer.fixed.size == 8
    lower = finer.positions[finer.fixed][:, 1] == 0
    order = np.argsort(finer.positions[finer.fixed][lower][:, 0])
    np.testing.assert_allclose(finer.fixed_height[lower][order], [0.0, 0.05, 0.1])
    np.testing.assert_array_equal(finer.support, 0.2)
    assert finer.mesh.groups["low"].shape == (2, 2)
    np.testing.assert_array_equal(finer.mesh.groups["spot"], [2])
    sheet = finer.mesh.groups["sheet"]
    assert len(sheet) == 4
    assert (finer.positions[sheet].mean(axis=1)[:, 0] > 0.5).all()
    doubled = with_load(model, 2.0).refined([0, 1])
    np.testing.assert_array_equal(doubled.load, 6.0)
    with pytest.raises(ValueError, match="chosen names triangle 4, but there are 4"):
        model.refined([4])
    by_name = square(groups=groups, fixed="low").refined().refined()
    np.testing.assert_array_equal(np.sort(by_name.positions[by_name.fixed][:, 0]), [0, 0.25, 0.5, 0.75, 1])
