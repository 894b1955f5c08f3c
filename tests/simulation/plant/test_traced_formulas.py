"""What formulas of effects may ask of numpy: the code gives its numbers, and anything else is told from code."""

import ctypes

import numpy as np
import pytest

from ffgym.simulation.plant.compiled.code import JointPlace, LoopCode, Slots, compile_code, declarations
from ffgym.simulation.plant.compiled.step import evaluate
from ffgym.simulation.plant.compiled.tracing import Graph, Traced, Untraceable

X = np.array([[-2.0, -0.5, 0.0, 0.7, 1.0, 3.2]])
"""One number per joint."""
Y = np.array([[1.0, 0.0, -1.0, 0.7, -4.0, 2.0]])
MEMORY = np.stack([X + 0.25, 2 * Y, X * Y], axis=-1)
"""Three numbers per joint."""


def into(target, values, **options):
    """Let numpy write into a copy of an array."""
    result = target.copy()
    np.add(values, values, out=result, **options)
    return result


def assigned(array, key, values):
    """Set a part of a copy of an array."""
    result = array.copy()
    result[key] = values
    return result


FORMULAS = {
    "operators": lambda x, y, m: (x + y) * x - y / (x * x + 1.0) + 3.0 * -x,
    "powers": lambda x, y, m: x**2 + np.abs(y) ** 0.5 + x**1 + np.abs(x) ** 1.5 + np.float_power(np.abs(y), 2.5),
    "square and reciprocal": lambda x, y, m: np.square(x) + np.reciprocal(x + 5.0) + np.positive(y),
    "numbers of joints": lambda x, y, m: x * np.arange(6.0) + np.ones(6),
    "powers of numbers": lambda x, y, m: (x * x + 0.5) ** y + 2.0**x,
    "numbers of a memory": lambda x, y, m: m * np.array([1.0, 2.0, 3.0]),
    "numbers of joints and memory": lambda x, y, m: m * np.arange(18.0).reshape(6, 3),
    "numbers of one robot": lambda x, y, m: x * np.arange(6.0).reshape(1, 6) + m[..., 0] * np.full((1, 6), 2.0),
    "comparisons": lambda x, y, m: np.where((x > 0) & (y <= 0.7), x, y),
    "truths": lambda x, y, m: ((x > 0) | (y > 0)).astype(float) - 2.0 * (~(x >= y) ^ (x == y)).astype(float),
    "a truth of two truths": lambda x, y, m: np.where(np.where(x > 0, y > 0, x < y), x, 1.0),
    "a truth or a number": lambda x, y, m: np.where(x > 0, y, x < y) + np.where(x > 0, x < y, y),
    "numbers as truths": lambda x, y, m: np.where(x.astype(bool), 2.0, y),
    "whole numbers": lambda x, y, m: (1.7 * x).astype(int) + 0.0,
    "where with one array": lambda x, y, m: np.where(y < 0, 1.5, x),
    "into an array": lambda x, y, m: into(y, x),
    "into a part of an array": lambda x, y, m: into(y, x, where=x > 0),
    "bounds": lambda x, y, m: np.clip(x, -1.0, y) + np.clip(y, None, 0.5) + np.clip(y, 0.2, None),
    "rounding": lambda x, y, m: np.round(3 * x) + np.around(y),
    "likes": lambda x, y, m: np.zeros_like(x) + np.ones_like(y) * x + np.full_like(x, 0.5) * y,
    "all joints": lambda x, y, m: x[:, :] + x[...] + y[:] + m[:, :, 1],
    "a memory of one number": lambda x, y, m: np.sum(x[..., None], axis=-1) + x[:, :, None][..., 0],
    "a memory": lambda x, y, m: m[..., 0] - m[..., 2],
    "the last of a memory": lambda x, y, m: m[:, :, -1] * x,
    "a part of a memory": lambda x, y, m: m[..., 1:],
    "a number beside a memory": lambda x, y, m: x[..., None] * m,
    "a sum": lambda x, y, m: np.sum(m, axis=-1),
    "a sum along the last of two axes": lambda x, y, m: np.sum(m[..., None, :], axis=-1),
    "numbers of fewer axes": lambda x, y, m: m[..., None, None, :] * np.arange(6.0).reshape(2, 3),
    "a stack": lambda x, y, m: np.stack([x, y], axis=-1),
    "a stack of memories": lambda x, y, m: np.stack([m, 2.0 * m], axis=-1),
    "memories side by side in two axes": lambda x, y, m: np.concatenate([m[..., None, :], -m[..., None, :]], axis=-1),
    "a memory that shifts": lambda x, y, m: np.concatenate([x[..., None], m[..., :-1]], axis=-1),
    "a part that is set": lambda x, y, m: assigned(m, (..., 1), x),
    "a part of joints that is set": lambda x, y, m: assigned(m, (slice(None), slice(None), 1), x),
    "all joints that are set": lambda x, y, m: x + assigned(y, (slice(None), slice(None)), 2.0),
    "all by a tuple": lambda x, y, m: x[()] + assigned(y, (slice(None),), x),
    "all that is set": lambda x, y, m: assigned(x, slice(None), 2.0) + assigned(y, ..., x),
    "a number that is looked up": lambda x, y, m: np.take_along_axis(
        m, np.clip(np.trunc(x), 0, 2).astype(int)[..., None], axis=-1
    ),
    "one number to look up": lambda x, y, m: np.take_along_axis(x[..., None], (0 * y)[..., None].astype(int), axis=-1),
    "computed numbers to look up": lambda x, y, m: np.take_along_axis(
        np.stack([y, x * y, x + y], axis=-1), np.clip(np.trunc(x), 0, 2).astype(int)[..., None], axis=-1
    )[..., 0],
    "numbers of joints to look up": lambda x, y, m: np.take_along_axis(
        np.stack([y, np.arange(6.0)[None], np.arange(6.0)[None] ** 2], axis=-1),
        np.clip(np.trunc(x), 0, 2).astype(int)[..., None],
        axis=-1,
    )[..., 0],
    "the same shape": lambda x, y, m: np.broadcast_to(x, y.shape) + y,
}

