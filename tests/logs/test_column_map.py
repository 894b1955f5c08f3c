"""Column maps: what they may say, and what is said of mistakes in them."""

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from log_samples import CLOCK, LOG, N_ROWS, POSITION, arrays, column_map, refused, write_npz

from ffgym.core.errors import FFGymError
from ffgym.logs import Contents, builtin_columns, load_columns, parse_columns, read_log
from ffgym.logs.column import _READERS, COUNTS, UNITS, MappedColumn, conversion
from ffgym.logs.column_map import column_map_of
from ffgym.logs.convert import recordings_of
from ffgym.logs.drive_units import with_drive_units
from ffgym.logs.keys import KEYS
from ffgym.logs.read import header_of
from ffgym.logs.text_layout import TextLayout
from ffgym.recordings import Header, Rewire


def test_every_key_is_explained_and_read():
    assert set(KEYS["columns"]) == set(_READERS) == {f.name for f in fields(MappedColumn)}
    assert set(KEYS["file"]) == {f.name for f in fields(TextLayout)}
    assert set(KEYS["rewire"]) == {f.name for f in fields(Rewire)}
    assert set(KEYS["log"]) - {"base", "trim"} == {f.name for f in fields(Header)} - {
        "schema_version", "phases", "provenance", "units", "meta"
    }  # fmt: skip


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        ([CLOCK], "No column has the clock of timestamp"),
        ([POSITION], "[columns.timestamp] is missing"),
        ([], "[columns] is missing"),
        ([CLOCK, "[colums]"], "Unknown table [colums]. Closest: columns"),
        ([CLOCK, POSITION, "sacle = 2"], "Unknown key 'sacle' in [columns.'motor.position']. Closest: scale"),
        ([CLOCK, POSITION, "scale = true"], "scale must be a number, got True"),
        ([CLOCK, POSITION, "scale = nan"], "scale must be finite"),
        ([CLOCK, POSITION, "sign = [1, 2]"], "sign = (1.0, 2.0) must be 1 or -1"),
        ([CLOCK, POSITION, 'axes = ["time", "joint"]'], "Unknown axes entry 'joint'. Available: motion, part, time"),
        ([CLOCK, POSITION, 'axes = ["part"]'], "axes = ['part'] must hold 'time'"),
        ([CLOCK, POSITION, "pick = [-1]"], "pick = [-1] must be numbers of parts, counted from 0"),
        ([CLOCK, POSITION, "pick = 1"], "pick = 1 must be a list of whole numbers"),
        ([CLOCK, POSITION, 'side = "tool"'], "Unknown side 'tool'"),
        ([CLOCK, POSITION, 'resample = "cubic"'], "Unknown resample 'cubic'"),
        ([CLOCK, POSITION, 'clock = "t"'], "clock needs resample"),
        ([CLOCK, POSITION, "rate_hz = 5"], "source says which array holds the numbers; it is missing, or stands"),
        ([CLOCK, POSITION, "optional = 1"], "optional = 1 must be true or false"),
        ([CLOCK, POSITION.replace('"rad"', '"?"')], "columns.motor.position.unit = '?' is still to be filled in"),
        ([CLOCK, POSITION.replace('unit = "rad"', "")], "unit is missing"),
        ([CLOCK, POSITION.replace('"q"', "3")], "source = 3 must be text"),
        ([CLOCK, POSITION, "[motions]\nsplitt = 's'"], "Unknown key 'splitt' in [motions]. Closest: split"),
        (["trim = 1", CLOCK, POSITION], "trim = 1 must be true or false"),
        ([CLOCK, POSITION.replace("position", "positions")], "Unknown column 'motor.positions'. Closest"),
        ([CLOCK, POSITION, 'parts = ["a"]'], "parts belongs to user. columns"),
        ([CLOCK, POSITION, "from_first = true"], "from_first belongs to timestamp and tcp.timestamp"),
        ([CLOCK, 'side = "motor"', POSITION], "the clock of the rows has no resample, optional, side or parts"),
        ([CLOCK, POSITION, 'source = "x"'], "not valid TOML"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_error_that_names_map_and_entry(tables, message, tmp_path):
    with refused("map.toml", message):
        read_log(write_npz(tmp_path), column_map(*tables))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("gear_ratio = [120.0, -80.0]\n", ""), "[log] has joints but no gear_ratio"),
        (("120.0, ", ""), "header gear_ratio has shape (1,), must be (2)"),
        (('"motor_side"', '"torque"'), "Unknown header torque_semantics 'torque'"),
        (("position_side", "position_sides"), "Unknown key 'position_sides' in [log]. Closest: position_side"),
        (('"press"', "5"), "robot = 5 must be text"),
    ],
)
def test_a_mistake_in_the_head_is_one_error(change, message, tmp_path):
    with refused("map.toml", message):
        read_log(write_npz(tmp_path), column_map(CLOCK, POSITION, log=LOG.replace(*change)))


