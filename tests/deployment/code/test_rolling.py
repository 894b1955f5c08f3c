"""Formulas with joints that are alike become one loop, others single statements; both compute the same."""

import ctypes

import numpy as np
import pytest

from ffgym.deployment.code.compiler import compile_c, find_compiler
from ffgym.deployment.code.rolling import Output, write_step
from ffgym.deployment.code.symbols import Symbols, node_of
from ffgym.deployment.code.tracing import evaluate
from ffgym.simulation.plant.compiled.tracing import Graph, Untraceable

N = 4


def alike(x):
    return np.tanh(x) * np.arange(1.0, N + 1) + np.where(x > 0.2, x**2, 1.0)


def mixed(x):
    """Joint 2 has a part of joint 1's, as in a coupled drive; the sum of all stops them."""
    turned = 2.0 * x
    turned[..., 2] = turned[..., 2] + 0.5 * x[..., 1]
    return np.where(np.any(turned != np.clip(turned, -1.0, 1.0), axis=-1, keepdims=True), np.exp(turned), turned)


def stopped(x):
    """All joints go on from a first loop, by what is true of any of them there."""
    first = np.tanh(x) * np.arange(1.0, N + 1)
    return np.where(np.any(first > 0.4, axis=-1, keepdims=True), np.exp(first), first)


def chained(x):
    """Each joint has the result of the joint before it."""
    total = x.copy()
    for j in range(1, N):
        total[..., j] = np.sin(total[..., j - 1]) + x[..., j]
    return total


def looked_up(x):
    index = (np.abs(x) * 3).astype(np.int64)
    table = np.arange(5.0 * N).reshape(N, 5)
    return np.take_along_axis(table, index[..., None], axis=-1)[..., 0] + np.sign(x) * np.minimum(x, 0.3)


def traced(formula):
    graph = Graph(1)
    given = Symbols.of(graph, [graph.make("given", value=("x", j), fixed=False) for j in range(N)])
    return graph, tuple(node_of(graph, value) for value in np.asarray(formula(given), dtype=object))


def turned_round(x):
    """What is taken from nothing, and from one."""
    return (0.0 - x) + 2.0 * (1.0 - x) + (x - 0.0)


FORMULAS = [alike, mixed, stopped, chained, looked_up, turned_round]
LOOPS = {alike: 2, mixed: 2, stopped: 3, chained: 1, looked_up: 2, turned_round: 2}
"""Loops over joints, that of the results included, which is all that joints in a chain have."""


def test_a_table_is_looked_up_along_its_last_axis_alone():
    def across(x):
        return np.take_along_axis(np.ones((2, N)), x[None].astype(np.int64), axis=0)

    with pytest.raises(Untraceable, match="along axis 0"):
        traced(across)


@pytest.mark.parametrize("formula", FORMULAS)
def test_the_graph_of_a_formula_computes_what_numpy_does(formula):
    x = np.random.default_rng(0).normal(scale=0.4, size=(200, N))
    graph, nodes = traced(formula)
    assert np.array_equal(np.stack(evaluate(graph, nodes, {"x": x}), axis=1), np.stack([formula(row) for row in x]))


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
@pytest.mark.parametrize("formula", FORMULAS)
def test_code_of_a_formula_computes_what_numpy_does(formula, tmp_path):
    tables, lines = write_step([Output("y", 0, 1, traced(formula)[1])], N)
    code = "\n".join(["#include <math.h>", *tables, "void f(const double *x, double *y) {", *lines, "}"])
    (tmp_path / "f.c").write_text(code)
    compile_c(find_compiler(), [tmp_path / "f.c"], tmp_path / "f.so", "-shared", "-fPIC")
    function = ctypes.CDLL(str(tmp_path / "f.so")).f
    for row in np.random.default_rng(0).normal(scale=0.4, size=(200, N)):
        found = np.empty(N)
        function(row.ctypes.data_as(ctypes.c_void_p), found.ctypes.data_as(ctypes.c_void_p))
        assert np.abs(found - formula(row)).max() <= 1e-15 * np.abs(formula(row)).max()


@pytest.mark.parametrize("formula", FORMULAS)
def test_joints_that_are_alike_are_one_loop(formula):
    _, lines = write_step([Output("y", 0, 1, traced(formula)[1])], N)
    assert sum(line.startswith("for (") for line in lines) == LOOPS[formula]


@pytest.mark.parametrize(
    "formula",
    [
        lambda x: x if x[0] > 0 else -x,
        lambda x: np.add(x, 1.0, out=np.zeros(N)),
        lambda x: np.linalg.norm(x) * x,
        lambda x: float(x[0]) * x,
        lambda x: np.add.accumulate(x),
    ],
)
def test_what_depends_on_values_cannot_be_traced(formula):
    with pytest.raises((Untraceable, TypeError)):
        traced(formula)