REFUSED = {
    "a branch": lambda x, y, m: x if x[0, 0] > 0 else y,
    "a number of one joint": lambda x, y, m: x[..., :1],
    "joints in another order": lambda x, y, m: x[:, ::-1],
    "some joints": lambda x, y, m: m[:, 1:, 0],
    "joints chosen by truths": lambda x, y, m: x[x > 0],
    "memory in another order": lambda x, y, m: m[..., [2, 0, 1]],
    "too many indices": lambda x, y, m: x[..., 0, 0],
    "a sum over joints": lambda x, y, m: np.sum(x, axis=-1),
    "a sum of all": lambda x, y, m: np.sum(m),
    "a reduction": lambda x, y, m: np.add.reduce(x),
    "two results": lambda x, y, m: np.modf(x)[0],
    "an option": lambda x, y, m: np.add(x, y, dtype=np.float32),
    "a function without code": lambda x, y, m: np.arctan2(x, y) + np.spacing(x),
    "a sort": lambda x, y, m: np.sort(x),
    "a stack before joints": lambda x, y, m: np.stack([x, y], axis=0),
    "a stack where none says along what": lambda x, y, m: np.stack([x, y]),
    "memories side by side where none says along what": lambda x, y, m: np.concatenate([m, m]),
    "joints side by side": lambda x, y, m: np.concatenate([x, y], axis=-1),
    "robots side by side": lambda x, y, m: np.concatenate([m, m], axis=0),
    "a memory beside joints": lambda x, y, m: x * m,
    "joints that are looked up": lambda x, y, m: np.take_along_axis(m, m.astype(int), axis=1),
    "a memory in two axes": lambda x, y, m: np.take_along_axis(
        m[..., None, :], np.zeros_like(m).astype(int)[..., None, :], axis=-1
    ),
    "indices in two axes": lambda x, y, m: np.take_along_axis(m, m.astype(int)[..., None], axis=-1),
    "a plain number to look up": lambda x, y, m: np.take_along_axis(np.float64(2.0), x[..., None].astype(int), axis=-1),
    "a plain number as an index": lambda x, y, m: np.take_along_axis(m, np.int64(1), axis=-1),
    "another shape": lambda x, y, m: np.broadcast_to(x, (2, 6)),
    "decimals": lambda x, y, m: np.round(x, 2),
    "an array of numbers": lambda x, y, m: np.asarray(x),
    "numbers that are written over": lambda x, y, m: np.add(x, y, out=np.zeros((1, 6))),
    "a condition without what else": lambda x, y, m: np.add(x, y, where=x > 0),
    "bits of numbers": lambda x, y, m: np.bitwise_and(x, y),
    "truth and a number of bits": lambda x, y, m: (x > 0) & x,
    "a sum of truths": lambda x, y, m: (x > 0) + (y > 0),
    "a difference of truths": lambda x, y, m: np.subtract(x > 0, y > 0),
    "numbers of robots": lambda x, y, m: x * np.arange(12.0).reshape(2, 6),
    "numbers of more joints than one robot has": lambda x, y, m: x * np.arange(12.0),
    "a sum over robots": lambda x, y, m: np.sum(m, axis=0),
    "one axis too many": lambda x, y, m: m[..., 0, 0],
    "joints from the first on": lambda x, y, m: x[:, 0:],
    "robots from the first on": lambda x, y, m: x[0:, :],
    "robots from the second on": lambda x, y, m: x[1:],
    "one key of robots": lambda x, y, m: x[0],
    "joints of another axis": lambda x, y, m: np.concatenate([x, x], axis=0),
    "a memory of joints beside one": lambda x, y, m: np.concatenate([m, x], axis=-1),
    "two graphs": lambda x, y, m: x + Graph(X.size).given("x"),
    "memories of other sizes that are looked up": lambda x, y, m: np.take_along_axis(m, x.astype(int), axis=-1),
    "numbers of other joints": lambda x, y, m: x * np.arange(5.0),
    "no numbers": lambda x, y, m: x * np.zeros(0),
    "text": lambda x, y, m: x * np.array(["a"] * 6),
    "complex numbers": lambda x, y, m: x * 1j,
}