def test_a_map_that_there_is_not_is_one_error(tmp_path):
    with refused("Unknown column map 'emsp'. Built in: abb_egm, emps, kuka_fri, "):
        load_columns("emsp")
    with refused("nowhere.toml: cannot be read: No such file"):
        load_columns(tmp_path / "nowhere.toml")
    with refused("columns = 5 must be a ColumnMap, a name or a path"):
        load_columns(5)  # type: ignore[arg-type]


def test_names_of_columns_need_no_quotes(tmp_path):
    plain = POSITION.replace('"motor.position"', "motor.position")
    assert read_log(write_npz(tmp_path), column_map(CLOCK, plain)).equals(
        read_log(write_npz(tmp_path), column_map(CLOCK, POSITION))
    )


NAMES = st.sampled_from(
    ["t", "q", "xyz", "stack", "run", "word", "gain", "absent", "q{number}", "x{joint}", "q{index+1}"]
)
JUNK = st.booleans() | st.integers(-2, 4) | st.floats() | st.just("") | st.lists(st.floats(-2, 2), max_size=3)
TRUTH = st.booleans()
VALUES = {
    "source": NAMES | st.lists(NAMES, min_size=1, max_size=3),
    "unit": st.sampled_from(
        ["rad", "deg", "m", "mm", "s", "ns", "count", "K", "A", "%", ["rad", "deg"], ["m", "mm", "m"]]
    ),
    "axes": st.permutations(["motion", "time", "part"]) | st.sampled_from([["time"], ["part", "time"]]),
    "pick": st.lists(st.integers(0, 3), min_size=1, max_size=3),
    "otherwise": st.lists(NAMES, min_size=1, max_size=3),
    "twos_complement": st.integers(1, 33),
    "times": NAMES,
    "scale": NAMES | st.floats(-2, 2),
    "offset": NAMES | st.floats(-2, 2),
    "sign": st.sampled_from([1, -1, [1, -1], [1, 1, -1]]),
    "side": st.sampled_from(["motor", "link"]),
    "counts_per_turn": st.sampled_from([4096, 0.0]),
    "clock": NAMES,
    "clock_unit": st.sampled_from(["s", "ms", "rad"]),
    "resample": st.sampled_from(["gaps", "linear", "hold"]),
    "rate_hz": NAMES | st.floats(-2, 300),
    "from_first": TRUTH,
    "parts": st.lists(st.sampled_from("ab"), min_size=1, max_size=2),
    "optional": TRUTH,
}
FAMILIES = ("timestamp", "motor.position", "motor.effort.a", "tcp.position", "tcp.timestamp", "temperature", "user.x")
changes = st.sampled_from(sorted(KEYS["columns"])).flatmap(lambda key: st.tuples(st.just(key), VALUES[key] | JUNK))


