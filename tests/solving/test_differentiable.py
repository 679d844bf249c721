"""Contact as a layer of differentiable programs, by PyTorch and by JAX."""

import numpy as np
import pytest

import contactqp as cq
from contactqp.solving.layer import Fields, Layer

CABLE = cq.Cable(nodes=19, spacing=0.5, tension=1.0, load=1.0, support=lambda x: 3.0 + 0.1 * x)
RNG = np.random.default_rng(0)
LOADS = 1.0 + 0.2 * RNG.uniform(size=(3, 19))
SUPPORTS = np.array(CABLE.support) + 0.05 * RNG.uniform(size=(3, 19))
WEIGHTS = Fields(*RNG.normal(size=(3, 3, 19)))


def number(load, support):
    fields = Layer(CABLE, 1e-12).answers(load, support)
    return sum(float((weight * field).sum()) for weight, field in zip(WEIGHTS, fields, strict=True))


def test_gradients_of_batches_are_those_of_finite_differences():
    by_load, by_support = Layer(CABLE).gradients(LOADS, SUPPORTS, WEIGHTS)
    direction = RNG.normal(size=LOADS.shape)
    for by, step in ((by_load, (direction, 0.0)), (by_support, (0.0, direction))):
        ends = [number(LOADS + sign * 1e-6 * step[0], SUPPORTS + sign * 1e-6 * step[1]) for sign in (1, -1)]
        assert float((by * direction).sum()) == pytest.approx((ends[0] - ends[1]) / 2e-6, rel=1e-5)


def test_gradients_solve_nothing_again(monkeypatch):
    from contactqp.solving import layer as module

    layer = Layer(CABLE)
    load = LOADS.copy()
    layer.answers(load, SUPPORTS)
    monkeypatch.setattr(module, "Solver", lambda *given, **more: pytest.fail("it was solved again"))
    by_load, _ = layer.gradients(LOADS, SUPPORTS, WEIGHTS)
    monkeypatch.undo()
    load *= 1.1  # of the caller's own array the layer keeps nothing
    np.testing.assert_array_equal(layer.gradients(LOADS, SUPPORTS, WEIGHTS)[0], by_load)
    other = layer.gradients(load, SUPPORTS, WEIGHTS)[0]
    np.testing.assert_array_equal(other, Layer(CABLE).gradients(load, SUPPORTS, WEIGHTS)[0])


def test_wrong_arguments_are_told():
    with pytest.raises(TypeError, match="model must be a Membrane"):
        Layer(CABLE.problem)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"load must have shape \(\.\.\., 19\), got \(4,\)"):
        Layer(CABLE).answers(np.ones(4), np.ones(4))


def test_biactive_nodes_count_as_held():
    """Without a load the cable lies straight on a floor at the frame's height: it neither presses nor leaves it."""
    flat = cq.Cable(nodes=5, spacing=1.0, tension=1.0, load=0.0, support=0.0)
    by_load, by_support = Layer(flat).gradients(np.zeros(5), np.zeros(5), Fields(0.0, np.ones(5), 0.0))  # type: ignore[arg-type]
    np.testing.assert_allclose(by_load, 0.0, atol=1e-12)
    np.testing.assert_allclose(by_support, 1.0)


def test_torch_differentiates_contact():
    torch = pytest.importorskip("torch")
    from contactqp.torch import contact

    load, support = (torch.tensor(values, requires_grad=True) for values in (LOADS, SUPPORTS))
    fields = contact(CABLE, load, support)
    sum((torch.tensor(weight) * field).sum() for weight, field in zip(WEIGHTS, fields, strict=True)).backward()
    by_load, by_support = Layer(CABLE).gradients(LOADS, SUPPORTS, WEIGHTS)
    np.testing.assert_allclose(load.grad.numpy(), by_load)
    np.testing.assert_allclose(support.grad.numpy(), by_support)
    one = torch.tensor(LOADS[0], requires_grad=True)
    assert torch.autograd.gradcheck(lambda load: tuple(contact(CABLE, load, tol=1e-12)), (one,), eps=1e-5, atol=1e-6)
    assert contact(CABLE).gap.shape == (19,)
    assert contact(CABLE, one, support).gap.shape == (3, 19)
    single = contact(CABLE, torch.ones(19, dtype=torch.float32)).gap
    assert single.dtype == torch.float32


def test_jax_differentiates_contact():
    jax = pytest.importorskip("jax")
    from contactqp.jax import contact

    with jax.enable_x64(True) if hasattr(jax, "enable_x64") else jax.experimental.enable_x64():
        weights = [jax.numpy.asarray(weight) for weight in WEIGHTS]

        def number(load, support):
            return sum(
                (weight * field).sum() for weight, field in zip(weights, contact(CABLE, load, support), strict=True)
            )

        found = jax.grad(number, argnums=(0, 1))(LOADS, SUPPORTS)
        by_load, by_support = Layer(CABLE).gradients(LOADS, SUPPORTS, WEIGHTS)
        np.testing.assert_allclose(found[0], by_load, rtol=1e-12)
        np.testing.assert_allclose(found[1], by_support, rtol=1e-12)
        compiled = jax.jit(lambda load: contact(CABLE, load).reaction.sum())
        assert float(compiled(LOADS[0])) == pytest.approx(float(contact(CABLE, LOADS[0]).reaction.sum()))
        mapped = jax.vmap(jax.grad(lambda load: contact(CABLE, load).deflection.sum()))(LOADS)
        alone = [jax.grad(lambda load: contact(CABLE, load).deflection.sum())(load) for load in LOADS]
        np.testing.assert_allclose(mapped, np.array(alone), rtol=1e-9)
        everywhere = contact(CABLE, 1.1, 3.0)
        np.testing.assert_allclose(everywhere.gap, contact(CABLE, np.full(19, 1.1), np.full(19, 3.0)).gap)
        assert jax.grad(lambda load: contact(CABLE, load, 3.0).reaction.sum())(1.1).shape == ()
        with pytest.raises(ValueError, match=r"load must be a number or have shape \(..., 19\), got \(4,\)"):
            contact(CABLE, np.ones(4))
        from jax.test_util import check_grads

        check_grads(
            lambda load: contact(CABLE, load, tol=1e-12).deflection, (LOADS[0],), order=1, modes=["rev"], eps=1e-5
        )
