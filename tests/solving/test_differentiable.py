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


def test_torch_differentiates_by_the_support_alone():
    torch = pytest.importorskip("torch")
    from contactqp.torch import contact

    support = torch.tensor(SUPPORTS, requires_grad=True)
    contact(CABLE, torch.tensor(LOADS), support).reaction.sum().backward()
    _, by_support = Layer(CABLE).gradients(LOADS, SUPPORTS, Fields(0.0, 0.0, np.ones_like(LOADS)))
    np.testing.assert_allclose(support.grad.numpy(), by_support)
    one = torch.tensor(SUPPORTS[0], requires_grad=True)
    answer = lambda support: tuple(contact(CABLE, support=support, tol=1e-12))  # noqa: E731
    assert torch.autograd.gradcheck(answer, (one,), eps=1e-6, atol=1e-6)


@pytest.mark.parametrize("name", ["float32", "float16", "bfloat16"])
def test_torch_keeps_the_type_of_what_is_given(name):
    torch = pytest.importorskip("torch")
    from contactqp.torch import contact

    dtype = getattr(torch, name)
    load = torch.tensor(LOADS, dtype=dtype, requires_grad=True)
    answer = contact(CABLE, load)
    assert {field.dtype for field in answer} == {contact(CABLE, support=load.detach()).gap.dtype} == {dtype}
    answer.reaction.sum().backward()
    exact = load.detach().to(torch.float64).numpy()  # what the numbers are once they are rounded
    by_load, _ = Layer(CABLE).gradients(exact, np.tile(CABLE.support, (3, 1)), Fields(0.0, 0.0, np.ones_like(exact)))
    assert load.grad.dtype == dtype
    np.testing.assert_allclose(load.grad.to(torch.float64), by_load, rtol=2 * torch.finfo(dtype).eps)
    wider = torch.tensor(SUPPORTS, requires_grad=True)
    contact(CABLE, load, wider).gap.sum().backward()
    assert (contact(CABLE, load, wider).gap.dtype, wider.grad.dtype) == (torch.float64, torch.float64)


def test_torch_func_differentiates_and_maps():
    torch = pytest.importorskip("torch")
    from contactqp.torch import contact

    loads, supports = torch.tensor(LOADS), torch.tensor(SUPPORTS)
    weights = Fields(0.0, np.ones_like(LOADS), 0.0)
    by_load, by_support = Layer(CABLE).gradients(LOADS, SUPPORTS, weights)

    def number(load, support):
        return contact(CABLE, load, support).deflection.sum()

    by_both = torch.func.vmap(torch.func.grad(number, argnums=(0, 1)))(loads, supports)
    np.testing.assert_allclose(by_both[0], by_load)
    np.testing.assert_allclose(by_both[1], by_support)
    columns = torch.func.vmap(lambda load: contact(CABLE, load, supports[0]).gap, in_dims=1)(loads.T)
    np.testing.assert_allclose(columns, contact(CABLE, loads, supports[0]).gap, rtol=1e-9, atol=1e-9)
    jacobian = torch.func.jacrev(lambda load: contact(CABLE, load, tol=1e-12).reaction)(loads[0])
    rows = torch.autograd.functional.jacobian(lambda load: contact(CABLE, load, tol=1e-12).reaction, loads[0])
    np.testing.assert_allclose(jacobian, rows, atol=1e-12)


def test_torch_tells_what_it_does_not_do():
    torch = pytest.importorskip("torch")
    from contactqp.torch import contact

    load = torch.tensor(LOADS[0], requires_grad=True)
    (slope,) = torch.autograd.grad((contact(CABLE, load).gap ** 2).sum(), load, create_graph=True)
    with pytest.raises(NotImplementedError, match="contact has no second derivatives"):
        slope.sum().backward()
    with pytest.raises(TypeError, match=r"load must be a torch.Tensor, got array\("):
        contact(CABLE, LOADS[0])
    with pytest.raises(TypeError, match="support must be a tensor of floating-point numbers, got"):
        contact(CABLE, support=torch.zeros(19, dtype=torch.int64))
    with pytest.raises(ValueError, match=r"load must have shape \(\.\.\., 19\), got \(4,\)"):
        contact(CABLE, torch.zeros(4))
    with pytest.raises(ValueError, match=r"batches that go together, got shapes \(3, 19\) and \(2, 19\)"):
        contact(CABLE, torch.zeros(3, 19), torch.zeros(2, 19))
    with pytest.raises(ValueError, match="load and support must be on one device, got cpu and meta"):
        contact(CABLE, torch.zeros(19), torch.zeros(19, device="meta"))


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