@given(
    family=st.sampled_from(FAMILIES),
    source=NAMES,
    unit=st.sampled_from(["rad", "m", "s", "N m", "degC"]),
    changes=st.lists(changes, max_size=3),
    log=st.fixed_dictionaries({}, optional={"trim": TRUTH, "coupling": st.just([[0, 1.0], [2.0, 0]])}),
    motions=st.fixed_dictionaries({}, optional={"split": NAMES, "names": NAMES}),
)
def test_whatever_a_map_says_is_read_or_refused(family, source, unit, changes, log, motions):
    head = {"robot": "press", "joints": ["a", "b"], "gear_ratio": [2.0, 3.0]}
    columns = {"timestamp": {"source": "t", "unit": "s"}, "motor.position": {"source": "q", "unit": "rad"}}
    columns[family] = columns.get(family, {"source": source, "unit": unit}) | dict(changes)
    more = {"xyz": np.ones((N_ROWS, 3)), "stack": np.ones((3, N_ROWS, 2)), "run": [0, 0, 1, 1, 1, 2, 2]}
    more |= {"word": ["a"] * N_ROWS, "gain": 2.0, "q1": arrays()["t"], "q2": arrays()["t"]}
    contents = Contents(where="x", arrays={name: np.array(values) for name, values in arrays(**more).items()})
    refusal = ""
    try:
        parsed = column_map_of({"log": head | log, "columns": columns, "motions": motions}, "map.toml", Path())
        parsed, header = with_drive_units(parsed, header_of(parsed, None), None)
        assert recordings_of(contents, parsed, header)
    except FFGymError as error:
        refusal = str(error)
    assert len(refusal.splitlines()) < 2


def test_units_of_ones_own_columns_are_one_for_all_or_one_each(tmp_path):
    entry = '[columns."user.x"]\nsource = "t"\nunit = ["rad", "deg"]\n'
    with refused("[columns.'user.x']: unit: the list has 2 entries, must be one, or 1"):
        read_log(write_npz(tmp_path), column_map(CLOCK, POSITION, entry))


@pytest.mark.parametrize("name", builtin_columns())
def test_built_in_maps_are_valid(name):
    assert load_columns(name).columns["timestamp"]
    assert parse_columns("[columns.timestamp]\nrate_hz = 5").robot == ""


def test_every_unit_is_as_large_as_it_says():
    known = {
        "deg": np.pi / 180,
        "turn": 2 * np.pi,
        "rpm": np.pi / 30,
        "ns": 1e-9,
        "arcmin": np.pi / 10800,
        "N cm": 0.01,
    }
    factors = {unit: factor for others in UNITS.values() for unit, factor in others.items()}
    for unit, factor in known.items():
        assert factors[unit] == pytest.approx(factor, rel=1e-15)
    for prefix, factor in {"m": 1e-3, "k": 1e3, "u": 1e-6, "c": 1e-2}.items():
        for unit in ("m", "N m", "N", "s", "rad", "rad/s", "m/s"):
            assert factors.get(f"{prefix}{unit}", factor) == factor
    assert all(COUNTS[unit] in UNITS for unit in COUNTS)
    assert conversion("K", "degC").factor * 293.15 + conversion("K", "degC").shift == pytest.approx(20.0)


@pytest.mark.parametrize(
    ("unit", "extra", "message"),
    [
        ("N m", "", "unit 'N m' does not fit a quantity in rad, must be 'rad', 'deg'"),
        ("count", "", "unit 'count' needs counts_per_turn"),
        ("count", "counts_per_turn = 0", "counts_per_turn = 0.0 is out of range"),
        ("deg", "counts_per_turn = 4096", "counts_per_turn belongs to unit 'count'"),
    ],
)
def test_a_unit_that_does_not_fit_is_one_error(unit, extra, message, tmp_path):
    entry = POSITION.replace('"rad"', f'"{unit}"') + extra
    with refused("[columns.'motor.position']", message):
        read_log(write_npz(tmp_path), column_map(CLOCK, entry))


@pytest.mark.parametrize(("unit", "gain"), [("A", "N m/A"), ("V", "N m/V"), ("%", "N m/%")])
def test_a_current_voltage_or_share_of_a_rated_torque_asks_for_its_gain(unit, gain, tmp_path):
    entry = f'[columns."motor.effort"]\nsource = "u"\nunit = "{unit}"\n'
    with refused(f"unit '{unit}' ", f"give scale = <{gain}> and unit = 'N m'"):
        read_log(write_npz(tmp_path), column_map(CLOCK, POSITION, entry))


def test_counts_become_angles(tmp_path):
    counts = np.round(arrays()["q"] * 1000).astype(np.int32)
    entry = POSITION.replace('"rad"', '"count"') + "counts_per_turn = 4096"
    recording = read_log(write_npz(tmp_path, q=counts), column_map(CLOCK, entry))
    np.testing.assert_allclose(recording.joint_array("motor.position"), counts * 2 * np.pi / 4096, rtol=1e-14)