def traced(formula):
    """Ask a formula for its graph."""
    graph = Graph(X.size)
    return formula(graph.given("x"), graph.given("y"), graph.given_memory(["m0", "m1", "m2"])), graph


def by_code(formula):
    """Compute a formula by code, for one joint after another."""
    result, graph = traced(formula)
    slots, sources = Slots(), {"x": 0, "y": 1, "m0": 2, "m1": 3, "m2": 4}
    code = LoopCode("probe", X.size, slots)
    nodes = [graph.cast(node, "number") for node in result.nodes.reshape(-1)]
    values = code.compute(nodes, lambda source: JointPlace(base="%inputs", offset=sources[source] * X.size))
    for k, value in enumerate(values):
        code.store(value, JointPlace(base="%out", offset=k * X.size))
    function = code.function(["ptr %inputs", "ptr %numbers", "ptr %out"], [])
    module = compile_code("\n".join([declarations(), function]))
    # numbers that are the same at all steps are computed once, by numpy
    fixed = evaluate(list(slots.places), lambda source: graph.tables[source[1]])
    numbers = np.array([np.broadcast_to(each, X.size) for each in fixed], dtype=float)
    inputs, found = np.concatenate([X, Y, *np.moveaxis(MEMORY, -1, 0)]), np.empty((len(nodes), X.size))
    call = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 3)(module.get_function_address("probe"))
    call(inputs.ctypes.data, numbers.ctypes.data, found.ctypes.data)
    return found.T.reshape(result.shape)


@pytest.mark.parametrize("name", FORMULAS)
def test_the_code_of_a_formula_gives_the_numbers_of_numpy(name):
    expected = FORMULAS[name](X, Y, MEMORY)
    found = by_code(FORMULAS[name])
    assert found.shape == expected.shape
    np.testing.assert_allclose(found, expected, rtol=1e-14, atol=1e-15)


def test_an_index_outside_gives_the_nearest_number():
    def looked_up(x, y, m):
        return np.take_along_axis(m, (3 * x).astype(int)[..., None], axis=-1)[..., 0]

    index = np.clip((3 * X).astype(int), 0, 2)
    np.testing.assert_array_equal(by_code(looked_up), np.take_along_axis(MEMORY, index[..., None], axis=-1)[..., 0])


def test_of_one_number_any_index_gives_it():
    found = by_code(lambda x, y, m: np.take_along_axis(y[..., None], (3 * x).astype(int)[..., None], axis=-1)[..., 0])
    np.testing.assert_array_equal(found, Y)


def test_powers_that_numpy_writes_by_others_are_those():
    x, graph = traced(lambda x, y, m: x)
    (given,) = x.nodes.flat
    for squared in (x**2, np.square(x)):
        assert squared.nodes[()].operation == "multiply"
        assert squared.nodes[()].arguments == (given, given)
    assert (x**0.5).nodes[()] is np.sqrt(x).nodes[()]
    assert (x**1).nodes[()] is np.positive(x).nodes[()] is given
    assert np.reciprocal(x).nodes[()].arguments == (graph.number(1.0), given)
    for exponent in (3.0, -1.0, 0.0, 1.5, x):
        assert (x**exponent).nodes[()].operation == "power"


