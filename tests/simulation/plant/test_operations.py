"""Operations of formulas: each one's code gives the numbers of numpy's function, special ones too."""

import ctypes

import numpy as np
import pytest

from ffgym.simulation.plant.compiled.code import JointPlace, LoopCode, Slots, compile_code, declarations
from ffgym.simulation.plant.compiled.operations import LIBRARY, OPERATIONS
from ffgym.simulation.plant.compiled.tracing import Graph


@pytest.mark.parametrize("name", OPERATIONS)
def test_each_operation_is_that_of_numpy(name):
    known, numbers = OPERATIONS[name], np.array([0.0, -0.0, 1.0, -2.5, 0.3, 5e-324, 1e300, np.inf, -np.inf, np.nan])
    one, other = (values.ravel() for values in np.meshgrid(numbers, numbers))
    operands = [one, other][: known.function.nin]
    with np.errstate(all="ignore"):
        expected = known.function(*(a.astype(bool) if known.of == "truth" else a for a in operands)).astype(float)
    # a loop over "joints" that applies it
    graph = Graph(len(one))
    given = [graph.given(k).nodes[()] for k in range(len(operands))]
    node = graph.cast(graph.apply(name, given), "number")
    code = LoopCode("probe", len(one), Slots())
    (value,) = code.compute([node], lambda k: JointPlace(base=f"%in{k}"))
    code.store(value, JointPlace(base="%out"))
    module = compile_code("\n".join([declarations(), code.function(["ptr %in0", "ptr %in1", "ptr %out"], [])]))
    found = np.empty(len(one))
    call = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 3)(module.get_function_address("probe"))
    call(one.ctypes.data, other.ctypes.data, found.ctypes.data)
    np.testing.assert_allclose(found, expected, rtol=1e-14)
    if name not in LIBRARY and known.gives == "number":
        np.testing.assert_array_equal(np.signbit(found[~np.isnan(found)]), np.signbit(expected[~np.isnan(found)]))


def loop(n, lines, pointers=("ptr %in", "ptr %out")):
    """Compile a loop over `n` joints that `lines` writes; returns what calls it."""
    code = LoopCode("probe", n, Slots())
    lines(code)
    text = [declarations(), code.constants(), code.function(list(pointers), [])]
    module = compile_code("\n".join(text))
    call = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * len(pointers))(module.get_function_address("probe"))
    return lambda *arrays: call(*(array.ctypes.data for array in arrays)) or module


def test_numbers_stand_at_a_stride_and_an_offset_or_where_a_table_says():
    values, found = np.arange(10.0, 22.0), np.zeros(12)

    def lines(code):
        number = code.load(JointPlace(base="%in", stride=2, offset=3))
        code.store(number, JointPlace(base="%out", addresses=(5, 0, 7)))

    loop(3, lines)(values, found)
    assert found.tolist() == [15.0, 0, 0, 0, 0, 13.0, 0, 17.0, 0, 0, 0, 0]


def test_an_address_below_0_is_nowhere():
    """Nothing is written for a joint that has none; the first place of the array is a place."""
    values, found = np.array([1.0, 2.0, 3.0]), np.full(4, 9.0)

    def lines(code):
        code.store(code.load(JointPlace(base="%in")), JointPlace(base="%out", addresses=(0, -1, 2)))

    loop(3, lines)(values, found)
    assert found.tolist() == [1.0, 9.0, 3.0, 9.0]


def test_one_table_serves_all_that_stand_at_the_same_places():
    code = LoopCode("probe", 2, Slots())
    for addresses in ((1, 0), (1, 0), (0, 1)):
        code.load(JointPlace(base="%in", addresses=addresses))
    assert len(code.constants().splitlines()) == 2


def test_numbers_that_are_the_same_at_all_steps_have_one_place_each():
    graph, slots = Graph(2), Slots()
    first, second = (graph.given(name, fixed=True).nodes[()] for name in "ab")
    assert [slots.place(node) for node in (first, second, first)] == [0, 1, 0]


def test_joints_that_all_have_a_place_are_not_asked_whether_they_have():
    code = LoopCode("probe", 2, Slots())
    code.load(JointPlace(base="%in", addresses=(1, 0)))
    assert not any("%nowhere" in line for line in code.lines)
    code.load(JointPlace(base="%in", addresses=(1, -1)))
    assert any("%nowhere" in line for line in code.lines)


@pytest.mark.parametrize(
    ("places", "is_copied"),
    [
        ([JointPlace(base="%in", stride=3, offset=2), JointPlace(base="%in", stride=3, offset=3)], False),
        ([JointPlace(base="%in", stride=3, offset=2), JointPlace(base="%in", stride=3, offset=1)], True),
        ([JointPlace(base="%in", stride=3, offset=2), JointPlace(base="%in", stride=3, offset=4)], True),
        ([JointPlace(base="%in", stride=3), JointPlace(base="%out", stride=3, offset=1)], True),
        ([JointPlace(base="%in", addresses=(4, 0))], True),
        (["%time", JointPlace(base="%in")], True),
    ],
)
def test_numbers_to_look_up_are_copied_unless_they_stand_side_by_side(places, is_copied):
    graph, code = Graph(2), LoopCode("probe", 2, Slots())
    first, *others = (graph.given(k).nodes[()] for k in range(len(places) + 1))
    code.compute([graph.pick(first, [first, *others])], lambda k: places[k - 1] if k else JointPlace(base="%in"))
    assert any("x double]" in line for line in code.entry) is is_copied


def test_an_index_looks_up_in_what_stands_side_by_side_from_the_first_of_it_on():
    values, index, found = np.arange(10.0, 22.0), np.array([0.0, 1.0, 3.0, 2.0]), np.empty(4)

    def lines(code):
        graph = Graph(4)
        nodes = [graph.given(k).nodes[()] for k in range(4)]
        picked = graph.pick(graph.given("index").nodes[()], nodes)
        row = {k: JointPlace(base="%in", stride=2, offset=k) for k in range(4)}
        code.store(code.compute([picked], {**row, "index": JointPlace(base="%index")}.get)[0], JointPlace(base="%out"))

    loop(4, lines, ("ptr %in", "ptr %index", "ptr %out"))(values, index, found)
    assert found.tolist() == [10.0, 13.0, 17.0, 18.0]