def test_a_look_up_is_along_the_last_axis_where_none_says_along_what():
    """As numpy's from 2.3 on; older ones want to be told."""
    m = Graph(X.size).given_memory(["m0", "m1", "m2"])
    index = m[..., :1].astype(int)
    found = m.__array_function__(np.take_along_axis, (Traced,), (m, index), {})
    assert found.nodes.tolist() == np.take_along_axis(m, index, axis=-1).nodes.tolist()


def test_equal_operations_are_made_once():
    _, graph = traced(lambda x, y, m: (x * y + 1.0) - (x * y + 1.0) * m[..., 0])
    assert [node.operation for node in graph.nodes.values()].count("multiply") == 2


def test_the_numbers_of_joints_are_kept_once():
    _, graph = traced(lambda x, y, m: x * np.arange(6.0) + y * np.arange(6.0) + x * np.arange(1.0, 7.0))
    assert len(graph.tables) == 2


def test_arrays_say_what_numpy_says_of_their_numbers():
    graph = Graph(X.size)
    x, m = graph.given("x"), graph.given_memory(["m0", "m1", "m2"])
    for array, numbers in ((x, X), (m, MEMORY), (x[..., None], X[..., None]), (x > 0, X > 0)):
        assert array.shape == numbers.shape
        assert array.ndim == numbers.ndim
        assert array.dtype == numbers.dtype
    both = np.stack([x.astype(bool), x], axis=-1)
    assert both.dtype == np.float64
    assert x.astype(bool).dtype == np.bool_
    assert x.astype(int).dtype == x.astype(float).dtype == np.float64


def test_a_copy_stays_as_it_was():
    m = Graph(X.size).given_memory(["m0", "m1"])
    copy = m.copy()
    m[..., 0] = 1.0
    assert [node.value for node in copy.nodes] == ["m0", "m1"]
    assert m.nodes[0].operation == "number"


def test_a_result_that_is_written_into_an_array_is_the_function_itself():
    graph = Graph(X.size)
    x, y = graph.given("x"), graph.given("y")
    target = y.copy()
    assert np.add(x, y, out=target) is target
    assert target.nodes[()] is (x + y).nodes[()]


def test_what_is_fixed_is_made_of_fixed_numbers_alone():
    graph = Graph(X.size)
    fixed, given = graph.given("a", fixed=True), graph.given("b")
    for array, expected in (
        (fixed, True),
        (given, False),
        (2.0 * fixed + 1.0, True),
        (fixed + given, False),
        (np.where(fixed > 0, fixed, 1.0), True),
        (np.where(fixed > 0, given, 1.0), False),
        (np.where(given > 0, fixed, 1.0), False),
        (np.take_along_axis(fixed[..., None] * np.arange(2.0), fixed[..., None], axis=-1)[..., 0], False),
    ):
        assert array.nodes[()].is_fixed is expected


def test_graphs_are_the_same_if_their_operations_and_numbers_are():
    described = [
        traced(formula)[1].describe()
        for formula in (
            lambda x, y, m: x + 2.0 * y,
            lambda x, y, m: x + 2.0 * y,
            lambda x, y, m: y + 2.0 * x,
            lambda x, y, m: x + 3.0 * y,
            lambda x, y, m: x - 2.0 * y,
            lambda x, y, m: x * np.arange(6.0),
            lambda x, y, m: x * np.arange(1.0, 7.0),
        )
    ]
    assert described[0] == described[1]
    for k, one in enumerate(described[1:]):
        assert all(one != other for other in described[k + 2 :])


def test_zeros_of_other_signs_are_other_numbers():
    graph = Graph(X.size)
    assert graph.number(0.0) is graph.number(0.0)
    assert graph.number(0.0) is not graph.number(-0.0)
    (node,) = graph.constant(np.zeros((6, 1)), 1)
    assert node is graph.number(0.0)
    assert graph.tables == []
    mixed = graph.constant(np.array([0.0, -0.0, 0.0, 0.0, 0.0, 0.0]), 0)[()]
    assert mixed.value == ("table", 0)
    assert mixed.is_fixed


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_not_of_one_joint_after_another_has_no_code(name):
    with pytest.raises(Untraceable):
        traced(REFUSED[name])
